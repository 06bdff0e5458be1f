//! A supplier's plant under our names: the numbers of `dct-harness`, and what is wrong with a mapping.
//!
//! Needs `target/fmu/*.fmu` and `.venv`, as `cargo xtask test` makes them; builds the plant itself.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod both;

use both::{Loop, column, root, shipped};
use cosim_master::known_units;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

fn python(words: &[&str]) -> String {
    let mut command = Command::new(root().join(".venv/bin/python"));
    let done = command.args(words).output().unwrap();
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.success(), "{told}");
    String::from_utf8(done.stdout).unwrap()
}

/// A folder with the plant in C of `examples/supplier_plant`.
fn built() -> TempDir {
    let folder = TempDir::new().unwrap();
    let script = root().join("examples/supplier_plant/build.py");
    let out = folder.path().display().to_string();
    python(&[&script.display().to_string(), &out]);
    folder
}

fn mapping() -> PathBuf {
    root().join("examples/supplier_plant/antrieb.toml")
}

fn words(plant: &Path, map: &Path) -> Vec<String> {
    let paths = [plant, map].map(|path| path.display().to_string());
    let [plant, map] = paths;
    vec!["--plant".into(), plant, "--map".into(), map]
}

#[test]
fn a_mapped_plant_agrees_with_fmpy() {
    let folder = built();
    let words = words(&folder.path().join("Antrieb.fmu"), &mapping());
    for more in [
        &[][..],
        &[
            "--interpolate",
            "--step",
            "0.007",
            "--set",
            "plant.vehicle.mass=1600",
        ],
    ] {
        let words: Vec<&str> = words
            .iter()
            .map(String::as_str)
            .chain(more.iter().copied())
            .collect();
        let system = shipped("paper_case1.toml");
        let table = Loop {
            system,
            words: &words,
        }
        .agreed();
        assert!(*column(&table, "plant.vehicle.speed").last().unwrap() > 0.1);
        let states = column(&table, "plant.clutch1.state");
        assert!(
            states.contains(&1.0) && states.contains(&2.0),
            "no coded state"
        );
    }
}

/// What in the mapping is replaced by what; the exit code, and what is told.
const FAULTS: [(&str, &str, i32, &str); 14] = [
    ("", "", 0, ""),
    (
        "mot.MInd",
        "mot.Mind",
        2,
        "'engine.torque' = 'mot.Mind': the FMU has no such variable",
    ),
    (
        "\"road.grade\" =",
        "\"road.slope\" =",
        2,
        "inputs: DctPlant has no input 'road.slope'",
    ),
    (
        "\"mot.n\" # 1/min",
        "\"fzg.v\"",
        2,
        "'km/h' (m s-1) cannot become 'rad/s' (s-1 rad)",
    ),
    (
        "variable = \"kuppl1.nDiff\"",
        "variable = \"kuppl1.nDiff\", unit = \"rmp\"",
        2,
        "unknown unit 'rmp' (1, -",
    ),
    (
        "slipping = \"schleift\"",
        "slipping = \"rutscht\"",
        2,
        "has no item 'rutscht' (geschlossen",
    ),
    (
        "slipping = \"schleift\"",
        "slipping = \"offen\"",
        2,
        "gives one value of theirs two meanings",
    ),
    (
        "derive = \"vehicle.speed\"",
        "derive = \"engine.speed\"",
        2,
        "can be derived: \"wheel.speed\" from",
    ),
    (
        "\"vehicle.mass\" = \"fzg.m\"\n",
        "",
        2,
        "nothing stands for 'vehicle.mass' of the system; map it",
    ),
    (
        "factor = -1, offset = 0.010",
        "factor = -1, ofset = 0.010",
        2,
        "m.toml:10: needs a variable's name, { variable",
    ),
    (
        "factor = -1, offset = 0.010",
        "factor = nan, offset = 0.010",
        2,
        "factor = NaN and offset = 0.01 must be finite, and factor not 0",
    ),
    (
        "radius = 0.310",
        "radius = 0",
        2,
        "outputs.wheel.speed: radius = 0 m must be above 0",
    ),
    (
        "share = [\"observer\"",
        "share = [\"obsrver\"",
        2,
        "has no component 'obsrver'",
    ),
    (
        ", slipping = \"schleift\"",
        "",
        4,
        "kuppl1.zustand = 1 is in no row of the table for 'clutch1.state' at t =",
    ),
];

#[test]
fn what_is_wrong_with_a_mapping_is_told() {
    let folder = built();
    let good = std::fs::read_to_string(mapping()).unwrap();
    let file = folder.path().join("m.toml");
    for (before, after, code, said) in FAULTS {
        let text = good.replacen(before, after, usize::from(!before.is_empty()));
        assert_eq!(text == good, before.is_empty(), "{before}");
        std::fs::write(&file, text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
        command.arg("run").arg(shipped("paper_case1.toml"));
        command.args(words(&folder.path().join("Antrieb.fmu"), &file));
        command.args(["--set", "plant.vehicle.mass=1500", "--stop", "1"]);
        command.arg("--fmu-dir").arg(root().join("target/fmu"));
        let done = command
            .arg("--out")
            .arg(folder.path().join("out.csv"))
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(code), "{before}: {told}");
        assert!(told.contains(said), "{before}: {told}");
    }
}

/// Name, factor, offset, exponents of every unit that `dct-harness` knows.
const UNITS: &str = "
from dct_harness.units import BASES, KNOWN, SPELLINGS, find
for name in [*KNOWN, *SPELLINGS]:
    unit = find(name)
    powers = dict(unit.exponents)
    print(name, unit.factor.hex(), unit.offset.hex(), *(powers.get(b, 0) for b in BASES), sep='|')
";

#[test]
fn units_are_those_of_the_harness() {
    let told = python(&["-c", UNITS]);
    let theirs: Vec<Vec<&str>> = told.lines().map(|line| line.split('|').collect()).collect();
    assert_eq!(theirs.len(), known_units::names().count());
    for row in theirs {
        let unit = known_units::find(row[0]).unwrap_or_else(|| panic!("no unit {row:?}"));
        let exponents: Vec<i32> = row[3..].iter().map(|text| text.parse().unwrap()).collect();
        assert_eq!(exponents, unit.exponents, "{row:?}");
        assert_eq!(
            [hex(row[1]), hex(row[2])],
            [unit.factor, unit.offset],
            "{row:?}"
        );
    }
}

/// A number as `float.hex` of Python writes it.
fn hex(text: &str) -> f64 {
    let digits = text.strip_prefix("0x").unwrap();
    let (mantissa, exponent) = digits.split_once('p').unwrap();
    let (whole, part) = mantissa.split_once('.').unwrap();
    let fraction = u64::from_str_radix(&format!("{part:0<13}"), 16).unwrap();
    let exponent: i32 = exponent.parse().unwrap();
    match whole {
        "0" => 0.0,
        _ => {
            let bits = u64::try_from(exponent + 1023).unwrap() << 52 | fraction;
            f64::from_bits(bits)
        }
    }
}
