//! `extra/org.fmi-standard.fmi-ls-ref`: parameter sets and a smoke experiment with reference results, as the
//! layered standard FMI-LS-REF 1.0.0-alpha.1 and the experiments format of the Modelica Association have it.
//!
//! ```text
//! fmi-ls-manifest.xml ──> NAME.ssv: parameter sets
//!                    └──> smoke.exp ──> smoke.ssv, smoke_in.csv, smoke_ref.csv
//! ```

use super::Members;
use crate::drive::{self, Loop, Stimuli};
use crate::parameters::ParameterSet;
use crate::xml::Element;
use crate::{Entry, Error, Result, Smoke};
use std::fmt::Write as _;

const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
/// Where the standard wants it explained.
const GUIDE: &str = "documentation/fmi-ls-ref.txt";
const PARAMETERS: &str = "smoke.ssv";
const INPUTS: &str = "smoke_in.csv";
const RESULTS: &str = "smoke_ref.csv";
const EXPERIMENTS: &str = "smoke.exp";

/// A file that the manifest lists.
struct Related {
    name: String,
    kind: &'static str,
    role: &'static str,
    description: String,
    text: String,
}

/// The files of an entry with their manifest and guide; none when it has neither sets nor an experiment.
pub(super) fn members(entry: &Entry) -> Result<Members> {
    let mut files: Vec<_> = (entry.sets)()?.into_iter().map(parameters).collect();
    if let Some(smoke) = &entry.smoke {
        files.extend(experiment(entry, smoke)?);
    }
    if files.is_empty() {
        return Ok(Members::new());
    }
    let mut members = vec![
        (GUIDE.to_owned(), guide(entry, &files).into_bytes()),
        (
            format!("{FOLDER}/fmi-ls-manifest.xml"),
            manifest(&files).into_bytes(),
        ),
    ];
    let member = |file: Related| (format!("{FOLDER}/{}", file.name), file.text.into_bytes());
    members.extend(files.into_iter().map(member));
    Ok(members)
}

fn manifest(files: &[Related]) -> String {
    let related = |file: &Related| {
        Element::new("Related")
            .with("type", file.kind)
            .with("source", &file.name)
            .with("role", file.role)
            .with("description", &file.description)
    };
    Element::new("fmiReferences")
        .with("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest")
        .with("fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-ref")
        .with("fmi-ls:fmi-ls-version", "1.0.0-alpha.1")
        .with(
            "fmi-ls:fmi-ls-description",
            "Layered Standard providing information on related files included in an FMU.",
        )
        .holding(files.iter().map(related))
        .document()
}

fn guide(entry: &Entry, files: &[Related]) -> String {
    let mut text = format!(
        "Files that belong to {}, in {FOLDER}\nand listed in its fmi-ls-manifest.xml:\n\n",
        entry.name
    );
    for file in files {
        let _ = writeln!(text, "{} ({}): {}", file.name, file.role, file.description);
    }
    if let Some(smoke) = &entry.smoke {
        let _ = write!(
            text,
            "\nTo repeat the experiment: set what {PARAMETERS} holds, step by {step} s, and set the inputs of\n\
             {INPUTS} before every step at its beginning: Reals between two rows on the straight line,\n\
             Integers and Booleans as in the last row. {RESULTS} has the outputs after every {every}. step.\n\
             So done, the results are the same to the last bit on every platform of this FMU. An importer\n\
             that holds inputs otherwise differs by as much as they change in a step.\n",
            step = smoke.step,
            every = smoke.every,
        );
    }
    text
}

fn parameters(set: ParameterSet) -> Related {
    Related {
        name: format!("{}.ssv", set.name),
        kind: "application/x-ssp-parameter-set",
        role: "parameter",
        description: set.title,
        text: set.text,
    }
}

/// The experiment, its inputs, its parameters and what comes out.
fn experiment(entry: &Entry, smoke: &Smoke) -> Result<Vec<Related>> {
    let inputs = (smoke.inputs)()?;
    let described = |what: &str| format!("{what} of: {}", smoke.description);
    let csv = |name: &str, role, what, text| Related {
        name: name.into(),
        kind: "text/csv",
        role,
        description: described(what),
        text,
    };
    Ok(vec![
        Related {
            name: EXPERIMENTS.into(),
            kind: "application/x-ma-hs-experiments",
            role: "experiment/smoke-test",
            description: smoke.description.into(),
            text: experiments(smoke, &stimuli(&inputs)?),
        },
        Related {
            name: PARAMETERS.into(),
            description: described("Parameters"),
            ..parameters(ParameterSet {
                name: "smoke".into(),
                title: String::new(),
                text: (entry.given)("smoke", smoke.parameters)?,
            })
        },
        csv(
            RESULTS,
            "result",
            "Outputs",
            results(entry, smoke, &inputs)?,
        ),
        csv(INPUTS, "other", "Inputs", inputs),
    ])
}

fn stimuli(inputs: &str) -> Result<Stimuli> {
    Stimuli::parse(inputs).map_err(|(line, what)| Error::Stimuli {
        path: INPUTS.into(),
        line,
        what,
    })
}

/// What the model makes of the inputs: the code of its FMU, run here.
fn results(entry: &Entry, smoke: &Smoke, inputs: &str) -> Result<String> {
    let mut part = (entry.part)(entry.folder())?;
    for (name, value) in smoke.parameters {
        let signal = part.signals().iter().find(|signal| signal.name == *name);
        if let Some(place) = signal.map(|signal| signal.place) {
            part.set(place, *value)?;
        }
    }
    let stimuli = stimuli(inputs)?;
    let mut all = Loop::new(vec![part], &stimuli);
    drive::table(&mut all, smoke.step, smoke.every)
}

fn experiments(smoke: &Smoke, stimuli: &Stimuli) -> String {
    let (start, stop) = stimuli.times();
    let source = |name: &'static str, file: &str| Element::new(name).with("source", file);
    let one = Element::new("Experiment")
        .with("name", "smoke")
        .with("description", smoke.description)
        .with("startTime", format!("{start:?}"))
        .with("stopTime", format!("{stop:?}"))
        .with("stepSize", format!("{:?}", smoke.step))
        .holding([
            source("Parameters", PARAMETERS),
            source("Stimuli", INPUTS),
            source("References", RESULTS),
        ]);
    Element::new("Experiments")
        .with("name", "Smoke test")
        .with(
            "description",
            "Shows that an importer runs the FMU as it was meant",
        )
        .holding([one])
        .document()
}
