//! What the observer's methods miss.

use super::{CASES, Figures, STEP, place, rounded};
use crate::Result;
use crate::dct::closed_loop::{models, scenario};
use crate::drive::{Loop, Place};

const TORQUES: [&str; 3] = ["clutch1.torque", "clutch2.torque", "driveShaft.torque"];
const METHODS: [&str; 5] = ["paper", "lyapunov", "energy", "kalman", "calibrating"];

/// What every method of the observer misses over the paper's scenario.
pub(crate) fn observer() -> Result<Figures> {
    let mut rows = Vec::new();
    for (method, name) in (1..).zip(METHODS) {
        let mut row = vec![name.to_owned()];
        for friction in CASES {
            let [estimate, _] = errors(method, friction)?;
            row.push(estimate.map(rounded).join(" / "));
        }
        rows.push(row);
    }
    let mut map = vec!["map-based, no observer".to_owned()];
    for friction in CASES {
        let [_, map_based] = errors(1, friction)?;
        map.push(map_based.map(rounded).join(" / "));
    }
    rows.push(map);
    Ok(Figures {
        caption: "RMS error of T_c1 / T_c2 / T_o in % of the RMS torque over the paper's 30 s at 1 kHz, on this \
                  plant, with exact sensors; the true friction is 0.26, 0.22"
            .into(),
        columns: vec!["method", "believed 0.4, 0.1", "believed 0.1, 0.4"],
        rows,
    })
}

/// Errors of the estimates and of the map-based torques [% of RMS].
fn errors(method: u8, friction: [f64; 2]) -> Result<[[f64; 3]; 2]> {
    let columns = [
        ("engine.speed_start", 90.0),
        ("clutch1.nominalFriction", friction[0]),
        ("clutch2.nominalFriction", friction[1]),
        ("observer.method", f64::from(method)),
    ];
    let stimuli = scenario("positions.csv", &columns, f64::INFINITY)?;
    let mut all = Loop::new(models().into_iter().take(2).collect(), &stimuli);
    let truth = places(&all, 0, "");
    let believed = [places(&all, 1, ""), places(&all, 1, "mapBased.")];
    let (mut squares, mut missed) = ([0.0; 3], [[0.0; 3]; 2]);
    all.run(STEP, &mut |_, all| {
        for torque in 0..3 {
            let exact = all.value(0, truth[torque])?;
            squares[torque] += exact * exact;
            for (missed, places) in missed.iter_mut().zip(&believed) {
                let error = all.value(1, places[torque])? - exact;
                missed[torque] += error * error;
            }
        }
        Ok(())
    })?;
    Ok(missed.map(|one| [0, 1, 2].map(|k| 100.0 * (one[k] / squares[k]).sqrt())))
}

fn places(all: &Loop<'_>, at: usize, prefix: &str) -> Vec<Place> {
    let torques = TORQUES.map(|torque| format!("{prefix}{torque}"));
    torques
        .iter()
        .filter_map(|name| place(all, at, name))
        .collect()
}
