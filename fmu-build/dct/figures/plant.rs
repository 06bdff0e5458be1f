//! What the plant's steps cost in accuracy.

use super::{Figures, place, rounded};
use crate::Result;
use crate::dct::closed_loop::{models, scenario};
use crate::drive::Loop;

/// Communication steps in parts of the longest one, which is the grid on which runs are compared.
const PARTS: [u32; 4] = [1, 2, 10, 100];
/// The longest communication step [s].
const LONGEST: f64 = 1e-2;

/// What a run leaves to be compared.
#[derive(Default)]
struct Run {
    /// Drive-shaft torque at every point of the grid [N·m].
    torque: Vec<f64>,
    /// Energy that the balance cannot account for, the most of it [J].
    residual: f64,
    /// Energy that both clutches have turned into heat [J].
    heat: f64,
}

/// Drive-shaft torque against that of the shortest step; energy that got lost.
pub(crate) fn plant() -> Result<Figures> {
    let runs: Vec<_> = PARTS.into_iter().map(run).collect::<Result<_>>()?;
    let mut rows = Vec::new();
    for (parts, run) in PARTS.iter().zip(&runs) {
        let missed = match runs.last() {
            Some(best) if run.torque.len() == best.torque.len() && *parts < PARTS[3] => {
                rounded(missed(run, best))
            }
            _ => "reference".into(),
        };
        let step = 1e3 * LONGEST / f64::from(*parts);
        let residual = format!("{:.0e}", run.residual);
        rows.push(vec![format!("{step}"), missed, residual]);
    }
    let heat = rounded(1e-3 * runs.last().map_or(0.0, |run| run.heat));
    Ok(Figures {
        caption: format!(
            "The paper's 30 s, inputs held over each communication step. T_o: RMS difference to the shortest step in \
             % of RMS, which is what holding the inputs costs. Energy: the most that the balance cannot account for, \
             while both clutches turn {heat} kJ into heat"
        ),
        columns: vec!["communication step [ms]", "T_o [%]", "energy lost [J]"],
        rows,
    })
}

fn run(parts: u32) -> Result<Run> {
    let stimuli = scenario(
        "positions.csv",
        &[("engine.speed_start", 90.0)],
        f64::INFINITY,
    )?;
    let mut all = Loop::new(models().into_iter().take(1).collect(), &stimuli);
    let names = [
        "driveShaft.torque",
        "energy.residual",
        "clutch1.frictionEnergy",
        "clutch2.frictionEnergy",
    ];
    let places: Vec<_> = names
        .iter()
        .filter_map(|name| place(&all, 0, name))
        .collect();
    let (mut run, mut point) = (Run::default(), 0_u32);
    all.run(LONGEST / f64::from(parts), &mut |_, all| {
        let mut values = [0.0; 4];
        for (value, place) in values.iter_mut().zip(&places) {
            *value = all.value(0, *place)?;
        }
        let [torque, residual, heat1, heat2] = values;
        run.residual = run.residual.max(residual.abs());
        run.heat = heat1 + heat2;
        if point % parts == 0 {
            run.torque.push(torque);
        }
        point += 1;
        Ok(())
    })?;
    Ok(run)
}

/// RMS difference [% of RMS].
fn missed(run: &Run, best: &Run) -> f64 {
    let differences = run
        .torque
        .iter()
        .zip(&best.torque)
        .map(|(one, other)| one - other);
    let square = |sum: f64, value: f64| sum + value * value;
    let (missed, whole) = (
        differences.fold(0.0, square),
        best.torque.iter().copied().fold(0.0, square),
    );
    100.0 * (missed / whole).sqrt()
}
