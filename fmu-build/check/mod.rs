//! Opens an FMU as an importer would and compares what it says with what it does.
//!
//! ```text
//! .fmu ─unpack─> modelDescription.xml ─parse─> rules on the text ┐
//!            └─> binaries/…  ─load─> symbols, life cycle, values ┴─> Report
//! ```

mod audit;
mod container;
mod native;
mod parsed;
mod replay;
mod roles;
mod rules;
mod run;
mod unpack;

use crate::binary::Version;
use crate::{Result, library};
use parsed::Description;
use std::path::{Path, PathBuf};
use std::{fmt, fs};
use unpack::Unpacked;

pub use replay::{Replay, replay};

/// Some importers' XML parsers stop at it.
const BYTE_ORDER_MARK: &str = "\u{feff}";

/// What a check found.
#[derive(Debug, Default)]
pub struct Report {
    /// `modelName`.
    pub model: String,
    /// Start values that were read from the library and compared with the description.
    pub compared: usize,
    /// What is wrong or remarkable, in the order in which it was seen.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Whether the FMU breaks no rule; remarks do not count.
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

    fn error(&mut self, clause: &'static str, text: impl Into<String>) {
        let text = text.into();
        self.findings.push(Finding {
            severity: Severity::Error,
            clause,
            text,
        });
    }

    fn remark(&mut self, clause: &'static str, text: impl Into<String>) {
        let text = text.into();
        self.findings.push(Finding {
            severity: Severity::Remark,
            clause,
            text,
        });
    }
}

/// One thing that is wrong or remarkable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// Clause of the FMI 2.0.4 standard that it concerns.
    pub clause: &'static str,
    /// A sentence.
    pub text: String,
}

/// How bad a [`Finding`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// The standard is broken: some importer will fail.
    Error,
    /// Legal but seldom meant.
    Remark,
}

impl Severity {
    fn word(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Remark => "remark",
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = self.severity.word();
        write!(f, "{severity} (FMI 2.0.4, {}): {}", self.clause, self.text)
    }
}

/// Checks the FMI 2.0 co-simulation FMU at `path`.
///
/// Runs the FMU's code in this process: check only FMUs whose origin is known.
///
/// # Errors
/// When the file cannot be opened at all; everything else is a finding.
pub fn check(path: &Path) -> Result<Report> {
    check_for(path, None)
}

/// Like [`check`]; a Linux library that asks for a newer glibc than `glibc` is an error.
///
/// # Errors
/// When the file cannot be opened at all; everything else is a finding.
pub fn check_for(path: &Path, glibc: Option<&Version>) -> Result<Report> {
    let (unpacked, description) = opened(path)?;
    let mut report = Report {
        model: description.model_name.clone(),
        ..Report::default()
    };
    let file = unpacked.folder().join("modelDescription.xml");
    if fs::read(&file).is_ok_and(|bytes| bytes.starts_with(BYTE_ORDER_MARK.as_bytes())) {
        report.error("2.2", "modelDescription.xml begins with a byte order mark");
    }
    container::check(path, &mut report)?;
    rules::check(&description, &mut report);
    roles::check(&description, &mut report);
    audit::check(unpacked.folder(), glibc, &mut report)?;
    check_library(&description, unpacked.folder(), &mut report)?;
    Ok(report)
}

/// Unpacks an FMU and reads its description.
fn opened(path: &Path) -> Result<(Unpacked, Description)> {
    let unpacked = Unpacked::open(path)?;
    let file = unpacked.folder().join("modelDescription.xml");
    let text = fs::read_to_string(&file).map_err(|source| crate::Error::Io {
        path: "modelDescription.xml".into(),
        source,
    })?;
    let description = parsed::parse(text.trim_start_matches(BYTE_ORDER_MARK))?;
    Ok((unpacked, description))
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
        let member = format!("binaries/{platform}/{name}.{extension}");
        let path = folder.join(&member);
        Ok(Self { member, path })
    }
}

fn check_library(description: &Description, folder: &Path, report: &mut Report) -> Result<()> {
    if description.co_simulation.is_none() {
        return Ok(());
    }
    let Library { member, path } = Library::of_this_machine(description, folder)?;
    if !path.is_file() {
        report.error(
            "2.3",
            format!("{member} is missing: the FMU does not run on this machine"),
        );
        return Ok(());
    }
    run::check(&path, folder, description, report)
}
