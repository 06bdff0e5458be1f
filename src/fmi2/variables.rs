//! One table for the fields of a model, their start values and their rows.

/// Defines a model all of whose fields are variables, with its `Default` and a table `TABLE` of them.
///
/// A line is a field, its row in the words of [`Variable`](crate::Variable) without the field, and its start
/// value, of a Real in SI units. The row tells the field's type: `f64`, `i32` for those of Integers and
/// enumerations, `bool`, `String`. A model with hidden states writes struct, `Default` and table itself.
///
/// ```
/// use fmi2_cosim::{Enumeration, Item, Unit};
///
/// const LID: Enumeration = Enumeration {
///     name: "Lid",
///     description: "What lies on the bucket",
///     items: &[
///         Item { name: "none", value: 0, description: "It is open" },
///         Item { name: "closed", value: 1, description: "Nothing comes in" },
///     ],
/// };
///
/// fmi2_cosim::variables! {
///     /// A bucket.
///     pub struct Bucket {
///         inflow: input("valve.flow", Unit::ONE, "what comes in").min(0.0) = 0.0,
///         lid: enumeration_parameter("bucket.lid", &LID, "what lies on it").tunable() = 0,
///         liquid: string_parameter("bucket.liquid", "what is poured in") = "water".into(),
///         content: output("bucket.content", Unit::ONE, "what is in it").depends_on(&[]) = 0.5,
///         spills: integer_output("bucket.spills", "how often it ran over").depends_on(&[]) = 0,
///         full: boolean_output("bucket.full", "no more goes in").depends_on(&[]).local() = false,
///     }
/// }
///
/// let bucket = Bucket::default();
/// assert_eq!((bucket.content, bucket.lid, bucket.full), (0.5, 0, false));
/// assert_eq!(Bucket::TABLE[3].name, "bucket.content");
/// fmi2_cosim::check(Bucket::TABLE);
/// ```
#[macro_export]
macro_rules! variables {
    (
        $(#[$about:meta])*
        $public:vis struct $model:ident {
            $(
                $field:ident: $row:ident($($said:expr),* $(,)?)
                    $(.$more:ident($($value:expr)?))* = $start:expr
            ),* $(,)?
        }
    ) => {
        $(#[$about])*
        #[derive(Clone)]
        $public struct $model {
            $($field: $crate::type_of_row!($row)),*
        }

        impl Default for $model {
            fn default() -> Self {
                Self { $($field: $start),* }
            }
        }

        impl $model {
            /// One row for each variable.
            $public const TABLE: &'static [$crate::Variable<Self>] = &[
                $($crate::row_of_field!($field: $row($($said),*)) $(.$more($($value)?))*),*
            ];
        }
    };
}

/// The type of a field by the constructor of its row.
#[doc(hidden)]
#[macro_export]
#[rustfmt::skip] // a list
macro_rules! type_of_row {
    (input) => { f64 };
    (parameter) => { f64 };
    (output) => { f64 };
    (boolean_input) => { bool };
    (boolean_parameter) => { bool };
    (boolean_output) => { bool };
    (string_input) => { ::std::string::String };
    (string_parameter) => { ::std::string::String };
    (string_output) => { ::std::string::String };
    ($integer_or_enumeration:ident) => { i32 };
}

/// A row without limits and the like; of a Real with its unit, of an enumeration with its type.
#[doc(hidden)]
#[macro_export]
macro_rules! row_of_field {
    ($field:ident: $row:ident($name:expr, $what:expr, $description:expr)) => {
        $crate::Variable::$row(
            $name,
            $what,
            |model: &mut Self| &mut model.$field,
            $description,
        )
    };
    ($field:ident: $row:ident($name:expr, $description:expr)) => {
        $crate::Variable::$row($name, |model: &mut Self| &mut model.$field, $description)
    };
}

/// `VERSION` and `LICENSE` of a [`Model`](crate::Model): those of the cargo package it is written in.
#[macro_export]
macro_rules! of_package {
    () => {
        const VERSION: &'static str = env!("CARGO_PKG_VERSION");
        const LICENSE: &'static str = env!("CARGO_PKG_LICENSE");
    };
}
