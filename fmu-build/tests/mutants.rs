//! Sixty ways to spoil an FMU: the check must name each of them.

// Clippy knows tests by their attribute; these are their helpers.
#![allow(clippy::unwrap_used)]

use fmu_build::Entry;
use fmu_build::models::MODELS;
use fmu_build::{Severity, library};
use std::path::{Path, PathBuf};
use std::{env, fs};

/// What is replaced once in the description of the plant, by what, and what the check must say.
const MUTANTS: &[(&str, &str, &str)] = &[
    ("<?xml", "\u{feff}<?xml", "byte order mark"),
    ("fmiVersion=\"2.0\"", "fmiVersion=\"2.1\"", "fmiVersion is"),
    (
        "guid=\"{",
        "guid=\"{0",
        "no instance with the description's GUID",
    ),
    ("guid=\"{", "guid=\"\" x=\"{", "guid is empty"),
    (
        "modelName=\"DctPlant\"",
        "modelName=\"\"",
        "modelName is empty",
    ),
    (
        "modelIdentifier=\"DctPlant\"",
        "modelIdentifier=\"Dct-Plant\"",
        "is no C identifier",
    ),
    (
        "modelIdentifier=\"DctPlant\"",
        "modelIdentifier=\"Other\"",
        "Other",
    ),
    (
        "canGetAndSetFMUstate=\"true\"",
        "canGetAndSetFMUstate=\"false\"",
        "canSerializeFMUstate needs",
    ),
    (
        "<CoSimulation ",
        "<ModelExchange ",
        "no CoSimulation element",
    ),
    (
        "<Unit name=\"N.m\">",
        "<Unit name=\"Nm\">",
        "the unit N.m of",
    ),
    (
        "<Unit name=\"N.m\">",
        "<Unit name=\"rad\">",
        "two units are named rad",
    ),
    (
        "name=\"slipping\"",
        "name=\"engaged\"",
        "two items of ClutchState are named engaged",
    ),
    (
        "value=\"2\" description=\"Kinetic",
        "value=\"3\" description=\"Kinetic",
        "have the same value",
    ),
    (
        "<SimpleType name=\"ClutchState\"",
        "<SimpleType name=\"State\"",
        "the type ClutchState is not defined",
    ),
    (
        "<Enumeration declaredType=\"ClutchState\"/>",
        "<Enumeration/>",
        "names no enumeration",
    ),
    (
        "<Category name=\"logEvents\"",
        "<Category name=\"logStatusError\"",
        "two log categories",
    ),
    (
        "stopTime=\"30.0\"",
        "stopTime=\"0.0\"",
        "the stop time is not above",
    ),
    (
        "startTime=\"0.0\"",
        "startTime=\"40.0\"",
        "the stop time is not above",
    ),
    (
        "stepSize=\"0.001\"",
        "stepSize=\"0\"",
        "stepSize = 0 is not above 0",
    ),
    (
        "stepSize=\"0.001\"",
        "tolerance=\"-1\"",
        "tolerance = -1 is not above 0",
    ),
    (
        "name=\"brake.torque\"",
        "name=\"engine.torque\"",
        "two variables are named engine.torque",
    ),
    ("name=\"brake.torque\"", "name=\"\"", "is no variable name"),
    (
        "name=\"brake.torque\"",
        "name=\"brake&#10;torque\"",
        "is no variable name",
    ),
    (
        "valueReference=\"1\"",
        "valueReference=\"0\"",
        "can both be set",
    ),
    (
        "valueReference=\"1\"",
        "valueReference=\"4000\"",
        "fmi2GetReal returns fmi2Status 3",
    ),
    (
        "causality=\"input\" variability=\"continuous\"",
        "causality=\"in\" variability=\"continuous\"",
        "in is no causality",
    ),
    (
        "causality=\"input\" variability=\"continuous\"",
        "causality=\"input\" variability=\"fixed\"",
        "no input may be fixed",
    ),
    (
        "causality=\"input\" variability=\"continuous\"",
        "causality=\"input\" variability=\"continuous\" initial=\"exact\"",
        "no input has initial",
    ),
    (
        "causality=\"input\" variability=\"discrete\"",
        "causality=\"input\" variability=\"continuous\"",
        "is continuous but no Real",
    ),
    (
        "causality=\"parameter\" variability=\"fixed\"",
        "causality=\"parameter\" variability=\"continuous\"",
        "no parameter may be continuous",
    ),
    (
        "variability=\"fixed\" initial=\"exact\"",
        "variability=\"fixed\" initial=\"calculated\"",
        "initial of a parameter is exact",
    ),
    (
        "<Real unit=\"N.m\" start=\"0.0\"/>",
        "<Real unit=\"N.m\"/>",
        "engine.torque needs a start value",
    ),
    (
        "<Real unit=\"N.m\" start=\"0.0\"/>",
        "<Real unit=\"N.m\" start=\"a\"/>",
        "is not a number",
    ),
    (
        "<Real unit=\"N.m\" start=\"0.0\"/>",
        "<Real unit=\"N.m\" start=\"1.0\"/>",
        "the description says 1.0",
    ),
    (
        "<Real unit=\"N.m\" start=\"0.0\"/>",
        "<Real displayUnit=\"N.m\" start=\"0.0\"/>",
        "a displayUnit but no unit",
    ),
    (
        "<Real unit=\"N.m\" start=\"0.0\"/>",
        "<Real unit=\"N.m\" nominal=\"0\" start=\"0.0\"/>",
        "nominal is not above 0",
    ),
    (
        "<Real unit=\"N.m\" start=\"0.0\"/>",
        "<Real unit=\"N.m\" min=\"NaN\" start=\"0.0\"/>",
        "a limit is no number",
    ),
    (
        "<Real unit=\"N.m\" start=\"0.0\"/>",
        "<Real unit=\"N.m\" derivative=\"9999\" start=\"0.0\"/>",
        "derivative = 9999 points at no variable",
    ),
    (
        "<Real unit=\"N.m\" start=\"0.0\"/>",
        "<Integer start=\"0\"/>",
        "fmi2GetInteger returns fmi2Status 3",
    ),
    (
        "min=\"0.0\" start=\"0.0\"",
        "min=\"1.0\" start=\"0.0\"",
        "start = 0 is outside",
    ),
    (
        "min=\"-1.5\" max=\"1.5\"",
        "min=\"1.5\" max=\"-1.5\"",
        "is above max",
    ),
    (
        "<Integer min=\"-1\" max=\"8\" start=\"1\"/>",
        "<Integer min=\"-1\" max=\"8\" start=\"9\"/>",
        "start = 9 is outside",
    ),
    (
        "<Real unit=\"rad/s\" displayUnit=\"rpm\"/>",
        "<Real unit=\"rad/s\" start=\"1\"/>",
        "is calculated, so it may have no start value",
    ),
    (
        "<Unknown index=\"10\" dependencies=\"\"/>",
        "",
        "Outputs must list all outputs",
    ),
    (
        "<Unknown index=\"10\" dependencies=\"\"/>",
        "<Unknown index=\"1\" dependencies=\"\"/>",
        "Outputs must list all outputs",
    ),
    (
        "<Unknown index=\"10\" dependencies=\"\"/>",
        "<Unknown index=\"9999\"/>",
        "points at no variable",
    ),
    (
        "<Unknown index=\"10\" dependencies=\"\"/>",
        "<Unknown index=\"10\" dependencies=\"0\"/>",
        "points at no variable",
    ),
    (
        "<Unknown index=\"11\" dependencies=\"\"/>",
        "<Unknown index=\"10\" dependencies=\"\"/>",
        "lists 10 twice",
    ),
    (
        "<Unknown index=\"10\" dependencies=\"\"/>",
        "<Unknown index=\"10\" dependencies=\"1\" dependenciesKind=\"fixed fixed\"/>",
        "another length than dependencies",
    ),
    (
        "<Unknown index=\"10\" dependencies=\"\"/>",
        "<Unknown index=\"10\" dependencies=\"1\" dependenciesKind=\"odd\"/>",
        "odd is no dependenciesKind",
    ),
    (
        "<Unknown index=\"22\" dependencies=\"2\"/>",
        "<Unknown index=\"22\" dependencies=\"\"/>",
        "which is not among its dependencies",
    ),
    (
        "<Category name=\"logEvents\"",
        "<Category name=\"logOther\"",
        "fmi2SetDebugLogging refuses the log category logOther",
    ),
    (
        "<InitialUnknowns>",
        "<InitialUnknowns><Unknown index=\"1\"/>",
        "is given, not computed",
    ),
    (
        "</Outputs>",
        "</Outputs><Derivatives><Unknown index=\"9999\"/></Derivatives>",
        "Derivatives: the unknown 9999",
    ),
];

fn plant() -> &'static Entry {
    MODELS
        .iter()
        .find(|entry| entry.name == "DctPlant")
        .unwrap()
}

/// Bytes of the first member of the archive that are written over, by their distance from the beginning of its
/// entry in the directory, and what the check must say.
const ARCHIVES: &[(&[(usize, u8)], &str)] = &[
    (&[(8, 1)], "binaries/linux64/DctPlant.so is encrypted"),
    (
        &[(10, 93)],
        "binaries/linux64/DctPlant.so is compressed by method 93",
    ),
    (
        &[(10, 12)],
        "binaries/linux64/DctPlant.so is compressed by method 12",
    ),
];

/// What the check says is wrong with an FMU of this description and library.
fn errors(folder: &Path, description: &str, library: &[u8]) -> String {
    errors_of(&packed(folder, description, library))
}

fn packed(folder: &Path, description: &str, library: &[u8]) -> PathBuf {
    let (platform, extension) = library::platform().unwrap();
    let path = folder.join("mutant.fmu");
    let members = vec![
        ("modelDescription.xml".into(), description.into()),
        (
            format!("binaries/{platform}/DctPlant.{extension}"),
            library.into(),
        ),
    ];
    fmu_build::package(&path, members).unwrap();
    path
}

fn errors_of(path: &Path) -> String {
    let report = fmu_build::check(path).unwrap();
    let wrong = report
        .findings
        .iter()
        .filter(|f| f.severity == Severity::Error);
    wrong.map(|finding| format!("{finding}\n")).collect()
}

/// The plant's description and library.
fn sound() -> (String, Vec<u8>) {
    let library = plant().library(&library::Target::host().unwrap());
    ((plant().describe)().unwrap(), library.unwrap())
}

fn new_folder(name: &str) -> PathBuf {
    let folder = env::temp_dir().join(format!("fmu-build-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn every_mutant_is_found_and_named() {
    let folder = new_folder("mutants");
    let (description, library) = sound();
    assert_eq!(errors(&folder, &description, &library), "");
    let mut missed = Vec::new();
    for (sound, broken, expected) in MUTANTS {
        let mutant = description.replacen(sound, broken, 1);
        assert_ne!(mutant, description, "{sound} is not in the description");
        let found = errors(&folder, &mutant, &library);
        if !found.contains(expected) {
            missed.push(format!("{sound} -> {broken}: {expected}? {found}"));
        }
    }
    fs::remove_dir_all(&folder).unwrap();
    assert!(MUTANTS.len() >= 40);
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

#[test]
fn every_spoilt_archive_is_found_and_named() {
    let folder = new_folder("archives");
    let (description, library) = sound();
    let path = packed(&folder, &description, &library);
    let bytes = fs::read(&path).unwrap();
    let entry = bytes
        .windows(4)
        .position(|part| part == b"PK\x01\x02")
        .unwrap();
    for (over, expected) in ARCHIVES {
        let mut spoilt = bytes.clone();
        for (offset, value) in *over {
            spoilt[entry + offset] = *value;
        }
        fs::write(&path, spoilt).unwrap();
        let found = errors_of(&path);
        assert!(found.contains(expected), "{expected}? {found}");
    }
    let names = ["a/B", "A/b", "modelDescription.xml"];
    let member = |name: &str| (name.to_owned(), description.clone().into_bytes());
    fmu_build::package(&path, names.map(member).into()).unwrap();
    let found = errors_of(&path);
    assert!(
        found.contains("is there twice where file names have no upper case"),
        "{found}"
    );
    fs::remove_dir_all(&folder).unwrap();
}
