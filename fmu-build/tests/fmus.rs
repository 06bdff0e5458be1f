//! The FMUs of this workspace: described, built and checked as a user does.

// Clippy knows tests by their attribute; these are their helpers.
#![allow(clippy::unwrap_used)]

use dct_models::Plant;
use fmi2_cosim::Model as _;
use fmu_build::Entry;
use fmu_build::models::MODELS;
use fmu_build::{Finding, Severity, library};
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

/// What a build for the own machine may need, other than one that `--target` links for older ones.
fn is_of_this_machine(finding: &Finding) -> bool {
    let texts = ["needs glibc 2.", "needs libgcc_s.so.1"];
    finding.severity == Severity::Warning && texts.iter().any(|text| finding.text.contains(text))
}

/// Copies files, but no build products.
fn copy(from: &Path, to: &Path) {
    if from.is_file() {
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(from, to).unwrap();
    } else if from.file_name().unwrap() != "target" {
        for entry in fs::read_dir(from).unwrap() {
            let name = entry.unwrap().file_name();
            copy(&from.join(&name), &to.join(&name));
        }
    }
}

/// Everything that cargo reads of this workspace.
const SOURCES: [&str; 8] = [
    "Cargo.toml",
    "Cargo.lock",
    "src",
    "fmu-build",
    "examples",
    "xtask",
    "benches",
    "tests/abi",
];

/// Builds the plant in a copy of the workspace and here; both have to be the same, and say nothing of the copy.
fn same_in_another_folder(name: &str, target: &library::Target) {
    let folder = Folder::new(name);
    for name in SOURCES {
        copy(&library::workspace().join(name), &folder.0.join(name));
    }
    let copied: &str = folder.0.to_str().unwrap().to_owned().leak();
    let elsewhere = Entry::of::<Plant>("dct-plant")
        .at(copied)
        .library(target)
        .unwrap();
    assert!(folder.0.join("target").is_dir(), "it was built there");
    let here = Entry::of::<Plant>("dct-plant").library(target).unwrap();
    assert!(
        here == elsewhere,
        "{} and {} bytes differ",
        here.len(),
        elsewhere.len()
    );
    assert!(!holds(&here, copied));
}

#[test]
fn the_same_sources_in_another_folder_give_the_same_library() {
    same_in_another_folder("another-name", &library::Target::host().unwrap());
}

#[test]
fn the_same_sources_in_another_folder_give_the_same_small_library() {
    let small = library::Target::host().unwrap().small();
    same_in_another_folder("another-name-of-a-small-one", &small);
}

#[test]
fn a_check_finds_nothing_in_a_small_fmu() {
    let folder = Folder::new("small");
    let small = library::Target::host().unwrap().small();
    let path = fmu_build::build_for(&MODELS[0], &[small], &folder.0).unwrap();
    let report = fmu_build::check(&path).unwrap();
    assert!(report.is_valid(), "{:?}", report.findings);
    assert!(
        report.findings.iter().all(is_of_this_machine),
        "{:?}",
        report.findings
    );
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
        assert!(report.is_valid(), "{}: {:?}", entry.name, report.findings);
        assert!(
            report.findings.iter().all(is_of_this_machine),
            "{:?}",
            report.findings
        );
        assert!(report.compared > 0, "{}", entry.name);
        assert_eq!(report.model, entry.name);
    }
}

fn holds(library: &[u8], text: &str) -> bool {
    library
        .windows(text.len())
        .any(|part| part == text.as_bytes())
}

#[test]
fn a_library_holds_the_names_of_its_variables_but_not_their_descriptions() {
    let host = library::Target::host().unwrap();
    let library = Entry::of::<Plant>("dct-plant").library(&host).unwrap();
    for row in Plant::VARIABLES {
        let (name, description) = (row.name, row.description);
        // The compiler cuts short texts that it compares with into numbers.
        assert!(name.len() < 16 || holds(&library, name), "{name}");
        assert!(!holds(&library, description), "{name}: {description}");
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
