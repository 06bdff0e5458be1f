//! What every chore needs first: system packages, Python packages in `.venv`, the FMUs.

use crate::plan::{Failure, Step, execute, succeeds};
use crate::words::Words;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The project's root and what lives in it.
#[derive(Debug, Clone)]
pub struct Project {
    root: PathBuf,
}

/// A program or library from outside the Rust and Python worlds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Package {
    /// Opens the report in a test.
    Chromium,
    /// `libtbb.so.12`, which the importer ecos needs.
    Tbb,
    /// Counts instructions in the benchmarks.
    Valgrind,
    /// `ensurepip`, which Debian keeps apart from Python.
    Venv,
    /// Links libraries for Windows.
    Mingw,
    /// Runs programs for Windows.
    Wine,
    /// Runs programs for ARM.
    Qemu,
    /// The C library of ARM, for the programs that qemu runs.
    Arm,
    /// A compiler with the sources of its standard library: Debian's.
    RustSource,
    /// The same, or the sources for the compiler at hand.
    AnyRustSource,
}

impl Package {
    const fn debian(self) -> &'static str {
        match self {
            Self::Chromium => "chromium",
            Self::Tbb => "libtbb12",
            Self::Valgrind => "valgrind",
            Self::Venv => "python3-venv",
            Self::Mingw => "gcc-mingw-w64-x86-64-win32",
            Self::Wine => "wine64 wine",
            Self::Qemu => "qemu-user",
            Self::Arm => "libc6-arm64-cross",
            Self::RustSource | Self::AnyRustSource => "rustc-web cargo-web rust-web-src",
        }
    }

    fn is_present(self) -> bool {
        match self {
            Self::Chromium => ["chromium", "chromium-browser", "google-chrome"]
                .iter()
                .any(starts),
            Self::Tbb => !cfg!(target_os = "linux") || library_is_known("libtbb.so.12"),
            Self::Valgrind => starts(&"valgrind"),
            Self::Mingw => starts(&"x86_64-w64-mingw32-gcc"),
            Self::Wine => starts(&"wine"),
            Self::Qemu => starts(&"qemu-aarch64") && starts(&"qemu-arm"),
            Self::Arm => Path::new("/usr/aarch64-linux-gnu/lib/libc.so.6").exists(),
            Self::RustSource => has_sources("/usr/bin/rustc") && starts(&"/usr/bin/cargo"),
            Self::AnyRustSource => {
                has_sources("rustc") || rustup_brings_sources() || Self::RustSource.is_present()
            }
            Self::Venv => python().is_ok_and(|python| {
                succeeds(Command::new(python).args(["-c", "import ensurepip, venv"]))
            }),
        }
    }
}

/// What a command prints, if it succeeds and prints anything.
pub fn printed(mut command: Command) -> Option<String> {
    let done = command.output().ok().filter(|done| done.status.success())?;
    let text = String::from_utf8_lossy(&done.stdout).trim().to_owned();
    (!text.is_empty()).then_some(text)
}

/// Whether a compiler finds the sources of its standard library.
fn has_sources(rustc: &str) -> bool {
    let mut command = Command::new(rustc);
    command.args(["--print", "sysroot"]);
    let library = "lib/rustlib/src/rust/library/std/Cargo.toml";
    printed(command).is_some_and(|sysroot| Path::new(&sysroot).join(library).exists())
}

/// Whether rustup can fetch them for the compiler at hand: Debian's may be older than this project's least version.
fn rustup_brings_sources() -> bool {
    succeeds(Command::new("rustup").args(["component", "add", "rust-src"])) && has_sources("rustc")
}

fn starts(program: &&str) -> bool {
    succeeds(Command::new(program).arg("--version"))
}

/// Whether the dynamic loader finds a library in its cache.
fn library_is_known(name: &str) -> bool {
    let mut paths = vec!["ldconfig", "/sbin/ldconfig"].into_iter();
    let cache = paths.find_map(|program| Command::new(program).arg("-p").output().ok());
    cache.is_some_and(|cache| String::from_utf8_lossy(&cache.stdout).contains(name))
}

impl Project {
    /// The project this xtask was built from; its root becomes the current directory.
    pub fn here() -> Result<Self, Failure> {
        let member = Path::new(env!("CARGO_MANIFEST_DIR"));
        let root = member.parent().unwrap_or(member).to_path_buf();
        match std::env::set_current_dir(&root) {
            Ok(()) => Ok(Self { root }),
            Err(error) => Err(Failure::File { path: root, error }),
        }
    }

    /// A cargo command.
    pub fn cargo(&self, words: &[&str]) -> Command {
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.args(words);
        command
    }

    /// A program of `.venv`.
    pub fn venv(&self, program: &str, words: &[&str]) -> Command {
        let mut command = Command::new(venv_program(program));
        command.args(words);
        command
    }

    /// What bindgen needs to find: the library of the PyPI package libclang, and the C headers
    /// that this package does not have but every C compiler does.
    pub fn bindgen(&self) -> Result<[(&'static str, String); 2], Failure> {
        const NATIVE: &str = "import clang, os; print(os.path.join(clang.__path__[0], 'native'))";
        let libclang =
            printed(self.venv("python", &["-c", NATIVE])).ok_or_else(|| Failure::Missing {
                what: "the Python package libclang in .venv".into(),
                remedy: ".venv/bin/python -m pip install -r tests/requirements.txt".into(),
            })?;
        let mut compiler = Command::new("cc");
        compiler.arg("-print-file-name=include");
        let headers = printed(compiler).ok_or_else(|| Failure::Missing {
            what: "a C compiler named cc".into(),
            remedy: "sudo apt-get install -y gcc libc6-dev".into(),
        })?;
        Ok([
            ("LIBCLANG_PATH", libclang),
            ("BINDGEN_EXTRA_CLANG_ARGS", format!("-I{headers}")),
        ])
    }

    /// System packages: installed by apt-get on Debian as root, else named.
    pub fn system_packages(&self, needed: &'static [Package]) -> Step {
        let names: Vec<_> = needed.iter().map(|package| package.debian()).collect();
        Step::new(
            format!("system packages: {}", names.join(", ")),
            move |words| install(words, needed),
        )
    }

    /// Python packages into `.venv`.
    pub fn python_packages(&self) -> Step {
        let root = self.root.clone();
        Step::new("Python packages into .venv", move |words| {
            make_venv(words, &root)
        })
    }

    /// The FMUs into `target/fmu`.
    pub fn fmus(&self) -> Step {
        Step::commands("FMUs into target/fmu", vec![self.cargo(&["fmu", "build"])])
    }

    /// The plant with a small library into `target/small`.
    pub fn small_fmu(&self) -> Step {
        let words = [
            "fmu",
            "build",
            "--small",
            "DctPlant",
            "--out",
            "target/small",
        ];
        Step::commands(
            "a small DctPlant.fmu into target/small",
            vec![self.cargo(&words)],
        )
    }
}

fn install(words: &Words, needed: &[Package]) -> Result<(), Failure> {
    let missing: Vec<_> = needed
        .iter()
        .filter(|package| !package.is_present())
        .collect();
    if missing.is_empty() {
        return Ok(());
    }
    let names: Vec<_> = missing.iter().map(|package| package.debian()).collect();
    if !(Path::new("/etc/debian_version").exists() && is_root()) {
        return Err(Failure::Missing {
            what: names.join(", "),
            remedy: format!(
                "sudo apt-get install -y --no-install-recommends {}",
                names.join(" ")
            ),
        });
    }
    execute(words, apt_get(&["update", "-qq"]))?;
    let mut command = apt_get(&["install", "-y", "-qq", "--no-install-recommends"]);
    command.args(names.iter().flat_map(|name| name.split(' ')));
    execute(words, command)
}

fn apt_get(words: &[&str]) -> Command {
    let mut command = Command::new("apt-get");
    command.args(words).env("DEBIAN_FRONTEND", "noninteractive");
    command
}

fn is_root() -> bool {
    let mut id = Command::new("id");
    id.arg("-u");
    printed(id).as_deref() == Some("0")
}

/// The first Python of the search path that is new enough.
fn python() -> Result<&'static str, Failure> {
    const NEW_ENOUGH: &str = "import sys; sys.exit(sys.version_info < (3, 10))";
    let names = ["python3", "python"];
    let found = names
        .into_iter()
        .find(|n| succeeds(Command::new(n).args(["-c", NEW_ENOUGH])));
    found.ok_or_else(|| Failure::Missing {
        what: "Python 3.10 or newer".into(),
        remedy: "sudo apt-get install -y python3 python3-venv".into(),
    })
}

fn venv_program(program: &str) -> PathBuf {
    let folder = if cfg!(windows) { "Scripts" } else { "bin" };
    Path::new(".venv").join(folder).join(program)
}

/// Makes `.venv` anew unless it was made from the same interpreter and the same requirements.
///
/// The stamp holds them in full, so no hash can collide and a look at it tells what is installed.
fn make_venv(words: &Words, root: &Path) -> Result<(), Failure> {
    let (venv, stamp) = (root.join(".venv"), root.join(".venv/requirements.stamp"));
    let wanted = wanted_stamp(root)?;
    if fs::read_to_string(&stamp).is_ok_and(|found| found == wanted) {
        return Ok(());
    }
    if venv.exists() {
        fs::remove_dir_all(&venv).map_err(|error| Failure::File {
            path: venv.clone(),
            error,
        })?;
    }
    install(words, &[Package::Venv])?;
    let mut create = Command::new(python()?);
    create.args(["-m", "venv", ".venv"]);
    execute(words, create)?;
    for arguments in PIP_INSTALLS {
        let mut pip = Command::new(venv_program("python"));
        pip.args(["-m", "pip", "--quiet", "--disable-pip-version-check"])
            .args(*arguments);
        execute(words, pip)?;
    }
    fs::write(&stamp, wanted).map_err(|error| Failure::File { path: stamp, error })
}

/// `check` proves that the pins satisfy the ranges that the harness states.
const PIP_INSTALLS: &[&[&str]] = &[
    &["install", "-r", "tests/requirements.txt"],
    &[
        "install",
        "--no-deps",
        "--no-build-isolation",
        "-e",
        "tests/harness",
    ],
    &["check"],
];

fn wanted_stamp(root: &Path) -> Result<String, Failure> {
    let python = Command::new(python()?).args(["-VV"]).output();
    let version = python.map(|done| String::from_utf8_lossy(&done.stdout).into_owned());
    let mut wanted = format!("{}{}\n", version.unwrap_or_default(), root.display());
    for file in ["tests/requirements.txt", "tests/harness/pyproject.toml"] {
        let path = root.join(file);
        let text = fs::read_to_string(&path).map_err(|error| Failure::File { path, error })?;
        wanted.push_str(&text);
    }
    Ok(wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stamp_changes_with_requirements_and_harness() {
        let root = Project::here().unwrap().root;
        let stamp = wanted_stamp(&root).unwrap();
        assert!(stamp.starts_with("Python 3."));
        assert!(stamp.contains("fmpy==") && stamp.contains("name = \"dct-harness\""));
    }

    #[test]
    fn a_library_that_does_not_exist_is_not_known() {
        assert!(!library_is_known("libno-such-library.so.0"));
    }
}
