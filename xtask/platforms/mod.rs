//! `cargo xtask platforms`: FMUs for linux64, aarch64-linux and win64, each run over the paper's
//! scenario, here, under qemu and under wine, with the same bits.

mod apple;
mod compiler;
mod ecu;
mod replay;

use crate::plan::Step;
use crate::setup::Project;
pub use compiler::Compiler;
use compiler::WINDOWS;
use std::process::Command;

/// What zig links for: the oldest Linux that tools still support.
const GLIBC: &str = "2.17";
/// What `cargo fmu` runs; called directly where it shall build with another compiler than its own.
const PACKAGER: &str = "target/debug/cargo-fmu";
const OUT: &str = "target/platforms";
const MODELS: [&str; 3] = ["DctPlant", "DctObserver", "DctClutchControl"];
/// An importer may load a library this often; `windows-gnu` ends at some 1,050.
const LOADS: &str = "1500";

/// The steps of `cargo xtask platforms`; `build_std`: without rustup's targets.
pub fn steps(project: &Project, build_std: bool) -> Vec<Step> {
    let compiler = Compiler::choose(build_std);
    let mut steps = vec![project.python_packages()];
    steps.extend(tools(project, compiler));
    steps.extend(checks(project, compiler));
    steps
}

/// What they need from outside, where the Python packages are there already.
pub fn tools(project: &Project, compiler: Compiler) -> [Step; 2] {
    [
        project.system_packages(compiler.packages()),
        Step::commands("zig", vec![zig(project)]),
    ]
}

/// The same where all that is there already.
pub fn checks(project: &Project, compiler: Compiler) -> Vec<Step> {
    vec![
        Step::commands(
            format!("FMUs for all three: {}", compiler.title()),
            vec![packager(project), fmus(compiler)],
        ),
        Step::commands(
            "audit: glibc, exports, libraries, paths",
            vec![audit(project)],
        ),
        Step::commands("importers in C for qemu and wine", importers(project)),
        replay::step(),
        Step::commands("loads of the library for Windows", loads()),
        apple::step(project, compiler),
        ecu::step(project, compiler),
    ]
}

fn zig(project: &Project) -> Command {
    let packages = ["ziglang==0.17.1", "cargo-zigbuild==0.24.1"];
    let mut pip = project.venv("python", &["-m", "pip", "install", "--quiet"]);
    pip.args(packages);
    pip
}

/// The packager is of this machine and its own compiler; what it calls cargo for is not.
fn packager(project: &Project) -> Command {
    project.cargo(&["build", "--quiet", "--package", "fmu-build"])
}

fn fmus(compiler: Compiler) -> Command {
    let mut command = Command::new(PACKAGER);
    command.args(["build", "--out", OUT, "--target", WINDOWS]);
    for machine in ["x86_64", "aarch64"] {
        command.arg("--target");
        command.arg(format!("{machine}-unknown-linux-gnu.{GLIBC}"));
    }
    compiler.equip(&mut command, &[]);
    command
}

fn audit(project: &Project) -> Command {
    let mut command = project.cargo(&["fmu", "check", "--strict", "--glibc", GLIBC]);
    command.args(MODELS.map(|model| format!("{OUT}/{model}.fmu")));
    command
}

/// The program that repeats calls, for both other machines, and the libraries out of the FMUs.
fn importers(project: &Project) -> Vec<Command> {
    let source = "xtask/platforms/calls.c";
    let mut windows = Command::new(MINGW);
    windows.args(C).arg(format!("{OUT}/calls.exe")).arg(source);
    let arm = format!("aarch64-linux-gnu.{GLIBC}");
    let mut linux = project.venv("python", &["-m", "ziglang", "cc", "-target", &arm]);
    linux
        .args(C)
        .arg(format!("{OUT}/calls"))
        .args([source, "-ldl"]);
    let unpack = |model: &str| {
        let fmu = format!("{OUT}/{model}.fmu");
        let mut unzip = project.venv("python", &["-m", "zipfile", "-e", &fmu]);
        unzip.arg(format!("{OUT}/{model}"));
        unzip
    };
    let all = [windows, linux].into_iter();
    all.chain(MODELS.map(unpack)).collect()
}

const MINGW: &str = "x86_64-w64-mingw32-gcc";
const C: [&str; 5] = ["-Wall", "-Wextra", "-Werror", "-O1", "-o"];

/// The library of a model for a platform, out of its FMU.
fn library(model: &str, platform: &str, extension: &str) -> String {
    format!("{OUT}/{model}/binaries/{platform}/{model}.{extension}")
}

fn loads() -> Vec<Command> {
    let program = format!("{OUT}/loads.exe");
    let mut compile = Command::new(MINGW);
    compile.args(C).args([&program, "xtask/windows/loads.c"]);
    let mut run = replay::wine();
    run.arg(program)
        .arg(library(MODELS[0], "win64", "dll"))
        .arg(LOADS);
    vec![compile, run]
}
