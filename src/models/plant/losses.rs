//! Rows of what is lost outside the clutches, and of the energy balance.

use super::Plant;
use super::start::NOTHING;
use crate::ports;
use fmi2_cosim::{Unit as U, Variable};

/// States only.
const STATES: &[&str] = &[];

/// Brake, synchronisers, balance.
pub(super) const LOSSES: [Variable<Plant>; 4] = [
    Variable::output(
        "brake.frictionPower",
        U::WATT,
        |m: &mut Plant| &mut m.y.brake_power,
        "Friction power of the brake",
    )
    .slope(|m| &mut m.y.brake_power)
    .depends_on(&[ports::BRAKE_TORQUE])
    .on_demand(),
    Variable::output(
        "brake.frictionEnergy",
        U::JOULE,
        |m: &mut Plant| &mut m.y.brake_energy,
        "Friction energy of the brake since the start",
    )
    .slope(|m| &mut m.y.brake_energy)
    .depends_on(STATES)
    .initially_depends_on(NOTHING)
    .on_demand(),
    Variable::output(
        "synchroniser.energy",
        U::JOULE,
        |m: &mut Plant| &mut m.y.synchroniser_energy,
        "Energy lost in the synchronisers since the start",
    )
    .slope(|m| &mut m.y.synchroniser_energy)
    .depends_on(STATES)
    .initially_depends_on(NOTHING)
    .on_demand(),
    Variable::output(
        "energy.residual",
        U::JOULE,
        |m: &mut Plant| &mut m.y.energy_residual,
        "Energy balance over the run: work in - stored - lost",
    )
    .slope(|m| &mut m.y.energy_residual)
    .depends_on(STATES)
    .on_demand(),
];
