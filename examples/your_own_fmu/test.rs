//! What an author's own tests look like: the oven led as an importer leads it, without C and without a file.

use Oven::Oven;
use fmi2_cosim::{Error, Instance, Log, Reference};

// A name that is not in the table, or another type, does not compile.
const POWER: Reference<Oven, f64> = Reference::named("heater.power");
const TEMPERATURE: Reference<Oven, f64> = Reference::named("body.temperature");
const LOSS: Reference<Oven, f64> = Reference::named("wall.heatFlow");

#[test]
fn a_heated_oven_loses_at_last_what_it_is_given() -> Result<(), Error> {
    const HOUR: f64 = 3600.0; // [s]
    let log = &mut Log::silent();
    let mut oven = Instance::<Oven>::default();
    oven.enter_initialization()?;
    oven.write(POWER, 1000.0)?;
    oven.exit_initialization(log)?;
    assert_eq!(oven.read(TEMPERATURE, log)?, 293.15);
    for hour in 0..50 {
        oven.step(f64::from(hour) * HOUR, HOUR, log)?;
    }
    assert!((oven.read(LOSS, log)? - 1000.0).abs() < 1e-9);
    Ok(())
}
