//! Propagators kept between steps: derived from parameters, coupling and step, so no part of the state.

use super::Plant;
use super::sets::Check;
use super::shared::Shared;
use super::shelf::User;
use dct_driveline::Params;
use dct_driveline::coupling::Coupling;
use dct_driveline::integrate::{Ladders, Propagators};
use dct_driveline::matrices::Systems;
use fmi2_cosim::{Failure, Model};
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

    #[inline(always)]
    fn of_gears(&mut self, p: &Params, gear: [i32; 2]) -> &Propagators {
        self.propagation.of_gears(p, gear, self.step)
    }
}

/// The propagators of the last few steps, from the shelf that all plants share.
#[derive(Default)]
pub(super) struct Propagation {
    kept: [Option<Arc<Propagators>>; KEPT],
    /// Which one was used last.
    latest: usize,
    user: Option<User>,
}

/// A saved state keeps the shelf, not what it finds there: that is found again.
impl Clone for Propagation {
    fn clone(&self) -> Self {
        Self {
            user: self.user.clone(),
            ..Self::default()
        }
    }
}

impl Propagation {
    /// Forgets what was kept, as the parameters may have changed, and finds what a run begins with. The parameters are
    /// shared from now on.
    ///
    /// # Errors
    /// When the parameters do not pass the check.
    pub(super) fn begin(
        &mut self,
        p: &mut Shared,
        check: Check,
        coupling: Coupling,
        step: f64,
    ) -> Result<(), Failure> {
        (self.kept, self.latest) = (Default::default(), 0);
        self.kept[0] = Some(User::begin(
            &mut self.user,
            p.held(),
            check,
            coupling,
            step,
        )?);
        Ok(())
    }

    /// Turns to the propagators of this coupling and this step [s] before a run, and sees that other steps than
    /// those kept allocate nothing.
    pub(super) fn turn_to(&mut self, p: &Params, coupling: Coupling, step: f64) {
        let latest = self.kept[self.latest % KEPT].as_ref();
        if !latest.is_some_and(|kept| kept.fits(coupling, step)) {
            self.of(p, coupling, step);
            self.user.get_or_insert_with(User::new).make_room();
        }
    }

    /// The propagators of this coupling and this step [s].
    #[inline(always)]
    pub(super) fn of(&mut self, p: &Params, coupling: Coupling, step: f64) -> &Propagators {
        let latest = &self.kept[self.latest % KEPT];
        if !latest
            .as_ref()
            .is_some_and(|kept| kept.fits(coupling, step))
        {
            self.look_for(coupling, step);
        }
        let user = &mut self.user;
        self.kept[self.latest % KEPT].get_or_insert_with(|| {
            let user = user.get_or_insert_with(User::new);
            user.find(p, coupling, step)
        })
    }

    /// [`Self::of`] where gears are all that is connected.
    #[inline(always)]
    pub(super) fn of_gears(&mut self, p: &Params, gear: [i32; 2], step: f64) -> &Propagators {
        let latest = &self.kept[self.latest % KEPT];
        if !latest
            .as_ref()
            .is_some_and(|kept| kept.fits_gears(gear, step))
        {
            self.look_for(gear.into(), step);
        }
        let user = &mut self.user;
        self.kept[self.latest % KEPT].get_or_insert_with(|| find_gears(user, p, gear, step))
    }

    /// Turns to the propagators that fit, or to room for them.
    #[cold]
    #[inline(never)]
    fn look_for(&mut self, coupling: Coupling, step: f64) {
        let fits = |kept: &Option<Arc<Propagators>>| {
            kept.as_ref()
                .is_some_and(|propagators| propagators.fits(coupling, step))
        };
        let found = self.kept.iter().position(fits);
        self.latest = found.unwrap_or((self.latest + 1) % KEPT);
        if found.is_none() {
            self.kept[self.latest] = None;
        }
    }

    /// The matrices of this coupling, whatever the step.
    pub(super) fn systems(&mut self, p: &Params, coupling: Coupling) -> &Systems {
        let kept = self.kept[self.latest].as_ref();
        let step = match kept.filter(|kept| kept.systems.coupling == coupling) {
            Some(kept) => kept.h,
            None => Plant::EXPERIMENT.step,
        };
        &self.of(p, coupling, step).systems
    }
}

#[cold]
#[inline(never)]
fn find_gears(user: &mut Option<User>, p: &Params, gear: [i32; 2], step: f64) -> Arc<Propagators> {
    let user = user.get_or_insert_with(User::new);
    user.find(p, gear.into(), step)
}

#[cfg(test)]
mod tests {
    use super::super::shelf::alone;
    use super::{KEPT, Propagation};
    use dct_driveline::Params;
    use dct_driveline::coupling::Coupling;
    use dct_driveline::integrate::Propagators;

    fn place(propagation: &mut Propagation, step: f64) -> *const Propagators {
        propagation.of(&Params::TABLE_1, Coupling::from([1, 2]), step)
    }

    #[test]
    fn a_step_that_repeats_but_for_rounding_finds_its_propagators() {
        let (_guard, mut propagation) = (alone(), Propagation::default());
        let first = place(&mut propagation, 1e-2);
        for step in [
            0.009_999_999_999_999_8,
            1e-2 * (1.0 + 9e-10),
            1e-2 * (1.0 - 9e-10),
        ] {
            assert_eq!(place(&mut propagation, step), first, "{step} s");
        }
        assert_ne!(place(&mut propagation, 1e-2 * (1.0 + 2e-9)), first);
    }

    #[test]
    fn four_step_sizes_in_turn_are_kept() {
        let (_guard, mut propagation) = (alone(), Propagation::default());
        let steps = [1e-3, 2e-3, 1.4e-3, 1e-2];
        assert_eq!(steps.len(), KEPT);
        let first = steps.map(|step| place(&mut propagation, step));
        for _ in 0..3 {
            assert_eq!(steps.map(|step| place(&mut propagation, step)), first);
        }
    }
}
