//! An FMU in C, compiled for a test.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;
use std::process::Command;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Writes the FMU `fmu` of one C file, which is compiled with these words too.
pub fn write(fmu: &Path, source: &str, words: &[&str], identifier: &str, description: &str) {
    let library = fmu.with_extension("so");
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-Wall", "-Wextra", "-Werror"]);
    cc.args(words).arg(source).arg("-o").arg(&library);
    assert!(cc.status().unwrap().success());
    let mut archive = ZipWriter::new(File::create(fmu).unwrap());
    let binary = format!("binaries/linux64/{identifier}.so");
    let members = [
        ("modelDescription.xml", description.as_bytes().to_vec()),
        (&binary, fs::read(library).unwrap()),
    ];
    for (name, bytes) in members {
        archive
            .start_file(name, SimpleFileOptions::default())
            .unwrap();
        archive.write_all(&bytes).unwrap();
    }
    archive.finish().unwrap();
}
