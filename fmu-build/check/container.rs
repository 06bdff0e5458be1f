//! The ZIP file itself: what some importer's archive library does not read. FMI 2.0.4, 2.3.
//!
//! Read from the central directory, byte by byte: a library for archives hides what it can handle.

use super::Report;
use crate::{Error, Result, archive};
use std::collections::BTreeSet;
use std::io::Read as _;
use std::path::Path;

const DIRECTORY_END: &[u8] = b"PK\x05\x06";
const ENTRY: &[u8] = b"PK\x01\x02";
/// Length of an entry without its name, its extra field and its comment.
const ENTRY_LENGTH: usize = 46;

const STORED: usize = 0;
const DEFLATED: usize = 8;
/// Bits of the general purpose flag.
const ENCRYPTED: usize = 1;
const SIZES_FOLLOW: usize = 1 << 3;

/// What the central directory says of a member.
struct Entry<'a> {
    name: &'a [u8],
    flags: usize,
    method: usize,
}

/// Checks the archive at `path`.
pub(super) fn check(path: &Path, report: &mut Report) -> Result<()> {
    let mut bytes = Vec::new();
    let read = archive::file(path)?.read_to_end(&mut bytes);
    read.map_err(Error::io(path))?;
    judge(&entries(&bytes), report);
    Ok(())
}

fn judge(entries: &[Entry<'_>], report: &mut Report) {
    let mut names = BTreeSet::new();
    for entry in entries {
        let name = String::from_utf8_lossy(entry.name);
        if entry.flags & ENCRYPTED != 0 {
            report.error("2.3", format!("{name} is encrypted"));
        }
        if ![STORED, DEFLATED].contains(&entry.method) {
            let method = entry.method;
            let text = format!("{name} is compressed by method {method}; importers know 0 and 8");
            report.error("2.3", text);
        }
        if entry.method == STORED && entry.flags & SIZES_FOLLOW != 0 {
            let text =
                format!("{name} is stored with its size behind it: not to be read as a stream");
            report.warn("2.3", text);
        }
        if !entry.name.is_ascii() {
            report.warn(
                "2.3",
                format!("{name} has letters that not every importer can read"),
            );
        }
        if !names.insert(name.to_lowercase()) {
            let text = format!("{name} is there twice where file names have no upper case");
            report.error("2.3", text);
        }
    }
}

/// Members in the order of the directory; what does not look like one ends it.
fn entries(bytes: &[u8]) -> Vec<Entry<'_>> {
    let found = bytes
        .windows(DIRECTORY_END.len())
        .rposition(|part| part == DIRECTORY_END);
    let start = found
        .and_then(|end| number(bytes, end + 16, 4))
        .unwrap_or(0);
    let (mut rest, mut all) = (bytes.get(start..).unwrap_or_default(), Vec::new());
    while let Some((entry, length)) = first(rest) {
        all.push(entry);
        rest = rest.get(length..).unwrap_or_default();
    }
    all
}

/// The entry that begins the bytes, and its length.
fn first(bytes: &[u8]) -> Option<(Entry<'_>, usize)> {
    if !bytes.starts_with(ENTRY) {
        return None;
    }
    let [name, extra, comment] = [28, 30, 32].map(|at| number(bytes, at, 2));
    let (name, more) = (name?, extra? + comment?);
    let entry = Entry {
        flags: number(bytes, 8, 2)?,
        method: number(bytes, 10, 2)?,
        name: bytes.get(ENTRY_LENGTH..ENTRY_LENGTH + name)?,
    };
    Some((entry, ENTRY_LENGTH + name + more))
}

/// A number of so many bytes, the lowest first.
fn number(bytes: &[u8], at: usize, length: usize) -> Option<usize> {
    let part = bytes.get(at..at + length)?;
    Some(
        part.iter()
            .rev()
            .fold(0, |sum, byte| sum * 256 + usize::from(*byte)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Cursor, Write as _};
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    /// Members, bytes of the first entry with their values, what is to be found.
    type Case = (
        &'static [&'static str],
        &'static [(usize, u8)],
        &'static str,
    );

    /// An archive of these members, with some bytes of the first entry written over.
    fn findings(names: &[&str], over: &[(usize, u8)]) -> String {
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        for name in names {
            writer
                .start_file(*name, SimpleFileOptions::default())
                .unwrap();
            writer.write_all(b"text").unwrap();
        }
        let mut bytes = writer.finish().unwrap().into_inner();
        let at = bytes.windows(4).position(|part| part == ENTRY).unwrap();
        for (offset, value) in over {
            bytes[at + offset] = *value;
        }
        let mut report = Report::default();
        judge(&entries(&bytes), &mut report);
        report
            .findings
            .iter()
            .map(|finding| format!("{finding}\n"))
            .collect()
    }

    #[test]
    fn what_an_importer_may_not_read_is_found_and_the_rest_is_left_alone() {
        const USUAL: [&str; 2] = ["modelDescription.xml", "binaries/linux64/A.so"];
        assert_eq!(findings(&USUAL, &[]), "");
        let cases: [Case; 5] = [
            (&USUAL, &[(8, 1)], "modelDescription.xml is encrypted"),
            (&USUAL, &[(10, 93)], "compressed by method 93"),
            (&USUAL, &[(8, 8), (10, 0)], "size behind it"),
            (&["resources/Stra\u{df}e"], &[], "letters"),
            (&["a/B", "A/b"], &[], "A/b is there twice"),
        ];
        for (names, over, expected) in cases {
            let found = findings(names, over);
            assert!(found.contains(expected), "{expected}: {found}");
        }
    }

    #[test]
    fn bytes_that_are_no_archive_have_no_entries() {
        assert!(entries(b"").is_empty());
        assert!(entries(b"PK\x05\x06PK\x01\x02").is_empty());
        assert!(entries(&[b'P', b'K', 5, 6].repeat(9)).is_empty());
    }
}
