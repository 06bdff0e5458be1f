//! Communication steps: those of the paper's scenario, and the longest of a model.

use fmi2_cosim::{Experiment, Failure, TIME_TOLERANCE};

/// The paper's scenario at 1 kHz.
pub(crate) const SCENARIO: Experiment = Experiment::new(0.0, 30.0, 1e-3);

/// Refuses a `step` [s] above `longest` [s], rounding of an importer's differences aside.
pub(crate) fn check_step(step: f64, longest: f64) -> Result<(), Failure> {
    if step > longest * (1.0 + TIME_TOLERANCE) {
        Err(Failure::StepTooLong { step, longest })
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::check_step;

    #[test]
    fn a_step_of_rounded_differences_is_taken_and_a_longer_one_is_not() {
        assert!(check_step(0.300_000_000_000_000_04 - 0.2, 0.1).is_ok());
        assert!(check_step(0.100_1, 0.1).is_err());
    }
}
