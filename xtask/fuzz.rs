//! `cargo xtask fuzz`: libFuzzer on the calls of the C boundary, on saved states and on what the
//! packager reads, with plain coverage and with the address sanitizer.
//!
//! An input that makes a target crash, hang or take too much memory is left in
//! `target/fuzz/reproducers`. `cargo xtask fuzz keep` takes what was found on the way, and covers
//! something new, into the corpus.

use crate::plan::{Failure, Step, execute, line};
use crate::setup::Project;
use crate::words::Words;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

const MANIFEST: &str = "tests/fuzz/Cargo.toml";
const CORPUS: &str = "tests/fuzz/corpus";
const OUT: &str = "target/fuzz";
/// Targets, with the longest input of each [bytes].
const TARGETS: [(&str, u32); 3] = [("calls", 400), ("states", 200), ("packages", 2000)];
/// How long a target runs when nobody says how long [s].
const LONG: u32 = 600;
/// One after the other on each core.
const CORES: usize = 2;

/// How the targets are built.
#[derive(Clone, Copy)]
enum Sanitizer {
    None,
    Address,
}

/// What cargo-fuzz passes to rustc: counters at every edge, and comparisons that the fuzzer sees.
const COVERAGE: &str = "--cfg fuzzing -Ccodegen-units=1 -Cpasses=sancov-module \
    -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
    -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares";

impl Sanitizer {
    const ALL: [Self; 2] = [Self::None, Self::Address];

    const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Address => "address",
        }
    }

    /// Cargo under its flags. rustc has sanitizers, but on stable it wants to be persuaded.
    fn build(self, project: &Project, words: &[&str], flags: &str) -> Command {
        let mut command = project.cargo(words);
        command.args(["--target", &host()]);
        let target = Path::new(OUT).join(self.name());
        command.arg("--target-dir").arg(target);
        match self {
            Self::None => command.env("RUSTFLAGS", flags),
            Self::Address => command
                .env("RUSTFLAGS", format!("{flags} -Zsanitizer=address"))
                .env("RUSTC_BOOTSTRAP", "1"),
        };
        command
    }

    fn program(self, target: &str) -> PathBuf {
        let release = format!("{}/{}/release", self.name(), host());
        Path::new(OUT).join(release).join(target)
    }
}

/// The triple of this machine: with a target named, build scripts are built without the flags.
fn host() -> String {
    let said = Command::new("rustc").arg("-vV").output();
    let said = said.map(|done| String::from_utf8_lossy(&done.stdout).into_owned());
    let line = said.unwrap_or_default();
    let host = line.lines().find_map(|line| line.strip_prefix("host: "));
    host.unwrap_or("x86_64-unknown-linux-gnu").to_owned()
}

/// What is asked for: so many seconds for each target, or to keep what was found.
pub fn steps_for(project: &Project, what: &[&str]) -> Result<Vec<Step>, Failure> {
    match what {
        [] => Ok(steps(project, LONG)),
        ["keep"] => Ok(keep(project)),
        [seconds] if seconds.parse::<u32>().is_ok() => {
            Ok(steps(project, seconds.parse().unwrap_or(LONG)))
        }
        _ => Err(Failure::Usage(format!(
            "fuzz takes seconds or `keep`, not {what:?}"
        ))),
    }
}

/// Builds the targets twice and runs each for `seconds` in both ways.
pub fn steps(project: &Project, seconds: u32) -> Vec<Step> {
    vec![build(project), campaign(seconds)]
}

/// Builds the targets twice.
pub fn build(project: &Project) -> Step {
    let builds = Sanitizer::ALL.map(|sanitizer| {
        let words = [
            "build",
            "--quiet",
            "--release",
            "--locked",
            "--manifest-path",
            MANIFEST,
        ];
        sanitizer.build(project, &words, COVERAGE)
    });
    Step::commands(
        "fuzz targets, plain and with address sanitizer",
        builds.into(),
    )
}

/// Runs each target for `seconds` in both ways, with both cores for itself.
pub fn campaign(seconds: u32) -> Step {
    let title = format!("libFuzzer: calls, states, packages, {seconds} s each, twice");
    Step::new(title, move |words| run(words, seconds))
}

/// Two at a time, so that two cores are busy.
fn run(words: &Words, seconds: u32) -> Result<(), Failure> {
    let jobs = Sanitizer::ALL
        .into_iter()
        .flat_map(|s| TARGETS.map(|t| (s, t)));
    let (jobs, failures) = (Mutex::new(jobs), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..CORES {
            scope.spawn(|| {
                while let Some((sanitizer, target)) = next(&jobs) {
                    if let Err(failure) = fuzz(words, sanitizer, target, seconds) {
                        put(&failures, failure);
                    }
                }
            });
        }
    });
    let found = failures.into_inner().unwrap_or_default();
    found.into_iter().next().map_or(Ok(()), Err)
}

fn next<I: Iterator>(jobs: &Mutex<I>) -> Option<I::Item> {
    jobs.lock().ok()?.next()
}

fn put<T>(list: &Mutex<Vec<T>>, value: T) {
    if let Ok(mut list) = list.lock() {
        list.push(value);
    }
}

/// Runs one target; its words go to a file, and are shown when it fails.
fn fuzz(
    words: &Words,
    sanitizer: Sanitizer,
    target: (&str, u32),
    seconds: u32,
) -> Result<(), Failure> {
    let (name, longest) = target;
    let label = format!("{name}-{}", sanitizer.name());
    let [found, reproducers] = [
        made(Path::new(OUT).join("found").join(&label))?,
        made(Path::new(OUT).join("reproducers"))?,
    ];
    let mut command = Command::new(sanitizer.program(name));
    command
        .arg(format!(
            "-artifact_prefix={}/{label}-",
            reproducers.display()
        ))
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-max_len={longest}"))
        .args([
            "-timeout=20",
            "-rss_limit_mb=4096",
            "-len_control=20",
            "-print_final_stats=1",
        ])
        .arg(found)
        .arg(Path::new(CORPUS).join(name));
    heard(words, &mut command, &label)
}

/// Runs a target with its words in `LABEL.log`.
fn heard(words: &Words, command: &mut Command, label: &str) -> Result<(), Failure> {
    let log = Path::new(OUT).join(format!("{label}.log"));
    let file = File::create(&log).map_err(|error| Failure::File {
        path: log.clone(),
        error,
    })?;
    let status = command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(file)
        .status();
    let said = fs::read_to_string(&log).unwrap_or_default();
    if status.is_ok_and(|status| status.success()) {
        words.say(format_args!("      {label}: {}", summary(&said)));
        return Ok(());
    }
    Err(Failure::Command {
        line: line(command),
        what: format!(
            "{}\nthe target {label} failed; all it said is in {}",
            end(&said),
            log.display()
        ),
    })
}

fn made(folder: PathBuf) -> Result<PathBuf, Failure> {
    match fs::create_dir_all(&folder) {
        Ok(()) => Ok(folder),
        Err(error) => Err(Failure::File {
            path: folder,
            error,
        }),
    }
}

/// The last line with counts, e.g. `#5973 DONE cov: 1717 ft: 4496 …`.
fn summary(said: &str) -> &str {
    let done = said.lines().rfind(|line| line.contains("DONE"));
    done.unwrap_or("no count").trim()
}

/// The lines from the fault on: what panicked, or the sanitizer's report, and the reproducer.
fn end(said: &str) -> String {
    let lines: Vec<_> = said.lines().collect();
    let signs = ["panicked at", "ERROR:", "ALARM"];
    let fault = lines
        .iter()
        .position(|line| signs.iter().any(|sign| line.contains(sign)));
    let from = fault.unwrap_or(lines.len().saturating_sub(40));
    let kept = lines[from..]
        .iter()
        .take(60)
        .chain(lines.iter().filter(|line| line.contains("Test unit")));
    kept.map(|line| format!("{line}\n")).collect()
}

/// Takes what earlier runs found into the corpus, the smallest set that covers as much.
fn keep(project: &Project) -> Vec<Step> {
    let mut steps = vec![build(project)];
    steps.push(Step::new("corpus", |words| {
        TARGETS.into_iter().try_for_each(|(name, longest)| {
            let kept = Path::new(CORPUS).join(name);
            let old = Path::new(OUT).join(format!("old-{name}"));
            let moved = fs::rename(&kept, &old).and_then(|()| fs::create_dir_all(&kept));
            moved.map_err(|error| Failure::File {
                path: kept.clone(),
                error,
            })?;
            let mut command = Command::new(Sanitizer::None.program(name));
            command
                .args([
                    "-set_cover_merge=1",
                    "-use_counters=0",
                    "-use_cmp=0",
                    &format!("-max_len={longest}"),
                ])
                .args([&kept, &old]);
            let found = Sanitizer::ALL.map(|s| format!("{OUT}/found/{name}-{}", s.name()));
            command.args(found.iter().filter(|folder| Path::new(folder).is_dir()));
            execute(words, command)?;
            fs::remove_dir_all(&old).map_err(|error| Failure::File { path: old, error })
        })
    }));
    steps
}

#[cfg(test)]
mod tests {
    use super::{end, summary};

    const SAID: &str = "INFO: Seed: 1\n#2 INITED cov: 9\nthread panicked at states.rs:30:5:\n\
        min > max\nstack backtrace:\nartifact_prefix='x'; Test unit written to x/crash-1\n";

    #[test]
    fn a_failure_is_told_from_its_cause_to_the_file_that_repeats_it() {
        let told = end(SAID);
        assert!(told.starts_with("thread panicked at states.rs:30:5:\nmin > max"));
        assert!(told.ends_with("Test unit written to x/crash-1\n") && !told.contains("INITED"));
    }

    #[test]
    fn a_run_without_failure_is_told_in_one_line() {
        assert_eq!(
            summary("#1 INITED cov: 9\n#7 DONE cov: 10\nbye"),
            "#7 DONE cov: 10"
        );
    }
}
