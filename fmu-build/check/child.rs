//! Runs a probe in a process of its own and tells how it ended: an FMU that crashes, hangs or prints takes
//! nobody with it.

use super::probe::Probe;
use super::trace::{self, Line};
use super::{Report, unpack};
use crate::{Error, Result};
use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Between two looks at the process.
const PAUSE: Duration = Duration::from_millis(2);
/// Printed text that a finding shows [characters].
const SHOWN: usize = 120;

/// The program that runs probes, and its patience.
pub(super) struct Host<'a> {
    /// Called as `PROGRAM probe NAME FOLDER TRACE`.
    pub program: &'a Path,
    /// The longest that one call of the FMU may take.
    pub limit: Duration,
}

/// A folder for what the process leaves behind; removed on drop.
struct Trace(PathBuf);

impl Drop for Trace {
    fn drop(&mut self) {
        // Nobody waits for it: a folder that stays behind in the temporary directory does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

enum Ending {
    Exit(ExitStatus),
    Hung,
}

/// Runs a probe on the FMU that is unpacked in `folder`; whether others make sense after it.
pub(super) fn run(
    host: &Host<'_>,
    probe: Probe,
    folder: &Path,
    report: &mut Report,
) -> Result<bool> {
    let trace = Trace(unpack::new_folder()?);
    let ending = watch(spawn(host, probe, folder, &trace.0)?, &trace.0, host.limit)?;
    let mut end = None;
    for line in trace::lines(&trace.0) {
        match line {
            Line::Found(finding) => report.push(finding),
            Line::End(found) => end = Some(found),
        }
    }
    let printed = printed(&trace.0);
    let call = trace::call(&trace.0).1;
    match (judge(&ending, end.is_some(), &call, host.limit), printed) {
        (Some(text), Some(printed)) => {
            report.error("2.1", format!("{text}; before, it printed {printed:?}"));
        }
        (Some(text), None) => report.error("2.1", text),
        (None, Some(printed)) => {
            let text = format!("the library prints to the console: {printed:?}");
            report.warn("2.1.5", text);
        }
        (None, None) => {}
    }
    let end = end.unwrap_or_default();
    report.compared = report.compared.max(end.compared);
    Ok(end.runs)
}

fn spawn(host: &Host<'_>, probe: Probe, folder: &Path, trace: &Path) -> Result<Child> {
    let failed = |source| Error::Io {
        path: host.program.into(),
        source,
    };
    let output = File::create(output_file(trace)).map_err(failed)?;
    let errors = output.try_clone().map_err(failed)?;
    Command::new(host.program)
        .args(["probe", probe.name()])
        .args([folder, trace])
        .stdin(Stdio::piped()) // closed when this process ends: the other one ends, too
        .stdout(output)
        .stderr(errors)
        .spawn()
        .map_err(failed)
}

/// Waits for the end, or for a call that lasts longer than `limit`.
fn watch(mut child: Child, trace: &Path, limit: Duration) -> Result<Ending> {
    let failed = |source| Error::Io {
        path: trace.into(),
        source,
    };
    let (mut last, mut since) = (String::new(), Instant::now());
    loop {
        if let Some(status) = child.try_wait().map_err(failed)? {
            return Ok(Ending::Exit(status));
        }
        let (number, _) = trace::call(trace);
        if number != last {
            (last, since) = (number, Instant::now());
        } else if since.elapsed() > limit {
            child.kill().and_then(|()| child.wait()).map_err(failed)?;
            return Ok(Ending::Hung);
        }
        thread::sleep(PAUSE);
    }
}

/// What is wrong with how the process ended.
fn judge(ending: &Ending, complete: bool, call: &str, limit: Duration) -> Option<String> {
    let place = match call {
        "" => String::from("before its first call"),
        call => format!("in {call}"),
    };
    match ending {
        Ending::Hung => Some(format!(
            "did not answer within {} s {place}",
            limit.as_secs_f64()
        )),
        Ending::Exit(status) => match abnormal(*status) {
            Some(how) => Some(format!("crashed with {how} {place}")),
            None if !complete => Some(format!("ended the process that runs it {place}")),
            None => None,
        },
    }
}

#[cfg(unix)]
fn abnormal(status: ExitStatus) -> Option<String> {
    use std::os::unix::process::ExitStatusExt as _;
    let name = |signal| match signal {
        4 => " (illegal instruction)",
        6 => " (abort)",
        7 => " (bus error)",
        8 => " (arithmetic fault)",
        11 => " (invalid memory access)",
        _ => "",
    };
    let signal = status.signal()?;
    Some(format!("signal {signal}{}", name(signal)))
}

/// Windows has the number of the exception as exit code.
#[cfg(not(unix))]
fn abnormal(status: ExitStatus) -> Option<String> {
    let code = status.code().filter(|code| *code < 0)?;
    Some(format!("exception {code:#x}"))
}

fn output_file(trace: &Path) -> PathBuf {
    trace.join("output")
}

/// The first line of what was printed.
fn printed(trace: &Path) -> Option<String> {
    let mut bytes = Vec::new();
    let file = File::open(output_file(trace)).ok()?;
    file.take(1 << 16).read_to_end(&mut bytes).ok()?;
    let text = String::from_utf8_lossy(&bytes);
    let first = text.trim().lines().next().unwrap_or_default();
    let text: String = first.chars().take(SHOWN).collect();
    (!text.is_empty()).then_some(text)
}
