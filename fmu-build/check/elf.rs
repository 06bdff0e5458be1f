//! The symbols that a Linux library exports, read from its ELF file.

use super::{Report, native};
use crate::{Error, Result};
use std::fs;
use std::path::Path;

/// Size of an `Elf64_Shdr` and of an `Elf64_Sym` [bytes].
const SECTION: usize = 64;
const SYMBOL: usize = 24;
/// `sh_type` of the dynamic symbol table.
const DYNSYM: usize = 11;

/// Remarks on symbols that are not of FMI: they may clash with those of another FMU.
pub(super) fn check(path: &Path, report: &mut Report) -> Result<()> {
    let file = fs::read(path).map_err(|source| Error::Io {
        path: path.into(),
        source,
    })?;
    let exported = exports(&file).unwrap_or_default();
    for name in exported
        .iter()
        .filter(|name| !native::FUNCTIONS.contains(&name.as_str()))
    {
        report.remark(
            "2.1.1",
            format!("{name} is exported though no importer calls it"),
        );
    }
    Ok(())
}

/// Names of the defined global symbols; `None` when it is no 64-bit little-endian ELF file.
fn exports(file: &[u8]) -> Option<Vec<String>> {
    if !file.starts_with(&[0x7f, b'E', b'L', b'F', 2, 1]) {
        return None;
    }
    let sections = number(file, 0x28, 8)?;
    let count = number(file, 0x3c, 2)?;
    let header = |at: usize| file.get(sections + at * SECTION..)?.get(..SECTION);
    let table = (0..count)
        .filter_map(header)
        .find(|s| number(s, 4, 4) == Some(DYNSYM))?;
    let names = contents(file, header(number(table, 40, 4)?)?)?;
    let symbols = contents(file, table)?.chunks_exact(SYMBOL);
    symbols
        .filter(|symbol| is_exported(symbol))
        .map(|symbol| name(symbol, names))
        .collect()
}

/// Defined (section index not 0), and global or weak (binding 1 or 2).
fn is_exported(symbol: &[u8]) -> bool {
    let binding = number(symbol, 4, 1).map(|info| info >> 4);
    matches!(binding, Some(1 | 2)) && number(symbol, 6, 2) != Some(0)
}

fn name(symbol: &[u8], names: &[u8]) -> Option<String> {
    let text = names
        .get(number(symbol, 0, 4)?..)?
        .split(|byte| *byte == 0)
        .next()?;
    Some(String::from_utf8_lossy(text).into_owned())
}

/// The bytes a section header points at.
fn contents<'a>(file: &'a [u8], header: &[u8]) -> Option<&'a [u8]> {
    file.get(number(header, 24, 8)?..)?
        .get(..number(header, 32, 8)?)
}

/// The little-endian number of `size` bytes at `offset`.
fn number(bytes: &[u8], offset: usize, size: usize) -> Option<usize> {
    let field = bytes.get(offset..)?.get(..size)?;
    let value = field
        .iter()
        .rev()
        .fold(0_u64, |value, byte| value << 8 | u64::from(*byte));
    usize::try_from(value).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The C library this test runs with.
    #[cfg(target_os = "linux")]
    fn c_library() -> Vec<u8> {
        let maps = fs::read_to_string("/proc/self/maps").unwrap();
        let mut paths = maps
            .lines()
            .filter_map(|line| line.split_whitespace().nth(5));
        fs::read(paths.find(|path| path.contains("libc.so")).unwrap()).unwrap()
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn exported_symbols_are_listed_and_imported_ones_are_not() {
        let names = exports(&c_library()).unwrap();
        assert!(names.iter().any(|name| name == "malloc"));
        // Defined by the dynamic loader, used by the C library.
        assert!(!names.iter().any(|name| name == "__tls_get_addr"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_without_its_end_has_no_section_table() {
        let file = c_library();
        let half = file.len() / 2;
        for length in (0..half).step_by(half / 50) {
            assert!(exports(&file[..length]).is_none(), "{length} bytes");
        }
    }

    #[test]
    fn other_files_have_no_elf_symbols() {
        assert_eq!(exports(b"MZ"), None);
        assert_eq!(exports(b""), None);
    }
}
