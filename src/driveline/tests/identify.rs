//! Identification (17), (18) on a launch of the SciPy reference, which knows nothing of least squares.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    dead_code,
    reason = "helpers of tests"
)]

mod golden_files;

use dct_driveline::Params;
use dct_driveline::identify::{LeastSquares, Shaft};
use golden_files::Case;

/// Columns of the reference without its time.
const OMEGA_C2: usize = 3;
const OMEGA_W: usize = 5;
const T_O: usize = 9;
/// |T_o| from which rows count [N·m]: it has built up.
const BUILT_UP: f64 = 20.0;

/// Fit over the rows of a run until `stop` [s]; `spoil` adds to T_o [N·m] by row.
fn fit(name: &str, h: f64, stop: f64, spoil: impl Fn(u32) -> f64) -> Shaft {
    let (case, g2) = (Case::read(name), Params::TABLE_1.g([1, 2])[1]);
    let (mut fit, mut twist, mut last) = (LeastSquares::default(), 0.0, 0.0);
    for k in 0_u32.. {
        let time = f64::from(k) * h;
        let Some(row) = case.row(time).filter(|_| time <= stop) else {
            break;
        };
        let rate = row[OMEGA_C2] / g2 - row[OMEGA_W];
        twist += 0.5 * h * (last + rate);
        last = rate;
        if row[T_O].abs() >= BUILT_UP {
            fit.add(twist, rate, row[T_O] + spoil(k));
        }
    }
    fit.solve().unwrap()
}

/// Relative error of k_o and c_o that the transfer shaft of the open clutch may cost: ω_c2/g2 stands
/// for ω_o, and the inertia behind it swings by itself.
const TRANSFER_SHAFT: f64 = 3e-3;

#[test]
fn a_launch_gives_stiffness_and_damping_of_the_drive_shaft() {
    let p = Params::TABLE_1;
    for (name, h, stop) in [
        ("launch_continuous", 1e-3, 0.6),
        ("launch_continuous", 1e-3, 1.5),
        ("paper_compliant", 1e-2, 2.5),
    ] {
        let shaft = fit(name, h, stop, |_| 0.0);
        println!("{name} until {stop} s: {shaft:?}");
        assert!((shaft.k_o_eq.value / p.k_o - 1.0).abs() < TRANSFER_SHAFT);
        assert!((shaft.c_o_eq.value / p.c_o - 1.0).abs() < 2.0 * TRANSFER_SHAFT);
        assert!(shaft.r_squared > 0.9999);
    }
}

/// Errors of ±5 N·m that alternate fit no shaft: the standard errors say so, the estimates stay.
#[test]
fn errors_of_the_torque_sensor_show_in_the_standard_errors() {
    const ERROR: f64 = 5.0;
    let alternate = |k: u32| if k.is_multiple_of(2) { ERROR } else { -ERROR };
    let clean = fit("launch_continuous", 1e-3, 1.0, |_| 0.0);
    let noisy = fit("launch_continuous", 1e-3, 1.0, alternate);
    for (clean, noisy) in [(clean.k_o_eq, noisy.k_o_eq), (clean.c_o_eq, noisy.c_o_eq)] {
        assert!(noisy.standard_error > 10.0 * clean.standard_error);
        assert!((noisy.value - clean.value).abs() < 2.0 * noisy.standard_error);
    }
    assert!(noisy.r_squared < clean.r_squared);
}
