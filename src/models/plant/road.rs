//! Vehicles whose road load (11) would be no number at any speed, at standstill first of all.

use crate::vehicle::invalid;
use dct_driveline::params::RoadParams;
use fmi2_cosim::Failure;

/// Refuses parameters whose products are beyond the largest number.
pub(super) fn check_road(road: &RoadParams) -> Result<(), Failure> {
    let remedy = "makes a torque at the wheel that is too large for a number: make it smaller, or what multiplies it";
    let [weight, rolling, drag] = road.sizes();
    for (name, value, size) in [
        ("vehicle.mass", road.m_v, weight),
        ("vehicle.rollingResistance", road.c_rr, rolling),
        ("vehicle.dragCoefficient", road.c_drag, drag),
    ] {
        if !size.is_finite() {
            return Err(invalid(name, value, remedy));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::check_road;
    use dct_driveline::Params;
    use dct_driveline::params::RoadParams;

    fn refused(road: RoadParams) -> String {
        check_road(&road).map_or_else(|failure| failure.to_string(), |()| String::new())
    }

    #[test]
    fn a_load_that_is_no_number_is_refused_by_the_name_of_what_makes_it() {
        let road = Params::TABLE_1.road;
        let heavy = RoadParams { m_v: 1e308, ..road };
        let sticky = RoadParams {
            c_rr: 1e305,
            ..road
        };
        let dense = RoadParams {
            rho_air: 1.7e308,
            ..road
        };
        for (road, name) in [
            (heavy, "vehicle.mass"),
            (sticky, "vehicle.rollingResistance"),
            (dense, "vehicle.dragCoefficient"),
        ] {
            let said = refused(road);
            assert!(said.starts_with(name), "{said}");
            assert!(!road.load_torque(0.0, 0.0).is_finite() || name == "vehicle.mass");
        }
    }

    #[test]
    fn every_preset_has_a_road() {
        for p in [Params::TABLE_1, Params::WET_6, Params::DRY_7] {
            assert_eq!(refused(p.road), "");
        }
    }
}
