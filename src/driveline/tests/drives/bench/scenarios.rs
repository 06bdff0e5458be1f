//! Scenarios: the paper's, and others on which nothing is tuned.

pub use super::random::random;
use super::{Knots, Scenario, faded, wet};
use dct_driveline::Params;

/// Table 1 with more gears on both shafts: `assumed:` ratios of a compact car.
pub fn six_gears() -> Params {
    Params {
        i_t: [[3.0, 1.35, 0.78, 0.0], [2.4, 1.25, 0.8, 0.0]],
        ..Params::TABLE_1
    }
}

fn knots(points: &[(f64, f64)]) -> Knots {
    points.to_vec()
}

/// Positions in mm to m.
pub fn mm(points: &[(f64, f64)]) -> Knots {
    points.iter().map(|(t, x)| (*t, x * 1e-3)).collect()
}

pub fn base(name: &str, stop: f64) -> Scenario {
    Scenario {
        name: name.to_string(),
        p: Params::TABLE_1,
        stop,
        omega_e: 90.0,
        v: 0.0,
        t_e: knots(&[(0.0, 0.0)]),
        theta: [mm(&[(0.0, 0.0)]), mm(&[(0.0, 0.0)])],
        pressure: [knots(&[(0.0, 0.0)]), knots(&[(0.0, 0.0)])],
        t_brake: knots(&[(0.0, 0.0)]),
        phi: knots(&[(0.0, 0.0)]),
        gears: vec![(0.0, [1, 2])],
    }
}

/// Fig. 9: launch, upshift, downshift, engine braking, tip-in, coast.
pub fn paper() -> Scenario {
    Scenario {
        t_e: knots(&[
            (0.0, 0.0),
            (1.0, 0.0),
            (1.6, 60.0),
            (4.0, 60.0),
            (4.3, 66.0),
            (9.3, 66.0),
            (9.5, -10.0),
            (10.1, -10.0),
            (10.6, 62.0),
            (13.0, 62.0),
            (13.4, 28.0),
            (16.0, 28.0),
            (16.3, 120.0),
            (17.65, 120.0),
            (17.95, 30.0),
            (18.8, 26.0),
            (21.8, 20.0),
            (22.1, -50.0),
            (23.8, -50.0),
            (24.2, 50.0),
            (26.0, 50.0),
            (26.4, -20.0),
            (28.4, -20.0),
            (28.8, 0.0),
            (30.0, 0.0),
        ]),
        theta: [
            mm(&[
                (0.0, 0.0),
                (0.8, 1.8),
                (1.0, 2.2),
                (1.8, 6.2),
                (2.6, 6.2),
                (3.2, 9.0),
                (8.6, 9.0),
                (8.9, 6.6),
                (9.3, 5.0),
                (9.55, 1.5),
                (9.7, 0.0),
                (16.6, 0.0),
                (17.0, 2.0),
                (17.5, 2.5),
                (17.75, 3.4),
                (18.0, 6.0),
                (18.6, 9.0),
                (28.2, 9.0),
                (28.6, 4.0),
                (28.8, 1.0),
                (29.0, 0.0),
                (30.0, 0.0),
            ]),
            mm(&[
                (0.0, 0.0),
                (8.2, 0.0),
                (8.6, 2.2),
                (8.9, 3.0),
                (9.4, 7.0),
                (10.6, 7.0),
                (11.1, 9.0),
                (15.7, 9.0),
                (16.1, 5.8),
                (17.4, 5.6),
                (17.75, 3.6),
                (18.0, 1.0),
                (18.1, 0.0),
                (30.0, 0.0),
            ]),
        ],
        phi: knots(&[
            (0.0, 0.0),
            (2.0, 0.0),
            (4.0, 0.05),
            (19.5, 0.05),
            (21.5, -0.04),
            (24.0, -0.04),
            (25.0, 0.0),
            (30.0, 0.0),
        ]),
        ..base("paper", 30.0)
    }
}

/// Creeps with a slipping clutch, holds a low speed, then pulls away.
pub fn creep() -> Scenario {
    Scenario {
        t_e: knots(&[
            (0.5, 0.0),
            (1.0, 12.0),
            (7.0, 14.0),
            (7.5, 55.0),
            (12.0, 55.0),
            (13.0, 15.0),
            (16.0, 15.0),
        ]),
        theta: [
            mm(&[
                (0.5, 0.0),
                (1.0, 3.1),
                (3.0, 3.4),
                (7.0, 3.3),
                (8.0, 5.4),
                (9.5, 6.0),
                (10.5, 9.0),
            ]),
            mm(&[(0.0, 0.0)]),
        ],
        phi: knots(&[(3.0, 0.0), (5.0, 0.015)]),
        ..base("creep", 16.0)
    }
}

/// Launches, gives up, rolls, launches again.
pub fn aborted_launch() -> Scenario {
    Scenario {
        t_e: knots(&[
            (0.5, 0.0),
            (1.0, 50.0),
            (1.8, 50.0),
            (2.1, 0.0),
            (4.0, 0.0),
            (4.4, 70.0),
            (9.0, 70.0),
            (9.5, 20.0),
            (12.0, 20.0),
        ]),
        theta: [
            mm(&[
                (0.5, 0.0),
                (1.2, 5.4),
                (1.8, 5.6),
                (2.1, 2.0),
                (2.3, 0.0),
                (4.0, 0.0),
                (4.8, 6.0),
                (6.5, 6.3),
                (7.2, 9.0),
            ]),
            mm(&[(0.0, 0.0)]),
        ],
        phi: knots(&[(0.0, 0.02)]),
        ..base("aborted launch", 12.0)
    }
}

/// Up from first to fourth gear, the next one preselected while its clutch is open.
pub fn double_upshift() -> Scenario {
    Scenario {
        p: six_gears(),
        t_e: knots(&[
            (0.3, 0.0),
            (0.8, 80.0),
            (4.8, 80.0),
            (5.1, 10.0),
            (5.6, 10.0),
            (6.0, 80.0),
            (8.8, 80.0),
            (9.1, 15.0),
            (9.7, 15.0),
            (10.1, 85.0),
            (13.2, 85.0),
            (13.5, 30.0),
            (14.2, 30.0),
            (14.6, 70.0),
            (18.0, 70.0),
        ]),
        theta: [
            mm(&[
                (0.3, 0.0),
                (1.0, 6.4),
                (2.6, 6.6),
                (3.2, 9.0),
                (4.5, 9.0),
                (4.9, 5.5),
                (5.2, 1.5),
                (5.3, 0.0),
                (8.6, 0.0),
                (8.9, 4.0),
                (9.2, 6.6),
                (9.9, 7.0),
                (10.3, 9.0),
                (12.9, 9.0),
                (13.3, 5.5),
                (13.6, 0.0),
            ]),
            mm(&[
                (4.3, 0.0),
                (4.7, 2.6),
                (5.1, 6.4),
                (5.9, 7.0),
                (6.3, 9.0),
                (8.4, 9.0),
                (8.9, 5.5),
                (9.2, 1.5),
                (9.3, 0.0),
                (12.6, 0.0),
                (13.1, 4.0),
                (13.5, 6.6),
                (14.3, 7.2),
                (14.8, 9.0),
            ]),
        ],
        gears: vec![(0.0, [1, 2]), (7.0, [3, 2]), (11.5, [3, 4])],
        ..base("double upshift", 18.0)
    }
}

/// Tip-in and tip-out in second gear, with the even clutch engaged and the odd shaft in neutral.
pub fn tip_in_tip_out() -> Scenario {
    Scenario {
        omega_e: 11.52 * 20.0,
        v: 6.0,
        t_e: knots(&[
            (0.5, 15.0),
            (0.8, 15.0),
            (0.9, 130.0),
            (2.5, 130.0),
            (2.6, -35.0),
            (4.5, -35.0),
            (4.7, 90.0),
            (6.0, 90.0),
            (6.3, 0.0),
            (7.5, 0.0),
            (7.6, 70.0),
            (8.2, 70.0),
            (8.3, -20.0),
            (10.0, -20.0),
        ]),
        theta: [mm(&[(0.0, 0.0)]), mm(&[(0.0, 9.0)])],
        gears: vec![(0.0, [0, 2])],
        ..base("tip-in, tip-out", 10.0)
    }
}

/// Kick-down from fourth to third to second gear under power.
pub fn kick_down() -> Scenario {
    Scenario {
        p: six_gears(),
        omega_e: 6.0 * 42.0,
        v: 12.6,
        t_e: knots(&[
            (0.0, 30.0),
            (1.0, 30.0),
            (1.2, 110.0),
            (4.3, 110.0),
            (4.5, 60.0),
            (6.0, 70.0),
            (6.2, 120.0),
            (8.5, 120.0),
            (8.7, 60.0),
            (12.0, 40.0),
        ]),
        theta: [
            mm(&[
                (2.0, 0.0),
                (2.3, 2.1),
                (3.2, 3.4),
                (3.6, 6.6),
                (4.2, 9.0),
                (6.0, 9.0),
                (6.3, 6.0),
                (7.2, 5.6),
                (7.5, 2.5),
                (7.7, 0.0),
            ]),
            mm(&[
                (1.2, 9.0),
                (1.6, 5.9),
                (3.2, 5.7),
                (3.5, 3.0),
                (3.7, 0.0),
                (6.2, 0.0),
                (6.6, 2.4),
                (7.3, 3.4),
                (7.6, 6.4),
                (8.4, 9.0),
            ]),
        ],
        gears: vec![(0.0, [3, 4]), (4.6, [3, 2])],
        phi: knots(&[(0.0, 0.02)]),
        ..base("kick-down", 12.0)
    }
}

/// Held on a hill by the brake, released against a slipping clutch, pulls away.
pub fn hill_hold() -> Scenario {
    Scenario {
        t_e: knots(&[
            (1.0, 0.0),
            (1.6, 45.0),
            (3.0, 60.0),
            (4.0, 85.0),
            (9.0, 85.0),
            (9.5, 60.0),
            (12.0, 60.0),
        ]),
        theta: [
            mm(&[
                (1.0, 0.0),
                (1.8, 4.6),
                (3.0, 5.4),
                (4.0, 6.2),
                (6.0, 6.5),
                (7.0, 9.0),
            ]),
            mm(&[(0.0, 0.0)]),
        ],
        t_brake: knots(&[(2.2, 800.0), (2.9, 0.0)]),
        phi: knots(&[(0.0, 0.08)]),
        ..base("hill hold", 12.0)
    }
}

/// Everything nothing was tuned on.
pub fn unseen() -> Vec<Scenario> {
    let mut all = vec![
        creep(),
        aborted_launch(),
        double_upshift(),
        tip_in_tip_out(),
        kick_down(),
        hill_hold(),
        faded::dry_7(),
        wet::wet_6(),
        faded::dry_7_fade(),
        faded::dry_7_hot(),
        wet::wet_6_fade(),
    ];
    all.extend([1, 2, 3].map(random));
    all
}

/// Every drive there is, the ones that gains were tuned on among them.
pub fn every() -> Vec<Scenario> {
    let mut all = vec![paper()];
    all.extend(unseen());
    all.extend((4..=9).chain(101..=108).map(random));
    all
}
