//! What a library keeps of its table: what it needs to answer calls, without what only the description says.

use crate::{Access, Causality, Model, Variability, Variable};

/// A [`Variable`] without description, unit, nominal value, whether it is a difference, and initial dependencies.
///
/// They stay out of the library, for nothing there points at the table itself: it answers from its rows.
pub struct Row<M: 'static> {
    pub(crate) name: &'static str,
    /// Smallest legal value; -∞ where there is none.
    pub(crate) min: f64,
    /// Largest legal value; ∞ where there is none.
    pub(crate) max: f64,
    pub(crate) access: Access<M>,
    pub(crate) dependencies: Option<&'static [&'static str]>,
    pub(crate) rate: Option<fn(&mut M) -> &mut f64>,
    pub(crate) slope: Option<fn(&mut M) -> &mut f64>,
    pub(crate) causality: Causality,
    pub(crate) variability: Variability,
    /// The model computes it: an output or a local variable that is no constant.
    pub(crate) computed: bool,
    pub(crate) on_demand: bool,
}

impl<M> Clone for Row<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Row<M> {}

impl<M> Row<M> {
    const fn of(variable: &Variable<M>) -> Self {
        let (min, max) = (variable.min, variable.max);
        Self {
            name: variable.name,
            min: if let Some(min) = min {
                min
            } else {
                f64::NEG_INFINITY
            },
            max: if let Some(max) = max {
                max
            } else {
                f64::INFINITY
            },
            access: variable.access,
            dependencies: variable.dependencies,
            rate: variable.rate,
            slope: variable.slope,
            causality: variable.causality,
            variability: variable.variability,
            computed: !matches!(variable.variability, Variability::Constant)
                && matches!(variable.causality, Causality::Output | Causality::Local),
            on_demand: variable.on_demand,
        }
    }
}

/// Whether a model has Strings. If not, nothing of how they are moved gets into its library.
pub(crate) const fn has_strings<M: Model>() -> bool {
    let mut row = 0;
    while row < M::VARIABLES.len() && !matches!(M::VARIABLES[row].access, Access::String(_)) {
        row += 1;
    }
    row < M::VARIABLES.len()
}

/// Whether a model has constants. If not, nothing of them gets into its library.
pub(crate) const fn has_constants<M: Model>() -> bool {
    let mut row = 0;
    while row < M::VARIABLES.len()
        && !matches!(M::VARIABLES[row].variability, Variability::Constant)
    {
        row += 1;
    }
    row < M::VARIABLES.len()
}

/// How many variables the description of a model has: as many as it has names. An importer may read all in one call.
pub(crate) const fn names<M: Model>() -> usize {
    let (mut names, mut row) = (M::VARIABLES.len(), 0);
    while row < M::VARIABLES.len() {
        names += M::VARIABLES[row].aliases.len();
        row += 1;
    }
    names
}

/// The rows of a model, in the order of the table.
pub(crate) fn rows<M: Model>() -> impl Iterator<Item = &'static Row<M>> {
    table::<M>().iter().flatten()
}

/// The row of a value reference.
#[inline]
pub(crate) fn row<M: Model>(reference: u32) -> Option<&'static Row<M>> {
    let index = usize::try_from(reference).ok()?;
    table::<M>().get(index)?.as_ref()
}

/// The longest table.
pub(crate) const MOST: usize = 8192;

/// No array can be as long as the table of whichever `M`: it has one of these lengths, the next one above,
/// and only that one gets into a library.
fn table<M: Model>() -> &'static [Option<Row<M>>] {
    macro_rules! shortest {
        ($($length:literal)*) => {
            $(if const { M::VARIABLES.len() <= $length } {
                return const { &padded::<M, $length>() };
            })*
        };
    }
    shortest!(8 16 24 32 40 48 56 64 72 80 88 96 104 112 120 128 136 144 152 160 168 176 184 192 200
        208 216 224 232 240 248 256 288 320 352 384 416 448 480 512 640 768 896 1024 2048 4096);
    const { &padded::<M, MOST>() }
}

/// All rows, and none behind them; of a table that is longer, no more than fit: the compiler makes those, too,
/// but nobody takes them.
const fn padded<M: Model, const N: usize>() -> [Option<Row<M>>; N] {
    let mut rows = [None; N];
    let mut index = 0;
    while index < M::VARIABLES.len() && index < N {
        rows[index] = Some(Row::of(&M::VARIABLES[index]));
        index += 1;
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Experiment, Failure, Log, StateFields, Unit};

    const LIMITS: [f64; 7] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];

    /// A model with `N` rows whose limits go round.
    #[derive(Clone, Default)]
    struct Tall<const N: usize>(f64);

    const fn variable<const N: usize>() -> Variable<Tall<N>> {
        Variable::input("", Unit::ONE, |m: &mut Tall<N>| &mut m.0, "")
    }

    impl<const N: usize> Model for Tall<N> {
        const NAME: &'static str = "Tall";
        const DESCRIPTION: &'static str = "";
        const EXPERIMENT: Experiment = Experiment::new(0.0, 1.0, 0.1);
        const VARIABLES: &'static [Variable<Self>] = &{
            let mut rows = [variable::<N>(); N];
            let mut index = 0;
            while index < N {
                rows[index] = variable::<N>().min(LIMITS[index % LIMITS.len()]);
                index += 1;
            }
            rows
        };

        fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
            Ok(())
        }

        fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
            Ok(())
        }

        fn hidden_state(&mut self, _: &mut dyn StateFields) {}
    }

    fn every_row_is_there<const N: usize>() {
        assert_eq!(rows::<Tall<N>>().count(), N);
        for ((reference, kept), limit) in (0..).zip(rows::<Tall<N>>()).zip(LIMITS.iter().cycle()) {
            assert_eq!((kept.min, kept.max), (*limit, f64::INFINITY));
            assert!(row::<Tall<N>>(reference).is_some_and(|row| core::ptr::eq(row, kept)));
        }
        let beyond = [N, N + 1, MOST].map(|index| u32::try_from(index).unwrap());
        assert!(
            beyond
                .into_iter()
                .all(|index| row::<Tall<N>>(index).is_none())
        );
    }

    #[test]
    fn there_is_a_row_for_every_variable_however_many_there_are() {
        every_row_is_there::<0>();
        every_row_is_there::<1>();
        every_row_is_there::<8>();
        every_row_is_there::<9>();
        every_row_is_there::<1100>();
        every_row_is_there::<MOST>();
    }
}
