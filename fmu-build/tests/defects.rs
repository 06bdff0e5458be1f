//! An FMU in C with one defect after another: the check must name each of them, and survive it.

// Clippy knows tests by their attribute; these are their helpers.
#![allow(clippy::unwrap_used)]

use fmu_build::{Finding, Options, Severity, library};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use std::{env, fs};

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/lag.c");

const DESCRIPTION: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Lag" guid="{lag}">
  <CoSimulation modelIdentifier="Lag" canHandleVariableCommunicationStepSize="true" canInterpolateInputs="true"
    maxOutputDerivativeOrder="1" canGetAndSetFMUstate="true" canSerializeFMUstate="true"
    canNotUseMemoryManagementFunctions="true" providesDirectionalDerivative="true"/>
  <LogCategories><Category name="logAll"/></LogCategories>
  <DefaultExperiment startTime="0" stopTime="5" stepSize="0.01"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="1.0"/></ScalarVariable>
    <ScalarVariable name="n" valueReference="0" causality="input" variability="discrete">
      <Integer start="3"/></ScalarVariable>
    <ScalarVariable name="T" valueReference="1" causality="parameter" variability="fixed">
      <Real min="0.1" start="0.5"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="2" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="z" valueReference="3" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="m" valueReference="1" causality="output" variability="discrete"><Integer/></ScalarVariable>
    <ScalarVariable name="gain" valueReference="4" causality="output" variability="constant"><Real start="2.0"/></ScalarVariable>
    <ScalarVariable name="x" valueReference="2" causality="local"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs>
      <Unknown index="4" dependencies=""/><Unknown index="5" dependencies="1"/>
      <Unknown index="6" dependencies="2"/><Unknown index="7" dependencies=""/>
    </Outputs>
    <InitialUnknowns><Unknown index="4"/><Unknown index="5"/><Unknown index="6"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>"#;

/// What is wrong with the library, and what the check must say.
const DEFECTS: &[(&str, &str)] = &[
    (
        "CRASH_EXIT",
        "crashed with signal 11 (invalid memory access) in fmi2ExitInitializationMode",
    ),
    (
        "CRASH_FREE",
        "crashed with signal 6 (abort) in fmi2FreeInstance; before, it printed",
    ),
    (
        "HANG_TERMINATE",
        "did not answer within 1 s in fmi2Terminate",
    ),
    (
        "EXIT_ENTER",
        "ended the process that runs it in fmi2EnterInitializationMode",
    ),
    (
        "PRINTS",
        "the library prints to the console: \"Licence of Lag Ltd. found",
    ),
    (
        "NO_STRING_STATUS",
        "Lag.so does not export fmi2GetStringStatus",
    ),
    ("CRASH_STEP", "crashed with signal 6 (abort) in fmi2DoStep"),
    ("STEP_REFUSED", "fmi2DoStep returns fmi2Status 3"),
    ("RESET_KEEPS", "after fmi2Reset, step 1 of 0.01 s: y is"),
    (
        "SHARED_STATE",
        "while another instance runs, step 2 of 0.01 s: y is",
    ),
    (
        "CLOCK",
        "in a second run, with a new instance, step 1 of 0.01 s: y is",
    ),
    ("ONLY_ONE", "a second instance is refused"),
    (
        "NOT_A_NUMBER",
        "y becomes NaN though fmi2DoStep returns fmi2OK",
    ),
    ("STATE_FORGETS", "after fmi2SetFMUstate: y is"),
    (
        "BYTES_FORGET",
        "after fmi2SetFMUstate of a serialised state in a new instance: y is 0.0",
    ),
    (
        "BYTES_OVERFLOW",
        "fmi2SerializeFMUstate writes more than fmi2SerializedFMUstateSize tells",
    ),
    (
        "FEEDS_THROUGH",
        "y changes at once with u, which is not among its dependencies",
    ),
    (
        "CONSTANT_DRIFTS",
        "gain is a constant of 2.0, but 2.5 after 20 steps",
    ),
    ("CONSTANT_SET", "gain is a constant, but can be set"),
    ("SET_FORGETS", "u was set to 1.01, then it is 1.0"),
    ("SET_REFUSES_START", "T refuses its own start value 0.5"),
    (
        "NO_CATEGORIES",
        "fmi2SetDebugLogging refuses the log category logAll",
    ),
    (
        "URI_NOT_DECODED",
        "no instance where resources lie in a folder",
    ),
    ("IMPORTERS_MEMORY", "without them there is no instance"),
    (
        "CANCELS_NOTHING",
        "fmi2CancelStep returns fmi2OK though no step is being computed",
    ),
    (
        "CRASH_CANCEL",
        "crashed with signal 6 (abort) in fmi2CancelStep",
    ),
    (
        "WRONG_DIRECTIONAL",
        "the directional derivative of z by u is 2.02 after a step",
    ),
    (
        "NO_DIRECTIONAL",
        "fmi2GetDirectionalDerivative returns fmi2Status 3",
    ),
    ("SLOPES_IGNORED", "the slope of u changes nothing"),
    (
        "NO_SLOPES",
        "fmi2SetRealInputDerivatives returns fmi2Status 3",
    ),
    (
        "WRONG_RATES",
        "y does not move as fmi2GetRealOutputDerivatives says",
    ),
    (
        "NO_RATES",
        "fmi2GetRealOutputDerivatives returns fmi2Status 3",
    ),
    ("FIXED_STEP", "fmi2DoStep returns fmi2Status 3"),
    (
        "OWN_STEP",
        "a step of half the size gets as far as a whole one",
    ),
    (
        "PENDING",
        "fmi2DoStep returns fmi2Pending though canRunAsynchronuously is not true",
    ),
    (
        "PENDING FOR_EVER",
        "did not answer within 1 s in fmi2GetStatus of a pending step",
    ),
    (
        "PENDING NO_SIGNAL",
        "stepFinished is not called at the end of a step",
    ),
    (
        "PENDING CANCEL_REFUSED",
        "fmi2CancelStep is refused while a step is being computed",
    ),
    (
        "PENDING CANCEL_LEAVES",
        "after fmi2CancelStep and fmi2Reset: y is",
    ),
    (
        "STARTS_PROGRAM",
        "the library starts the program sleep, but needsExecutionTool is not true",
    ),
];

/// An option of the linker that the loader sees, for one of the defects.
fn search_path(defect: &str) -> String {
    match defect {
        "UNTIDY" => "-Wl,-rpath,/opt/lag".into(),
        _ => "-O1".into(),
    }
}

/// Compiles the library with a defect; packs it with a description.
fn fmu(folder: &Path, defect: &str, description: &str) -> PathBuf {
    let (platform, extension) = library::platform().unwrap();
    let library = folder.join(defect);
    let done = Command::new("cc")
        .args(["-shared", "-fPIC", "-fvisibility=hidden", "-O1", "-w"])
        .args(defect.split(' ').map(|name| format!("-D{name}")))
        .arg(search_path(defect))
        .args(["-o".as_ref(), library.as_os_str(), SOURCE.as_ref()])
        .status()
        .unwrap();
    assert!(done.success(), "{defect}");
    let path = folder.join(format!("{defect}.fmu"));
    let members = vec![
        ("modelDescription.xml".into(), description.into()),
        ("resources/table.csv".into(), b"1\n".to_vec()),
        (
            format!("binaries/{platform}/Lag.{extension}"),
            fs::read(&library).unwrap(),
        ),
    ];
    fmu_build::package(&path, members).unwrap();
    path
}

/// Patience with a call of a library that hangs [s].
const SHORT: u64 = 1;

/// With one that does not: a busy machine is no defect [s].
const LONG: u64 = 600;

fn findings(folder: &Path, defect: &str, limit: u64) -> Vec<Finding> {
    let options = Options {
        host: Some(env!("CARGO_BIN_EXE_cargo-fmu").into()),
        limit: Duration::from_secs(limit),
        ..Options::default()
    };
    fmu_build::check_with(&fmu(folder, defect, DESCRIPTION), &options)
        .unwrap()
        .findings
}

fn new_folder(name: &str) -> PathBuf {
    let folder = env::temp_dir().join(format!("fmu-build-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn the_sound_library_has_no_findings() {
    let folder = new_folder("sound");
    assert_eq!(findings(&folder, "SOUND", LONG), []);
    fs::remove_dir_all(&folder).unwrap();
}

/// Findings of an FMU in whose description something is replaced.
fn findings_of(folder: &Path, defect: &str, flag: &str) -> Vec<String> {
    let description = DESCRIPTION.replace(
        "canInterpolateInputs=",
        &format!("{flag} canInterpolateInputs="),
    );
    let path = fmu(folder, defect, &description);
    let report = fmu_build::check(&path).unwrap();
    report.findings.iter().map(ToString::to_string).collect()
}

#[test]
fn promises_of_other_ways_to_compute_are_taken_at_their_word() {
    let folder = new_folder("promises");
    let asynchronous = "canRunAsynchronuously=\"true\"";
    for library in ["PENDING", "SOUND"] {
        assert_eq!(
            findings_of(&folder, library, asynchronous),
            Vec::<String>::new()
        );
    }
    let tool = "needsExecutionTool=\"true\"";
    let said = [
        "warning (FMI 2.0.4, 4.3.1): needsExecutionTool is true: it runs only where that tool is installed",
    ];
    assert_eq!(findings_of(&folder, "STARTS_PROGRAM", tool), said);
    let missing = findings_of(&folder, "NO_TOOL", tool);
    assert!(
        missing[0].contains("(needsExecutionTool is true: is that tool installed?)"),
        "{missing:?}"
    );
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_belongs_to_the_build_machine_is_an_error_in_fmus_packed_here_and_in_strict_checks() {
    let folder = new_folder("untidy");
    let packed = DESCRIPTION.replace("guid=", "generationTool=\"fmu-build 9\" guid=");
    for (description, strict, errors) in [
        (DESCRIPTION, false, 0),
        (DESCRIPTION, true, 3),
        (&packed, false, 3),
    ] {
        let options = Options {
            strict,
            ..Options::default()
        };
        let report = fmu_build::check_with(&fmu(&folder, "UNTIDY", description), &options).unwrap();
        let texts: Vec<_> = report.findings.iter().map(|f| f.text.as_str()).collect();
        assert_eq!(
            texts,
            [
                "binaries/linux64/Lag.so exports lag_version, which no importer calls",
                "binaries/linux64/Lag.so makes the loader search /opt/lag, a folder of another machine",
                "binaries/linux64/Lag.so names /home/lag/lag.c, a file of the machine it was built on",
            ]
        );
        let wrong = report
            .findings
            .iter()
            .filter(|f| f.severity == Severity::Error);
        assert_eq!((wrong.count(), report.is_valid()), (errors, errors == 0));
    }
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn every_defect_is_found_and_named_once() {
    let folder = new_folder("defects");
    let mut wrong = Vec::new();
    for (defect, expected) in DEFECTS {
        let hangs = expected.starts_with(&format!("did not answer within {SHORT} s"));
        let found = findings(&folder, defect, if hangs { SHORT } else { LONG });
        let texts = found.iter().map(|finding| &finding.text);
        if texts.filter(|text| text.contains(expected)).count() != 1 {
            wrong.push(format!("{defect}: {expected}? {found:#?}"));
        }
    }
    fs::remove_dir_all(&folder).unwrap();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
