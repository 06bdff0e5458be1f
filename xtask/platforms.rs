//! `cargo xtask platforms`: FMUs for linux64, aarch64-linux and win64, each run over the paper's
//! scenario, here, under qemu and under wine, with the same bits.

use crate::plan::{Failure, Step, execute};
use crate::setup::{Package, Project};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What zig links for: the oldest Linux that tools still support.
const GLIBC: &str = "2.17";
const LINUX: [&str; 2] = ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu"];
/// Threads of its own kind: `windows-gnu` leaks a TLS index with every load of a library.
const WINDOWS: &str = "x86_64-pc-windows-gnullvm";
/// The program that runs the FMUs under wine; it is loaded once, so it may be of the other kind.
const RUNNER: &str = "x86_64-pc-windows-gnu";
const OUT: &str = "target/platforms";
const MODEL: &str = "DctPlant.fmu";

/// The steps of `cargo xtask platforms`.
pub fn steps(project: &Project) -> Vec<Step> {
    vec![
        project.system_packages(&[Package::Mingw, Package::Wine, Package::Qemu, Package::Arm]),
        project.python_packages(),
        Step::commands("zig and the targets of rustc", tools(project)),
        Step::commands("FMUs for all three", vec![fmus(project)]),
        Step::commands(
            "audit: glibc, exports, libraries, paths",
            vec![audit(project)],
        ),
        Step::commands("runners for wine and qemu", runners(project)),
        replay_step(project),
    ]
}

fn tools(project: &Project) -> Vec<Command> {
    let pip = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "ziglang==0.17.1",
        "cargo-zigbuild==0.24.1",
    ];
    let mut targets = Command::new("rustup");
    targets.args(["target", "add", LINUX[1], WINDOWS, RUNNER]);
    vec![project.venv("python", &pip), targets]
}

/// cargo with zig in its path and mingw's gcc as the linker of the Windows target.
fn cross(project: &Project, words: &[&str]) -> Command {
    let root = std::env::current_dir().unwrap_or_default();
    let mut path = root.join(".venv/bin").into_os_string();
    path.push(":");
    path.push(std::env::var_os("PATH").unwrap_or_default());
    let mut command = project.cargo(words);
    command.env("PATH", path).env(
        "CARGO_TARGET_X86_64_PC_WINDOWS_GNULLVM_LINKER",
        root.join("xtask/windows/mingw-linker.sh"),
    );
    command
}

fn fmus(project: &Project) -> Command {
    let mut command = cross(
        project,
        &["fmu", "build", "--out", OUT, "--target", WINDOWS],
    );
    for target in LINUX {
        command.arg("--target").arg(format!("{target}.{GLIBC}"));
    }
    command
}

fn audit(project: &Project) -> Command {
    let mut command = project.cargo(&["fmu", "check", "--glibc", GLIBC]);
    for model in ["DctPlant", "DctObserver", "DctClutchControl"] {
        command.arg(format!("{OUT}/{model}.fmu"));
    }
    command
}

fn runners(project: &Project) -> Vec<Command> {
    let arm = format!("{}.{GLIBC}", LINUX[1]);
    let build = ["--quiet", "--package", "fmu-build", "--target"];
    let mut qemu = cross(project, &["zigbuild"]);
    qemu.args(build).arg(arm);
    let mut wine = cross(project, &["build"]);
    wine.args(build).arg(RUNNER);
    let mut random = Command::new("x86_64-w64-mingw32-gcc");
    random.args(["-shared", "-o"]);
    random.arg(format!("target/{RUNNER}/debug/bcryptprimitives.dll"));
    random.args(["xtask/windows/bcryptprimitives.c", "-ladvapi32"]);
    vec![qemu, wine, random]
}

fn replay_step(project: &Project) -> Step {
    let project = project.clone();
    Step::new(
        "the paper's scenario on all three: the same bits",
        move || replay(&project),
    )
}

fn replay(project: &Project) -> Result<(), Failure> {
    let stimuli = stimuli()?;
    let mut qemu = Command::new("qemu-aarch64");
    qemu.args(["-L", "/usr/aarch64-linux-gnu"]);
    qemu.arg(format!("target/{}/debug/fmu-build", LINUX[1]));
    let mut wine = Command::new("wine");
    wine.env("WINEDEBUG", "-all")
        .env("WINEPREFIX", absolute("target/wine"));
    wine.arg(format!("target/{RUNNER}/debug/fmu-build.exe"));
    let runs = [
        ("linux64", project.cargo(&["fmu"])),
        ("aarch64-linux", qemu),
        ("win64", wine),
    ];
    let mut results = Vec::new();
    for (platform, mut command) in runs {
        let out = PathBuf::from(format!("{OUT}/{platform}.csv"));
        command.args(["replay", &format!("{OUT}/{MODEL}")]);
        command.arg(&stimuli).arg("--out").arg(&out);
        execute(command)?;
        results.push((platform, read(&out)?));
    }
    let (first, expected) = &results[0];
    for (platform, bytes) in &results[1..] {
        if bytes != expected {
            return Err(Failure::Usage(format!(
                "{platform} differs from {first} in {OUT}"
            )));
        }
    }
    println!(
        "      {} bytes of results, the same on linux64, aarch64-linux, win64",
        expected.len()
    );
    println!(
        "      not done: darwin64 and aarch64-darwin need Apple's SDK; `cargo fmu merge` adds them"
    );
    Ok(())
}

/// The paper's positions, with the speed at which its engine starts.
fn stimuli() -> Result<PathBuf, Failure> {
    let path = PathBuf::from(format!("{OUT}/stimuli.csv"));
    let scenario = read(Path::new("examples/closed_loop/scenarios/positions.csv"))?;
    let mut text = String::new();
    for (index, line) in String::from_utf8_lossy(&scenario).lines().enumerate() {
        let cell = if index == 0 {
            "engine.speed_start"
        } else {
            "90"
        };
        text.push_str(&format!("{line},{cell}\n"));
    }
    match fs::write(&path, text) {
        Ok(()) => Ok(path),
        Err(error) => Err(Failure::File { path, error }),
    }
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(|error| Failure::File {
        path: path.into(),
        error,
    })
}

fn absolute(path: &str) -> PathBuf {
    std::env::current_dir().unwrap_or_default().join(path)
}
