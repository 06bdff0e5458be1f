//! The observer's static library for a processor without an operating system, whose target has no std.

use super::compiler::{BARE, Compiler, FOLDER};
use crate::plan::Step;
use crate::setup::Project;
use std::process::Command;

const ECU: &str = "examples/ecu_observer";
/// [`BARE`] in zig's words: its single-precision unit has to be named, or doubles are passed elsewhere.
const CORTEX_M4: [&str; 3] = [
    "-target",
    "thumb-freestanding-eabihf",
    "-mcpu=cortex_m4+vfp4d16sp",
];
const STRICT: [&str; 5] = ["-O2", "-std=c11", "-Wall", "-Wextra", "-Werror"];

/// Builds the library, links it with nothing but `bare_metal.c` and runs that under qemu.
pub fn step(project: &Project, compiler: Compiler) -> Step {
    Step::commands(
        format!("observer for a Cortex-M4, {BARE}: no std, no C library"),
        vec![library(compiler), program(project), run()],
    )
}

fn library(compiler: Compiler) -> Command {
    let mut command = compiler.cargo_without_std();
    command.args([
        "build",
        "--release",
        "--locked",
        "--quiet",
        "--target",
        BARE,
    ]);
    command
        .arg("--manifest-path")
        .arg(format!("{ECU}/Cargo.toml"));
    command.args(["--target-dir", FOLDER]);
    command
}

fn program(project: &Project) -> Command {
    let mut cc = project.venv("python", &["-m", "ziglang", "cc"]);
    cc.args(CORTEX_M4).args(STRICT);
    cc.args([
        "-ffreestanding",
        "-nostdlib",
        "-static",
        "-Wl,--gc-sections",
    ]);
    cc.arg(format!("-I{ECU}"))
        .arg(format!("{ECU}/bare_metal.c"));
    cc.arg(format!("{FOLDER}/{BARE}/release/libdct_observer.a"));
    cc.args(["-o", OUT]);
    cc
}

const OUT: &str = "target/cross/bare_metal";

/// qemu's programs of a Linux know no Cortex-M: `max` runs its instructions too.
fn run() -> Command {
    let mut qemu = Command::new("qemu-arm");
    qemu.args(["-cpu", "max", OUT]);
    qemu
}
