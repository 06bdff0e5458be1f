//! What is tried with an FMU's library: each probe begins with a library that was loaded just now.

mod asynchronous;
mod dependencies;
mod derivatives;
mod life;
mod repeat;
mod resources;
mod session;
mod settings;
mod slopes;
mod states;
mod stimuli;
mod tool;
mod value;

use super::native::Binary;
use super::parsed::Description;
use super::trace::{self, End, Line};
use super::{Library, Report, audit};
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
    /// The same run after fmi2Reset, in a new instance, beside another one.
    Repeat,
    /// FMU states, in memory and as bytes.
    States,
    /// Dependencies that ModelStructure does not name.
    Dependencies,
    /// What is set stays set; memory, log categories, fmi2CancelStep.
    Settings,
    /// Directional derivatives.
    Derivatives,
    /// Slopes of inputs and outputs, steps of another size.
    Slopes,
    /// Steps that are still being computed when fmi2DoStep returns.
    Asynchronous,
    /// Resources in a folder with a name that is encoded.
    Resources,
    /// Programs that the library starts.
    Tool,
}

impl Probe {
    /// The first tells whether the others make sense.
    pub(super) const ALL: [Self; 10] = [
        Self::Life,
        Self::Repeat,
        Self::States,
        Self::Dependencies,
        Self::Settings,
        Self::Derivatives,
        Self::Slopes,
        Self::Asynchronous,
        Self::Resources,
        Self::Tool,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Life => "life",
            Self::Repeat => "repeat",
            Self::States => "states",
            Self::Dependencies => "dependencies",
            Self::Settings => "settings",
            Self::Derivatives => "derivatives",
            Self::Slopes => "slopes",
            Self::Asynchronous => "asynchronous",
            Self::Resources => "resources",
            Self::Tool => "tool",
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
        audit::lacks(&library.member, &missing, report);
        if !missing.is_empty() {
            return Ok(false);
        }
        let session = Session::new(&binary, description, folder);
        let tried = match self {
            Self::Life => return life::check(&session, report),
            Self::Repeat => repeat::check(&session, report),
            Self::States => states::check(&session, report),
            Self::Dependencies => dependencies::check(&session, report),
            Self::Settings => settings::check(&session, report),
            Self::Derivatives => derivatives::check(&session, report),
            Self::Slopes => slopes::check(&session, report),
            Self::Asynchronous => asynchronous::check(&session, report),
            Self::Resources => resources::check(&session, folder, report),
            Self::Tool => tool::check(&session, report),
        };
        refusal(tried, &session, report).map(|()| true)
    }
}

/// A refused call ends a probe. It is a finding; one of a step may be due to its size, if no size is proposed.
fn refusal(tried: Result<()>, session: &Session<'_>, report: &mut Report) -> Result<()> {
    let Err(Error::Refused {
        function,
        status,
        messages,
    }) = tried
    else {
        return tried;
    };
    let text = format!("{function} returns fmi2Status {status}: {messages}");
    let guessed = session.description.experiment.step.is_none();
    if function == "fmi2DoStep" && guessed && !session.can(|can| can.variable_step) {
        let step = session.step();
        let text = format!("{text} (a step of {step} s, as the description proposes none)");
        report.warn("2.1", text);
    } else {
        report.error("2.1", text);
    }
    Ok(())
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
