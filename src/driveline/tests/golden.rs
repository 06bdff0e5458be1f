//! The plant against the independent SciPy reference in `tests/golden`, inputs held per step.
//!
//! Limits: events within 0.1 ms, speeds within 1e-3 rad/s and torques within 1e-2 N·m away from ±2 ms
//! of an event.

mod golden_files;

use dct_driveline::Params;
use dct_driveline::integrate::Propagators;
use dct_driveline::plant::{Input, InputRate, Output, Plant};
use golden_files::{Case, ClutchEvent};

const SPEED_LIMIT: f64 = 1e-3;
const TORQUE_LIMIT: f64 = 1e-2;
const EVENT_LIMIT: f64 = 1e-4;
const AROUND_EVENT: f64 = 2e-3;

/// Largest differences of a run from its reference.
#[derive(Debug, Default)]
struct Misfit {
    speed: f64,
    torque: f64,
    event: f64,
}

fn input_at(case: &Case, p: &Params, time: f64) -> Input {
    let signal = |name: &str| case.scenario.at(name, time);
    Input {
        t_e: signal("engine.torque"),
        force: [
            p.clutch[0].map.force(signal("clutch1.position")),
            p.clutch[1].map.force(signal("clutch2.position")),
        ],
        gear: [1, 2],
        t_brake: 0.0,
        phi: signal("road.grade"),
    }
}

fn values(y: &Output) -> [f64; 11] {
    [
        y.omega_e,
        y.omega_d,
        y.omega_c[0],
        y.omega_c[1],
        y.omega_o,
        y.omega_w,
        y.t_d,
        y.t_c[0],
        y.t_c[1],
        y.t_o,
        y.t_v,
    ]
}

/// Compares a row, except next to an event.
fn compare(case: &Case, time: f64, y: &Output, misfit: &mut Misfit) {
    let Some(row) = case.row(time) else { return };
    if case
        .events
        .iter()
        .any(|event| (event.time - time).abs() < AROUND_EVENT)
    {
        return;
    }
    for (column, (ours, theirs)) in values(y).iter().zip(row).enumerate() {
        let worst = if column < 6 {
            &mut misfit.speed
        } else {
            &mut misfit.torque
        };
        *worst = worst.max((ours - theirs).abs());
    }
    for i in [0, 1] {
        assert_eq!(
            f64::from(y.state[i] as u8),
            row[11 + i],
            "state of clutch {i} at {time} s"
        );
    }
}

fn run(name: &str) -> Misfit {
    let case = Case::read(name);
    let p = Params {
        rigid: case.rigid,
        ..Params::TABLE_1
    };
    let mut propagators = Propagators::new(&p, [1, 2], case.h);
    let mut plant = Plant::start(&p, &input_at(&case, &p, 0.0), case.omega_e, case.v);
    let mut misfit = Misfit::default();
    let mut ours = Vec::new();
    let mut k = 0_u32;
    let mut time = 0.0;
    while time < case.stop - 1e-9 {
        let input = input_at(&case, &p, time);
        let end = (f64::from(k + 1) * case.h).min(case.stop);
        if !propagators.fits([1, 2], end - time) {
            propagators = Propagators::new(&p, [1, 2], end - time);
        }
        plant.step_observed(
            &p,
            &propagators,
            &input,
            &InputRate::default(),
            |offset, before, after| {
                for i in (0..2).filter(|i| before[*i] != after[*i]) {
                    ours.push(ClutchEvent::new(time + offset, i, before[i], after[i]));
                }
            },
        );
        compare(
            &case,
            end,
            &plant.outputs(&p, &propagators.systems, &input),
            &mut misfit,
        );
        (k, time) = (k + 1, end);
    }
    misfit.event = case.compare_events(&ours);
    let residual = plant.energy_residual(&propagators.systems).abs();
    println!(
        "{name}: {misfit:?}, energy residual {residual:.1e} J of {:.1e} J",
        case.turnover
    );
    assert!(
        residual < 1e-6 * case.turnover,
        "energy residual {residual} J"
    );
    misfit
}

fn check(name: &str) {
    let misfit = run(name);
    assert!(misfit.event < EVENT_LIMIT, "{misfit:?}");
    assert!(misfit.speed < SPEED_LIMIT, "{misfit:?}");
    assert!(misfit.torque < TORQUE_LIMIT, "{misfit:?}");
}

macro_rules! golden {
    ($($name:ident)*) => {$(
        #[test]
        fn $name() {
            check(stringify!($name));
        }
    )*};
}

golden! {
    paper_compliant paper_rigid tie_up tie_up_rigid break_away overrun slip_reversal slip_through_zero
    slip_returns_h10 coast_grade hill_start launch_both launch_h10 launch_h1 launch_h01 last_step
}
