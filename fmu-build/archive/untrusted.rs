//! What nobody should unpack of an archive that nobody vouches for.

use crate::{Error, Result};
use std::fmt;
use std::fs::File;
use std::path::Path;
use zip::ZipArchive;
use zip::read::ZipFile;

/// Members up to this size may be packed as small as they like [bytes].
const SMALL: u64 = 16 << 20;
/// How many times smaller others may be packed: libraries are about 3 times, zeros 1000 times.
const RATIO: u64 = 200;

/// Why an archive is not unpacked, or a file not packed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Untrusted {
    /// A member has a name that could write outside the folder it is unpacked to.
    Name(String),
    /// The name of a file, here as far as it is text, is not UTF-8.
    NotUtf8(String),
    /// A member of this name is a symbolic link.
    Link(String),
    /// A member of this name is packed far smaller than libraries, tables or pictures can be.
    Bomb(String),
    /// All unpack to more bytes than any FMU needs.
    TooLarge {
        /// The largest accepted size [bytes].
        limit: u64,
    },
}

impl Untrusted {
    /// The error of the file at `path`.
    pub(crate) fn of(self, path: &Path) -> Error {
        Error::Untrusted {
            path: path.to_owned(),
            fault: self,
        }
    }
}

impl fmt::Display for Untrusted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => write!(f, "{name:?} would be unpacked outside its folder"),
            Self::NotUtf8(name) => write!(f, "the name {name:?} is not UTF-8: rename the file"),
            Self::Link(name) => write!(f, "{name:?} is a symbolic link"),
            Self::Bomb(name) => write!(
                f,
                "{name:?} is packed more than {RATIO} times smaller: a bomb"
            ),
            Self::TooLarge { limit } => write!(f, "it unpacks to more than {limit} bytes"),
        }
    }
}

/// Refuses an archive by what its directory says of its members, which are to unpack to at most `limit` bytes.
///
/// # Errors
/// For the first member that nobody should unpack.
pub(crate) fn examine(path: &Path, archive: &mut ZipArchive<File>, limit: u64) -> Result<()> {
    let mut left = limit;
    for at in 0..archive.len() {
        let member = archive.by_index_raw(at).map_err(Error::zip(path))?;
        let name = member_name(path, &member)?;
        let size = member.size();
        let fault = if !is_safe(&name) {
            Untrusted::Name(name)
        } else if member.is_symlink() {
            Untrusted::Link(name)
        } else if size > SMALL && size / RATIO > member.compressed_size() {
            Untrusted::Bomb(name)
        } else if let Some(rest) = left.checked_sub(size) {
            left = rest;
            continue;
        } else {
            Untrusted::TooLarge { limit }
        };
        return Err(fault.of(path));
    }
    Ok(())
}

/// Name of a member of the archive at `path`.
pub(crate) fn member_name(path: &Path, member: &ZipFile<'_, File>) -> Result<String> {
    let name = member.name().map_err(Error::zip(path))?;
    Ok(name.into_owned())
}

/// Relative, with `/` between plain names: nothing that climbs out, on any operating system.
fn is_safe(name: &str) -> bool {
    let parts = name.strip_suffix('/').unwrap_or(name).split('/');
    parts.clone().all(|part| !matches!(part, "" | "." | "..")) && !name.contains(['\\', ':', '\0'])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{archive, check, merge, package};
    use std::{fs, slice::from_ref};

    #[test]
    fn member_names_that_climb_out_are_refused() {
        for name in [
            "modelDescription.xml",
            "binaries/linux64/A.so",
            "resources/",
            "a..b/c",
        ] {
            assert!(is_safe(name), "{name}");
        }
        for name in [
            "",
            "/etc/passwd",
            "../a",
            "a/../../b",
            "a\\b",
            "C:a",
            "a//b",
            "./a",
            "a\0",
        ] {
            assert!(!is_safe(name), "{name}");
        }
    }

    /// What is said of an archive with this member, by `check` as well as by whoever reads it, then with its path.
    fn refused(name: &str, bytes: Vec<u8>) -> String {
        let file = format!("untrusted-{}-{}.fmu", std::process::id(), bytes.len());
        let path = std::env::temp_dir().join(file);
        package(&path, vec![(name.into(), bytes)]).unwrap();
        let merged = merge(from_ref(&path), Path::new("never.fmu"))
            .unwrap_err()
            .to_string();
        let found = check(&path).unwrap().findings;
        fs::remove_file(&path).unwrap();
        let said = merged
            .strip_prefix(&format!("{}: ", path.display()))
            .unwrap();
        assert!(
            found.iter().any(|finding| finding.text == said),
            "{found:?}"
        );
        said.to_owned()
    }

    #[test]
    fn zeros_without_end_are_not_unpacked() {
        let zeros = vec![0; usize::try_from(SMALL + 1).unwrap()];
        let said = refused("resources/zeros", zeros);
        assert_eq!(
            said,
            "\"resources/zeros\" is packed more than 200 times smaller: a bomb"
        );
    }

    #[test]
    fn an_archive_that_climbs_out_is_not_unpacked() {
        let said = refused("../evil", Vec::new());
        assert_eq!(said, "\"../evil\" would be unpacked outside its folder");
    }

    #[test]
    fn more_than_anybody_needs_is_not_unpacked() {
        let path = std::env::temp_dir().join(format!("untrusted-{}-size.fmu", std::process::id()));
        package(
            &path,
            vec![("a".into(), vec![1; 10]), ("b".into(), vec![1; 10])],
        )
        .unwrap();
        let examined = |limit| examine(&path, &mut archive::open(&path).unwrap(), limit);
        assert!(examined(20).is_ok());
        let said = examined(19).unwrap_err().to_string();
        assert!(
            said.ends_with(".fmu: it unpacks to more than 19 bytes"),
            "{said}"
        );
        fs::remove_file(&path).unwrap();
    }
}
