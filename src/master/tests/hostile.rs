//! FMU files that nobody vouches for: refused with a sentence, and nothing is left or written elsewhere.
//!
//! Needs `target/fmu/DctPlant.fmu`, as `cargo xtask test` makes it.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

const XML: &str = "modelDescription.xml";
const LIBRARY: &str = "binaries/linux64/DctPlant.so";
const SYSTEM: &str = "[system]\nname = 's'\nstep = 0.001\nstop = 0.01\nscenario = 's.csv'\n\
                      [components.plant]\nfmu = 'F.fmu'\n";
const SIGNALS: &str = "engine.torque brake.torque road.grade shaft1.gear shaft2.gear clutch1.pressure \
                       clutch2.pressure clutch1.position clutch2.position";

fn ours(member: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/fmu/DctPlant.fmu");
    let mut archive = ZipArchive::new(File::open(path).unwrap()).unwrap();
    let mut bytes = Vec::new();
    archive
        .by_name(member)
        .unwrap()
        .read_to_end(&mut bytes)
        .unwrap();
    bytes
}

fn write(path: PathBuf, members: &[(&str, &[u8])]) {
    let mut out = ZipWriter::new(File::create(path).unwrap());
    for (name, bytes) in members {
        out.start_file(*name, SimpleFileOptions::default()).unwrap();
        out.write_all(bytes).unwrap();
    }
    out.finish().unwrap();
}

/// Runs a system with an FMU of these members; its exit code and what it tells.
fn run(members: &[(&str, &[u8])]) -> (Option<i32>, String) {
    let folder = TempDir::new().unwrap();
    let file = |name: &str| folder.path().join(name);
    write(file("F.fmu"), members);
    fs::write(file("s.toml"), SYSTEM).unwrap();
    let names: Vec<&str> = SIGNALS.split_whitespace().collect();
    let zeros = ",0".repeat(names.len());
    fs::write(
        file("s.csv"),
        format!("time,{}\n0{zeros}\n1{zeros}\n", names.join(",")),
    )
    .unwrap();
    fs::create_dir(file("tmp")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command
        .arg("run")
        .arg(file("s.toml"))
        .arg("--fmu-dir")
        .arg(folder.path());
    command
        .arg("--out")
        .arg(file("out.csv"))
        .env("TMPDIR", file("tmp"));
    let done = command.output().unwrap();
    assert_eq!(fs::read_dir(file("tmp")).unwrap().count(), 0);
    assert!(!file("escaped").exists() && !file("tmp/escaped").exists());
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    (done.status.code(), told)
}

#[track_caller]
fn check(members: &[(&str, &[u8])], said: &str) {
    let (code, told) = run(members);
    assert_eq!(code, Some(3), "{told}");
    assert!(told.contains(said), "{told}");
}

#[test]
fn a_sound_fmu_runs() {
    let (xml, library) = (ours(XML), ours(LIBRARY));
    let (code, told) = run(&[(XML, &xml), (LIBRARY, &library)]);
    assert_eq!(code, Some(0), "{told}");
}

#[test]
fn members_that_leave_the_archive_are_refused() {
    let (xml, library) = (ours(XML), ours(LIBRARY));
    for name in [
        "resources/../../escaped",
        "binaries/linux64/../../../escaped",
        "resources/../../../../../../../../../escaped",
    ] {
        check(
            &[(XML, &xml), (LIBRARY, &library), (name, b"x")],
            "leaves it",
        );
    }
}

#[test]
fn a_bomb_is_refused_before_it_is_unpacked() {
    let (xml, library, zeros) = (ours(XML), ours(LIBRARY), vec![0; 17 << 20]);
    let members: [(&str, &[u8]); 3] = [
        (XML, &xml),
        (LIBRARY, &library),
        ("resources/zeros", &zeros),
    ];
    check(&members, "a bomb");
}

#[test]
fn a_library_that_is_cut_short_is_refused_before_it_ends_the_process() {
    let (xml, library) = (ours(XML), ours(LIBRARY));
    for part in [70, 1000, library.len() / 2, library.len() * 9 / 10] {
        check(
            &[(XML, &xml), (LIBRARY, &library[..part])],
            "the library is cut short",
        );
    }
}

#[test]
fn a_model_identifier_that_is_a_path_is_refused() {
    let text = String::from_utf8(ours(XML)).unwrap();
    for name in [
        "../../../../DctPlant",
        "/tmp/DctPlant",
        "..\\DctPlant",
        "C:DctPlant",
    ] {
        let named = format!("modelIdentifier=\"{name}\"");
        let text = text.replace("modelIdentifier=\"DctPlant\"", &named);
        check(
            &[(XML, text.as_bytes()), (LIBRARY, &ours(LIBRARY))],
            "is a path",
        );
    }
}

#[test]
fn descriptions_that_are_none_are_refused() {
    let (xml, library) = (ours(XML), ours(LIBRARY));
    let text = String::from_utf8(xml).unwrap();
    let deep = "<a>".repeat(100_000) + &"</a>".repeat(100_000);
    let entity = text.replace(
        "<fmiModelDescription",
        "<!DOCTYPE f [<!ENTITY a \"aa\"><!ENTITY b \"&a;&a;\">]><fmiModelDescription",
    );
    let entity = entity.replace("modelName=\"DctPlant\"", "modelName=\"&b;\"");
    for text in [
        "",
        "no XML",
        "<a><b></a>",
        "<fmiModelDescription/>",
        &deep,
        &entity,
    ] {
        let (code, told) = run(&[(XML, text.as_bytes()), (LIBRARY, &library)]);
        assert!(matches!(code, Some(2 | 3)), "{told}");
        assert!(!told.is_empty() && told.len() < 1000, "{told}");
    }
    check(&[(XML, b"\xff\xfe<a/>"), (LIBRARY, &library)], "UTF-8");
    check(&[(LIBRARY, &library)], "not found");
}
