//! `cosim-master`: runs a closed loop of FMUs and writes its results as CSV.

use cosim_master::{Component, Error, Master, Scenario, Value};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

const HELP: &str = "\
cosim-master --scenario S.csv --out R.csv [options] NAME=FILE.fmu…

  NAME=FILE.fmu              a component; components step in the given order
  --scenario S.csv           signals over time: `time` [s], then one column per signal
  --out R.csv                results: `time` [s], then `component.variable`
  --step H                   communication step [s] (0.001)
  --stop T                   end of the run [s], a multiple of the step (30)
  --set NAME.VARIABLE=VALUE  a parameter or start value: a number, true or false

example:
  cosim-master --scenario examples/closed_loop/scenarios/positions.csv --out r.csv \\
    plant=target/fmu/DctPlant.fmu observer=target/fmu/DctObserver.fmu \\
    --set plant.engine.speed_start=90
";

#[derive(Default)]
struct Options {
    components: Vec<Component>,
    values: Vec<(String, String, Value)>,
    scenario: Option<PathBuf>,
    out: Option<PathBuf>,
    step: Option<f64>,
    stop: Option<f64>,
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if words.is_empty() || words.iter().any(|word| word == "--help" || word == "-h") {
        print!("{HELP}");
        return ExitCode::SUCCESS;
    }
    match parse(words.into_iter()).and_then(run) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cosim-master: {error}");
            ExitCode::from(if matches!(error, Error::Usage(_)) {
                2
            } else {
                1
            })
        }
    }
}

fn parse(mut words: impl Iterator<Item = String>) -> Result<Options, Error> {
    let mut options = Options::default();
    while let Some(word) = words.next() {
        let mut value = || {
            words
                .next()
                .ok_or_else(|| usage(format!("{word} needs a value")))
        };
        match word.as_str() {
            "--scenario" => options.scenario = Some(value()?.into()),
            "--out" => options.out = Some(value()?.into()),
            "--step" => options.step = Some(number(&value()?)?),
            "--stop" => options.stop = Some(number(&value()?)?),
            "--set" => options.values.push(assignment(&value()?)?),
            _ => options.components.push(component(&word)?),
        }
    }
    Ok(options)
}

fn usage(what: String) -> Error {
    Error::Usage(format!("{what}; see cosim-master --help"))
}

fn number(text: &str) -> Result<f64, Error> {
    text.parse()
        .map_err(|_| usage(format!("'{text}' is not a number")))
}

fn assignment(text: &str) -> Result<(String, String, Value), Error> {
    let parts = text
        .split_once('=')
        .and_then(|(key, value)| Some((key.split_once('.')?, value)));
    let ((component, variable), value) =
        parts.ok_or_else(|| usage(format!("--set {text}: write NAME.VARIABLE=VALUE")))?;
    let value = match value {
        "true" => Value::Boolean(true),
        "false" => Value::Boolean(false),
        other => Value::Number(number(other)?),
    };
    Ok((component.to_owned(), variable.to_owned(), value))
}

fn component(word: &str) -> Result<Component, Error> {
    let parts = word.split_once('=').filter(|_| !word.starts_with('-'));
    let (name, path) = parts.ok_or_else(|| usage(format!("'{word}' is not NAME=FILE.fmu")))?;
    Ok(Component {
        name: name.to_owned(),
        path: path.into(),
        values: vec![],
    })
}

fn run(mut options: Options) -> Result<(), Error> {
    for (name, variable, value) in options.values {
        let mut components = options.components.iter_mut();
        let component = components.find(|component| component.name == name);
        let component = component.ok_or_else(|| usage(format!("--set: no component '{name}'")))?;
        component.values.push((variable, value));
    }
    let missing = |what: &str| usage(format!("{what} is missing"));
    let path = options.scenario.ok_or_else(|| missing("--scenario"))?;
    let out = options.out.ok_or_else(|| missing("--out"))?;
    let (step, stop) = (options.step.unwrap_or(0.001), options.stop.unwrap_or(30.0));
    let steps = count(step, stop)?;
    let mut master = Master::new(&options.components, Scenario::load(&path)?, step, steps)?;
    let mut text = format!("time,{}\n", master.names().join(","));
    let done = master.run(|time, values| write_row(&mut text, time, values));
    std::fs::write(&out, text).map_err(|error| Error::File { path: out, error })?;
    done
}

/// Steps of a run; the stop must be a multiple of the step, but for rounding.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked right here
fn count(step: f64, stop: f64) -> Result<u32, Error> {
    const ROUNDING: f64 = 1e-9; // relative; a stop this close to a multiple is one
    let steps = (stop / step).round();
    let whole = (steps * step - stop).abs() <= ROUNDING * stop.max(step);
    if step > 0.0 && whole && (1.0..=f64::from(u32::MAX)).contains(&steps) {
        Ok(steps as u32)
    } else {
        Err(usage(format!(
            "--stop {stop} is not a multiple of --step {step}"
        )))
    }
}

/// Shortest text that reads back as the same bits.
fn write_row(text: &mut String, time: f64, values: &[f64]) {
    let _ = write!(text, "{time:?}"); // writing to a String cannot fail
    values.iter().for_each(|value| {
        let _ = write!(text, ",{value:?}");
    });
    text.push('\n');
}
