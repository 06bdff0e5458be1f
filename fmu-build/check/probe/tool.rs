//! Whether a library needs a tool of its vendor: what it says, and what it does.

use super::super::Report;
use super::session::Session;
use crate::Result;
use std::{fs, process};

pub(super) fn check(session: &Session<'_>, report: &mut Report) -> Result<()> {
    if session.can(|can| can.needs_tool) {
        let text = "needsExecutionTool is true: it runs only where that tool is installed";
        report.warn("4.3.1", text);
        return Ok(());
    }
    if !report.is_of_one_process() {
        return Ok(()); // whose children others may start
    }
    let run = session.run()?;
    run.step(session.step())?;
    for name in children() {
        let text =
            format!("the library starts the program {name}, but needsExecutionTool is not true");
        report.warn("4.3.1", text);
    }
    Ok(())
}

/// Names of the programs that this process has started, where the system has `/proc`.
fn children() -> Vec<String> {
    let me = process::id().to_string();
    let running = fs::read_dir("/proc").into_iter().flatten().flatten();
    let states = running.filter_map(|entry| fs::read_to_string(entry.path().join("stat")).ok());
    let started = states.filter_map(|state| {
        // number (name) state parent …; a name may hold blanks and brackets
        let (head, rest) = state.rsplit_once(") ")?;
        let (_, name) = head.split_once(" (")?;
        let parent = rest.split(' ').nth(1)?;
        (parent == me).then(|| name.to_owned())
    });
    started.collect()
}
