//! Strings: read and set under the rules of other variables. They may be of any length, so they are no `Value`.

use super::{Instance, distinct};
use crate::row::{Row, row};
use crate::value::{as_many, settable};
use crate::{Access, Call, Error, Log, Model};

type Field<M> = fn(&mut M) -> &mut String;

impl<M: Model> Instance<M> {
    /// `fmi2GetString`: the texts, in the order of their references.
    ///
    /// Outputs are computed first when something was set since.
    ///
    /// # Errors
    /// For a reference of another type, and when the model fails.
    pub fn strings(
        &mut self,
        references: &[u32],
        log: &mut Log<'_>,
    ) -> Result<impl Iterator<Item = String>, Error> {
        self.permit(Call::GetString)?;
        let found = all::<M>(references)?;
        if found.iter().any(|(row, _)| row.computed) {
            self.refresh(log)?;
        }
        let model = &mut self.now.model;
        Ok(found.into_iter().map(|(_, field)| field(model).clone()))
    }

    /// `fmi2SetString`: checks everything, then writes everything.
    ///
    /// # Errors
    /// For another number of texts than of references, a reference of another type or one that is there twice, and a
    /// row that may not be set now.
    pub fn set_strings(&mut self, references: &[u32], texts: &[&str]) -> Result<(), Error> {
        self.permit(Call::SetString)?;
        as_many(references.len(), texts.len())?;
        distinct::<M>(references)?;
        let found = all::<M>(references)?;
        for (row, _) in &found {
            settable(row, self.now.state)?;
        }
        for ((_, field), &text) in found.into_iter().zip(texts) {
            text.clone_into(field(&mut self.now.model));
            self.now.stale = true;
        }
        Ok(())
    }
}

type Found<M> = Vec<(&'static Row<M>, Field<M>)>;

/// The rows of these references with their fields.
fn all<M: Model>(references: &[u32]) -> Result<Found<M>, Error> {
    let find = |&reference: &u32| {
        let found = row::<M>(reference).and_then(|row| match row.access {
            Access::String(field) => Some((row, field)),
            _ => None,
        });
        let kind = "String";
        found.ok_or(Error::UnknownReference { reference, kind })
    };
    references.iter().map(find).collect()
}
