//! What a dynamic library of any platform tells about itself, read from its file without loading it.

use object::read::elf::ElfFile64;
use object::read::{ImportFlags, NameOrOrdinal};
use object::{Architecture, BinaryFormat, Endianness, File, Object as _, elf};
use std::collections::BTreeSet;
use std::fmt;

/// The facts of a library that an importer depends on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Binary {
    /// Folders of `binaries/` that may hold it; empty when FMI names none for its machine.
    pub platforms: &'static [&'static str],
    /// Symbols it exports, sorted.
    pub exports: Vec<String>,
    /// Libraries it needs, sorted.
    pub libraries: Vec<String>,
    /// The newest glibc symbols it asks for: it runs with that glibc and later ones.
    pub glibc: Option<Version>,
    /// Folders it tells the loader to search: those of the machine it was built on.
    pub search_path: Option<String>,
}

/// A version of glibc, e.g. 2.17.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version(Vec<u32>);

impl Version {
    /// The version of a symbol, e.g. `GLIBC_2.17`; `None` when it is of another library.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        text.strip_prefix("GLIBC_")?.parse().ok()
    }
}

impl std::str::FromStr for Version {
    type Err = std::num::ParseIntError;

    /// Reads `2.17`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.split('.')
            .map(str::parse)
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers: Vec<_> = self.0.iter().map(u32::to_string).collect();
        f.write_str(&numbers.join("."))
    }
}

impl Binary {
    /// Reads a library; `None` when it is none of ELF, PE and Mach-O, or damaged.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let file = File::parse(bytes).ok()?;
        let libraries = file.import_libraries().ok()?;
        let libraries = libraries.map(|library| Some(text(library.ok()?.name())));
        Some(Self {
            platforms: platforms(&file),
            exports: exports(&file)?.into_iter().collect(),
            libraries: libraries
                .collect::<Option<BTreeSet<_>>>()?
                .into_iter()
                .collect(),
            glibc: glibc(&file)?,
            search_path: search_path(bytes),
        })
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Names of the exported symbols as C writes them: Mach-O puts an underscore in front.
fn exports(file: &File<'_>) -> Option<BTreeSet<String>> {
    let underscore = file.format() == BinaryFormat::MachO;
    let name = |name: String| match name.strip_prefix('_') {
        Some(rest) if underscore => rest.to_owned(),
        _ => name,
    };
    let exports = file
        .exports()
        .ok()?
        .map(|symbol| match symbol.ok()?.name() {
            NameOrOrdinal::Name(bytes) => Some(name(text(bytes))),
            NameOrOrdinal::Ordinal(number) => Some(format!("#{number}")),
        });
    exports.collect()
}

fn glibc(file: &File<'_>) -> Option<Option<Version>> {
    let mut newest = None;
    for import in file.imports().ok()? {
        if let ImportFlags::Elf {
            version: Some(version),
            ..
        } = import.ok()?.flags()
        {
            newest = newest.max(Version::parse(&text(version)));
        }
    }
    Some(newest)
}

fn search_path(bytes: &[u8]) -> Option<String> {
    let file = ElfFile64::<Endianness>::parse(bytes).ok()?;
    let table = file.elf_dynamic_table().ok()?;
    let entry = table
        .iter()
        .find(|entry| matches!(entry.tag, elf::DT_RUNPATH | elf::DT_RPATH))?;
    table.string(entry).ok().map(text)
}

/// The names of FMI 2.0 first; `aarch64-linux` and the like are FMI 3.0's, which importers have
/// taken over for machines that FMI 2.0 does not name.
fn platforms(file: &File<'_>) -> &'static [&'static str] {
    match (file.format(), file.architecture()) {
        (BinaryFormat::Elf, Architecture::X86_64) => &["linux64", "x86_64-linux"],
        (BinaryFormat::Elf, Architecture::I386) => &["linux32", "x86-linux"],
        (BinaryFormat::Elf, Architecture::Aarch64) => &["aarch64-linux"],
        (BinaryFormat::Pe, Architecture::X86_64) => &["win64", "x86_64-windows"],
        (BinaryFormat::Pe, Architecture::I386) => &["win32", "x86-windows"],
        (BinaryFormat::Pe, Architecture::Aarch64) => &["aarch64-windows"],
        (BinaryFormat::MachO, Architecture::X86_64) => &["darwin64", "x86_64-darwin"],
        (BinaryFormat::MachO, Architecture::Aarch64) => &["aarch64-darwin", "darwin64"],
        _ => &[],
    }
}
