//! The command `cargo fmu`: describe, build and check FMUs.

#![forbid(unsafe_code)]

mod help;

use clap::{Parser, Subcommand};
use fmu_build::binary::Version;
use fmu_build::library::Target;
use fmu_build::models::MODELS;
use fmu_build::outside::{self, Order};
use fmu_build::{Entry, Options, Report, sources};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Describes, builds and checks FMI 2.0 co-simulation FMUs.
#[derive(Parser)]
#[command(
    bin_name = "cargo fmu",
    version,
    after_help = "Examples:
  cargo fmu build                          all FMUs into target/fmu
  cargo fmu build DctPlant --out /data     one FMU into a folder of your choice
  cargo fmu build --manifest-path ../tank  the FMU of a package of your own
  cargo fmu describe                       after a change in src/models
  cargo fmu describe --check               fail when modelDescription/ is out of date
  cargo fmu build --target x86_64-unknown-linux-gnu.2.17
  cargo fmu build --small                  libraries of two thirds the size
  cargo fmu merge linux.fmu windows.fmu --out both.fmu
  cargo fmu ssp                            the closed loop as one file, for tools that read SSP
  cargo fmu check target/fmu/DctPlant.fmu  what an importer would stumble over

Exit codes: 0 done, 1 failed or out of date, 2 usage, 3 `check` found an FMU invalid."
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write modelDescription/ and the parameter files (.ssv) of the presets from the models.
    #[command(after_help = "Commit what it writes: the FMUs carry exactly these descriptions.")]
    Describe {
        /// Write nothing; fail when a file differs from what the models say.
        #[arg(long)]
        check: bool,
    },
    /// Build FMUs.
    #[command(after_help = help::BUILD)]
    Build {
        /// Models to build, e.g. DctPlant; all when none is named.
        #[arg(value_parser = fmu_build::models::find)]
        models: Vec<&'static Entry>,
        /// Build the FMU of this package instead, or those of this workspace.
        #[arg(long, value_name = "PATH", conflicts_with = "models")]
        manifest_path: Option<PathBuf>,
        /// Folder for the FMUs [default: target/fmu of the workspace].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// What to build for [default: this machine].
        #[arg(long = "target", value_name = "T")]
        targets: Vec<String>,
        /// Smaller libraries: build the standard library along, which takes its sources (rust-src).
        #[arg(long)]
        small: bool,
    },
    /// Join FMUs of one model for several platforms.
    #[command(after_help = help::MERGE)]
    Merge {
        /// The FMU to add to, unless --out names another file.
        one: PathBuf,
        /// FMUs whose libraries are added.
        #[arg(required = true, value_name = "OTHER")]
        others: Vec<PathBuf>,
        /// File to write.
        #[arg(long, value_name = "FMU")]
        out: Option<PathBuf>,
    },
    /// Run FMUs over a table of inputs and write their outputs, bit for bit.
    #[command(after_help = help::REPLAY)]
    Replay {
        /// FMU files.
        #[arg(required = true, value_name = "FMU")]
        fmus: Vec<PathBuf>,
        /// CSV file: column `time` [s], then columns named like inputs and parameters; others are named and passed over.
        #[arg(long, value_name = "CSV")]
        inputs: PathBuf,
        /// Communication step [s].
        #[arg(long, value_name = "SECONDS", default_value = "0.001")]
        step: f64,
        /// Write every Nth communication point.
        #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..))]
        every: u32,
        /// File to write.
        #[arg(long, value_name = "CSV")]
        out: PathBuf,
        /// Write every call with its value, too, for machines without this program (xtask/platforms/calls.c).
        #[arg(long, value_name = "FILE")]
        calls: Option<PathBuf>,
    },
    /// Write the closed loop of all FMUs, with their connections, as an SSP 1.0 file.
    #[command(after_help = "Takes the FMUs that `cargo fmu build` wrote into the same folder.")]
    Ssp {
        /// Folder of the FMUs and of DctClosedLoop.ssp [default: target/fmu of the workspace].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Check FMI 2.0 co-simulation FMUs of any origin; the exit code is 3 when one is invalid.
    #[command(after_help = help::CHECK)]
    Check {
        /// FMU files.
        #[arg(required = true, value_name = "FMU")]
        fmus: Vec<PathBuf>,
        /// Oldest glibc that their Linux libraries shall run with, e.g. 2.17.
        #[arg(long, value_name = "VERSION", value_parser = glibc)]
        glibc: Option<Version>,
        /// Take warnings for errors, too: for FMUs that are handed over to others.
        #[arg(long)]
        strict: bool,
        /// The longest that one call of an FMU may take.
        #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
        limit: Duration,
        /// Print one JSON object a line and FMU instead of sentences.
        #[arg(long)]
        json: bool,
    },
    /// Run the code of an unpacked FMU: what `check` calls.
    #[command(hide = true)]
    Probe {
        name: String,
        folder: PathBuf,
        trace: PathBuf,
    },
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|seconds: &f64| *seconds > 0.0);
    let known = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    known.ok_or_else(|| "must be a number of seconds above 0".into())
}

fn glibc(text: &str) -> Result<Version, String> {
    text.parse()
        .map_err(|_| "must be a version like 2.17".into())
}

/// Exit code when a checked FMU is invalid, the same as that of `dct-harness`.
const INVALID: u8 = 3;

fn main() -> ExitCode {
    match run(Arguments::parse_from(words()).command) {
        Ok(code) => code,
        Err(error) => {
            // Where nobody can read the message any more, the exit code has to do.
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The arguments; cargo calls what is installed as `cargo-fmu fmu ...`.
fn words() -> impl Iterator<Item = std::ffi::OsString> {
    let second = |(index, word): &(usize, std::ffi::OsString)| *index != 1 || word != "fmu";
    std::env::args_os()
        .enumerate()
        .filter(second)
        .map(|(_, word)| word)
}

fn run(command: Command) -> Result<ExitCode, Box<dyn std::error::Error>> {
    match command {
        Command::Describe { check: true } => fmu_build::compare()?,
        Command::Describe { check: false } => print_paths(&fmu_build::refresh()?)?,
        Command::Build {
            models,
            manifest_path,
            out,
            targets,
            small,
        } => {
            if manifest_path.is_some() || models.is_empty() && outside::is_here() {
                outside::build(&Order {
                    manifest: manifest_path.as_deref(),
                    out: out.as_deref(),
                    targets: &targets,
                    small,
                })?;
            } else {
                build(&models, out, &targets, small)?;
            }
        }
        Command::Merge { one, others, out } => merge(one, others, out)?,
        Command::Replay {
            fmus,
            inputs,
            step,
            every,
            out,
            calls,
        } => {
            let options = fmu_build::Replay {
                inputs: &inputs,
                step,
                every,
                out: &out,
                calls: calls.as_deref(),
            };
            for remark in fmu_build::replay(&fmus, &options)? {
                writeln!(io::stderr(), "warning: {}: {remark}", inputs.display())?;
            }
        }
        Command::Ssp { out } => ssp(out)?,
        Command::Check {
            fmus,
            glibc,
            strict,
            limit,
            json,
        } => {
            let options = Options {
                glibc,
                strict,
                host: Some(std::env::current_exe()?),
                limit,
            };
            return check(&fmus, &options, json);
        }
        Command::Probe {
            name,
            folder,
            trace,
        } => fmu_build::probe(&name, &folder, &trace)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn build(
    models: &[&'static Entry],
    out: Option<PathBuf>,
    targets: &[String],
    small: bool,
) -> Result<(), Box<dyn std::error::Error>> {
    // As they are before the compiler reads them.
    let made_from = out.is_none().then(sources::checksum).transpose()?;
    let out = folder(out);
    let mut targets = match targets {
        [] => vec![Target::host()?],
        some => some
            .iter()
            .map(|t| Target::parse(t))
            .collect::<Result<Vec<_>, _>>()?,
    };
    if small {
        targets = targets.into_iter().map(Target::small).collect();
    }
    let all: Vec<_> = MODELS.iter().collect();
    for entry in if models.is_empty() { &all } else { models } {
        let path = fmu_build::build_for(entry, &targets, &out)?;
        if let Some(made_from) = made_from {
            sources::record(&path, made_from)?;
        }
        print_paths(&[path])?;
    }
    Ok(())
}

fn merge(
    one: PathBuf,
    others: Vec<PathBuf>,
    out: Option<PathBuf>,
) -> Result<(), Box<dyn std::error::Error>> {
    let path = out.unwrap_or_else(|| one.clone());
    let all: Vec<_> = std::iter::once(one).chain(others).collect();
    let made_from = sources::recorded(&path);
    fmu_build::merge(&all, &path)?;
    if let Some(made_from) = made_from {
        sources::record(&path, made_from)?;
    }
    Ok(print_paths(&[path])?)
}

fn ssp(out: Option<PathBuf>) -> Result<(), Box<dyn std::error::Error>> {
    use fmu_build::models::{CLOSED_LOOP, COMPONENTS};
    let folder = folder(out);
    let path = folder.join(format!("{CLOSED_LOOP}.ssp"));
    fmu_build::ssp::write(&path, CLOSED_LOOP, COMPONENTS, &folder)?;
    Ok(print_paths(&[path])?)
}

fn folder(out: Option<PathBuf>) -> PathBuf {
    out.unwrap_or_else(|| fmu_build::library::workspace().join("target").join("fmu"))
}

fn print_paths(paths: &[PathBuf]) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    paths
        .iter()
        .try_for_each(|path| writeln!(stdout, "{}", path.display()))
}

fn check(
    fmus: &[PathBuf],
    options: &Options,
    json: bool,
) -> Result<ExitCode, Box<dyn std::error::Error>> {
    let mut stdout = io::stdout().lock();
    let (mut all_valid, mut all_checked) = (true, true);
    for fmu in fmus {
        match fmu_build::check_with(fmu, options) {
            Ok(report) => {
                if json {
                    writeln!(stdout, "{}", report.to_json(fmu))?;
                } else {
                    print_report(&mut stdout, fmu, &report)?;
                }
                all_valid &= report.is_valid();
            }
            Err(error) => {
                writeln!(io::stderr(), "error: {error}")?;
                all_checked = false;
            }
        }
    }
    Ok(match (all_checked, all_valid) {
        (true, true) => ExitCode::SUCCESS,
        (true, false) => ExitCode::from(INVALID),
        (false, _) => ExitCode::FAILURE,
    })
}

fn print_report(to: &mut impl io::Write, fmu: &Path, report: &Report) -> io::Result<()> {
    let name = fmu.display();
    for finding in &report.findings {
        writeln!(to, "{name}: {finding}")?;
    }
    let verdict = if report.is_valid() {
        "valid"
    } else {
        "INVALID"
    };
    let compared = report.compared;
    writeln!(to, "{name}: {verdict}, {compared} start values compared")
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn the_examples_of_the_help_are_understood() {
        let help = Arguments::command().get_after_help().unwrap().to_string();
        let examples = help
            .lines()
            .filter_map(|line| line.trim().strip_prefix("cargo fmu "));
        let examples: Vec<_> = examples.collect();
        assert_eq!(examples.len(), 10);
        for example in examples {
            let words = example.split("  ").next().unwrap().split(' ');
            let parsed = Arguments::try_parse_from(std::iter::once("cargo-fmu").chain(words));
            assert!(parsed.is_ok(), "{example}");
        }
    }
    #[test]
    fn a_misspelt_model_is_an_error_of_usage() {
        let parsed = Arguments::try_parse_from(["cargo-fmu", "build", "DctPlnt"]);
        let error = parsed.err().unwrap();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("did you mean 'DctPlant'?"));
    }
}
