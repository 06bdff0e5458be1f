//! How well the control makes the clutches carry what is requested.

use super::{CASES, Figures, STEP, place, rounded};
use crate::Result;
use crate::dct::closed_loop::{models, scenario};
use crate::drive::{Loop, Place};

/// `slipping` of the clutches' states.
const SLIPPING: f64 = 2.0;

/// Error of the torques while a clutch slips, with the observer and without.
pub(crate) fn control() -> Result<Figures> {
    let mut rows = Vec::new();
    for (feedback, name) in [(1.0, "with the observer"), (0.0, "map-based, without")] {
        let mut row = vec![name.to_owned()];
        for friction in CASES {
            let [missed, requested] = errors(feedback, friction)?;
            let share = rounded(100.0 * missed / requested);
            row.push(format!("{} ({share} %)", rounded(missed)));
        }
        rows.push(row);
    }
    Ok(Figures {
        caption: "RMS of |T_c| - request of both clutches while they slip, over the 30 s of the torque-tracking \
                  scenario at 1 kHz on DctPlant, in N·m (in % of the RMS request); the true friction is 0.26, 0.22"
            .into(),
        columns: vec!["control", "believed 0.4, 0.1", "believed 0.1, 0.4"],
        rows,
    })
}

/// RMS error and RMS request [N·m].
fn errors(feedback: f64, friction: [f64; 2]) -> Result<[f64; 2]> {
    let columns = [
        ("engine.speed_start", 90.0),
        ("clutch1.nominalFriction", friction[0]),
        ("clutch2.nominalFriction", friction[1]),
        ("feedback.enabled", feedback),
    ];
    let stimuli = scenario("torque_tracking.csv", &columns, f64::INFINITY)?;
    let mut all = Loop::new(models(), &stimuli);
    let clutches = [1, 2].map(|clutch| Clutch::of(&all, clutch));
    let (mut squares, mut count) = ([0.0; 2], 0.0);
    all.run(STEP, &mut |time, all| {
        let mut slipping = Vec::new();
        for Clutch([state, torque, request]) in clutches.iter().flatten() {
            if all.value(0, *state)? == SLIPPING {
                slipping.push((all.value(0, *torque)?.abs(), *request));
            }
        }
        all.exchange(time)?; // the requests of this communication point, not of the one before
        for (torque, request) in slipping {
            let request = all.value(2, request)?;
            let error = torque - request;
            squares[0] += error * error;
            squares[1] += request * request;
            count += 1.0;
        }
        Ok(())
    })?;
    Ok(squares.map(|square| (square / count).sqrt()))
}

/// Where the state and the torque of a clutch are in the plant, and its request in the control.
struct Clutch([Place; 3]);

impl Clutch {
    fn of(all: &Loop<'_>, number: u8) -> Option<Self> {
        let place = |at, what| place(all, at, &format!("clutch{number}.{what}"));
        Some(Self([
            place(0, "state")?,
            place(0, "torque")?,
            place(2, "torqueRequest")?,
        ]))
    }
}
