//! What the packager reads: archives, descriptions, libraries of other platforms. No code is loaded.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::OnceLock;

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else {
        return;
    };
    match first % 4 {
        0 => archive(bytes),
        1 => check(vec![("modelDescription.xml", bytes)]),
        2 => check(vec![
            ("modelDescription.xml", DESCRIPTION),
            ("binaries/win64/A.dll", bytes),
            ("binaries/aarch64-linux/A.so", bytes),
            ("binaries/darwin64/A.dylib", bytes),
        ]),
        _ => pair(bytes),
    }
});

/// A description that names no library of this machine.
const DESCRIPTION: &[u8] = br#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="A" guid="{1}">
<CoSimulation modelIdentifier="A"/><ModelVariables/><ModelStructure/></fmiModelDescription>"#;

/// A folder in memory where there is one: thousands of files a second are written.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let base = if memory.is_dir() {
            memory.into()
        } else {
            env::temp_dir()
        };
        let folder = base.join(format!("fmu-fuzz-{}", process::id()));
        drop(fs::create_dir_all(&folder));
        // SAFETY: called once, before any other thread exists; the checker unpacks where it says.
        unsafe { env::set_var("TMPDIR", &folder) };
        folder
    })
}

/// Bytes that claim to be an FMU.
fn archive(bytes: &[u8]) {
    let (path, out) = (folder().join("A.fmu"), folder().join("merged.fmu"));
    assert!(fs::write(&path, bytes).is_ok());
    if !holds_code(&path) {
        examine(&path);
    }
    drop(fmu_build::merge(&[path.clone(), path], &out));
}

/// The checker runs what is a library of this machine: that is no matter of reading.
fn holds_code(path: &Path) -> bool {
    fs::read(path).is_ok_and(|bytes| {
        let here = b"binaries/linux64/";
        bytes.windows(here.len()).any(|part| part == here)
    })
}

fn check(members: Vec<(&str, &[u8])>) {
    let path = folder().join("A.fmu");
    let members = members
        .into_iter()
        .map(|(name, bytes)| (name.into(), bytes.into()));
    assert!(fmu_build::package(&path, members.collect()).is_ok());
    examine(&path);
}

fn examine(path: &Path) {
    if let Ok(report) = fmu_build::check(path) {
        let json = report.to_json(path);
        assert!(json.starts_with('{') && json.ends_with('}'));
        report
            .findings
            .iter()
            .for_each(|finding| drop(finding.to_string()));
    }
}

/// Two FMUs that share some members: what merging gives can be opened again.
fn pair(bytes: &[u8]) {
    let half = bytes.len() / 2;
    let paths = [("one", &bytes[..half]), ("two", &bytes[half..])].map(|(name, part)| {
        let path = folder().join(name);
        let members = part.chunks(7).map(|part| {
            let (name, contents) = part.split_at(part.len() / 2);
            (
                String::from_utf8_lossy(name).into_owned(),
                contents.to_vec(),
            )
        });
        let unique: std::collections::BTreeMap<_, _> = members.collect();
        fmu_build::package(&path, unique.into_iter().collect()).map(|()| path)
    });
    let [Ok(one), Ok(two)] = paths else {
        return;
    };
    let out = folder().join("merged.fmu");
    if fmu_build::merge(&[one, two], &out).is_ok() {
        drop(fmu_build::check(&out));
    }
}
