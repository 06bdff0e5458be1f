//! What a process that runs an FMU's code leaves behind for the one that watches it, in a folder of its own.
//!
//! `call` names the C function that is under way; `findings` has one JSON object a line. A process that
//! crashes or hangs can say nothing any more, these files still can.

use super::Finding;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek as _, Write as _};
use std::path::Path;

const CALL: &str = "call";
const FINDINGS: &str = "findings";

/// A line of `findings`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum Line {
    Found(Finding),
    /// The last line: the probe came to its end.
    End(End),
}

/// What a probe knows at its end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct End {
    /// Start values that were compared.
    pub compared: usize,
    /// Whether the FMU can be instantiated and initialised, so that further probes make sense.
    pub runs: bool,
}

thread_local! {
    /// Where calls are announced, and how many were.
    static CALLS: RefCell<Option<(File, u64)>> = const { RefCell::new(None) };
}

/// Announces every call of this thread in `folder` from now on.
pub(super) fn start(folder: &Path) -> io::Result<()> {
    let file = File::create(folder.join(CALL))?;
    CALLS.set(Some((file, 0)));
    Ok(())
}

/// Tells which call is made next. A process that nobody watches does nothing.
pub(super) fn announce(call: &str) {
    CALLS.with_borrow_mut(|calls| {
        if let Some((file, number)) = calls {
            *number += 1;
            let record = format!("{number:020} {call:<40}");
            // Whoever watches sees an older call then: the finding is less exact, not wrong.
            let _ = file
                .rewind()
                .and_then(|()| file.write_all(record.as_bytes()));
        }
    });
}

/// The number of the call under way and its name; nothing before the first one.
pub(super) fn call(folder: &Path) -> (String, String) {
    let text = fs::read_to_string(folder.join(CALL)).unwrap_or_default();
    let (number, name) = text.split_once(' ').unwrap_or_default();
    (number.into(), name.trim_end().into())
}

/// Appends a line to the findings.
pub(super) fn write(folder: &Path, line: &Line) -> io::Result<()> {
    let mut file = OpenOptions::new()
        .create(true)
        .append(true)
        .open(folder.join(FINDINGS))?;
    let text = serde_json::to_string(line)?;
    file.write_all(format!("{text}\n").as_bytes())
}

/// The lines written so far; one that was cut short is left out.
pub(super) fn lines(folder: &Path) -> Vec<Line> {
    let text = fs::read_to_string(folder.join(FINDINGS)).unwrap_or_default();
    text.lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Severity, unpack};
    use super::*;

    #[test]
    fn what_a_process_leaves_behind_can_be_read() {
        let folder = unpack::new_folder().unwrap();
        assert_eq!(call(&folder), (String::new(), String::new()));
        start(&folder).unwrap();
        announce("fmi2GetRealOutputDerivatives");
        announce("fmi2DoStep");
        assert_eq!(call(&folder).1, "fmi2DoStep");
        let finding = Finding {
            severity: Severity::Error,
            clause: "2.1".into(),
            text: "a \"text\"\nof two lines".into(),
        };
        write(&folder, &Line::Found(finding.clone())).unwrap();
        write(
            &folder,
            &Line::End(End {
                compared: 3,
                runs: true,
            }),
        )
        .unwrap();
        let lines = lines(&folder);
        assert!(matches!(&lines[0], Line::Found(found) if *found == finding));
        assert!(matches!(
            &lines[1],
            Line::End(End {
                compared: 3,
                runs: true
            })
        ));
        fs::remove_dir_all(&folder).unwrap();
    }
}
