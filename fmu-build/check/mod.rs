//! Opens an FMU as an importer would and compares what it says with what it does.
//!
//! ```text
//! .fmu ─unpack─> modelDescription.xml ─parse─> rules on the text ┐
//!            └─> binaries/…  ─load─> symbols, life cycle, values ┴─> Report
//! ```

mod audit;
mod native;
mod parsed;
mod rules;
mod run;
mod unpack;

use crate::binary::Version;
use crate::{Result, library};
use parsed::Description;
use std::path::Path;
use std::{fmt, fs};
use unpack::Unpacked;

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

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Remark => "remark",
        };
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
    let unpacked = Unpacked::open(path)?;
    let file = unpacked.folder().join("modelDescription.xml");
    let text = fs::read_to_string(&file).map_err(|source| crate::Error::Io {
        path: "modelDescription.xml".into(),
        source,
    })?;
    let description = parsed::parse(&text)?;
    let mut report = Report {
        model: description.model_name.clone(),
        ..Report::default()
    };
    rules::check(&description, &mut report);
    audit::check(unpacked.folder(), glibc, &mut report)?;
    check_library(&description, unpacked.folder(), &mut report)?;
    Ok(report)
}

fn check_library(description: &Description, folder: &Path, report: &mut Report) -> Result<()> {
    let Some(co_simulation) = &description.co_simulation else {
        return Ok(());
    };
    let (platform, extension) = library::platform()?;
    let member = format!(
        "binaries/{platform}/{}.{extension}",
        co_simulation.model_identifier
    );
    let path = folder.join(&member);
    if !path.is_file() {
        report.error(
            "2.3",
            format!("{member} is missing: the FMU does not run on this machine"),
        );
        return Ok(());
    }
    run::check(&path, folder, description, report)
}
