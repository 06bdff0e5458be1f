//! Builds and checks `Oven.fmu`: `cargo run -p your-own-fmu --example package -- FOLDER`.

use Oven::Oven;
use fmu_build::Entry;
use fmu_build::about::{About, Equation};
use std::error::Error;
use std::path::PathBuf;

/// What `documentation/index.html` says beside the table.
const ABOUT: About = About {
    purpose: &["Heats a body, as `heater.power` and `room.temperature` tell."],
    equations: &[Equation {
        number: "",
        formula: "C T' = P - G (T - T_room)",
        meaning: "heat balance; solved exactly while the inputs are held",
    }],
    validity: &["One temperature: the body conducts far better than its surface."],
};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1);
    let folder = folder.map_or_else(|| PathBuf::from("target/your_own_fmu"), PathBuf::from);
    let oven = Entry::of::<Oven>(env!("CARGO_PKG_NAME"))
        .at(env!("CARGO_MANIFEST_DIR"))
        .about(ABOUT);
    let fmu = fmu_build::build(&oven, &folder)?;
    let report = fmu_build::check(&fmu)?;
    for finding in &report.findings {
        println!("{finding}");
    }
    if !report.is_valid() {
        return Err(format!("{} is not valid", fmu.display()).into());
    }
    println!(
        "{}: valid, {} start values compared",
        fmu.display(),
        report.compared
    );
    Ok(())
}
