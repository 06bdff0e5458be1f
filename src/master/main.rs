//! `cosim`: runs a system file of `dct-harness` and writes its results.

mod ending;

use clap::{Args, Parser, Subcommand};
use cosim_master::plan::Value;
use cosim_master::{
    Error, Job, Libraries, Live, Mapping, Measured, Message, Outcome, Plan, Scenario, Seconds,
    System, Told, csv, run_seen,
};
use ending::Ending;
use std::fmt::{self, Write as _};
use std::io::{self, Write as _};
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, mpsc};
use std::thread;

/// A compiled master for FMI 2.0 co-simulation FMUs.
#[derive(Parser)]
#[command(
    name = "cosim",
    version,
    after_help = "`cosim run --help` shows options, examples and exit codes."
)]
struct Words {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Run a closed loop and write its results as CSV.
    ///
    /// The numbers are those of `dct-harness run`, to the last bit; for KPIs, limits and reports take that.
    /// FMUs run inside this process: use FMUs you trust, or `dct-harness run --engine native`, which puts
    /// others into a process of their own.
    #[command(verbatim_doc_comment)]
    #[command(after_help = RUN_EXAMPLES)]
    Run(RunWords),
}

const RUN_EXAMPLES: &str = "\
Examples:
  cosim run examples/closed_loop/paper_case1.toml --out results.csv
  cosim run examples/closed_loop/torque_tracking_case1.toml --set control.feedback.enabled=false
  cosim run examples/closed_loop/paper_case1.toml --step 0.01 --stop 10 --interpolate
  cosim run examples/closed_loop/paper_case1.toml --record plant.vehicle.speed
  cosim run examples/closed_loop/paper_case1.toml --plant Antrieb.fmu --map antrieb.toml
  cosim run paper_case1.ssp --scenario other.csv --set plant.vehicle.mass=1600
  cosim run examples/closed_loop/launch_wet6.toml --parameters plant own.ssv
  cosim run examples/closed_loop/calibration_case1.toml --calibration earlier/calibration.ssv
  cosim run examples/closed_loop/paper_case1.toml --timeout 60

Exit codes: 0 done, 2 usage or configuration, 3 an FMU does not load, 4 an FMU failed or asked to end
the simulation before the stop, 5 timeout, 130 Ctrl-C; the rows before a failure, the limit or Ctrl-C are
written, also when an FMU does not return within 2 s of either. A second Ctrl-C ends at once.";

/// What to do about an FMU that does not return.
const REMEDY: &str = "; another --step may get past this time, else who made the FMU must mend it";

#[derive(Args)]
struct RunWords {
    /// System file (.toml or .ssp).
    system: PathBuf,
    /// Communication step [s]; without it that of the file.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    step: Option<f64>,
    /// End of the run [s]; without it that of the file.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    stop: Option<f64>,
    /// Scenario CSV instead of the file's.
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Results (.csv) of `dct-harness run` whose noise is used, where the file has [noise].
    #[arg(long, value_name = "FILE")]
    noise: Option<PathBuf>,
    /// FMU to use as component `plant`.
    #[arg(long, value_name = "FMU")]
    plant: Option<PathBuf>,
    /// Mapping file (.toml): names, units and codings of that plant.
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Where FMUs are.
    #[arg(long, value_name = "FOLDER", default_value = "target/fmu")]
    fmu_dir: PathBuf,
    /// Values of a component from a parameter file (.ssv); may be said again.
    #[arg(long, num_args = 2, value_names = ["COMPONENT", "FILE"])]
    parameters: Vec<PathBuf>,
    /// calibration.ssv of an earlier run, or its folder: observer and control start with what it had learnt.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// A parameter or start value in SI units, COMPONENT.VARIABLE=VALUE; may be said again.
    #[arg(long, value_name = "ASSIGNMENT", value_parser = assignment)]
    set: Vec<(String, String, Value)>,
    /// Inputs with slopes within a step, where the FMU can interpolate.
    #[arg(long)]
    interpolate: bool,
    /// A signal to keep, COMPONENT.VARIABLE; may be said again. Without it all are kept.
    #[arg(long, value_name = "SIGNAL")]
    record: Vec<String>,
    /// Longest time of the loop [s of the clock]; without it none.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    timeout: Option<f64>,
    /// Results: `time` [s], then `component.variable`.
    #[arg(long, value_name = "FILE", default_value = "results.csv")]
    out: PathBuf,
    /// Ask FMUs that this project did not build to log what they do: why they refuse a call; may be slow.
    #[arg(long)]
    fmu_log: bool,
    /// Also what the FMUs say, with their times.
    #[arg(short, long)]
    verbose: bool,
}

fn main() -> ExitCode {
    let Verb::Run(words) = Words::parse().verb;
    let ending = match Ending::begin(words.timeout) {
        Ok(ending) => ending,
        Err(error) => return failed(2, &error.to_string()),
    };
    match run(words, &ending) {
        Ok(told) => {
            // Whoever reads may have had enough; the results are written.
            let _ = writeln!(io::stdout(), "{told}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            let (code, told) = told(&error, &ending);
            let done = failed(code, &told);
            if let Error::Stuck { .. } = error {
                ending.leave(code)
            }
            done
        }
    }
}

fn failed(code: u8, told: &str) -> ExitCode {
    remark(format_args!("cosim: {told}"));
    ExitCode::from(code)
}

/// Says a line beside the results; where nobody can read it any more, the exit code has to do.
fn remark(line: fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Exit code of an error, and what to tell.
fn told(error: &Error, ending: &Ending) -> (u8, String) {
    let code = match error {
        Error::Ended { .. } => {
            let (code, cause) = ending.cause();
            return (code, format!("{error}: {cause}"));
        }
        Error::Stuck { .. } => ending.cause().0,
        error if error.is_at_run_time() => 4,
        error if error.is_of_an_fmu() => 3,
        _ => 2,
    };
    (code, error.to_string())
}

fn seconds(text: &str) -> Result<f64, String> {
    let known = text.parse().ok();
    let usable = known.filter(|seconds: &f64| seconds.is_finite() && *seconds > 0.0);
    usable.ok_or_else(|| "must be a number of seconds above 0".to_owned())
}

fn assignment(text: &str) -> Result<(String, String, Value), String> {
    let parts = text
        .split_once('=')
        .and_then(|(key, value)| Some((key.trim().split_once('.')?, value.trim())));
    let ((component, variable), value) = parts.ok_or("write COMPONENT.VARIABLE=VALUE")?;
    let value = match value {
        "true" => Value::Boolean(true),
        "false" => Value::Boolean(false),
        other => other.parse().map_or_else(
            |_| Value::Text(other.trim_matches('"').to_owned()),
            Value::Number,
        ),
    };
    Ok((component.to_owned(), variable.to_owned(), value))
}

/// Takes the values of the command line, each kind above the one before it.
fn give(system: &mut System, words: &RunWords) -> Result<(), Error> {
    let (presets, _) = words.parameters.as_chunks();
    for [component, file] in presets {
        system.preset(&component.to_string_lossy(), file)?;
    }
    if let Some(file) = &words.calibration {
        system.start_with(file)?;
    }
    for (component, variable, value) in &words.set {
        system.set(component, variable, value.clone())?;
    }
    Ok(())
}

/// Reads the system file, and puts what the command line says above it.
fn opened(words: &RunWords, libraries: &mut Libraries) -> Result<System, Error> {
    let mut system = System::open(&words.system, libraries)?;
    system.step = words.step.unwrap_or(system.step);
    system.stop = words.stop.unwrap_or(system.stop);
    system.scenario = words.scenario.clone().or(system.scenario);
    system.interpolate |= words.interpolate;
    let plant = words.plant.clone();
    plant.map_or(Ok(()), |fmu| system.replace_plant(fmu))?;
    if let Some(file) = &words.map {
        system.map(Mapping::load(file)?)?;
    }
    if let Some(file) = &words.noise {
        system.noise.take(Scenario::load(file)?);
    }
    give(&mut system, words)?;
    Ok(system)
}

/// Reads the scenario, and says what is odd about it.
fn scenario(system: &mut System) -> Result<Scenario, Error> {
    let (scenario, free) = system.scenario()?;
    for line in scenario.beyond(system.stop) {
        remark(format_args!("{line}"));
    }
    if !free.is_empty() {
        let free = free.join(", ");
        remark(format_args!(
            "the scenario has no column for {free}: start values"
        ));
    }
    Ok(scenario)
}

/// Returns what to tell when all went well.
fn run(words: RunWords, ending: &Ending) -> Result<String, Error> {
    let mut libraries = Libraries::below(ending.folder().to_owned());
    let mut system = opened(&words, &mut libraries)?;
    let times = system.times()?;
    make_room(&words.out)?;
    let scenario = scenario(&mut system)?;
    let (mut plan, held) = system.plan(&words.fmu_dir, &scenario, &mut libraries)?;
    let (mut measured, mut record) = (Measured::new(&scenario, &plan)?, words.record);
    for line in &measured.doubts {
        remark(format_args!("{line}"));
    }
    measured.take(&mut record)?;
    plan.log = words.fmu_log;
    plan.record = (!record.is_empty()).then_some(record);
    let script = system.rows(&scenario, (&plan, &held), &times)?;
    let outcome = made(plan, (&times, script), libraries, ending);
    if words.verbose {
        tell(&outcome.log);
    }
    let rows = outcome.rows.len() / outcome.names.len().max(1);
    if rows > 0 {
        write(&words.out, &times, &outcome, &measured)?;
    }
    match outcome.error {
        Some(error) => Err(error),
        None => Ok(format!(
            "{}: {rows} samples to t = {} s",
            words.out.display(),
            Seconds(system.stop)
        )),
    }
}

/// Makes a run in a thread of its own, which is left alone when an FMU does not return.
fn made(
    plan: Plan,
    (times, script): (&[f64], Vec<f64>),
    mut libraries: Libraries,
    ending: &Ending,
) -> Outcome {
    let live = Arc::new(Live::default());
    let (give, take) = mpsc::channel();
    let (seen, watch, points) = (live.clone(), ending.watch.clone(), times.to_vec());
    let worker = thread::spawn(move || {
        let job = Job {
            plan,
            times: &points,
            script: &script,
        };
        // Nobody takes it any more when that took too long.
        let _ = give.send(run_seen(&job, &mut libraries, &watch, &seen));
    });
    ending.awaited(&take).unwrap_or_else(|| {
        if !ending.watch.is_ended()
            && let Err(panic) = worker.join()
        {
            resume_unwind(panic);
        }
        let why = format!("{}{REMEDY}", ending.cause().1);
        live.stuck(times, &why)
    })
}

/// Prints the messages of all FMUs by their times.
fn tell(log: &Told) {
    let all = log
        .iter()
        .flat_map(|(name, messages)| messages.iter().map(move |message| (name, message)));
    let mut all: Vec<_> = all.collect();
    all.sort_by(|(_, one), (_, other)| one.time.total_cmp(&other.time));
    for (name, message) in all {
        let Message {
            time,
            category,
            text,
            ..
        } = message;
        let time = Seconds(*time);
        remark(format_args!("{time} s {name} [{category}] {text}"));
    }
}

/// Makes the folder of the results, before a run rather than after.
fn make_room(out: &Path) -> Result<(), Error> {
    if out.is_dir() {
        let out = out.display();
        return Err(Error::Usage(format!(
            "--out {out}: is a folder; name a file, {out}/results.csv"
        )));
    }
    let folder = out.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).map_err(|error| Error::File {
        path: folder.to_owned(),
        error,
    })
}

/// Writes the rows whole: to a temporary name beside it, then renamed.
fn write(
    out: &Path,
    times: &[f64],
    outcome: &Outcome,
    measured: &Measured<'_>,
) -> Result<(), Error> {
    let width = outcome.names.len().max(1);
    let names = outcome.names.iter().map(String::as_str);
    let names = names.chain(measured.names());
    let mut text = csv::heading(std::iter::once("time").chain(names));
    text.push('\n');
    for (time, row) in times.iter().zip(outcome.rows.chunks_exact(width)) {
        // Writing to a String cannot fail.
        let _ = write!(text, "{time:?}");
        let row = row.iter().copied().chain(measured.at(*time));
        row.for_each(|value| {
            let _ = write!(text, ",{value:?}");
        });
        text.push('\n');
    }
    let mut part = out.as_os_str().to_owned();
    part.push(".part");
    let part = PathBuf::from(part);
    let done = std::fs::write(&part, text).and_then(|()| std::fs::rename(&part, out));
    done.map_err(|error| Error::File {
        path: out.to_owned(),
        error,
    })
}
