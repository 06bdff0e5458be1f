//! What an instance ought to answer, written a second time and more plainly: the shadow of a model
//! with one variable of every sort.

use crate::state::standard;
use crate::{
    Enumeration, Experiment, Failure, Item, Log, Model, State, StateFields, Status, Unit, Variable,
};

static LEVEL: Enumeration = Enumeration {
    name: "Level",
    description: "Two values with a gap",
    items: &[
        Item {
            name: "low",
            value: 1,
            description: "",
        },
        Item {
            name: "high",
            value: 3,
            description: "",
        },
    ],
};

/// The longest step of the model [s].
const LONGEST: f64 = 0.5;

/// `fixed` above 9 fails to initialise, `count` = 3 fails to step.
#[derive(Clone)]
pub(super) struct Probe {
    fixed: f64,
    gain: f64,
    u: f64,
    u_rate: f64,
    count: i32,
    open: bool,
    level: i32,
    y: f64,
    slope: f64,
    late: bool,
}

impl Default for Probe {
    fn default() -> Self {
        Self {
            fixed: 1.0,
            gain: 1.0,
            u: 0.0,
            u_rate: 0.0,
            count: 0,
            open: false,
            level: 1,
            y: 0.0,
            slope: 0.0,
            late: false,
        }
    }
}

pub(super) const FIXED: u32 = 0;
pub(super) const GAIN: u32 = 1;
pub(super) const U: u32 = 2;
pub(super) const COUNT: u32 = 3;
pub(super) const OPEN: u32 = 4;
pub(super) const MODE: u32 = 5;
pub(super) const Y: u32 = 6;
pub(super) const LATE: u32 = 7;
/// No variable.
pub(super) const NONE: u32 = 99;

impl Model for Probe {
    const NAME: &'static str = "Probe";
    const DESCRIPTION: &'static str = "One variable of every sort";
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 1.0,
        step: 0.1,
    };
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::parameter("fixed", Unit::ONE, |m: &mut Self| &mut m.fixed, "").max(10.0),
        Variable::parameter("gain", Unit::ONE, |m: &mut Self| &mut m.gain, "").tunable(),
        Variable::input("u", Unit::ONE, |m: &mut Self| &mut m.u, "")
            .min(0.0)
            .max(5.0)
            .rate(|m| &mut m.u_rate),
        Variable::integer_input("count", |m: &mut Self| &mut m.count, "")
            .min(0.0)
            .max(3.0),
        Variable::boolean_input("open", |m: &mut Self| &mut m.open, ""),
        Variable::enumeration_parameter("level", &LEVEL, |m: &mut Self| &mut m.level, ""),
        Variable::output("y", Unit::ONE, |m: &mut Self| &mut m.y, "")
            .depends_on(&[])
            .slope(|m| &mut m.slope),
        Variable::boolean_output("late", |m: &mut Self| &mut m.late, "").depends_on(&["open"]),
    ];

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        if self.fixed > 9.0 {
            return Err(Failure::Invalid {
                variable: "fixed",
                value: self.fixed,
                remedy: "must be at most 9",
            });
        }
        (self.y, self.slope, self.late) = (self.fixed, self.gain * self.u, self.open);
        Ok(())
    }

    fn step(&mut self, time: f64, step: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        if self.count == 3 {
            return Err(Failure::Diverged {
                variable: "count",
                time,
            });
        }
        if step > LONGEST {
            return Err(Failure::StepTooLong {
                step,
                longest: LONGEST,
            });
        }
        self.slope = self.gain * self.u;
        self.y = (self.y + step * self.slope).clamp(-1e300, 1e300);
        self.late = self.open;
        Ok(())
    }

    fn update_outputs(&mut self) {
        self.late = self.open;
    }

    fn hidden_state(&mut self, _: &mut dyn StateFields) {}
}

/// FMI's types at the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Real,
    Integer,
    Boolean,
}

impl Kind {
    fn of(reference: u32) -> Option<Self> {
        match reference {
            FIXED | GAIN | U | Y => Some(Self::Real),
            COUNT | MODE => Some(Self::Integer),
            OPEN | LATE => Some(Self::Boolean),
            _ => None,
        }
    }
}

/// What the shell should know of an instance.
#[derive(Debug, Clone)]
pub(super) struct Shadow {
    pub(super) state: State,
    pub(super) time: f64,
    stop: f64,
    /// Values as set, by reference.
    values: [f64; 8],
    /// Initial values are due.
    due: bool,
}

impl Default for Shadow {
    fn default() -> Self {
        Self {
            state: State::Instantiated,
            time: 0.0,
            stop: f64::INFINITY,
            values: [1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            due: true,
        }
    }
}

impl Shadow {
    /// Whether the standard allows a call, or importers make it without harm.
    pub(super) fn allows(&self, function: &str) -> bool {
        let reading = ["fmi2GetReal", "fmi2GetInteger", "fmi2GetBoolean"];
        let early = self.state == State::Instantiated
            && (reading.contains(&function) || function == "fmi2GetString");
        early || standard::allows(function, &self.state.to_string())
    }

    /// The value a variable was set to.
    pub(super) fn value(&self, reference: u32) -> Option<f64> {
        self.values.get(usize::try_from(reference).ok()?).copied()
    }

    /// Sets these values, by the function of their type.
    pub(super) fn set(&mut self, kind: Kind, values: &[(u32, f64)]) -> Status {
        let twice = |at: usize| values[..at].iter().any(|(r, _)| *r == values[at].0);
        if (0..values.len()).any(twice) {
            return Status::Error;
        }
        for &(reference, value) in values {
            let status = self.may_set(kind, reference, value);
            if status != Status::Ok {
                return status;
            }
        }
        for &(reference, value) in values {
            self.values[usize::try_from(reference).unwrap()] = value;
            self.due = true;
        }
        Status::Ok
    }

    fn may_set(&self, kind: Kind, reference: u32, value: f64) -> Status {
        let running = self.state == State::StepComplete;
        let fixed = matches!(reference, FIXED | MODE) && running;
        if Kind::of(reference) != Some(kind) || matches!(reference, Y | LATE) || fixed {
            return Status::Error;
        }
        let legal = match reference {
            FIXED => value.is_finite() && value <= 10.0,
            GAIN => value.is_finite(),
            U => (0.0..=5.0).contains(&value),
            COUNT => (0.0..=3.0).contains(&value),
            MODE => [1.0, 3.0].contains(&value),
            _ => true,
        };
        if legal { Status::Ok } else { Status::Discard }
    }

    /// Gets these variables, by the function of their type.
    pub(super) fn get(&mut self, kind: Kind, references: &[u32]) -> Status {
        if references.iter().any(|r| Kind::of(*r) != Some(kind)) {
            return Status::Error;
        }
        if references.iter().any(|r| matches!(*r, Y | LATE)) {
            return self.initial_values();
        }
        Status::Ok
    }

    /// Computes initial values, where they are due.
    pub(super) fn initial_values(&mut self) -> Status {
        if self.state == State::Initialization && self.due {
            if self.value(FIXED) > Some(9.0) {
                self.state = State::Error;
                return Status::Error;
            }
            self.due = false;
        }
        Status::Ok
    }

    /// `fmi2SetupExperiment`.
    pub(super) fn setup(&mut self, start: f64, stop: Option<f64>) -> Status {
        let stop = stop.unwrap_or(f64::INFINITY);
        if !start.is_finite() || stop.is_nan() || stop <= start {
            return Status::Error;
        }
        (self.time, self.stop) = (start, stop);
        Status::Ok
    }

    /// `fmi2EnterInitializationMode`.
    pub(super) fn initialize(&mut self) -> Status {
        (self.state, self.due) = (State::Initialization, true);
        Status::Ok
    }

    /// `fmi2DoStep`.
    pub(super) fn step(&mut self, time: f64, step: f64) -> Status {
        let end = time + step;
        let here = (time - self.time).abs() <= 1e-9 * self.time.abs().max(1.0);
        let advances = end > time && end.is_finite();
        let over = end > self.stop + 1e-9 * self.stop.abs().max(1.0) || time >= self.stop;
        if !here || !advances || over {
            return Status::Error;
        }
        if self.value(COUNT) == Some(3.0) {
            self.state = State::Error;
            return Status::Error;
        }
        if step.min(self.stop - time) > LONGEST {
            return Status::Discard;
        }
        (self.time, self.due) = (end.min(self.stop), false);
        Status::Ok
    }
}
