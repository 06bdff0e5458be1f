//! Opens an FMU as an importer would and compares what it says with what it does.
//!
//! ```text
//! .fmu ─unpack─> modelDescription.xml ─parse─> rules on the text ┐
//!            └─> binaries/…  ─load─> symbols, life cycle, values ┴─> Report
//! ```

mod aliases;
mod audit;
mod child;
mod container;
mod native;
mod parsed;
mod probe;
mod refused;
mod replay;
mod roles;
mod rules;
mod text;
mod trace;
mod unpack;

use crate::archive::DESCRIPTION;
use crate::binary::Version;
use crate::{Error, Result, library};
use parsed::Description;
use probe::Probe;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{fmt, fs};
use unpack::Unpacked;

pub use probe::probe;
pub use replay::{Replay, replay};

/// How the generation tool of our own FMUs begins.
const PACKER: &str = concat!(env!("CARGO_PKG_NAME"), " ");

/// What a check found.
#[derive(Debug, Default)]
pub struct Report {
    /// `modelName`.
    pub model: String,
    /// Start values that were read from the library and compared with the description.
    pub compared: usize,
    /// What is wrong or remarkable, in the order in which it was seen.
    pub findings: Vec<Finding>,
    /// The same, to be found fast: a large FMU may have as many as it has variables.
    known: HashSet<Finding>,
    trace: Option<PathBuf>,
}

impl Report {
    /// Whether no finding is an error; warnings do not count.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.findings
            .iter()
            .all(|finding| finding.severity != Severity::Error)
    }

    /// One JSON object: `fmu`, `model`, `valid`, `compared` and `findings`, each with `severity`,
    /// `clause` and `text`.
    #[must_use]
    pub fn to_json(&self, fmu: &Path) -> String {
        let findings = self.findings.iter().map(|finding| {
            serde_json::json!({
                "severity": finding.severity.word(),
                "clause": finding.clause,
                "text": finding.text,
            })
        });
        serde_json::json!({
            "fmu": fmu.display().to_string(),
            "model": self.model,
            "valid": self.is_valid(),
            "compared": self.compared,
            "findings": findings.collect::<Vec<_>>(),
        })
        .to_string()
    }

    /// A report whose findings are written to the folder `trace`, too, as soon as they are made.
    fn written_to(trace: &Path) -> Self {
        Self {
            trace: Some(trace.into()),
            ..Self::default()
        }
    }

    /// Whether a process runs for this report and nothing else.
    fn is_of_one_process(&self) -> bool {
        self.trace.is_some()
    }

    fn error(&mut self, clause: &'static str, text: impl Into<String>) {
        self.find(Severity::Error, clause, text);
    }

    fn warn(&mut self, clause: &'static str, text: impl Into<String>) {
        self.find(Severity::Warning, clause, text);
    }

    fn find(&mut self, severity: Severity, clause: &'static str, text: impl Into<String>) {
        self.push(Finding {
            severity,
            clause: clause.into(),
            text: text.into(),
        });
    }

    /// Adds a finding, unless it is there already.
    fn push(&mut self, finding: Finding) {
        if !self.known.insert(finding.clone()) {
            return;
        }
        if let Some(folder) = &self.trace {
            // Where it cannot be written, the folder is gone, and with it whoever would read it.
            let _ = trace::write(folder, &trace::Line::Found(finding.clone()));
        }
        self.findings.push(finding);
    }
}

/// One thing that is wrong or remarkable.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// Clause of the FMI 2.0.4 standard that it concerns.
    pub clause: Cow<'static, str>,
    /// A sentence.
    pub text: String,
}

/// How bad a [`Finding`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The standard is broken: some importer will fail.
    Error,
    /// Legal, but some machine or user will stumble over it.
    Warning,
}

impl Severity {
    fn word(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = self.severity.word();
        write!(f, "{severity} (FMI 2.0.4, {}): {}", self.clause, self.text)
    }
}

/// How an FMU is checked.
#[derive(Debug, Clone)]
pub struct Options {
    /// Oldest glibc that its Linux libraries shall run with; a newer need is an error. Without it, needing
    /// a newer one than 2.17 is a warning.
    pub glibc: Option<Version>,
    /// Whether warnings are errors, too: what is handed over to others should have none.
    pub strict: bool,
    /// Program that runs the FMU's code, called as `PROGRAM probe NAME FOLDER TRACE`, which calls [`probe`]:
    /// `fmu-build` is one. Without it, this process runs the code, and crashes with it.
    pub host: Option<PathBuf>,
    /// The longest that the host waits for one call of the FMU.
    pub limit: Duration,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            glibc: None,
            strict: false,
            host: None,
            limit: Duration::from_secs(10),
        }
    }
}

/// Checks the FMI 2.0 co-simulation FMU at `path`.
///
/// Runs the FMU's code in this process: for FMUs of one's own; [`check_with`] can do without.
///
/// # Errors
/// When the file cannot be opened at all; everything else is a finding.
pub fn check(path: &Path) -> Result<Report> {
    check_with(path, &Options::default())
}

/// Like [`check`], with options.
///
/// # Errors
/// When the file cannot be opened at all; everything else is a finding.
pub fn check_with(path: &Path, options: &Options) -> Result<Report> {
    let mut report = Report::default();
    container::check(path, &mut report)?;
    match Unpacked::open(path) {
        Ok(unpacked) => check_unpacked(unpacked.folder(), options, &mut report)?,
        Err(Error::Untrusted { fault, .. }) => report.error("2.3", fault.to_string()),
        Err(error) => report.error("2.3", error.to_string()),
    }
    if options.strict {
        for finding in &mut report.findings {
            finding.severity = Severity::Error;
        }
    }
    Ok(report)
}

fn check_unpacked(folder: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let Ok(bytes) = fs::read(folder.join(DESCRIPTION)) else {
        report.error("2.3", "modelDescription.xml is missing");
        return Ok(());
    };
    let Some(text) = text::read(&bytes, report) else {
        return Ok(());
    };
    match parsed::parse(&text) {
        Ok(description) => check_contents(&description, folder, options, report),
        Err(error) => {
            report.error("2.2", error.to_string());
            Ok(())
        }
    }
}

fn check_contents(
    description: &Description,
    folder: &Path,
    options: &Options,
    report: &mut Report,
) -> Result<()> {
    report.model.clone_from(&description.model_name);
    rules::check(description, report);
    roles::check(description, report);
    aliases::check(description, report);
    let packed = description.generation_tool.starts_with(PACKER);
    audit::check(folder, options.glibc.as_ref(), packed, report)?;
    check_library(description, folder, options, report)
}

/// Unpacks an FMU and reads its description.
fn opened(path: &Path) -> Result<(Unpacked, Description)> {
    let unpacked = Unpacked::open(path)?;
    let description = described(unpacked.folder())?;
    Ok((unpacked, description))
}

/// Reads the description of an unpacked FMU.
fn described(folder: &Path) -> Result<Description> {
    let bytes = fs::read(folder.join(DESCRIPTION)).map_err(Error::io(DESCRIPTION))?;
    let text = text::read(&bytes, &mut Report::default());
    parsed::parse(&text.unwrap_or_default())
}

/// Whether a text names a file, and does not lead to one elsewhere.
fn is_file_name(text: &str) -> bool {
    !text.contains(['/', '\\', ':'])
}

/// Where the library for the machine that runs this program should be.
struct Library {
    member: String,
    path: PathBuf,
}

impl Library {
    fn of_this_machine(description: &Description, folder: &Path) -> Result<Self> {
        let (platform, extension) = library::platform()?;
        let co_simulation = description.co_simulation.as_ref();
        let name = co_simulation.map_or("", |found| &found.model_identifier);
        if !is_file_name(name) {
            return Err(Error::Identifier(name.into()));
        }
        let member = format!("binaries/{platform}/{name}.{extension}");
        let path = folder.join(&member);
        Ok(Self { member, path })
    }
}

fn check_library(
    description: &Description,
    folder: &Path,
    options: &Options,
    report: &mut Report,
) -> Result<()> {
    let Some(co_simulation) = &description.co_simulation else {
        return Ok(());
    };
    if !is_file_name(&co_simulation.model_identifier) {
        return Ok(()); // was found to be no C identifier; what lies there is no part of the FMU
    }
    let Library { member, path } = Library::of_this_machine(description, folder)?;
    if !path.is_file() {
        report.error(
            "2.3",
            format!("{member} is missing: the FMU does not run on this machine"),
        );
        return Ok(());
    }
    for probe in Probe::ALL {
        let goes_on = match &options.host {
            None => probe.run(description, folder, report)?,
            Some(program) => {
                let limit = options.limit;
                child::run(&child::Host { program, limit }, probe, folder, report)?
            }
        };
        if !goes_on {
            break;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package;

    /// A library of somebody else is neither loaded by a check nor by a replay.
    #[test]
    fn a_model_identifier_that_is_a_path_leads_nowhere() {
        let path = |name: &str| {
            std::env::temp_dir().join(format!("identifier-{}{name}", std::process::id()))
        };
        let (fmu, inputs, out) = (path(".fmu"), path("-in.csv"), path("-out.csv"));
        fs::write(&inputs, "time\n0\n1\n").unwrap();
        for name in ["../../libc", "/lib/libc", "..\\libc", "C:libc"] {
            let xml = format!(
                "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"A\" guid=\"g\">\
                 <CoSimulation modelIdentifier=\"{name}\"/></fmiModelDescription>"
            );
            package(&fmu, vec![(DESCRIPTION.into(), xml.into_bytes())]).unwrap();
            let said: Vec<_> = check(&fmu).unwrap().findings;
            let said: Vec<_> = said.iter().map(|finding| finding.text.as_str()).collect();
            assert_eq!(
                said,
                [format!("modelIdentifier {name:?} is no C identifier")]
            );
            let options = Replay {
                inputs: &inputs,
                step: 0.1,
                every: 1,
                out: &out,
                calls: None,
            };
            let refused = replay(std::slice::from_ref(&fmu), &options).unwrap_err();
            assert_eq!(
                refused.to_string(),
                format!("modelIdentifier {name:?} is a path")
            );
        }
        fs::remove_file(fmu).unwrap();
        fs::remove_file(inputs).unwrap();
    }
}
