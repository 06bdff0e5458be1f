//! The GUID: a hash of the table and its start values, so that a library refuses a model
//! description that was written from another table.

use crate::hash::Hash;
use crate::row::{has_strings, rows};
use crate::{Access, Alias, Enumeration, Model, Unit, Variable};
use core::any::TypeId;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// GUID of model `M`, as in `modelDescription.xml`: `{xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx}`.
///
/// What the table says is hashed by the compiler, the start values once in a process.
#[must_use]
pub fn guid<M: Model>() -> String {
    text(kept_hash::<M>()).map(char::from).iter().collect()
}

/// How a GUID is written; each x is a digit.
const LAYOUT: Text = *b"{xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx}";

/// The characters of a GUID.
pub(crate) type Text = [u8; 38];

/// The GUID that [`table_hash`] makes.
pub(crate) fn text(hash: u128) -> Text {
    let mut rest = hash;
    LAYOUT.map(|place| {
        if place != b'x' {
            return place;
        }
        rest = rest.rotate_left(4);
        let [digit, ..] = rest.to_le_bytes();
        match digit % 16 {
            digit @ 0..10 => b'0' + digit,
            digit => b'a' + digit - 10,
        }
    })
}

/// [`table_hash`], made once for each model of a process; an FMU has one model, and keeps its own.
pub(crate) fn kept_hash<M: Model>() -> u128 {
    static KEPT: Mutex<BTreeMap<TypeId, u128>> = Mutex::new(BTreeMap::new());
    let kept = || KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let model = TypeId::of::<M>();
    if let Some(hash) = kept().get(&model) {
        return *hash;
    }
    let hash = table_hash::<M>(); // without the lock: a start value may ask for another model's GUID
    kept().insert(model, hash);
    hash
}

/// The GUID as a number. What the table says is hashed by the compiler; so the library need not hold it.
pub(crate) fn table_hash<M: Model>() -> u128 {
    let mut hash = const { said::<M>() };
    let mut model = M::default();
    for row in rows::<M>() {
        match row.access {
            Access::Real(field) => hash.bytes(&field(&mut model).to_bits().to_le_bytes()),
            Access::Boolean(field) => hash.bytes(&[u8::from(*field(&mut model))]),
            Access::Integer(field) | Access::Enumeration(field, _) => {
                hash.bytes(&field(&mut model).to_le_bytes());
            }
            Access::String(field) if const { has_strings::<M>() } => hash.text(field(&mut model)),
            Access::String(_) => {}
        }
    }
    hash.value()
}

/// Hash of everything but the start values.
const fn said<M: Model>() -> Hash {
    let mut hash = Hash::new();
    hash.text(M::NAME);
    hash.text(M::DESCRIPTION);
    let experiment = M::EXPERIMENT;
    number(&mut hash, experiment.start);
    number(&mut hash, experiment.stop);
    number(&mut hash, experiment.step);
    let mut index = 0;
    while index < M::VARIABLES.len() {
        add(&mut hash, &M::VARIABLES[index]);
        index += 1;
    }
    hash
}

const fn add<M>(hash: &mut Hash, row: &Variable<M>) {
    hash.text(row.name);
    hash.text(row.description);
    hash.text(row.access.type_name());
    hash.bytes(&[row.causality as u8, row.variability as u8]);
    hash.bytes(&[row.rate.is_some() as u8, row.slope.is_some() as u8]);
    unit(hash, &row.unit);
    limit(hash, row.min);
    limit(hash, row.max);
    limit(hash, row.nominal);
    names(hash, row.dependencies);
    names(hash, row.initial_dependencies);
    if let Access::Enumeration(_, kind) = row.access {
        enumeration(hash, kind);
    }
    if row.relative {
        hash.text("relative");
    }
    if !row.aliases.is_empty() {
        aliases(hash, row.aliases);
    }
}

const fn aliases(hash: &mut Hash, aliases: &[Alias]) {
    count(hash, aliases.len());
    let mut index = 0;
    while index < aliases.len() {
        let alias = &aliases[index];
        hash.text(alias.name);
        hash.text(alias.description);
        hash.bytes(&[alias.causality as u8]);
        index += 1;
    }
}

const fn unit(hash: &mut Hash, unit: &Unit) {
    hash.text(unit.name);
    let mut base = 0;
    while base < unit.exponents.len() {
        hash.bytes(&unit.exponents[base].to_le_bytes());
        base += 1;
    }
    count(hash, unit.display.len());
    let mut index = 0;
    while index < unit.display.len() {
        let display = &unit.display[index];
        hash.text(display.name);
        number(hash, display.factor);
        number(hash, display.offset);
        index += 1;
    }
}

const fn enumeration(hash: &mut Hash, kind: &Enumeration) {
    hash.text(kind.name);
    hash.text(kind.description);
    count(hash, kind.items.len());
    let mut index = 0;
    while index < kind.items.len() {
        let item = &kind.items[index];
        hash.text(item.name);
        hash.bytes(&item.value.to_le_bytes());
        hash.text(item.description);
        index += 1;
    }
}

const fn names(hash: &mut Hash, names: Option<&[&str]>) {
    hash.bytes(&[names.is_some() as u8]);
    let Some(names) = names else {
        return;
    };
    count(hash, names.len());
    let mut index = 0;
    while index < names.len() {
        hash.text(names[index]);
        index += 1;
    }
}

const fn limit(hash: &mut Hash, limit: Option<f64>) {
    hash.bytes(&[limit.is_some() as u8]);
    if let Some(limit) = limit {
        number(hash, limit);
    }
}

const fn number(hash: &mut Hash, number: f64) {
    hash.bytes(&number.to_bits().to_le_bytes());
}

const fn count(hash: &mut Hash, count: usize) {
    hash.bytes(&(count as u64).to_le_bytes());
}

#[cfg(test)]
mod tests {
    use super::guid;
    use crate::{Experiment, Failure, Log, Model, StateFields, Unit, Variable};
    use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    static MADE: AtomicUsize = AtomicUsize::new(0);

    /// A model that counts how often it is made.
    #[derive(Clone)]
    struct Counted(f64);

    impl Default for Counted {
        fn default() -> Self {
            MADE.fetch_add(1, Relaxed);
            Self(0.5)
        }
    }

    impl Model for Counted {
        const NAME: &'static str = "Counted";
        const DESCRIPTION: &'static str = "";
        const EXPERIMENT: Experiment = Experiment::new(0.0, 1.0, 0.1);
        const VARIABLES: &'static [Variable<Self>] =
            &[Variable::input("u", Unit::ONE, |m: &mut Self| &mut m.0, "")];

        fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
            Ok(())
        }

        fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
            Ok(())
        }

        fn hidden_state(&mut self, _: &mut dyn StateFields) {}
    }

    /// A model whose row is a temperature or a difference of two.
    #[derive(Clone, Default)]
    struct Warm<const DIFFERENCE: bool>(f64);

    impl<const DIFFERENCE: bool> Model for Warm<DIFFERENCE> {
        const NAME: &'static str = "Warm";
        const DESCRIPTION: &'static str = "";
        const EXPERIMENT: Experiment = Experiment::new(0.0, 1.0, 0.1);
        const VARIABLES: &'static [Variable<Self>] = &[{
            let row = Variable::input("u", Unit::KELVIN, |m: &mut Self| &mut m.0, "");
            if DIFFERENCE { row.relative() } else { row }
        }];

        fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
            Ok(())
        }

        fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
            Ok(())
        }

        fn hidden_state(&mut self, _: &mut dyn StateFields) {}
    }

    #[test]
    fn a_difference_is_another_variable() {
        assert_ne!(guid::<Warm<true>>(), guid::<Warm<false>>());
    }

    #[test]
    fn a_model_is_made_once_for_its_guid() {
        let first = guid::<Counted>();
        assert_eq!(guid::<Counted>(), first);
        assert_eq!(MADE.load(Relaxed), 1);
    }
}
