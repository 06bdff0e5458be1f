//! The libraries of an FMU, whatever machine they are for: read from their files, not run.

use super::{Report, Severity, native};
use crate::binary::{Binary, Version};
use crate::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// The glibc of RHEL 7 and manylinux2014: libraries that need no newer one load on every Linux of today.
const OLDEST: &str = "2.17";
/// Part of every compiler for Linux, though not of every Linux.
const OF_COMPILER: &str = "libgcc_s.so.";

/// Libraries that are part of the systems themselves; names of Windows in lower case.
const SYSTEM: [&str; 16] = [
    "libc.so.",
    "libm.so.",
    "libdl.so.",
    "libpthread.so.",
    "librt.so.",
    "libgcc_s.so.",
    "ld-linux",
    "linux-vdso",
    "kernel32.dll",
    "ntdll.dll",
    "msvcrt.dll",
    "ucrtbase.dll",
    "api-ms-win-",
    "advapi32.dll",
    "/usr/lib/libsystem",
    "user32.dll",
];

/// Checks every library in `binaries/` of the unpacked FMU `folder`.
///
/// What the standard leaves open is a warning, but an error in FMUs that this program `packed`: exports,
/// libraries of others, folders and files of the machine it was built on.
pub(super) fn check(
    folder: &Path,
    glibc: Option<&Version>,
    packed: bool,
    report: &mut Report,
) -> Result<()> {
    let level = if packed {
        Severity::Error
    } else {
        Severity::Warning
    };
    for (platform, path) in libraries(folder)? {
        let bytes = fs::read(&path).map_err(|source| failed(&path, source))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let name = format!("binaries/{platform}/{name}");
        match Binary::read(&bytes) {
            Some(binary) => {
                judge(&name, &platform, &binary, level, report);
                judge_glibc(&name, &binary, glibc, report);
            }
            None => report.error("2.3", format!("{name} is no dynamic library, or damaged")),
        }
        if let Some(path) = source_path(&bytes) {
            let text = format!("{name} names {path}, a file of the machine it was built on");
            report.find(level, "2.3", text);
        }
    }
    Ok(())
}

fn failed(path: &Path, source: std::io::Error) -> Error {
    Error::Io {
        path: path.into(),
        source,
    }
}

/// The libraries with the folder they are in, sorted; what is no library by its ending is left out.
fn libraries(folder: &Path) -> Result<Vec<(String, PathBuf)>> {
    let (mut found, binaries) = (Vec::new(), folder.join("binaries"));
    if !binaries.is_dir() {
        return Ok(found);
    }
    for platform in entries(&binaries)? {
        for file in entries(&platform)? {
            let ending = file.extension().unwrap_or_default();
            if ["so", "dll", "dylib"].iter().any(|known| ending == *known) {
                let name = platform.file_name().unwrap_or_default().to_string_lossy();
                found.push((name.into_owned(), file));
            }
        }
    }
    found.sort();
    Ok(found)
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let read = fs::read_dir(folder).map_err(|source| failed(folder, source))?;
    read.map(|entry| Ok(entry.map_err(|source| failed(folder, source))?.path()))
        .collect()
}

fn judge(name: &str, platform: &str, binary: &Binary, level: Severity, report: &mut Report) {
    if !binary.platforms.contains(&platform) {
        let right = binary.platforms.first().unwrap_or(&"no platform of FMI");
        report.error("2.3", format!("{name} is a library for {right}"));
    }
    let exported = |name: &&&str| binary.exports.iter().any(|export| export == **name);
    let missing = native::FUNCTIONS.iter().filter(|name| !exported(name));
    lacks(name, &missing.copied().collect::<Vec<_>>(), report);
    judge_exports(name, binary, level, report);
    for library in binary
        .libraries
        .iter()
        .filter(|library| !is_system(library))
    {
        let text = format!("{name} needs {library}, which is no part of the operating system");
        report.find(level, "2.3", text);
    }
    if let Some(path) = &binary.search_path {
        let text = format!("{name} makes the loader search {path}, a folder of another machine");
        report.find(level, "2.3", text);
    }
}

/// Reports the functions of FMI 2.0 that a library lacks.
pub(super) fn lacks(name: &str, functions: &[&str], report: &mut Report) {
    if !functions.is_empty() {
        let text = format!("{name} does not export {}", functions.join(", "));
        report.error("2.1.1", text);
    }
}

/// Symbols that no importer looks up: each can clash with one of the same name in another library.
fn judge_exports(name: &str, binary: &Binary, level: Severity, report: &mut Report) {
    // One library may serve model exchange and FMI 3.0, too.
    let others = binary.exports.iter().filter(|export| {
        let known = ["fmi2", "fmi3"]
            .iter()
            .any(|begin| export.starts_with(begin));
        !known
    });
    let others: Vec<_> = others.collect();
    if let [first, more @ ..] = others.as_slice() {
        let more = match more.len() {
            0 => String::new(),
            count => format!(" and {count} more symbols"),
        };
        let text = format!("{name} exports {first}{more}, which no importer calls");
        report.find(level, "2.1.1", text);
    }
}

fn is_system(library: &str) -> bool {
    let name = library.to_lowercase();
    SYSTEM.iter().any(|begin| name.starts_with(begin))
}

/// What a Linux library asks of its system: errors where the user said what it may ask for.
fn judge_glibc(name: &str, binary: &Binary, wanted: Option<&Version>, report: &mut Report) {
    let oldest = OLDEST.parse().ok();
    let limit = wanted.or(oldest.as_ref());
    if let (Some(found), Some(limit)) = (&binary.glibc, limit)
        && found > limit
    {
        let text = format!("{name} needs glibc {found}: no Linux with an older one loads it");
        match wanted {
            Some(wanted) => report.error("2.3", format!("{text}, and it shall run with {wanted}")),
            None => report.warn("2.3", text),
        }
    }
    for library in binary
        .libraries
        .iter()
        .filter(|l| l.starts_with(OF_COMPILER))
    {
        report.warn(
            "2.3",
            format!("{name} needs {library}, which small Linux systems lack"),
        );
    }
}

/// The first absolute name of a source file, e.g. of a panic message; `/rustc/` stands for the Rust
/// standard library on every machine.
fn source_path(bytes: &[u8]) -> Option<String> {
    let printable = |byte: &u8| byte.is_ascii_graphic() || *byte == b' ';
    let texts = bytes
        .split(|byte| !printable(byte))
        .filter(|text| text.len() > 8);
    let mut names = texts.flat_map(|text| text.split(|byte| *byte == b' '));
    let name = names.find(|name| is_source_path(name))?;
    Some(String::from_utf8_lossy(name).into_owned())
}

fn is_source_path(name: &[u8]) -> bool {
    const HOMES: [&[u8]; 5] = [
        b"/home/",
        b"/root/",
        b"/Users/",
        b"/builds/",
        b"C:\\Users\\",
    ];
    HOMES.iter().any(|home| name.starts_with(home))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_source_files_are_found_and_those_of_the_standard_library_are_not() {
        let bytes = b"\0\x01/rustc/59807/library/core/src/num.rs\0/home/me/fmu/lib.rs\0";
        assert_eq!(source_path(bytes).as_deref(), Some("/home/me/fmu/lib.rs"));
        assert_eq!(
            source_path(b"a text about / and /rustc/x.rs, long enough"),
            None
        );
    }

    #[test]
    fn system_libraries_are_known_on_all_systems() {
        for name in [
            "libc.so.6",
            "KERNEL32.dll",
            "api-ms-win-core-synch-l1-2-0.dll",
        ] {
            assert!(is_system(name), "{name}");
        }
        assert!(!is_system("libstdc++.so.6") && !is_system("libcurl.so.4"));
    }

    /// A library with everything that the standard leaves open.
    fn open() -> Binary {
        let exports = native::FUNCTIONS
            .iter()
            .copied()
            .chain(["a", "b", "fmi2SetTime"]);
        Binary {
            platforms: &["linux64"],
            exports: exports.map(str::to_owned).collect(),
            libraries: vec!["libcurl.so.4".into(), "libgcc_s.so.1".into()],
            glibc: Version::parse("GLIBC_2.33"),
            search_path: Some("/opt".into()),
        }
    }

    #[test]
    fn what_the_standard_leaves_open_is_an_error_in_what_this_program_packs() {
        for (level, errors) in [(Severity::Warning, 0), (Severity::Error, 3)] {
            let mut report = Report::default();
            judge("A.so", "linux64", &open(), level, &mut report);
            judge_glibc("A.so", &open(), None, &mut report);
            let texts: Vec<_> = report.findings.iter().map(|f| f.text.as_str()).collect();
            assert_eq!(
                texts,
                [
                    "A.so exports a and 1 more symbols, which no importer calls",
                    "A.so needs libcurl.so.4, which is no part of the operating system",
                    "A.so makes the loader search /opt, a folder of another machine",
                    "A.so needs glibc 2.33: no Linux with an older one loads it",
                    "A.so needs libgcc_s.so.1, which small Linux systems lack",
                ]
            );
            let wrong = report
                .findings
                .iter()
                .filter(|f| f.severity == Severity::Error);
            assert_eq!(wrong.count(), errors);
        }
    }

    #[test]
    fn a_library_in_the_wrong_folder_is_an_error() {
        let binary = Binary {
            platforms: &["win64"],
            exports: native::FUNCTIONS[1..]
                .iter()
                .map(|&name| name.into())
                .collect(),
            libraries: vec!["foo.dll".into()],
            glibc: Version::parse("GLIBC_2.33"),
            search_path: Some("/opt".into()),
        };
        let mut report = Report::default();
        judge(
            "binaries/linux64/A.so",
            "linux64",
            &binary,
            Severity::Warning,
            &mut report,
        );
        judge_glibc(
            "A.so",
            &binary,
            Version::parse("GLIBC_2.17").as_ref(),
            &mut report,
        );
        let texts: Vec<_> = report.findings.iter().map(ToString::to_string).collect();
        for text in [
            "library for win64",
            "fmi2GetTypesPlatform",
            "foo.dll",
            "/opt",
            "glibc 2.33",
        ] {
            assert!(
                texts.iter().any(|finding| finding.contains(text)),
                "{text}: {texts:?}"
            );
        }
        assert_eq!(texts.len(), 5);
    }
}
