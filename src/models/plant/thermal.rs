//! Rows of the thermal model of a clutch and of its wear.

use super::Plant;
use super::start::{HEAT, NOTHING};
use crate::vehicle::{indexed, invalid};
use dct_driveline::Params;
use dct_driveline::thermal::FADE_POINTS;
use fmi2_cosim::{Failure, Unit, Variable};

const JOULE_PER_KELVIN: Unit = Unit::new("J/K", [1, 2, -2, 0, -1, 0, 0, 0], &[]);
const WATT_PER_KELVIN: Unit = Unit::new("W/K", [1, 2, -3, 0, -1, 0, 0, 0], &[]);
const CUBIC_METRE: Unit = Unit::new("m3", [0, 3, 0, 0, 0, 0, 0, 0], &[]);
const CUBIC_METRE_PER_JOULE: Unit = Unit::new("m3/J", [-1, 1, 2, 0, 0, 0, 0, 0], &[]);

const TEMPERATURE: [[&str; FADE_POINTS]; 2] = [
    indexed!("clutch1.thermal.temperature": 1, 2, 3, 4),
    indexed!("clutch2.thermal.temperature": 1, 2, 3, 4),
];
const FACTOR: [[&str; FADE_POINTS]; 2] = [
    indexed!("clutch1.thermal.factor": 1, 2, 3, 4),
    indexed!("clutch2.thermal.factor": 1, 2, 3, 4),
];

const START: [&str; 2] = ["clutch1.temperature_start", "clutch2.temperature_start"];

/// What clutch `I` shows of heat and wear.
pub(super) const fn thermal_outputs<const I: usize>() -> [Variable<Plant>; 2] {
    [
        Variable::output(
            ["clutch1.temperature", "clutch2.temperature"][I],
            Unit::KELVIN,
            |m: &mut Plant| &mut m.y.temperature[I],
            "Temperature of the clutch; without a thermal model that of ambient or oil",
        )
        .slope(|m| &mut m.y.temperature[I])
        .depends_on(&[])
        .initially_depends_on(HEAT[I])
        .on_demand(),
        Variable::output(
            ["clutch1.wear", "clutch2.wear"][I],
            CUBIC_METRE,
            |m: &mut Plant| &mut m.y.wear[I],
            "Volume worn off the lining since the start: specificWear times friction energy",
        )
        .slope(|m| &mut m.y.wear[I])
        .depends_on(&[])
        .initially_depends_on(NOTHING)
        .on_demand(),
    ]
}

/// Heat, cooling, fade and wear of clutch `I`.
pub(super) const fn thermal<const I: usize>() -> [Variable<Plant>; 5 + 2 * FADE_POINTS] {
    [
        Variable::parameter(
            ["clutch1.thermal.capacity", "clutch2.thermal.capacity"][I],
            JOULE_PER_KELVIN,
            |m: &mut Plant| &mut m.p.clutch[I].thermal.capacity,
            "Heat capacity that friction heats; 0: no thermal model",
        )
        .min(0.0),
        Variable::parameter(
            ["clutch1.thermal.conductance", "clutch2.thermal.conductance"][I],
            WATT_PER_KELVIN,
            |m: &mut Plant| &mut m.p.clutch[I].thermal.conductance,
            "Conductance from the clutch to ambient or oil",
        )
        .min(0.0),
        Variable::parameter(
            ["clutch1.thermal.ambient", "clutch2.thermal.ambient"][I],
            Unit::KELVIN,
            |m: &mut Plant| &mut m.p.clutch[I].thermal.ambient,
            "Temperature of ambient or oil",
        )
        .min(0.0),
        Variable::parameter(
            START[I],
            Unit::KELVIN,
            |m: &mut Plant| &mut m.p.clutch[I].thermal.start,
            "Temperature of the clutch at the start; 0: that of ambient",
        )
        .min(0.0),
        Variable::parameter(
            ["clutch1.specificWear", "clutch2.specificWear"][I],
            CUBIC_METRE_PER_JOULE,
            |m: &mut Plant| &mut m.p.clutch[I].specific_wear,
            "Volume worn off the lining per friction energy",
        )
        .min(0.0),
        temperature::<I, 0>(),
        temperature::<I, 1>(),
        temperature::<I, 2>(),
        temperature::<I, 3>(),
        factor::<I, 0>(),
        factor::<I, 1>(),
        factor::<I, 2>(),
        factor::<I, 3>(),
    ]
}

const fn temperature<const I: usize, const K: usize>() -> Variable<Plant> {
    Variable::parameter(
        TEMPERATURE[I][K],
        Unit::KELVIN,
        |m: &mut Plant| &mut m.p.clutch[I].thermal.temperature[K],
        "Temperature of a point of the factor on friction, ascending; all 0: no fade by heat",
    )
    .min(0.0)
}

const fn factor<const I: usize, const K: usize>() -> Variable<Plant> {
    Variable::parameter(
        FACTOR[I][K],
        Unit::ONE,
        |m: &mut Plant| &mut m.p.clutch[I].thermal.factor[K],
        "Factor on kinetic and static friction at that temperature, linear between, constant outside",
    )
    .min(0.0)
}

/// Refuses tables that are no functions, and those that would not act.
pub(super) fn check_thermal(p: &Params) -> Result<(), Failure> {
    for (i, clutch) in p.clutch.iter().enumerate() {
        let (temperature, factor) = (clutch.thermal.temperature, clutch.thermal.factor);
        let none = temperature == [0.0; FADE_POINTS];
        if !clutch.thermal.is_on() && clutch.thermal.start > 0.0 {
            let remedy = "does not act without thermal.capacity: set it above 0";
            return Err(invalid(START[i], clutch.thermal.start, remedy));
        }
        if none || !clutch.thermal.is_on() {
            if let Some(k) = factor.iter().position(|factor| *factor != 1.0) {
                let remedy = if none {
                    "does not act while all temperatures of the table are 0: set them, ascending"
                } else {
                    "does not act without thermal.capacity: set it above 0"
                };
                return Err(invalid(FACTOR[i][k], factor[k], remedy));
            }
            continue;
        }
        for k in 1..FADE_POINTS {
            if temperature[k] <= temperature[k - 1] {
                let remedy = "must be above the temperature before it; all 0 is no table";
                return Err(invalid(TEMPERATURE[i][k], temperature[k], remedy));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::check_thermal;
    use dct_driveline::Params;
    use dct_driveline::thermal::Thermal;

    #[test]
    fn a_start_temperature_needs_a_thermal_model() {
        let mut p = Params::TABLE_1;
        p.clutch[1].thermal.start = 350.0;
        let said = check_thermal(&p).map_err(|failure| failure.to_string());
        let expected = "clutch2.temperature_start = 350 does not act without thermal.capacity";
        assert!(said.is_err_and(|text| text.starts_with(expected)));
        p.clutch[1].thermal.capacity = 5e3;
        assert!(check_thermal(&p).is_ok());
    }

    #[test]
    fn a_table_ascends_and_acts_or_is_not_there() {
        let (table, none) = ([300.0, 400.0, 500.0, 600.0], [0.0; 4]);
        let cases = [
            (0.0, none, 1.0, ""),
            (5e3, table, 0.6, ""),
            (
                5e3,
                none,
                0.6,
                "clutch1.thermal.factor[4] = 0.6 does not act while",
            ),
            (
                0.0,
                table,
                0.6,
                "clutch1.thermal.factor[4] = 0.6 does not act without",
            ),
            (
                5e3,
                [300.0, 400.0, 400.0, 600.0],
                1.0,
                "clutch1.thermal.temperature[3] = 400 must be above",
            ),
        ];
        for (capacity, temperature, last, said) in cases {
            let mut p = Params::TABLE_1;
            p.clutch[0].thermal = Thermal {
                capacity,
                temperature,
                factor: [1.0, 1.0, 1.0, last],
                ..Thermal::OFF
            };
            let found =
                check_thermal(&p).map_or_else(|failure| failure.to_string(), |()| String::new());
            assert!(
                found.starts_with(said) && found.is_empty() == said.is_empty(),
                "{found}"
            );
        }
    }
}
