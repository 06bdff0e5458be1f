//! The FMUs of this workspace: described, built and checked as a user does.

// Clippy knows tests by their attribute; these are their helpers.
#![allow(clippy::unwrap_used)]

use fmu_build::models::{Entry, MODELS};
use fmu_build::{Severity, library};
use std::path::{Path, PathBuf};
use std::{env, fs};

/// A folder of its own for a test, removed on drop.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = env::temp_dir().join(format!("fmu-build-test-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Packs the FMU of `entry` with its description changed.
fn changed(entry: &Entry, folder: &Folder, from: &str, to: &str) -> PathBuf {
    let description = (entry.describe)().unwrap();
    let text = description.replacen(from, to, 1);
    assert_ne!(text, description, "{from} is not in the description");
    let (platform, extension) = library::platform().unwrap();
    let binary = format!("binaries/{platform}/{}.{extension}", entry.name);
    let path = folder.0.join("changed.fmu");
    let members = vec![
        ("modelDescription.xml".to_owned(), text.into_bytes()),
        (
            binary,
            entry.library(&library::Target::host().unwrap()).unwrap(),
        ),
    ];
    fmu_build::package(&path, members).unwrap();
    path
}

fn errors(path: &Path) -> Vec<String> {
    let report = fmu_build::check(path).unwrap();
    let errors = report
        .findings
        .iter()
        .filter(|finding| finding.severity == Severity::Error);
    errors.map(ToString::to_string).collect()
}

#[test]
fn committed_descriptions_are_those_of_the_models() {
    if let Err(error) = fmu_build::compare() {
        panic!("{error}");
    }
}

#[test]
fn every_output_states_what_it_depends_on() {
    for entry in MODELS {
        let text = (entry.describe)().unwrap();
        let outputs = text
            .split("<Outputs>")
            .nth(1)
            .unwrap()
            .split("</Outputs>")
            .next()
            .unwrap();
        let unknowns = outputs.matches("<Unknown ").count();
        assert!(unknowns > 0, "{}", entry.name);
        assert_eq!(
            outputs.matches(" dependencies=").count(),
            unknowns,
            "{}",
            entry.name
        );
    }
}

#[test]
fn two_builds_give_the_same_bytes_and_a_check_finds_nothing() {
    let folder = Folder::new("same");
    for entry in MODELS {
        let path = fmu_build::build(entry, &folder.0).unwrap();
        let first = fs::read(&path).unwrap();
        assert_eq!(fmu_build::build(entry, &folder.0).unwrap(), path);
        assert!(first == fs::read(&path).unwrap(), "{} differs", entry.name);
        let report = fmu_build::check(&path).unwrap();
        assert_eq!(report.findings, [], "{}", entry.name);
        assert!(report.compared > 0, "{}", entry.name);
        assert_eq!(report.model, entry.name);
    }
}

#[test]
fn a_start_value_that_differs_from_the_librarys_is_found() {
    let folder = Folder::new("start");
    let entry = &MODELS[0];
    let path = changed(
        entry,
        &folder,
        "<Boolean start=\"false\"",
        "<Boolean start=\"true\"",
    );
    let errors = errors(&path);
    assert!(
        errors
            .iter()
            .all(|error| error.contains("the description says true")),
        "{errors:?}"
    );
    assert!(!errors.is_empty());
}

#[test]
fn a_guid_of_another_table_is_found() {
    let folder = Folder::new("guid");
    let path = changed(&MODELS[0], &folder, "guid=\"", "guid=\"0");
    let errors = errors(&path);
    assert!(
        errors[0].contains("no instance with the description's GUID"),
        "{errors:?}"
    );
}
