//! Propagators kept between steps: derived from parameters, gears and step, so no part of the state.

use dct_driveline::Params;
use dct_driveline::integrate::Propagators;
use dct_driveline::plant_matrices::Systems;
use std::sync::Arc;

/// How many combinations of gears and step are kept.
const KEPT: usize = 4;

/// The propagators of the last few steps; saved states share them.
#[derive(Clone, Default)]
pub(super) struct Propagation {
    kept: [Option<Arc<Propagators>>; KEPT],
    /// Which one was used last.
    latest: usize,
}

impl Propagation {
    /// Builds the propagators of `step` [s] and makes room for others, so that no step allocates.
    pub(super) fn prepare(&mut self, p: &Params, gear: [i32; 2], step: f64) {
        let first = Propagators::new(p, gear, step);
        self.kept = core::array::from_fn(|_| Some(Arc::new(first.clone())));
        self.latest = 0;
    }

    /// The propagators of these gears and this step [s].
    pub(super) fn of(&mut self, p: &Params, gear: [i32; 2], step: f64) -> &Propagators {
        let fits = |kept: &Option<Arc<Propagators>>| {
            kept.as_ref()
                .is_some_and(|propagators| propagators.fits(gear, step))
        };
        let found = if fits(&self.kept[self.latest]) {
            Some(self.latest)
        } else {
            self.kept.iter().position(fits)
        };
        self.latest = found.unwrap_or((self.latest + 1) % KEPT);
        let kept =
            self.kept[self.latest].get_or_insert_with(|| Propagators::new(p, gear, step).into());
        if !kept.fits(gear, step) {
            Arc::make_mut(kept).rebuild(p, gear, step);
        }
        kept
    }

    /// The matrices of these gears, where propagators of them are at hand.
    pub(super) fn systems(&self, gear: [i32; 2]) -> Option<&Systems> {
        let kept = self.kept[self.latest]
            .as_ref()
            .map(|propagators| &propagators.systems);
        kept.filter(|systems| systems.gear == gear)
    }
}
