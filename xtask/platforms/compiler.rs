//! Where the compiler for other machines comes from: rustup, or Debian with the standard library built here.

use crate::plan::succeeds;
use crate::setup::Package;
use std::path::Path;
use std::process::Command;

/// Threads of its own kind: `windows-gnu` leaks a TLS index with every load of a library.
pub const WINDOWS: &str = "x86_64-pc-windows-gnullvm";
/// Both kinds of Mac.
pub const APPLE: [&str; 2] = ["x86_64-apple-darwin", "aarch64-apple-darwin"];
/// A Cortex-M4 or M7 without an operating system: no std.
pub const BARE: &str = "thumbv7em-none-eabihf";
/// Targets that the machine's own compiler may lack.
pub const FOREIGN: [&str; 5] = [
    "aarch64-unknown-linux-gnu",
    WINDOWS,
    APPLE[0],
    APPLE[1],
    BARE,
];
/// What is built for other machines stays apart: it may come of another compiler.
pub const FOLDER: &str = "target/cross";

const DEBIAN_CARGO: &str = "/usr/bin/cargo";

/// A compiler with standard libraries for [`FOREIGN`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compiler {
    /// That of rustup, with its targets.
    Rustup,
    /// That of Debian, which has the sources of the standard library: `-Z build-std`.
    Debian,
}

impl Compiler {
    /// rustup's where it has the targets or can fetch them, unless `build_std` is asked for.
    pub fn choose(build_std: bool) -> Self {
        let rustup = || {
            let _ = succeeds(Command::new("rustup").args(["target", "add"]).args(FOREIGN));
            FOREIGN.iter().all(|target| has_library(target))
        };
        if !build_std && rustup() {
            Self::Rustup
        } else {
            Self::Debian
        }
    }

    /// In a few words.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Rustup => "rustup's compiler and targets",
            Self::Debian => "Debian's compiler, standard library built here",
        }
    }

    /// What Debian has to install.
    pub const fn packages(self) -> &'static [Package] {
        const TOOLS: [Package; 4] = [Package::Mingw, Package::Wine, Package::Qemu, Package::Arm];
        const ALL: [Package; 5] = [
            Package::Mingw,
            Package::Wine,
            Package::Qemu,
            Package::Arm,
            Package::RustSource,
        ];
        match self {
            Self::Rustup => &TOOLS,
            Self::Debian => &ALL,
        }
    }

    /// Makes `command`, or what it starts, compile with it: zig and, last, the folders `tools` in
    /// the path, mingw's gcc as linker.
    pub fn equip(self, command: &mut Command, tools: &[&Path]) {
        let root = std::env::current_dir().unwrap_or_default();
        let mut path = root.join(".venv/bin").into_os_string();
        path.push(":");
        path.push(std::env::var_os("PATH").unwrap_or_default());
        for folder in tools {
            path.push(":");
            path.push(folder);
        }
        command
            .env("PATH", path)
            .env("CARGO_TARGET_DIR", root.join(FOLDER))
            .env(
                "CARGO_TARGET_X86_64_PC_WINDOWS_GNULLVM_LINKER",
                root.join("xtask/windows/mingw-linker.sh"),
            );
        self.choose_sources(command, "std,panic_unwind");
    }

    /// cargo for [`BARE`].
    pub fn cargo_without_std(self) -> Command {
        let mut command = Command::new(match self {
            Self::Rustup => "cargo",
            Self::Debian => DEBIAN_CARGO,
        });
        self.choose_sources(&mut command, "core");
        command
    }

    /// Where Debian's compiler has no library of a target: builds these crates of it.
    fn choose_sources(self, command: &mut Command, crates: &str) {
        if self == Self::Debian {
            command
                .env("CARGO", DEBIAN_CARGO)
                .env("RUSTC", "/usr/bin/rustc")
                .env("RUSTC_BOOTSTRAP", "1")
                .env("CARGO_UNSTABLE_BUILD_STD", crates);
        }
    }
}

/// Whether the machine's compiler has the standard library of a target.
fn has_library(target: &str) -> bool {
    let mut command = Command::new("rustc");
    command.args(["--print", "target-libdir", "--target", target]);
    crate::setup::printed(command).is_some_and(|folder| Path::new(&folder).is_dir())
}
