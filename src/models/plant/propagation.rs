//! Propagators kept between steps: derived from parameters, coupling and step, so no part of the state.

use dct_driveline::Params;
use dct_driveline::coupling::{Coupling, Ladders};
use dct_driveline::integrate::Propagators;
use dct_driveline::plant_matrices::Systems;
use std::sync::Arc;

/// How many combinations of coupling and step are kept.
const KEPT: usize = 4;

/// The propagators of one step, whatever its coupling becomes.
pub(super) struct OneStep<'a> {
    pub(super) propagation: &'a mut Propagation,
    /// Communication step [s].
    pub(super) step: f64,
}

impl Ladders for OneStep<'_> {
    fn of(&mut self, p: &Params, coupling: Coupling) -> &Propagators {
        self.propagation.of(p, coupling, self.step)
    }
}

/// The propagators of the last few steps; saved states share them.
#[derive(Clone, Default)]
pub(super) struct Propagation {
    kept: [Option<Arc<Propagators>>; KEPT],
    /// Which one was used last.
    latest: usize,
}

impl Propagation {
    /// Builds the propagators of `step` [s] and makes room for others, so that no step allocates.
    pub(super) fn prepare(&mut self, p: &Params, coupling: Coupling, step: f64) {
        let first = Propagators::new(p, coupling, step);
        self.kept = core::array::from_fn(|_| Some(Arc::new(first.clone())));
        self.latest = 0;
    }

    /// The propagators of this coupling and this step [s].
    pub(super) fn of(&mut self, p: &Params, coupling: Coupling, step: f64) -> &Propagators {
        let fits = |kept: &Option<Arc<Propagators>>| {
            kept.as_ref()
                .is_some_and(|propagators| propagators.fits(coupling, step))
        };
        let found = if fits(&self.kept[self.latest]) {
            Some(self.latest)
        } else {
            self.kept.iter().position(fits)
        };
        self.latest = found.unwrap_or((self.latest + 1) % KEPT);
        let kept = self.kept[self.latest]
            .get_or_insert_with(|| Propagators::new(p, coupling, step).into());
        if !kept.fits(coupling, step) {
            Arc::make_mut(kept).rebuild(p, coupling, step);
        }
        kept
    }

    /// The matrices of this coupling, where propagators of it are at hand.
    pub(super) fn systems(&self, coupling: Coupling) -> Option<&Systems> {
        let kept = self.kept[self.latest]
            .as_ref()
            .map(|propagators| &propagators.systems);
        kept.filter(|systems| systems.coupling == coupling)
    }
}
