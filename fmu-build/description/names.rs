//! What a description calls the values of a model: one name for each row, then the aliases.

use fmi2_cosim::{Alias, Causality, Initial, Variability, Variable};

/// A variable of the description.
pub(crate) struct Named<'a, M: 'static> {
    /// Value reference: the index of the row.
    pub(crate) reference: usize,
    pub(crate) row: &'a Variable<M>,
    /// The name, unless it is the row's own.
    alias: Option<&'static Alias>,
}

/// All variables. Aliases are behind all rows, so that a row's place is its value reference plus 1.
pub(crate) fn all<M>(rows: &[Variable<M>]) -> impl Iterator<Item = Named<'_, M>> {
    let own = rows.iter().enumerate().map(|(reference, row)| Named {
        reference,
        row,
        alias: None,
    });
    let others = rows.iter().enumerate().flat_map(|(reference, row)| {
        row.aliases.iter().map(move |alias| Named {
            reference,
            row,
            alias: Some(alias),
        })
    });
    own.chain(others)
}

impl<M> Named<'_, M> {
    pub(crate) fn name(&self) -> &'static str {
        self.alias.map_or(self.row.name, |alias| alias.name)
    }

    pub(crate) fn description(&self) -> &'static str {
        self.alias
            .map_or(self.row.description, |alias| alias.description)
    }

    pub(crate) fn causality(&self) -> Causality {
        self.alias
            .map_or(self.row.causality, |alias| alias.causality)
    }

    /// FMI's `initial`. Of all names of a value one has a start value, but all names of a constant have it
    /// (FMI 2.0.4, 2.2.7).
    pub(crate) fn initial(&self) -> Option<Initial> {
        match (self.alias, self.row.variability) {
            (Some(_), variability) if variability != Variability::Constant => {
                Some(Initial::Calculated)
            }
            _ => self.row.initial(),
        }
    }
}
