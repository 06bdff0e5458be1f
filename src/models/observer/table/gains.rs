//! Gains of every method, tunable; given for 1 ms where `gain.scheduled`.

use crate::observer::Observer;
use fmi2_cosim::{Unit as U, Variable};

/// Intensity of a torque's walk.
pub(super) const SQUARE_TORQUE_PER_SECOND: U = U::new("(N.m)2/s", [2, 4, -5, 0, 0, 0, 0, 0], &[]);
/// Intensity of a speed's walk.
pub(super) const SQUARE_SPEED_PER_SECOND: U = U::new("(rad/s)2/s", [0, 0, -3, 0, 0, 0, 0, 2], &[]);
/// L_c of (29), as ε̂' [N/(m·s)] = L_c (r N θ) [m2] a [1/(kg·m2)] x̃ [rad/s] has it.
const PAPER: U = U::new("kg.N/m", [2, 0, -2, 0, 0, 0, 0, 0], &[]);
/// L_c of `lyapunov`: ε̂' [N/(m·s)] over r N θ [m2] and a speed, by inertia ratios.
const LYAPUNOV: U = U::new("N2/(m2.J)", [1, -2, -2, 0, 0, 0, 0, 0], &[]);

/// A gain that may be zero.
const fn gain(
    name: &'static str,
    unit: U,
    field: fn(&mut Observer) -> &mut f64,
    description: &'static str,
) -> Variable<Observer> {
    Variable::parameter(name, unit, field, description)
        .min(0.0)
        .tunable()
}

/// All of them: `paper` without a prefix, the others under their names.
pub(super) const GAINS: [Variable<Observer>; 19] = [
    gain(
        "gain.L11",
        U::PER_SECOND,
        |m| &mut m.settings.gains.l_11,
        "L11 of (27), paper",
    ),
    gain(
        "gain.L22",
        U::PER_SECOND,
        |m| &mut m.settings.gains.l_22,
        "L22 of (27), paper",
    ),
    gain(
        "gain.Lc1",
        PAPER,
        |m| &mut m.settings.gains.l_c[0],
        "L_c1 of (29), with the position in m, paper",
    ),
    gain(
        "gain.Lc2",
        PAPER,
        |m| &mut m.settings.gains.l_c[1],
        "L_c2 of (29), with the position in m, paper",
    ),
    gain(
        "gain.lyapunov.L11",
        U::PER_SECOND,
        |m| &mut m.settings.lyapunov.l_11,
        "L11, lyapunov",
    ),
    gain(
        "gain.lyapunov.L22",
        U::PER_SECOND,
        |m| &mut m.settings.lyapunov.l_22,
        "L22, lyapunov",
    ),
    gain(
        "gain.lyapunov.Lc1",
        LYAPUNOV,
        |m| &mut m.settings.lyapunov.l_c[0],
        "L_c1, with the position in m, lyapunov",
    ),
    gain(
        "gain.lyapunov.Lc2",
        LYAPUNOV,
        |m| &mut m.settings.lyapunov.l_c[1],
        "L_c2, with the position in m, lyapunov",
    ),
    gain(
        "gain.p2",
        U::ONE,
        |m| &mut m.settings.lyapunov.p_2,
        "p2 of V: weight of the error of x2 over that of its energy, lyapunov",
    )
    .min(WEIGHT),
    gain(
        "gain.p3",
        U::ONE,
        |m| &mut m.settings.lyapunov.p_3,
        "p3 of V: weight of the error of c x2 - x3 over that of its energy, lyapunov",
    )
    .min(WEIGHT),
    gain(
        "gain.energy.engine",
        U::PER_SECOND,
        |m| &mut m.settings.energy.l[0],
        "l_e: correction of the engine speed, energy",
    ),
    gain(
        "gain.energy.output",
        U::PER_SECOND,
        |m| &mut m.settings.energy.l[1],
        "l_o: correction of the output speed, energy",
    ),
    gain(
        "gain.energy.wheel",
        U::PER_SECOND,
        |m| &mut m.settings.energy.l[2],
        "l_w: correction of the wheel speed, energy",
    ),
    gain(
        "gain.energy.Lc",
        U::NEWTON_METRE_PER_RADIAN,
        |m| &mut m.settings.energy.l_c,
        "L of both clutches, before it is normalised, energy",
    ),
    gain(
        "gain.kalman.clutch",
        U::PER_SECOND,
        |m| &mut m.settings.kalman.q_t,
        "q_T: intensity of the friction of a slipping clutch, relative, kalman",
    ),
    gain(
        "gain.kalman.load",
        SQUARE_TORQUE_PER_SECOND,
        |m| &mut m.settings.kalman.q_v,
        "q_v: intensity of the load torque, kalman",
    ),
    gain(
        "gain.kalman.speed",
        SQUARE_SPEED_PER_SECOND,
        |m| &mut m.settings.kalman.q_w,
        "q_w: intensity of the speeds, kalman",
    ),
    gain(
        "gain.kalman.shaft",
        SQUARE_TORQUE_PER_SECOND,
        |m| &mut m.settings.kalman.q_s,
        "q_s: intensity of the drive shaft's spring torque, kalman",
    ),
    gain(
        "gain.kalman.sensor",
        U::RADIAN_PER_SECOND,
        |m| &mut m.settings.kalman.sigma,
        "Standard deviation of a measured speed, kalman",
    )
    .min(SENSOR),
];

/// Smallest weight of a Lyapunov function.
const WEIGHT: f64 = 1e-9;
/// Smallest deviation of a measured speed [rad/s]: without any a filter divides by zero.
pub(super) const SENSOR: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;
    use fmi2_cosim::Model as _;

    /// Product of powers of units.
    fn product(factors: &[(U, i8)]) -> [i8; 8] {
        let sum = |base: usize| {
            factors
                .iter()
                .map(|(unit, n)| n * unit.exponents[base])
                .sum()
        };
        core::array::from_fn(sum)
    }

    fn unit(name: &str) -> [i8; 8] {
        let row = Observer::VARIABLES.iter().find(|row| row.name == name);
        row.map(|row| row.unit.exponents).unwrap()
    }

    #[test]
    fn units_follow_from_the_equations() {
        let torque = (U::NEWTON_METRE, 2);
        let speed = (U::RADIAN_PER_SECOND, 2);
        let rate = (U::PER_SECOND, 1);
        for method in ["kalman", "calibrating"] {
            let told = |name: &str| unit(&format!("gain.{method}.{name}"));
            assert_eq!(told("clutch"), product(&[rate]), "{method}: relative");
            assert_eq!(told("load"), product(&[torque, rate]), "{method}");
            assert_eq!(told("shaft"), product(&[torque, rate]), "{method}");
            assert_eq!(told("speed"), product(&[speed, rate]), "{method}");
            assert_eq!(
                told("sensor"),
                product(&[(U::RADIAN_PER_SECOND, 1)]),
                "{method}"
            );
        }
        // ε̂' over r N θ and a speed without its rad.
        let adaptation = [(U::NEWTON_PER_METRE, 1), (U::SQUARE_METRE, -1)];
        let inertia = (U::KILOGRAM_SQUARE_METRE, 1);
        for k in 1..=2 {
            let [first, second] = adaptation;
            assert_eq!(unit(&format!("gain.lyapunov.Lc{k}")), product(&adaptation));
            assert_eq!(
                unit(&format!("gain.Lc{k}")),
                product(&[first, second, inertia])
            );
        }
        // μ̂' [1/s] over 1/w [1/(N.m)] and a speed.
        let energy = [(U::NEWTON_METRE, 1), rate, (U::RADIAN_PER_SECOND, -1)];
        assert_eq!(unit("gain.energy.Lc"), product(&energy));
    }
}
