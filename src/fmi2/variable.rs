//! The row: everything the shell and the packager know of one variable, written once.

use crate::{Alias, Enumeration, Unit};

/// How the shell reaches a variable of model `M`, and its FMI type: to read it as well.
///
/// What reaches an input or output points at a field and does nothing else; what reaches a parameter may do
/// more, e.g. give the model a copy of its own of what it shares with others.
pub enum Access<M> {
    /// `fmi2Real`.
    Real(fn(&mut M) -> &mut f64),
    /// `fmi2Integer`.
    Integer(fn(&mut M) -> &mut i32),
    /// `fmi2Boolean`.
    Boolean(fn(&mut M) -> &mut bool),
    /// `fmi2Integer` at the ABI, `Enumeration` in the description.
    Enumeration(fn(&mut M) -> &mut i32, &'static Enumeration),
    /// `fmi2String`. To set or read one allocates.
    String(fn(&mut M) -> &mut String),
}

impl<M> Clone for Access<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Access<M> {}

impl<M> Access<M> {
    /// Name of the type in the model description.
    #[must_use]
    pub const fn type_name(&self) -> &'static str {
        match self {
            Self::Real(_) => "Real",
            Self::Integer(_) => "Integer",
            Self::Boolean(_) => "Boolean",
            Self::Enumeration(..) => "Enumeration",
            Self::String(_) => "String",
        }
    }
}

/// FMI's `causality`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set by the importer before or, when tunable, during the run.
    Parameter,
    /// Set by the importer at every communication point.
    Input,
    /// Computed by the model for other models.
    Output,
    /// Computed by the model for people.
    Local,
}

/// FMI's `variability`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Never changes after initialisation.
    Fixed,
    /// A parameter that may change at communication points.
    Tunable,
    /// Changes at communication points only.
    Discrete,
    /// Changes all the time.
    Continuous,
    /// Has its start value for ever.
    Constant,
}

/// FMI's `initial`. Inputs have none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Initial {
    /// The start value is the initial value.
    Exact,
    /// Computed from others in initialisation mode.
    Calculated,
}

/// Who gives a value and when it may change.
type Kind = (Causality, Variability);

const CONTINUOUS_INPUT: Kind = (Causality::Input, Variability::Continuous);
const DISCRETE_INPUT: Kind = (Causality::Input, Variability::Discrete);
const CONTINUOUS_OUTPUT: Kind = (Causality::Output, Variability::Continuous);
const DISCRETE_OUTPUT: Kind = (Causality::Output, Variability::Discrete);
const PARAMETER: Kind = (Causality::Parameter, Variability::Fixed);

/// A row of the table: name, roles, unit, limits, dependencies, and where the value lives.
///
/// ```
/// use fmi2_cosim::{Unit, Variable};
///
/// #[derive(Default)]
/// struct Tank { inflow: f64, level: f64, area: f64 }
///
/// const VARIABLES: &[Variable<Tank>] = &[
///     Variable::input("inflow", Unit::ONE, |m: &mut Tank| &mut m.inflow, "Inflow").min(0.0),
///     Variable::parameter("area", Unit::SQUARE_METRE, |m: &mut Tank| &mut m.area, "Base area"),
///     Variable::output("level", Unit::METRE, |m: &mut Tank| &mut m.level, "Level").depends_on(&[]),
/// ];
/// # assert_eq!(VARIABLES[2].name, "level");
/// ```
#[must_use = "a row does something in a table only"]
#[non_exhaustive]
pub struct Variable<M: 'static> {
    /// Structured name, e.g. `valve1.position`.
    pub name: &'static str,
    /// One sentence with the symbol and equation number.
    pub description: &'static str,
    /// Role.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// Unit of a Real.
    pub unit: Unit,
    /// Smallest legal value.
    pub min: Option<f64>,
    /// Largest legal value.
    pub max: Option<f64>,
    /// Typical magnitude, for importers that scale.
    pub nominal: Option<f64>,
    /// FMI's `relativeQuantity`: a difference, which the offset of a display unit does not move.
    pub relative: bool,
    /// Outputs: names of the inputs it depends on directly at a communication point.
    pub dependencies: Option<&'static [&'static str]>,
    /// Outputs and locals: what their initial value depends on; `None`: on all inputs and parameters.
    pub initial_dependencies: Option<&'static [&'static str]>,
    /// The value.
    pub access: Access<M>,
    /// Inputs: where the first time derivative goes (`fmi2SetRealInputDerivatives`).
    pub rate: Option<fn(&mut M) -> &mut f64>,
    /// Outputs: where the first time derivative is read (`fmi2GetRealOutputDerivatives`).
    pub slope: Option<fn(&mut M) -> &mut f64>,
    /// Outputs and locals: `update_outputs` of the model computes it, not `step`.
    pub on_demand: bool,
    /// Further names of the value.
    pub aliases: &'static [Alias],
}

impl<M> Clone for Variable<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Variable<M> {}

impl<M> Variable<M> {
    const fn new(
        name: &'static str,
        description: &'static str,
        (causality, variability): Kind,
        access: Access<M>,
    ) -> Self {
        Self {
            name,
            description,
            causality,
            variability,
            unit: Unit::ONE,
            min: None,
            max: None,
            nominal: None,
            relative: false,
            dependencies: None,
            initial_dependencies: None,
            access,
            rate: None,
            slope: None,
            on_demand: false,
            aliases: &[],
        }
    }

    /// A Real input, continuous.
    pub const fn input(
        name: &'static str,
        unit: Unit,
        field: fn(&mut M) -> &mut f64,
        description: &'static str,
    ) -> Self {
        Self::new(name, description, CONTINUOUS_INPUT, Access::Real(field)).unit(unit)
    }

    /// An Enumeration input, discrete.
    pub const fn enumeration_input(
        name: &'static str,
        kind: &'static Enumeration,
        field: fn(&mut M) -> &mut i32,
        description: &'static str,
    ) -> Self {
        let access = Access::Enumeration(field, kind);
        Self::new(name, description, DISCRETE_INPUT, access)
    }

    /// A Real parameter, fixed.
    pub const fn parameter(
        name: &'static str,
        unit: Unit,
        field: fn(&mut M) -> &mut f64,
        description: &'static str,
    ) -> Self {
        Self::new(name, description, PARAMETER, Access::Real(field)).unit(unit)
    }

    /// An Enumeration parameter, fixed.
    pub const fn enumeration_parameter(
        name: &'static str,
        kind: &'static Enumeration,
        field: fn(&mut M) -> &mut i32,
        description: &'static str,
    ) -> Self {
        let access = Access::Enumeration(field, kind);
        Self::new(name, description, PARAMETER, access)
    }

    /// A Real output, continuous.
    pub const fn output(
        name: &'static str,
        unit: Unit,
        field: fn(&mut M) -> &mut f64,
        description: &'static str,
    ) -> Self {
        Self::new(name, description, CONTINUOUS_OUTPUT, Access::Real(field)).unit(unit)
    }

    /// An Enumeration output, discrete.
    pub const fn enumeration_output(
        name: &'static str,
        kind: &'static Enumeration,
        field: fn(&mut M) -> &mut i32,
        description: &'static str,
    ) -> Self {
        let access = Access::Enumeration(field, kind);
        Self::new(name, description, DISCRETE_OUTPUT, access)
    }

    const fn unit(mut self, unit: Unit) -> Self {
        self.unit = unit;
        self
    }

    /// Smallest legal value, in the variable's unit.
    pub const fn min(mut self, min: f64) -> Self {
        self.min = Some(min);
        self
    }

    /// Largest legal value, in the variable's unit.
    pub const fn max(mut self, max: f64) -> Self {
        self.max = Some(max);
        self
    }

    /// Typical magnitude, in the variable's unit.
    pub const fn nominal(mut self, nominal: f64) -> Self {
        self.nominal = Some(nominal);
        self
    }

    /// Makes a Real a difference of two values of its unit: people read 10 K of it as 10 °C, not as −263.15 °C.
    pub const fn relative(mut self) -> Self {
        self.relative = true;
        self
    }

    /// Makes a parameter tunable: it may be set at communication points too.
    pub const fn tunable(mut self) -> Self {
        self.variability = Variability::Tunable;
        self
    }

    /// Makes a Real input or output discrete: it changes at communication points only.
    pub const fn discrete(mut self) -> Self {
        self.variability = Variability::Discrete;
        self
    }

    /// Makes an output a local variable: shown to people, not offered for connection.
    ///
    /// # Panics
    /// For anything but an output: in a table that is a fault which the compiler reports.
    pub const fn local(mut self) -> Self {
        assert!(
            matches!(self.causality, Causality::Output),
            "only an output can be made local"
        );
        self.causality = Causality::Local;
        self
    }

    /// Makes an output, or a local variable, a constant: importers read its start value, always. The model may use
    /// the field, but not change it; `cargo fmu check` tells if it does.
    pub const fn constant(mut self) -> Self {
        self.variability = Variability::Constant;
        if self.dependencies.is_none() {
            self.dependencies = Some(&[]);
        }
        self
    }

    /// Gives the value further names; all have one value reference.
    pub const fn aliases(mut self, aliases: &'static [Alias]) -> Self {
        self.aliases = aliases;
        self
    }

    /// The inputs an output depends on directly; `&[]`: on states only.
    pub const fn depends_on(mut self, names: &'static [&'static str]) -> Self {
        self.dependencies = Some(names);
        self
    }

    /// The inputs and parameters that an output's initial value depends on.
    pub const fn initially_depends_on(mut self, names: &'static [&'static str]) -> Self {
        self.initial_dependencies = Some(names);
        self
    }

    /// Leaves the value to `update_outputs`, which is called before it is read.
    pub const fn on_demand(mut self) -> Self {
        self.on_demand = true;
        self
    }

    /// Where an input's first time derivative is stored: the importer may give it.
    pub const fn rate(mut self, field: fn(&mut M) -> &mut f64) -> Self {
        self.rate = Some(field);
        self
    }

    /// Where an output's first time derivative is found: the importer may ask for it.
    pub const fn slope(mut self, field: fn(&mut M) -> &mut f64) -> Self {
        self.slope = Some(field);
        self
    }

    /// FMI's `initial`; `None` for inputs.
    pub const fn initial(&self) -> Option<Initial> {
        match (self.causality, self.variability) {
            (Causality::Input, _) => None,
            (Causality::Parameter, _) | (_, Variability::Constant) => Some(Initial::Exact),
            (Causality::Output | Causality::Local, _) => Some(Initial::Calculated),
        }
    }
}

/// Constructors that need neither a unit nor an enumeration.
macro_rules! constructors {
    ($($about:literal $name:ident: $access:ident($value:ty), $kind:ident;)*) => {
        impl<M> Variable<M> {
            $(
                #[doc = $about]
                pub const fn $name(
                    name: &'static str,
                    field: fn(&mut M) -> &mut $value,
                    description: &'static str,
                ) -> Self {
                    Self::new(name, description, $kind, Access::$access(field))
                }
            )*
        }
    };
}

constructors! {
    "An Integer input, discrete." integer_input: Integer(i32), DISCRETE_INPUT;
    "A Boolean input, discrete." boolean_input: Boolean(bool), DISCRETE_INPUT;
    "A String input, discrete." string_input: String(String), DISCRETE_INPUT;
    "An Integer parameter, fixed." integer_parameter: Integer(i32), PARAMETER;
    "A Boolean parameter, fixed." boolean_parameter: Boolean(bool), PARAMETER;
    "A String parameter, fixed." string_parameter: String(String), PARAMETER;
    "An Integer output, discrete." integer_output: Integer(i32), DISCRETE_OUTPUT;
    "A Boolean output, discrete." boolean_output: Boolean(bool), DISCRETE_OUTPUT;
    "A String output, discrete." string_output: String(String), DISCRETE_OUTPUT;
}
