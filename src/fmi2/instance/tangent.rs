//! Directional derivatives: how the outputs change when the inputs move in a direction.

use super::{Instance, distinct};
use crate::row::{Row, rows};
use crate::value::{Sealed as _, as_many, find, finite};
use crate::{Call, Causality, Error, Log, Model};

/// Whether a model has directional derivatives: it computes them, or no output depends on an input.
#[must_use]
pub fn provides_directional_derivatives<M: Model>() -> bool {
    let mut outputs = reals::<M>(Causality::Output);
    M::TANGENT || outputs.all(|row| row.dependencies == Some(&[]))
}

fn reals<M: Model>(causality: Causality) -> impl Iterator<Item = &'static Row<M>> {
    rows::<M>().filter(move |row| row.causality == causality && f64::field(&row.access).is_some())
}

impl<M: Model> Instance<M> {
    /// `fmi2GetDirectionalDerivative`: Σ ∂unknown/∂known · direction, per unknown.
    ///
    /// `unknowns`: Real outputs. `knowns`: Real inputs; the others stay, and so does the state. `direction`: one
    /// number per known. `derivatives`: where the results go, one per unknown; untouched after an error.
    ///
    /// # Errors
    /// When the model has none, for a reference that is no output or no input of type Real, and for other numbers of
    /// values than of references.
    pub fn directional_derivative(
        &mut self,
        (unknowns, knowns): (&[u32], &[u32]),
        direction: &[f64],
        derivatives: &mut [f64],
        log: &mut Log<'_>,
    ) -> Result<(), Error> {
        self.permit(Call::GetDirectionalDerivative)?;
        if !provides_directional_derivatives::<M>() {
            return Err(Error::NotSupported("directional derivatives"));
        }
        as_many(knowns.len(), direction.len())?;
        as_many(unknowns.len(), derivatives.len())?;
        distinct::<M>(knowns)?;
        for &reference in unknowns {
            of_causality::<M>(reference, Causality::Output)?;
        }
        for (&reference, &value) in knowns.iter().zip(direction) {
            finite(of_causality::<M>(reference, Causality::Input)?.name, value)?;
        }
        self.refresh(log)?;
        let mut seed = self.seed(knowns, direction);
        self.now.model.tangent(&mut seed);
        for (to, &reference) in derivatives.iter_mut().zip(unknowns) {
            if let Some(found) = derivative(&mut seed, reference, knowns) {
                *to = found;
            }
        }
        Ok(())
    }

    /// The model with the direction in its Real inputs.
    #[inline(never)] // one model on the caller's stack, not two
    fn seed(&self, knowns: &[u32], direction: &[f64]) -> M {
        let mut seed = self.now.model.clone();
        for field in reals::<M>(Causality::Input).filter_map(|row| f64::field(&row.access)) {
            *field(&mut seed) = 0.0;
        }
        for (&reference, &value) in knowns.iter().zip(direction) {
            if let Ok((_, field)) = find::<M, f64>(reference) {
                *field(&mut seed) = value;
            }
        }
        seed
    }
}

/// The result for one output: 0 where its row says that it depends on none of the knowns.
fn derivative<M: Model>(result: &mut M, unknown: u32, knowns: &[u32]) -> Option<f64> {
    let (row, field) = find::<M, f64>(unknown).ok()?;
    let named = |known: &u32| {
        let found = find::<M, f64>(*known).ok()?;
        Some(found.0.name)
    };
    let depends = |names: &[&str]| {
        knowns
            .iter()
            .filter_map(named)
            .any(|name| names.contains(&name))
    };
    if row.dependencies.is_none_or(depends) {
        Some(*field(result))
    } else {
        Some(0.0)
    }
}

fn of_causality<M: Model>(reference: u32, causality: Causality) -> Result<&'static Row<M>, Error> {
    let (row, _) = find::<M, f64>(reference)?;
    if row.causality == causality {
        Ok(row)
    } else {
        Err(Error::NotDifferentiable { variable: row.name })
    }
}
