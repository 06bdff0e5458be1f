//! One table for the fields of a model, their start values and their rows.

/// Defines a model whose variables are all Real, with its `Default` and a table `TABLE` of its variables.
///
/// A line is a field, its row in the words of [`Variable`](crate::Variable) without the field, and its start
/// value in SI units. Models with other types or hidden states write struct, `Default` and table themselves.
///
/// ```
/// use fmi2_cosim::Unit;
///
/// fmi2_cosim::variables! {
///     /// A bucket.
///     pub struct Bucket {
///         inflow: input("valve.flow", Unit::ONE, "what comes in").min(0.0) = 0.0,
///         content: output("bucket.content", Unit::ONE, "what is in it").depends_on(&[]) = 0.5,
///     }
/// }
///
/// assert_eq!(Bucket::default().content, 0.5);
/// assert_eq!(Bucket::TABLE[1].name, "bucket.content");
/// ```
#[macro_export]
macro_rules! variables {
    (
        $(#[$about:meta])*
        $public:vis struct $model:ident {
            $(
                $field:ident: $row:ident($name:expr, $unit:expr, $description:expr)
                    $(.$more:ident($value:expr))* = $start:expr
            ),* $(,)?
        }
    ) => {
        $(#[$about])*
        #[derive(Clone)]
        $public struct $model {
            $($field: f64),*
        }

        impl Default for $model {
            fn default() -> Self {
                Self { $($field: $start),* }
            }
        }

        impl $model {
            /// One row for each variable.
            $public const TABLE: &'static [$crate::Variable<Self>] = &[
                $($crate::Variable::$row($name, $unit, |model: &mut Self| &mut model.$field, $description)
                    $(.$more($value))*),*
            ];
        }
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
