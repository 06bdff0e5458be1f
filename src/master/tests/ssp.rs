//! `.ssp` files by `cosim run` and by `dct-harness run`: the same bits, and what is wrong with one.
//!
//! Needs `target/fmu/*.fmu` and `.venv`, as `cargo xtask test` makes them.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod both;

use both::{Loop, column, root, shipped, succeed};
use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

/// Writes the packages of the harness's own tests: two lags, and nested systems.
const PACKAGES: &str = "src/master/tests/ssp_packages.py";

fn python(words: &[&str]) {
    let mut command = Command::new(root().join(".venv/bin/python"));
    succeed(command.args(words).current_dir(root()));
}

fn packages() -> TempDir {
    let folder = TempDir::new().unwrap();
    python(&[PACKAGES, &folder.path().display().to_string()]);
    folder
}

fn exported(folder: &Path, system: &str, words: &[&str]) -> PathBuf {
    let out = folder.join(system).with_extension("ssp");
    let (system, fmus) = (shipped(system), root().join("target/fmu"));
    let paths = [&system, &fmus, &out].map(|path| path.display().to_string());
    let [system, fmus, out_text] = &paths;
    let verb = ["-m", "dct_harness.cli", "export-ssp", system];
    let more = ["--fmu-dir", fmus, "--out", out_text];
    python(&[&verb[..], &more, words].concat());
    out
}

#[test]
fn exported_systems_agree_with_fmpy() {
    let folder = TempDir::new().unwrap();
    let supplier = root().join("examples/supplier_plant");
    let script = supplier.join("build.py").display().to_string();
    python(&[&script, &folder.path().display().to_string()]);
    let plant = folder.path().join("Antrieb.fmu").display().to_string();
    let map = supplier.join("antrieb.toml").display().to_string();
    let ours = "plant.vehicle.speed";
    for (system, speed, exports, words) in [
        ("torque_tracking_case1.toml", ours, &[][..], &[][..]),
        (
            "launch_wet6.toml",
            ours,
            &[],
            &["--step", "0.01", "--interpolate"],
        ),
        (
            "paper_case1.toml",
            "plant.fzg.v",
            &["--plant", &plant, "--map", &map],
            &["--set", "plant.fzg.m=1600.0"],
        ),
    ] {
        let system = exported(folder.path(), system, exports);
        let table = Loop { system, words }.agreed();
        assert!(*column(&table, speed).last().unwrap() > 0.1, "{speed}");
    }
}

#[test]
fn nested_systems_transformations_and_parameter_sets_agree_with_fmpy() {
    let folder = packages();
    for (name, signal, last) in [("two", "second.m", 8.0), ("nested", "box/first.grade", 8.0)] {
        let system = folder.path().join(format!("{name}.ssp"));
        let scenario = folder.path().join(format!("{name}.csv"));
        let words = [
            "--scenario",
            &scenario.display().to_string(),
            "--step",
            "0.01",
        ];
        let table = Loop {
            system,
            words: &words,
        }
        .agreed();
        assert!(column(&table, signal).contains(&last));
        let lags = table.0.iter().filter(|name| name.ends_with(".x"));
        for lag in lags {
            assert!(column(&table, lag).iter().any(|x| x.abs() > 0.1), "{lag}");
        }
    }
}

/// What in which file of `two.ssp` is replaced by what, and what is told.
const FAULTS: [(&str, &str, &str, &str); 27] = [
    (
        SSD,
        "source=\"resources/Lag.fmu\"",
        "source=\"resources/Log.fmu\"",
        "SystemStructure.ssd:10: component 'first' has no file 'resources/Log.fmu' inside",
    ),
    (
        SSD,
        "source=\"resources/Lag.fmu\"",
        "source=\"../../Lag.fmu\"",
        "has no file '../../Lag.fmu' inside",
    ),
    (
        SSD,
        "source=\"resources/Lag.fmu\"",
        "source=\"/etc/passwd\"",
        "has no file '/etc/passwd' inside",
    ),
    (
        SSD,
        "source=\"resources/all.ssv\"",
        "source=\"resources/none.ssv\"",
        "has no 'resources/none.ssv'",
    ),
    (
        SSD,
        "source=\"resources/all.ssv\"",
        "source=\"../all.ssv\"",
        "has no '../all.ssv'",
    ),
    (
        SSD,
        "<ssd:Component name=\"second\"",
        "<ssd:SignalDictionaryReference name=\"second\"",
        "SystemStructure.ssd:17: SignalDictionaryReference 'second' is not supported: put components",
    ),
    (
        SSD,
        "name=\"second\" source",
        "name=\"zweite\" source",
        "SystemStructure.ssd:21: no 'second.u'",
    ),
    (
        SSD,
        "startElement=\"first\" startConnector=\"x\"",
        "startElement=\"first\" startConnector=\"y\"",
        "'first.y' does not exist",
    ),
    (
        SSM,
        "target=\"second.tau\"",
        "target=\"second.tua\"",
        "'second.tua' does not exist",
    ),
    (
        SSM,
        "target=\"second.tau\"",
        "target=\"third.tau\"",
        "parameter 'third.tau': no such component",
    ),
    (
        SSM,
        "source=\"lag in ms\"",
        "source=\"lag in s\"",
        "all.ssm:4: mapping: no parameter 'lag in s'; did you mean 'lag in ms'?",
    ),
    (
        SSD,
        "endElement=\"second\" endConnector=\"u\"",
        "endElement=\"first\" endConnector=\"u\"",
        "SystemStructure.ssd:21: 'first.u' has two sources",
    ),
    (
        SSD,
        " stopTime=\"1.0\"",
        " stopTime=\"soon\"",
        "stopTime = 'soon' is no number",
    ),
    (
        SSD,
        " stopTime=\"1.0\"",
        "",
        "two.ssp: says no stopTime; give --stop SECONDS",
    ),
    (
        SSD,
        "version=\"1.0\" name=\"two\"",
        "version=\"3.0\" name=\"two\"",
        "is of SSP version '3.0'; known are",
    ),
    (
        SSD,
        "name=\"second\" source",
        "name=\"a.b\" source",
        "an element is called 'a.b'",
    ),
    (
        SSD,
        "name=\"second\" source",
        "name=\"first\" source",
        "two elements are called 'first'",
    ),
    (
        SSD,
        "name=\"second\" source",
        "name=\"second\" type=\"application/x-ssp-package\" source",
        "'second' is of type application/x-ssp-package; only FMUs can run",
    ),
    (
        SSV,
        "value=\"250\"",
        "value=\"long\"",
        "'second.tau': 'long' is no number and no known item",
    ),
    (
        SSD,
        "target=\"4\"/>",
        "target=\"four\"/>",
        "'second.n': 'four' is no number and no known item",
    ),
    (
        SSD,
        "factor=\"-2\"",
        "factor=\"two\"",
        "SystemStructure.ssd:22: factor = 'two' is no number",
    ),
    (
        SSD,
        "<ssd:DefaultExperiment",
        "<ssd:Units><ssc:Unit name='rpm'><ssc:BaseUnit rad='one'/></ssc:Unit></ssd:Units><ssd:DefaultExperiment",
        "SystemStructure.ssd:35: rad = 'one' is no whole number",
    ),
    (
        SSD,
        "</ssd:SystemStructureDescription>",
        "<ssd:Annotations><ssc:Annotation type='dct-harness'><Run step='soon'/></ssc:Annotation></ssd:Annotations>\
         </ssd:SystemStructureDescription>",
        "step = 'soon' is no number",
    ),
    (
        SSD,
        "<?xml version=\"1.0\"?>",
        "<!DOCTYPE a [<!ENTITY b \"c\">]>",
        "SystemStructure.ssd:1: XML with DTD",
    ),
    (
        SSD,
        "<ssd:Elements>",
        "<ssd:Elements",
        "SystemStructure.ssd:10: invalid name token\n",
    ),
    (
        SSD,
        "<ssd:Connector name=\"push\" kind=\"input\"/>",
        "<ssd:Connector name=\"push\" kind=\"input\"><ssd:Dimension size=\"3\"/></ssd:Connector>",
        "connector 'push' is an array; FMI 2.0 has none",
    ),
    (
        SSD,
        "<ssd:Connection startConnector=\"push\"",
        "<ssd:Connection startConnector=\"a\" endConnector=\"b\"/>\n\
         <ssd:Connection startConnector=\"b\" endConnector=\"a\"/>\n\
         <ssd:Connection startConnector=\"a\"",
        "'first.u' is fed by a ring of connectors",
    ),
];
const SSD: &str = "SystemStructure.ssd";
const SSV: &str = "resources/all.ssv";
const SSM: &str = "resources/all.ssm";

/// Copies a package; a text in one of its files is replaced.
fn changed(from: &Path, to: &Path, change: impl Fn(&str, Vec<u8>) -> Vec<u8>) {
    let mut old = ZipArchive::new(File::open(from).unwrap()).unwrap();
    let mut new = ZipWriter::new(File::create(to).unwrap());
    for index in 0..old.len() {
        let mut member = old.by_index(index).unwrap();
        let mut bytes = vec![];
        member.read_to_end(&mut bytes).unwrap();
        let options = SimpleFileOptions::default();
        new.start_file(member.name(), options).unwrap();
        new.write_all(&change(member.name(), bytes)).unwrap();
    }
    new.finish().unwrap();
}

/// Runs a package beside the scenario `two.csv`: its exit code, and what it tells.
fn run(package: &Path, words: &[&str]) -> (Option<i32>, String) {
    let folder = package.parent().unwrap();
    fs::create_dir_all(folder.join("tmp")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command.arg("run").arg(package).args(words);
    command.arg("--out").arg(folder.join("out.csv"));
    let command = command
        .env("TMPDIR", folder.join("tmp"))
        .current_dir(folder);
    let done = command.output().unwrap();
    assert_eq!(fs::read_dir(folder.join("tmp")).unwrap().count(), 0);
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    (done.status.code(), told)
}

#[test]
fn what_is_wrong_is_told_with_its_file_and_line() {
    let folder = packages();
    let bad = folder.path().join("bad");
    fs::create_dir(&bad).unwrap();
    fs::copy(folder.path().join("two.csv"), bad.join("two.csv")).unwrap();
    for (file, old, new, said) in FAULTS {
        let package = bad.join("two.ssp");
        changed(&folder.path().join("two.ssp"), &package, |name, bytes| {
            if name != file {
                return bytes;
            }
            let text = String::from_utf8(bytes).unwrap();
            assert!(text.contains(old), "{old}");
            text.replace(old, new).into_bytes()
        });
        let (code, told) = run(&package, &["--scenario", "two.csv"]);
        assert_eq!(code, Some(2), "{told}");
        assert!(told.contains(said), "{said}: {told}");
        assert_eq!(told.lines().count(), 1, "{told}");
    }
}

#[test]
fn inputs_of_the_system_need_a_scenario_or_keep_their_start_values() {
    let folder = packages();
    let package = folder.path().join("two.ssp");
    let (code, told) = run(&package, &[]);
    assert_eq!(code, Some(2));
    assert!(
        told.contains("two.ssp: has inputs of its own; give --scenario FILE.csv"),
        "{told}"
    );
    fs::write(folder.path().join("pull.csv"), "time,pull\n0,2\n9,2\n").unwrap();
    let (code, told) = run(&package, &["--scenario", "pull.csv"]);
    assert_eq!(code, Some(0), "{told}");
    assert_eq!(
        told,
        "the scenario has no column for first.u: start values\n"
    );
    let table = fs::read_to_string(folder.path().join("out.csv")).unwrap();
    assert!(
        table.starts_with("time,first.x,first.m,second.x,second.m\n"),
        "{table:.60}"
    );
    let kept = table
        .lines()
        .skip(1)
        .all(|row| row.split(',').nth(1) == Some("0.0"));
    assert!(kept, "first.u starts at 0");
}

#[test]
fn systems_that_lie_too_deep_in_each_other_are_refused() {
    let folder = packages();
    let package = folder.path().join("deep.ssp");
    let ends = [
        "<ssd:System name='deeper'><ssd:Elements>",
        "</ssd:Elements></ssd:System>",
    ];
    let [begin, end] = ends.map(|end| end.repeat(100_000));
    changed(&folder.path().join("two.ssp"), &package, |name, bytes| {
        if name != SSD {
            return bytes;
        }
        let text = String::from_utf8(bytes).unwrap();
        let text = text.replacen("<ssd:Elements>", &format!("<ssd:Elements>{begin}{end}"), 1);
        text.into_bytes()
    });
    let (code, told) = run(&package, &[]);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.len() < 200, "{told:.200}");
}

#[test]
fn a_file_that_is_no_package_is_refused() {
    let folder = TempDir::new().unwrap();
    let package = folder.path().join("a.SSP");
    fs::write(&package, "text").unwrap();
    let (code, told) = run(&package, &[]);
    assert_eq!(code, Some(3), "{told}");
    assert!(told.contains("a.SSP: invalid Zip archive"), "{told}");
    let (code, told) = run(&folder.path().join("b.ssp"), &[]);
    assert_eq!(code, Some(2), "{told}");
    assert!(
        told.ends_with("b.ssp: No such file or directory\n"),
        "{told}"
    );
}
