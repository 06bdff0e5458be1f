//! Builds the probe's library as `cargo fmu build --small` builds those of models; writes it to a file.

#[path = "../model.rs"]
mod model;

use fmu_build::Entry;
use fmu_build::library::Target;
use model::Probe;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("which file?")?;
    let library = Entry::of::<Probe>("abi-probe").library(&Target::host()?.small())?;
    Ok(std::fs::write(path, library)?)
}
