//! A variable by its name and type, found by the compiler.

use crate::check::same;
use crate::{Access, Alias, Error, Instance, Log, Model, Value};
use core::fmt;
use core::marker::PhantomData;

/// The variable of type `T` of a model that has a name, e.g. in a model's own tests.
///
/// In a constant a name that the table does not have, or that is of another type, does not compile. One of an
/// [`Alias`] leads to the same value.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/tank.rs"));
/// use fmi2_cosim::{Error, Instance, Reference};
///
/// const INFLOW: Reference<Tank, f64> = Reference::named("inflow");
/// const CONTENT: Reference<Tank, f64> = Reference::named("volume");
///
/// # fn main() -> Result<(), Error> {
/// let mut tank = Instance::<Tank>::default();
/// tank.write(INFLOW, 0.002)?;
/// assert_eq!(tank.read(CONTENT, &mut Log::silent())?, 0.0);
/// assert!(Reference::<Tank, i32>::find("inflow").is_none()); // it is a Real
/// # Ok(())
/// # }
/// ```
///
/// A name that is not there:
///
/// ```compile_fail,E0080
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/tank.rs"));
/// # use fmi2_cosim::Reference;
/// const INFLOW: Reference<Tank, f64> = Reference::named("inflwo");
/// # fn main() { let _ = INFLOW; }
/// ```
pub struct Reference<M, T> {
    number: u32,
    of: PhantomData<fn(&mut M) -> &mut T>,
}

impl<M: Model, T: Typed> Reference<M, T> {
    /// The variable of that name.
    ///
    /// # Panics
    /// When the table has no such name, or it is of another type: in a constant that is an error of the compiler.
    #[must_use]
    #[expect(clippy::panic)] // the only way to fail to compile
    pub const fn named(name: &str) -> Self {
        match Self::find(name) {
            Some(found) => found,
            None => panic!("the table has no variable of that name and type"),
        }
    }

    /// The variable of that name, if the table has one and it is of this type.
    #[must_use]
    pub const fn find(name: &str) -> Option<Self> {
        let (rows, mut number) = (M::VARIABLES, 0);
        let mut index = 0;
        while index < rows.len() {
            let row = &rows[index];
            if same(row.name, name) || is_alias(row.aliases, name) {
                let of = PhantomData;
                let found = same(T::TYPE, exchanged(&row.access));
                return if found {
                    Some(Self { number, of })
                } else {
                    None
                };
            }
            (index, number) = (index + 1, number + 1);
        }
        None
    }

    /// FMI's value reference: the place in the table.
    #[must_use]
    pub const fn value_reference(self) -> u32 {
        self.number
    }
}

const fn is_alias(aliases: &[Alias], name: &str) -> bool {
    let mut index = 0;
    while index < aliases.len() && !same(aliases[index].name, name) {
        index += 1;
    }
    index < aliases.len()
}

/// The type of a row as the getters and setters have it.
const fn exchanged<M>(access: &Access<M>) -> &'static str {
    match access {
        Access::Enumeration(..) => "Integer",
        other => other.type_name(),
    }
}

impl<M, T> Clone for Reference<M, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M, T> Copy for Reference<M, T> {}

impl<M, T> fmt::Debug for Reference<M, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Reference").field(&self.number).finish()
    }
}

impl<M, T> PartialEq for Reference<M, T> {
    fn eq(&self, other: &Self) -> bool {
        self.number == other.number
    }
}

impl<M, T> Eq for Reference<M, T> {}

/// A type of variables: `f64` (Real), `i32` (Integer, Enumeration), `bool` (Boolean) or `String`; no other.
pub trait Typed: Exchanged {}

impl<T: Value> Typed for T {}
impl Typed for String {}

/// How an instance exchanges a value of a type. Nobody else can name it.
pub trait Exchanged: Sized {
    /// FMI's name of the type.
    const TYPE: &'static str;

    /// [`Instance::get`] of one.
    fn read_from<M: Model>(
        instance: &mut Instance<M>,
        reference: u32,
        log: &mut Log<'_>,
    ) -> Result<Self, Error>;

    /// [`Instance::set`] of one.
    fn write_to<M: Model>(self, instance: &mut Instance<M>, reference: u32) -> Result<(), Error>;
}

impl<T: Value> Exchanged for T {
    const TYPE: &'static str = T::KIND;

    fn read_from<M: Model>(
        instance: &mut Instance<M>,
        reference: u32,
        log: &mut Log<'_>,
    ) -> Result<Self, Error> {
        let value = instance.get(&[reference], log)?.next();
        let kind = T::KIND;
        value.ok_or(Error::UnknownReference { reference, kind })
    }

    fn write_to<M: Model>(self, instance: &mut Instance<M>, reference: u32) -> Result<(), Error> {
        instance.set(&[reference], core::iter::once(self))
    }
}

impl Exchanged for String {
    const TYPE: &'static str = "String";

    fn read_from<M: Model>(
        instance: &mut Instance<M>,
        reference: u32,
        log: &mut Log<'_>,
    ) -> Result<Self, Error> {
        let text = instance.strings(&[reference], log)?.next();
        let kind = Self::TYPE;
        text.ok_or(Error::UnknownReference { reference, kind })
    }

    fn write_to<M: Model>(self, instance: &mut Instance<M>, reference: u32) -> Result<(), Error> {
        instance.set_strings(&[reference], &[&self])
    }
}

impl<M: Model> Instance<M> {
    /// The value of one variable: [`Self::get`], or [`Self::strings`], by its name.
    ///
    /// # Errors
    /// When the value is not finite, and when the model fails.
    pub fn read<T: Typed>(
        &mut self,
        variable: Reference<M, T>,
        log: &mut Log<'_>,
    ) -> Result<T, Error> {
        T::read_from(self, variable.number, log)
    }

    /// Sets one variable: [`Self::set`], or [`Self::set_strings`], by its name.
    ///
    /// # Errors
    /// When it may not be set now, and when the value is out of its range.
    pub fn write<T: Typed>(&mut self, variable: Reference<M, T>, value: T) -> Result<(), Error> {
        value.write_to(self, variable.number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Enumeration, Experiment, Failure, Item, StateFields, Unit, Variable};

    const LID: Enumeration = Enumeration {
        name: "Lid",
        description: "",
        items: &[Item {
            name: "open",
            value: 1,
            description: "",
        }],
    };

    /// A bucket with a variable of every type.
    #[derive(Clone)]
    struct Bucket {
        inflow: f64,
        lid: i32,
        count: i32,
        full: bool,
        liquid: String,
    }

    impl Default for Bucket {
        fn default() -> Self {
            Self {
                inflow: 0.0,
                lid: 1,
                count: 0,
                full: false,
                liquid: "water".into(),
            }
        }
    }

    impl Model for Bucket {
        const NAME: &'static str = "Bucket";
        const DESCRIPTION: &'static str = "";
        const EXPERIMENT: Experiment = Experiment::new(0.0, 1.0, 0.1);
        const VARIABLES: &'static [Variable<Self>] = &[
            Variable::input("inflow", Unit::ONE, |m: &mut Self| &mut m.inflow, "")
                .aliases(&[Alias::local("in", "")]),
            Variable::enumeration_input("lid", &LID, |m: &mut Self| &mut m.lid, ""),
            Variable::integer_input("count", |m: &mut Self| &mut m.count, ""),
            Variable::boolean_input("full", |m: &mut Self| &mut m.full, ""),
            Variable::string_parameter("liquid", |m: &mut Self| &mut m.liquid, ""),
        ];

        fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
            Ok(())
        }

        fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
            Ok(())
        }

        fn hidden_state(&mut self, _: &mut dyn StateFields) {}
    }

    fn comes_back<T: Typed + Clone + PartialEq + fmt::Debug>(name: &str, value: T) {
        let variable = Reference::<Bucket, T>::named(name);
        let mut bucket = Instance::default();
        bucket.write(variable, value.clone()).unwrap();
        assert_eq!(bucket.read(variable, &mut Log::silent()), Ok(value));
    }

    #[test]
    fn a_value_of_every_type_is_written_and_read_by_name() {
        comes_back("inflow", 0.5);
        comes_back("in", 0.5);
        comes_back("lid", 1);
        comes_back("count", -3);
        comes_back("full", true);
        comes_back("liquid", String::from("oil"));
        let mut bucket = Instance::default();
        let wrong = bucket.write(Reference::<Bucket, i32>::named("lid"), 2);
        assert!(wrong.is_err_and(|error| error.to_string() == "lid = 2 is no value of Lid"));
    }

    #[test]
    fn a_name_is_found_under_its_own_type_only() {
        let types = |name| {
            [
                Reference::<Bucket, f64>::find(name).map(Reference::value_reference),
                Reference::<Bucket, i32>::find(name).map(Reference::value_reference),
                Reference::<Bucket, bool>::find(name).map(Reference::value_reference),
                Reference::<Bucket, String>::find(name).map(Reference::value_reference),
            ]
        };
        assert_eq!(types("inflow"), [Some(0), None, None, None]);
        assert_eq!(types("in"), [Some(0), None, None, None]);
        assert_eq!(types("lid"), [None, Some(1), None, None]);
        assert_eq!(types("count"), [None, Some(2), None, None]);
        assert_eq!(types("full"), [None, None, Some(3), None]);
        assert_eq!(types("liquid"), [None, None, None, Some(4)]);
        for name in ["", "inflo", "inflows"] {
            assert_eq!(types(name), [None; 4]);
        }
    }
}
