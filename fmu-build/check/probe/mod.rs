//! What is tried with an FMU's library: each probe begins with a library that was loaded just now.

mod life;
mod session;
mod value;

use super::native::Binary;
use super::parsed::Description;
use super::trace::{self, End, Line};
use super::{Library, Report};
use crate::{Error, Result};
use session::Session;
pub(super) use session::resource_uri;
use std::path::Path;
use std::{process, thread};

/// A group of trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Probe {
    /// The life cycle, and every start value.
    Life,
}

impl Probe {
    /// The first tells whether the others make sense.
    pub(super) const ALL: [Self; 1] = [Self::Life];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Life => "life",
        }
    }

    /// Tries the FMU that is unpacked in `folder`; whether other probes make sense after it.
    pub(super) fn run(
        self,
        description: &Description,
        folder: &Path,
        report: &mut Report,
    ) -> Result<bool> {
        let library = Library::of_this_machine(description, folder)?;
        let binary = match Binary::load(&library.path) {
            Ok(binary) => binary,
            Err(error) => {
                report.error("2.3", format!("the library cannot be loaded: {error}"));
                return Ok(false);
            }
        };
        let missing = binary.missing();
        for name in &missing {
            report.error(
                "2.1.1",
                format!("{} does not export {name}", library.member),
            );
        }
        if !missing.is_empty() {
            return Ok(false);
        }
        let session = Session::new(&binary, description, folder);
        match self {
            Self::Life => life::check(&session, report),
        }
    }
}

/// Runs the probe `name` on the FMU that is unpacked in `folder` and writes what it finds to `trace`: what
/// [`check_with`](super::check_with) has another process do.
///
/// # Errors
/// When there is no such probe, or a file cannot be read or written.
pub fn probe(name: &str, folder: &Path, trace: &Path) -> Result<()> {
    let io = |source| Error::Io {
        path: trace.into(),
        source,
    };
    let found = Probe::ALL.into_iter().find(|probe| probe.name() == name);
    let found = found.ok_or_else(|| Error::UnknownProbe { name: name.into() })?;
    end_with_parent();
    trace::start(trace).map_err(io)?;
    let description = super::described(folder)?;
    let mut report = Report::written_to(trace);
    let runs = found.run(&description, folder, &mut report)?;
    let end = End {
        compared: report.compared,
        runs,
    };
    trace::write(trace, &Line::End(end)).map_err(io)
}

/// The other end of standard input closes when the process that watches this one is gone.
fn end_with_parent() {
    thread::spawn(|| {
        let read = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        process::exit(i32::from(read.is_err()));
    });
}
