//! The FMUs over the paper's scenario: what linux64 computes, the other platforms compute to the last bit.

use super::{MODELS, OUT, PACKAGER, library};
use crate::plan::{Failure, Step, execute};
use crate::words::Words;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Outputs are compared in every tenth step, what other FMUs take in each: what differs once differs later.
const EVERY: &str = "10";

/// A drive: which FMUs are coupled, in this order, over which scenario, with which parameters.
struct Drive {
    name: &'static str,
    models: &'static [&'static str],
    scenario: &'static str,
    parameters: &'static [(&'static str, &'static str)],
}

/// The paper's positions with its observer, and the closed loop with the method that has most to compute.
const DRIVES: [Drive; 2] = [
    Drive {
        name: "positions",
        models: &[MODELS[0], MODELS[1]],
        scenario: "positions.csv",
        parameters: &[
            ("engine.speed_start", "90"),
            ("clutch1.nominalFriction", "0.4"),
            ("clutch2.nominalFriction", "0.1"),
        ],
    },
    Drive {
        name: "closed_loop",
        models: &MODELS,
        scenario: "torque_tracking.csv",
        parameters: &[
            ("engine.speed_start", "90"),
            ("clutch1.nominalFriction", "0.1"),
            ("clutch2.nominalFriction", "0.4"),
            ("observer.method", "5"),
        ],
    },
];

/// All drives on all platforms.
pub fn step() -> Step {
    Step::new(
        "the paper's scenario, open and closed loop, on all three: the same bits",
        move |words| DRIVES.iter().try_for_each(|drive| compare(drive, words)),
    )
}

/// wine with a prefix of its own.
pub fn wine() -> Command {
    let mut wine = Command::new("wine");
    let root = std::env::current_dir().unwrap_or_default();
    wine.env("WINEDEBUG", "-all")
        .env("WINEPREFIX", root.join("target/wine"));
    wine
}

/// Runs a drive here, writes its calls, and repeats them on the other platforms.
fn compare(drive: &Drive, words: &Words) -> Result<(), Failure> {
    let (inputs, calls) = (inputs(drive)?, format!("{OUT}/{}.calls", drive.name));
    let mut here = Command::new(PACKAGER);
    here.arg("replay");
    here.args(
        drive
            .models
            .iter()
            .map(|model| format!("{OUT}/{model}.fmu")),
    );
    here.args(["--every", EVERY, "--calls", &calls, "--inputs"])
        .arg(&inputs);
    here.arg("--out")
        .arg(format!("{OUT}/{}_linux64.csv", drive.name));
    execute(words, here)?;
    let mut qemu = Command::new("qemu-aarch64");
    qemu.args(["-L", "/usr/aarch64-linux-gnu"])
        .arg(format!("{OUT}/calls"));
    let mut windows = wine();
    windows.arg(format!("{OUT}/calls.exe"));
    for (mut command, platform, extension) in
        [(qemu, "aarch64-linux", "so"), (windows, "win64", "dll")]
    {
        let coupled = drive.models.join(" + ");
        words.say(format_args!("      {coupled} on {platform}:"));
        command.arg(&calls);
        command.args(
            drive
                .models
                .iter()
                .map(|model| library(model, platform, extension)),
        );
        execute(words, command)?;
    }
    Ok(())
}

/// The scenario with the parameters as further columns.
fn inputs(drive: &Drive) -> Result<PathBuf, Failure> {
    let path = PathBuf::from(format!("{OUT}/{}.csv", drive.name));
    let folder = Path::new("examples/closed_loop/scenarios");
    let scenario = read(&folder.join(drive.scenario))?;
    let mut text = String::new();
    for (index, line) in String::from_utf8_lossy(&scenario).lines().enumerate() {
        text.push_str(line);
        for (name, value) in drive.parameters {
            text.push(',');
            text.push_str(if index == 0 { name } else { value });
        }
        text.push('\n');
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
