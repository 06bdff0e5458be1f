//! Which cargo and rustc build a library.

use crate::{Error, Result};
use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A cargo and its rustc.
#[derive(Debug)]
pub(crate) struct Compiler {
    cargo: OsString,
    rustc: OsString,
}

impl Compiler {
    /// What runs this program, or is first in the search path.
    pub(crate) fn present() -> Self {
        Self {
            cargo: env::var_os("CARGO").unwrap_or_else(|| "cargo".into()),
            rustc: env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()),
        }
    }

    /// That of the system: Debian has the sources of its standard library as a package.
    fn of_the_system() -> Self {
        Self {
            cargo: "/usr/bin/cargo".into(),
            rustc: "/usr/bin/rustc".into(),
        }
    }

    /// One that has the sources of its standard library: the present one rather than that of the system.
    ///
    /// # Errors
    /// When neither has them.
    pub(crate) fn with_sources() -> Result<Self> {
        let both = [Self::present(), Self::of_the_system()];
        let mut found = both.into_iter().filter(Self::has_sources);
        found.next().ok_or(Error::NoSources)
    }

    fn has_sources(&self) -> bool {
        let sources = self.sources();
        sources.is_some_and(|folder| folder.join("library/std/Cargo.toml").is_file())
    }

    /// Where it looks for the sources of the standard library.
    pub(crate) fn sources(&self) -> Option<PathBuf> {
        let sysroot = self.asked(&["--print", "sysroot"])?;
        Some(Path::new(sysroot.trim()).join("lib/rustlib/src/rust"))
    }

    /// The target that is this machine.
    pub(crate) fn host(&self) -> Option<String> {
        let version = self.asked(&["--version", "--verbose"])?;
        let host = version.lines().find_map(|line| line.strip_prefix("host: "));
        host.map(str::to_owned)
    }

    fn asked(&self, words: &[&str]) -> Option<String> {
        let output = Command::new(&self.rustc).args(words).output().ok()?;
        let printed = String::from_utf8(output.stdout).ok()?;
        output.status.success().then_some(printed)
    }

    /// A command of this cargo.
    pub(crate) fn command(&self) -> Command {
        let mut command = Command::new(&self.cargo);
        command.env("RUSTC", &self.rustc);
        command
    }
}

/// Makes a command of cargo build the standard library, too, without what turns addresses into names of
/// functions: two fifths of a library, for a message of a panic that an FMU never prints.
///
/// The options are not stable yet; the variable lets a stable compiler take them.
pub(crate) fn build_small_std(command: &mut Command) {
    command
        .env("RUSTC_BOOTSTRAP", "1")
        .env("CARGO_UNSTABLE_BUILD_STD", "std,panic_unwind")
        .env("CARGO_UNSTABLE_BUILD_STD_FEATURES", "optimize_for_size");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_compiler_tells_its_machine_and_where_sources_would_be() {
        let compiler = Compiler::present();
        let host = compiler.host().unwrap();
        assert!(host.starts_with(env::consts::ARCH), "{host}");
        assert!(compiler.sources().unwrap().is_absolute());
    }

    #[test]
    fn a_compiler_that_is_not_there_has_no_sources() {
        let missing = Compiler {
            cargo: "/nowhere/cargo".into(),
            rustc: "/nowhere/rustc".into(),
        };
        assert!(!missing.has_sources());
        assert_eq!(missing.host(), None);
    }
}
