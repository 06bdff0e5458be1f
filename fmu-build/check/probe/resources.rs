//! Whether an FMU finds its resources in a folder whose name a URI has to encode.

use super::super::Report;
use super::super::native::take_messages;
use super::session::{Session, resource_uri};
use crate::Result;
use std::fs;
use std::path::Path;

/// A blank, a percent sign and a letter that is none of ASCII: `C:\Users\Jürgen Maier` is a common place.
const NAME: &str = "a b%20 \u{e4}";

/// The folder is reached by a link with that name; where none can be made, nothing is tried.
pub(super) fn check(session: &Session<'_>, folder: &Path, report: &mut Report) -> Result<()> {
    let link = folder.join(NAME);
    if !has_files(&folder.join("resources")) || !linked(folder, &link) {
        return Ok(());
    }
    take_messages();
    let guid = &session.description.guid;
    let made = session
        .binary
        .instantiate(guid, &resource_uri(&link), true)?;
    if made.is_none() {
        let messages = take_messages().join("; ");
        let text = format!(
            "no instance where resources lie in a folder {NAME:?}, which their URI encodes: {messages}"
        );
        report.error("2.1.5", text);
    }
    Ok(())
}

fn has_files(folder: &Path) -> bool {
    fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some())
}

#[cfg(unix)]
fn linked(folder: &Path, link: &Path) -> bool {
    std::os::unix::fs::symlink(folder, link).is_ok()
}

#[cfg(not(unix))]
fn linked(_: &Path, _: &Path) -> bool {
    false
}
