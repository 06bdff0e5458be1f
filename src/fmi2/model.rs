//! What a model author writes: a struct, its table of rows, how it starts and how it steps.

use crate::number::{Number, Seconds};
use crate::{LoadError, Resources, Variable};
use core::fmt;

/// A model that the shell turns into an FMI 2.0 co-simulation FMU.
///
/// The struct holds everything the model knows: parameters, inputs, states, outputs. `Default` is
/// the model at its start values; those are the ones the model description shows. `Clone` is a saved
/// FMU state, so it must be cheap and must copy everything that `step` reads. None of the methods
/// may print, open files (but for `load`), spawn threads or touch process-wide settings, and `step` and
/// `update_outputs` may not allocate, but for a String.
pub trait Model: Clone + Default + Send + 'static {
    /// `modelName` and `modelIdentifier`: a C identifier, e.g. `DctPlant`.
    const NAME: &'static str;
    /// One sentence for the model description.
    const DESCRIPTION: &'static str;
    /// Version of the model, e.g. `env!("CARGO_PKG_VERSION")`; empty: the description states none.
    const VERSION: &'static str = "";
    /// Licence of the model, e.g. `env!("CARGO_PKG_LICENSE")`; empty: the description states none.
    const LICENSE: &'static str = "";
    /// The one table everything else is derived from. A row's index is its value reference.
    const VARIABLES: &'static [Variable<Self>];
    /// `DefaultExperiment` of the model description.
    const EXPERIMENT: Experiment;

    /// Whether `initialize` and `step` fail by themselves rather than leave an output that is not finite. Else the
    /// shell looks at every output after each of them; at those on demand it looks when they are read.
    const STEPS_STAY_FINITE: bool = false;

    /// The model reads files that come with its FMU: [`Self::load`] is there.
    const RESOURCES: bool = false;

    /// Takes from the files under `resources/` of the FMU what the model needs of them, e.g. a map. `None`: the
    /// importer named no folder.
    ///
    /// Called once, when an instance is made, of a model at its start values; it leaves the variables of the table
    /// alone. What it loads is neither a variable nor a hidden state: it is there again after a reset, and where a
    /// serialised state is read back. Large data belongs into an `Arc`, as `Clone` is a saved state.
    ///
    /// # Errors
    /// When the model cannot start from the files: the importer gets no instance, and the error in its log.
    fn load(&mut self, resources: Option<&Resources>, log: &mut Log<'_>) -> Result<(), LoadError> {
        let _ = (resources, log);
        Ok(())
    }

    /// Computes the initial state and outputs from parameters, inputs and start values.
    ///
    /// `time` is the start time [s]. May be called more than once before the first step (an importer
    /// may read outputs in initialisation mode between sets), so it must not depend on what an
    /// earlier call left in the state.
    fn initialize(&mut self, time: f64, log: &mut Log<'_>) -> Result<(), Failure>;

    /// Advances from `time` to `time + step` [s] with the inputs held (plus their rates, where the
    /// rows have one), and computes all outputs but those on demand. `step` is finite and > 0; one that an importer reckoned
    /// as a difference of times comes without its rounding, so that equal steps are equal to the bit.
    fn step(&mut self, time: f64, step: f64, log: &mut Log<'_>) -> Result<(), Failure>;

    /// Recomputes the outputs that depend directly on inputs or tunable parameters, and those on demand.
    ///
    /// The shell calls it when an importer reads after it has set, without a step in between, and when it reads
    /// an output on demand after a step.
    fn update_outputs(&mut self) {}

    /// The model computes directional derivatives: [`Self::tangent`] is there.
    const TANGENT: bool = false;

    /// Turns a direction into derivatives, at the present values of `self`.
    ///
    /// `direction` holds a change in its Real inputs; the Real outputs of it become the change of the
    /// outputs that follows while the states stay, to first order.
    fn tangent(&mut self, direction: &mut Self) {
        let _ = direction;
    }

    /// Computes the time derivatives of its outputs into what the slopes of the rows point at in `copy`,
    /// a copy of `self` that is dropped when they were read: they may take the places of the outputs.
    fn slopes(&mut self, copy: &mut Self) {
        let _ = copy;
    }

    /// Visits every field that is neither a variable of the table nor derived from one: the
    /// hidden state. It is written to and read from serialised FMU states in this order.
    ///
    /// A field that is forgotten here keeps its start value where a state is read back from bytes, and nothing else
    /// tells. Name all fields, then one that is added does not compile before it was decided about. A test of a model
    /// that is `PartialEq` finds one whatever it is for:
    ///
    /// ```
    /// # use fmi2_cosim::{Experiment, Failure, Log, Model, StateFields, Unit, Variable};
    /// #[derive(Clone, Default, PartialEq)]
    /// struct Lags {
    ///     u: f64,
    ///     first: f64,
    ///     y: f64,
    /// }
    ///
    /// impl Model for Lags {
    ///     fn hidden_state(&mut self, fields: &mut dyn StateFields) {
    ///         let Self { first, u: _, y: _ } = self; // without `..`
    ///         fields.real(first);
    ///     }
    ///     // … NAME, VARIABLES, initialize, step and so on
    /// #   const NAME: &'static str = "Lags";
    /// #   const DESCRIPTION: &'static str = "";
    /// #   const EXPERIMENT: Experiment = Experiment::new(0.0, 10.0, 0.1);
    /// #   const VARIABLES: &'static [Variable<Self>] = &[
    /// #       Variable::input("u", Unit::ONE, |m: &mut Self| &mut m.u, ""),
    /// #       Variable::output("y", Unit::ONE, |m: &mut Self| &mut m.y, "").depends_on(&[]),
    /// #   ];
    /// #   fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
    /// #       Ok((self.first, self.y) = (0.0, 0.0))
    /// #   }
    /// #   fn step(&mut self, _: f64, step: f64, _: &mut Log<'_>) -> Result<(), Failure> {
    /// #       self.y += step * (self.first - self.y);
    /// #       self.first += step * (self.u - self.first);
    /// #       Ok(())
    /// #   }
    /// }
    ///
    /// # use fmi2_cosim::{Error, Instance, Reference, Saved};
    /// # fn main() -> Result<(), Error> {
    /// # let log = &mut Log::silent();
    /// # let mut lags = Instance::<Lags>::default();
    /// # lags.enter_initialization()?;
    /// # lags.write(Reference::named("u"), 1.0)?;
    /// # lags.exit_initialization(log)?;
    /// lags.step(0.0, 0.1, log)?; // `lags` is an `Instance<Lags>`
    /// let saved = lags.save()?;
    /// assert_eq!(Saved::from_bytes(&saved.to_bytes())?, saved);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// `cargo fmu check` reads a state back from bytes, too, and finds what shows in an output within eight steps.
    fn hidden_state(&mut self, fields: &mut dyn StateFields);

    /// Whether the parameters fit together. [`Self::initialize`] makes sure that they do; a serialised
    /// state of a run whose parameters do not is refused.
    ///
    /// # Errors
    /// [`Failure::Invalid`] with the variable to blame.
    fn consistent(&self) -> Result<(), Failure> {
        Ok(())
    }

    /// Called after a serialised state was read back: rebuild what is derived from parameters.
    fn restored(&mut self) {}
}

/// The experiment an importer is offered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Experiment {
    /// Start time [s].
    pub start: f64,
    /// Stop time [s].
    pub stop: f64,
    /// Communication step [s].
    pub step: f64,
}

impl Experiment {
    /// From a start to a stop time with a communication step, all [s].
    #[must_use]
    pub const fn new(start: f64, stop: f64, step: f64) -> Self {
        Self { start, stop, step }
    }
}

/// Visits the hidden state of a model: one method for writing, reading and counting.
pub trait StateFields {
    /// A real; bit for bit, NaN included.
    fn real(&mut self, value: &mut f64);
    /// An integer.
    fn integer(&mut self, value: &mut i32);
    /// A boolean.
    fn boolean(&mut self, value: &mut bool);
    /// A text, of any length.
    fn text(&mut self, value: &mut String);

    /// Several reals.
    fn reals(&mut self, values: &mut [f64]) {
        values.iter_mut().for_each(|value| self.real(value));
    }
}

/// Where a model's messages go: the importer's logger, if it wants them.
pub struct Log<'a> {
    sink: &'a mut dyn FnMut(Category, fmt::Arguments<'_>),
}

impl<'a> Log<'a> {
    /// A log that hands every message to `sink`.
    pub fn new(sink: &'a mut dyn FnMut(Category, fmt::Arguments<'_>)) -> Self {
        Self { sink }
    }

    /// A log that nobody reads.
    #[must_use]
    pub fn silent() -> Log<'static> {
        let nobody = |_: Category, _: fmt::Arguments<'_>| {};
        Log {
            sink: Box::leak(Box::new(nobody)), // of no size, so nothing is allocated
        }
    }

    /// Something that happened in the model, e.g. a valve that opened.
    pub fn event(&mut self, message: fmt::Arguments<'_>) {
        (self.sink)(Category::Event, message);
    }

    /// Something the user should look at though the run goes on.
    pub fn warning(&mut self, message: fmt::Arguments<'_>) {
        (self.sink)(Category::Warning, message);
    }
}

/// Log categories, as in `LogCategories` of the model description.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Category {
    /// `logEvents`.
    Event,
    /// `logStatusWarning`: a remark; the status of the call stays OK.
    Warning,
    /// `logStatusDiscard`.
    Discard,
    /// `logStatusError`.
    Error,
    /// `logStatusFatal`.
    Fatal,
}

/// Why a model could not initialise or step; the text is what the importer's log shows.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Failure {
    /// The values of two or more variables contradict each other, or one is unusable. fmi2Error.
    Invalid {
        /// Name of the variable to blame.
        variable: &'static str,
        /// Its value.
        value: f64,
        /// What is wrong and what would be right, e.g. `must be above valve1.map.position[1]`.
        remedy: &'static str,
    },
    /// The solution became unusable (not finite). fmi2Error.
    Diverged {
        /// Name of the variable that left the realm of numbers.
        variable: &'static str,
        /// Time at which it was seen [s].
        time: f64,
    },
    /// The communication step is longer than the model can take. fmi2Discard: the importer may try a shorter one, so
    /// return this from `step` only, before it has changed anything.
    StepTooLong {
        /// The step asked for [s].
        step: f64,
        /// The longest step [s].
        longest: f64,
    },
    /// Anything else, in a sentence of the model's own, e.g. `the flow through both valves was not found`. fmi2Error.
    Other(&'static str),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Invalid {
                variable,
                value,
                remedy,
            } => write!(f, "{variable} = {} {remedy}", Number(*value)),
            Self::Diverged { variable, time } => {
                let time = Seconds(*time);
                write!(f, "{variable} is no longer finite at t = {time} s")
            }
            Self::StepTooLong { step, longest } => {
                let (step, longest) = (Number(*step), Number(*longest));
                write!(f, "communicationStepSize = {step} s is above {longest} s")
            }
            Self::Other(sentence) => f.write_str(sentence),
        }
    }
}

impl std::error::Error for Failure {}
