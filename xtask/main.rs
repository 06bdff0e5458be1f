//! The project's chores, each with its own set-up: `cargo xtask demo | test | bench | deny | fuzz | native | docs | ci`.
//!
//! ```text
//! main (arguments) ──> demo, test, bench: lists of steps ──> plan (runs them, says [3/9] …)
//!                                  └── setup: system packages, .venv, FMUs
//! ```
//!
//! The standard library is all it uses, so the first command on a fresh machine starts at once.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::print_stderr)] // talking to people is its purpose

mod bench;
mod beside;
mod demo;
mod dependencies;
mod fuzz;
mod native;
mod packages;
mod plan;
mod platforms;
mod setup;
mod test;
mod words;

use plan::{Failure, Step};
use setup::Project;
use std::process::ExitCode;

const HELP: &str = "\
cargo xtask COMMAND: the project's chores. Each sets up what it needs by itself.

commands:
  demo [--open]  build the FMUs, run the paper's closed loop for both friction cases and write
                 target/report/index.html; --open shows it in a browser
  test           every check: formatters, linters, licences, Rust tests, docs, 60 s of each fuzz
                 target, all platforms, Python tests with the FMUs in fmpy, ecos, libcosim and
                 the fmi crate; fuzz targets and FMUs for all platforms are built beside the
                 Rust tests: what they say is in target/beside.log, and shown when they are done
  bench [--quick]
                 every performance gate, C FMUs beside: a table and target/bench/summary.json;
                 fails when a gate is missed; --quick is a short run that judges nothing,
                 its results are in target/bench/quick
  bench growth   cost of the compiled master against runs, step, recorded signals, instances and
                 threads: table and plot in target/bench, growth.md and growth.svg
  deny           licences, advisories, origin and place of every crate: cargo-deny, deny.toml
  native         the compiled master as a Python module in .venv: dct-harness run --engine native
  fuzz [SECONDS | keep]
                 libFuzzer on calls, saved states and packages, 600 s each, plain and with the
                 address sanitizer; an input that breaks one is left in target/fuzz/reproducers;
                 keep takes inputs that cover something new into tests/fuzz/corpus
  docs           the docs site into target/docs
  platforms [--build-std]
                 FMUs for linux64 (glibc 2.17), aarch64-linux and win64 in target/platforms, all
                 run over the paper's scenario, under qemu and wine, with the same bits; for
                 macOS in target/platforms/darwin, not run; the observer's C library for a
                 Cortex-M4, linked with nothing else and run under qemu; where rustup has no such
                 targets, or with --build-std, by Debian's compiler
  ci             demo, then test: what a change must pass

set-up (done by every command, kept between runs):
  .venv          Python packages of tests/requirements.txt; made anew when that file changes
  target/fmu     the FMUs, by `cargo fmu build`
  system         chromium, libtbb12, valgrind: by apt-get on Debian as root; elsewhere a missing
                 one is named with the line that installs it

A step that fails shows the command that repeats it alone.

exit codes:
  0 all steps done, 1 a step failed, 2 no such command

examples:
  cargo xtask demo --open
  cargo fmu build DctPlant            # one FMU only
  .venv/bin/dct-harness run examples/closed_loop/paper_case1.toml
  .venv/bin/python -m pytest tests -k importers
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match command(&words) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Usage(what)) => {
            eprintln!("xtask: {what}\n\n{HELP}");
            ExitCode::from(2)
        }
        Err(failure) => {
            eprintln!("xtask: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn command(words: &[&str]) -> Result<(), Failure> {
    let project = Project::here()?;
    match words {
        ["demo"] => plan::run(demo::steps(&project, false)),
        ["demo", "--open"] => plan::run(demo::steps(&project, true)),
        ["test"] => plan::run(test::steps(&project)),
        ["bench"] => plan::run(bench::steps(&project, &[])),
        ["bench", "growth"] => plan::run(bench::growth(&project)),
        ["bench", "--quick"] => plan::run(bench::steps(&project, &["--quick"])),
        ["deny"] => plan::run(deny(&project)),
        ["native"] => plan::run(native(&project)),
        ["fuzz", what @ ..] => plan::run(fuzz::steps_for(&project, what)?),
        ["docs"] => plan::run(docs(&project)),
        ["platforms"] => plan::run(platforms::steps(&project, false)),
        ["platforms", "--build-std"] => plan::run(platforms::steps(&project, true)),
        ["ci"] => plan::run(ci(&project)),
        [] | ["help" | "--help" | "-h"] | [_, "--help" | "-h"] => {
            print!("{HELP}");
            Ok(())
        }
        _ => Err(Failure::Usage(format!("no command `{}`", words.join(" ")))),
    }
}

/// What `test` asks about dependencies, alone.
fn deny(project: &Project) -> Vec<Step> {
    vec![project.python_packages(), dependencies::step(project)]
}

/// The compiled master, for `dct-harness run --engine native`.
fn native(project: &Project) -> Vec<Step> {
    vec![project.python_packages(), native::module(project)]
}

/// The site of docs/, whose reference pages come from the code.
fn docs(project: &Project) -> Vec<Step> {
    let build = ["-m", "mkdocs", "build", "--strict", "-f", "docs/mkdocs.yml"];
    let mut command = project.venv("python", &build);
    command.env("NO_MKDOCS_2_WARNING", "1"); // an advertisement of the theme
    vec![
        project.python_packages(),
        Step::commands("docs into target/docs", vec![command]),
    ]
}

/// Demo first: what closes the output are the test runners' own summary lines.
fn ci(project: &Project) -> Vec<Step> {
    let mut steps = demo::steps(project, false);
    steps.extend(test::steps(project));
    steps
}
