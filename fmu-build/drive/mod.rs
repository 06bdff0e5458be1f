//! Components over a table of inputs, coupled by the names of their variables.
//!
//! ```text
//! table ──> inputs, parameters ─> component ─> outputs ──> a row of results at every communication point
//!                      ^── outputs of equal names ──┘
//!
//! Components step one after the other, as `dct-harness` lets them: one takes what those before it in the list
//! have just computed (Gauss-Seidel).
//! ```

mod model;
mod recorded;
mod stimuli;
mod wiring;

pub(crate) use model::Driven;
pub(crate) use recorded::{Calls, Recorded};
pub(crate) use stimuli::Stimuli;

use crate::suggest::did_you_mean;
use crate::{Error, Result};
use std::fmt::Write as _;
use stimuli::Column;
use wiring::{Wire, wires};

/// Where a value is: its type at the C interface and its value reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    pub(crate) kind: Kind,
    pub(crate) reference: u32,
}

/// Types that a number stands for; 0 is false.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Real,
    Integer,
    Boolean,
}

/// What a variable is to others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    Input,
    Output,
    Parameter,
}

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Signal {
    pub(crate) name: String,
    pub(crate) role: Role,
    pub(crate) place: Place,
}

/// A component in its life cycle.
pub(crate) trait Part {
    /// Name of its model.
    fn name(&self) -> &str;
    fn signals(&self) -> &[Signal];
    fn set(&mut self, place: Place, value: f64) -> Result<()>;
    fn get(&mut self, place: Place) -> Result<f64>;
    /// Into initialisation mode.
    fn initialize(&mut self, time: f64) -> Result<()>;
    /// Out of it.
    fn start(&mut self) -> Result<()>;
    fn step(&mut self, time: f64, step: f64) -> Result<()>;
    fn terminate(&mut self) -> Result<()>;
}

/// Components with the wires between them.
pub(crate) struct Loop<'a> {
    parts: Vec<Box<dyn Part + 'a>>,
    wires: Vec<Wire>,
    given: Vec<Given<'a>>,
    times: (f64, f64),
}

/// An input or parameter that comes from the table.
struct Given<'a> {
    at: usize,
    place: Place,
    role: Role,
    column: Column<'a>,
}

impl<'a> Loop<'a> {
    /// An input takes the output of its name from the component nearest before its own, going round;
    /// what none gives comes from the table.
    pub(crate) fn new(parts: Vec<Box<dyn Part + 'a>>, stimuli: &'a Stimuli) -> Self {
        let signals: Vec<&[Signal]> = parts.iter().map(|part| part.signals()).collect();
        let wires = wires(&signals);
        Self {
            given: given(&signals, &wires, stimuli),
            wires,
            parts,
            times: stimuli.times(),
        }
    }

    /// Runs from the first to the last time of the table and hands every communication point to `see`.
    ///
    /// `step`: communication step [s].
    pub(crate) fn run(
        &mut self,
        step: f64,
        see: &mut dyn FnMut(f64, &mut Self) -> Result<()>,
    ) -> Result<()> {
        let (start, stop) = self.times;
        let times = self.times;
        if !(step > 0.0 && (stop - start) / step < f64::from(u32::MAX)) {
            return Err(Error::Step { step, times });
        }
        self.give(start, &[Role::Input, Role::Parameter])?;
        self.each(start, &|part| part.initialize(start))?;
        (0..self.parts.len()).try_for_each(|at| self.connect_to(at, start))?;
        self.each(start, &|part| part.start())?;
        see(start, self)?;
        let point = |index| start + f64::from(index) * step;
        for index in 0_u32.. {
            let time = point(index);
            if time + 0.5 * step > stop {
                break;
            }
            self.give(time, &[Role::Input])?;
            for at in 0..self.parts.len() {
                self.connect_to(at, time)?;
                let stepped = self.parts[at].step(time, step);
                stepped.map_err(|cause| self.failed(at, time, String::new(), cause))?;
            }
            see(point(index + 1), self)?;
        }
        self.each(stop, &|part| part.terminate())
    }

    /// Calls every component.
    fn each(&mut self, time: f64, call: &dyn Fn(&mut dyn Part) -> Result<()>) -> Result<()> {
        for at in 0..self.parts.len() {
            let called = call(&mut *self.parts[at]);
            called.map_err(|cause| self.failed(at, time, String::new(), cause))?;
        }
        Ok(())
    }

    /// Whose failure it is, and when. `setting`: the variable that was to be set, with its value.
    fn failed(&self, at: usize, time: f64, setting: String, cause: Error) -> Error {
        Error::Run {
            component: self.parts[at].name().to_owned(),
            setting,
            time,
            source: Box::new(cause),
        }
    }

    /// Sets every input to what it is at a communication point.
    #[cfg(feature = "dct")]
    pub(crate) fn exchange(&mut self, time: f64) -> Result<()> {
        (0..self.parts.len()).try_for_each(|at| self.connect_to(at, time))?;
        self.give(time, &[Role::Input])
    }

    /// Sets what the table has at a time: Reals interpolated, others kept.
    fn give(&mut self, time: f64, roles: &[Role]) -> Result<()> {
        for given in self.given.iter().filter(|one| roles.contains(&one.role)) {
            let value = match given.place.kind {
                Kind::Real => given.column.at(time),
                Kind::Integer | Kind::Boolean => given.column.kept(time),
            };
            if given.place.kind == Kind::Integer && !is_whole(value) {
                let variable = given.column.name.to_owned();
                return Err(Error::NotWhole {
                    variable,
                    value,
                    time,
                });
            }
            self.parts[given.at]
                .set(given.place, value)
                .map_err(|cause| self.failed(given.at, time, told(given, value, &cause), cause))?;
        }
        Ok(())
    }

    /// Sets every wired input of a component.
    fn connect_to(&mut self, at: usize, time: f64) -> Result<()> {
        for Wire { from, to } in self.wires.iter().filter(|wire| wire.to.0 == at) {
            let value = self.parts[from.0].get(from.1);
            let value = value.map_err(|cause| self.failed(from.0, time, String::new(), cause))?;
            let set = self.parts[at].set(to.1, value);
            set.map_err(|cause| self.failed(at, time, String::new(), cause))?;
        }
        Ok(())
    }

    /// What is wrong with columns of the table that set nothing, one sentence each.
    pub(crate) fn passed_over(&self, stimuli: &Stimuli) -> Vec<String> {
        let signals = || self.parts.iter().flat_map(|part| part.signals());
        let idle = |name: &&str| !self.given.iter().any(|given| given.column.name == *name);
        let why = |name: &str| {
            if signals().any(|signal| signal.name == name) {
                return format!("column '{name}' is passed over: an output gives it");
            }
            let settable = signals().filter(|signal| signal.role != Role::Output);
            let hint = did_you_mean(name, settable.map(|signal| signal.name.as_str()));
            format!("column '{name}' is passed over: no input or parameter has this name{hint}")
        };
        stimuli.names().filter(idle).map(why).collect()
    }

    /// Names and places of a component's signals of a role.
    pub(crate) fn signals(&self, at: usize, role: Role) -> Vec<(String, Place)> {
        let signals = self.parts[at].signals().iter();
        let found = signals.filter(|signal| signal.role == role);
        found.map(|one| (one.name.clone(), one.place)).collect()
    }

    /// Names of all outputs, each behind the name of its component when there are several.
    fn outputs(&self) -> Vec<(String, usize, Place)> {
        let mut all = Vec::new();
        for at in 0..self.parts.len() {
            for (name, place) in self.signals(at, Role::Output) {
                let name = match self.parts.as_slice() {
                    [_] => name,
                    several => format!("{}.{name}", several[at].name()),
                };
                all.push((name, at, place));
            }
        }
        all
    }

    /// The value of an output.
    pub(crate) fn value(&mut self, at: usize, place: Place) -> Result<f64> {
        self.parts[at].get(place)
    }
}

/// What was to be set, unless the cause names it.
fn told(given: &Given<'_>, value: f64, cause: &Error) -> String {
    let name = given.column.name;
    if cause.to_string().contains(name) {
        return String::new();
    }
    format!("{name} = {}: ", shown(given.place.kind, value))
}

/// What the table gives: everything of its names that no wire reaches.
fn given<'a>(signals: &[&[Signal]], wires: &[Wire], stimuli: &'a Stimuli) -> Vec<Given<'a>> {
    let mut found = Vec::new();
    for (at, signals) in signals.iter().enumerate() {
        for &Signal {
            ref name,
            role,
            place,
        } in *signals
        {
            let wired = wires.iter().any(|wire| wire.to == (at, place));
            let column = stimuli.column(name);
            if let Some(column) = column.filter(|_| role != Role::Output && !wired) {
                found.push(Given {
                    at,
                    place,
                    role,
                    column,
                });
            }
        }
    }
    found
}

/// All outputs of the components as CSV; every `every`-th communication point.
pub(crate) fn table(all: &mut Loop<'_>, step: f64, every: u32) -> Result<String> {
    let outputs = all.outputs();
    let mut text = String::from("time");
    for (name, ..) in &outputs {
        let _ = write!(text, ",{name}");
    }
    text.push('\n');
    let mut count = 0_u32;
    all.run(step, &mut |time, all| {
        if count.is_multiple_of(every) {
            let _ = write!(text, "{time:?}");
            for (_, at, place) in &outputs {
                let _ = write!(text, ",{}", shown(place.kind, all.value(*at, *place)?));
            }
            text.push('\n');
        }
        count += 1;
        Ok(())
    })?;
    Ok(text)
}

/// Whether an Integer may have a value.
pub(crate) fn is_whole(value: f64) -> bool {
    (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&value) && value % 1.0 == 0.0
}

/// A value that [`is_whole`] as an Integer.
pub(crate) fn whole(value: f64) -> i32 {
    format!("{value:.0}").parse().unwrap_or_default()
}

/// The shortest text that reads back as the same bits; whole numbers without a fraction.
pub(crate) fn shown(kind: Kind, value: f64) -> String {
    match kind {
        Kind::Real => format!("{value:?}"),
        Kind::Integer | Kind::Boolean => format!("{value:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::{Driven, Loop, Stimuli, table};
    use dct_models::Plant;

    fn refused(inputs: &str, step: f64) -> String {
        let stimuli = Stimuli::parse(inputs).unwrap();
        let parts = vec![Driven::<Plant>::boxed()];
        let done = table(&mut Loop::new(parts, &stimuli), step, 1);
        done.err().map(|error| error.to_string()).unwrap()
    }

    #[test]
    fn a_step_that_leads_nowhere_is_refused() {
        for step in [0.0, -0.01, f64::NAN, 1e-12] {
            let told = refused("time,engine.torque\n0,60\n1,60\n", step);
            assert!(
                told.starts_with(&format!("steps of {step} s do not lead from 0 s to 1 s")),
                "{told}"
            );
        }
    }

    #[test]
    fn a_failure_names_component_time_variable_and_value() {
        let told = refused("time,clutch1.position\n0,0\n0.02,-1\n1,0\n", 0.01);
        assert_eq!(
            told,
            "DctPlant at t = 0.01 s: clutch1.position = -0.5 is below 0"
        );
    }

    #[test]
    fn columns_that_set_nothing_are_named() {
        let stimuli = "time,engine.torqe,vehicle.speed,x,engine.torque\n0,1,1,1,1\n";
        let stimuli = Stimuli::parse(stimuli).unwrap();
        let all = Loop::new(vec![Driven::<Plant>::boxed()], &stimuli);
        let unknown = "is passed over: no input or parameter has this name";
        assert_eq!(
            all.passed_over(&stimuli),
            [
                format!("column 'engine.torqe' {unknown}; did you mean 'engine.torque'?"),
                "column 'vehicle.speed' is passed over: an output gives it".into(),
                format!("column 'x' {unknown}"),
            ]
        );
    }

    #[test]
    fn an_integer_gets_whole_numbers_only() {
        for gear in ["3e9", "1.5"] {
            let told = refused(&format!("time,shaft1.gear\n0,1\n0.02,{gear}\n1,1\n"), 0.01);
            let value: f64 = gear.parse().unwrap();
            assert!(
                told.starts_with(&format!("shaft1.gear = {value} at t = 0.02 s")),
                "{told}"
            );
        }
    }
}
