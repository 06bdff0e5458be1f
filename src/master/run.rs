//! The loop itself: initialisation, then Gauss-Seidel or Jacobi steps.

use crate::discard::is_over_after;
use crate::error::Error;
use crate::library::Libraries;
use crate::live::Live;
use crate::part::Part;
use crate::plan::{Coupling, Plan};
use crate::recorder::Recorder;
use crate::rest;
use crate::slopes::Slopes;
use crate::watch::Watch;
use crate::world;
use cosim_raw::Places;

/// Sweeps over the initial values, beyond one per component.
const SWEEPS: usize = 50;

/// Relative change of an initial value that counts as none.
const SETTLED: f64 = 1e-14;

/// FMUs wired together, ready to run once.
///
/// Every signal has one place in one vector, the world: the scenario's signals first, then the
/// outputs of each FMU.
pub struct Run {
    parts: Vec<Part>,
    /// Names of the signals of the world.
    all: Vec<String>,
    /// Places of the recorded ones; `None`: all, as they lie.
    kept: Option<Places>,
    script: usize,
    world: Vec<f64>,
    coupling: Coupling,
    slopes: Option<Slopes>,
    /// Signals of the scenario that have not changed since the first step, which set them: columns and bits.
    still: Vec<(usize, u64)>,
}

impl Run {
    /// Instantiates and wires the FMUs of a plan; `live` tells others of it.
    pub fn new(plan: &Plan, libraries: &mut Libraries, live: &Live) -> Result<Self, Error> {
        let opened = plan.components.iter().map(|c| libraries.open(&c.fmu));
        let opened: Vec<_> = opened.collect::<Result<_, _>>()?;
        let descriptions: Vec<_> = opened.iter().map(|library| library.description()).collect();
        let read = world::outputs(plan, &descriptions)?;
        let all = world::names(plan, &read);
        let places = world::index(&all);
        let logs = live.begin(plan);
        let mut parts = vec![];
        let mut first = plan.script.len();
        let components = plan.components.iter().zip(&logs);
        for (((component, log), library), read) in components.zip(&opened).zip(&read) {
            let part = Part::new(component, log, library, read, &places, first)?;
            first = part.outputs.end;
            parts.push(part);
        }
        let moving = read.iter().flat_map(|read| read.moving.iter().copied());
        let moving: Vec<bool> = plan.script.iter().map(|_| true).chain(moving).collect();
        let interpolate = plan.interpolate;
        Ok(Self {
            slopes: interpolate.then(|| Slopes::new(&mut parts, &moving)),
            parts,
            world: vec![0.0; all.len()],
            kept: world::places(&all, plan.record.as_deref()).map(Places::new),
            all,
            script: plan.script.len(),
            coupling: plan.coupling,
            still: vec![],
        })
    }

    /// Names of the signals that a run of `plan` records, in the order of a row; opens its FMUs.
    pub fn recorded(plan: &Plan, libraries: &mut Libraries) -> Result<Vec<String>, Error> {
        let opened = plan.components.iter().map(|c| libraries.open(&c.fmu));
        let opened: Vec<_> = opened.collect::<Result<_, _>>()?;
        if let Some(record) = &plan.record {
            return Ok(record.clone());
        }
        let descriptions: Vec<_> = opened.iter().map(|library| library.description()).collect();
        Ok(world::names(plan, &world::outputs(plan, &descriptions)?))
    }

    /// How many signals are recorded.
    pub(crate) fn width(&self) -> usize {
        let kept = self.kept.as_ref().map(Places::all);
        kept.map_or(self.all.len(), <[usize]>::len)
    }

    /// Names of the recorded signals, in the order of a row.
    pub fn names(&self) -> Vec<String> {
        match &self.kept {
            None => self.all.clone(),
            Some(kept) => kept
                .all()
                .iter()
                .filter_map(|k| self.all.get(*k).cloned())
                .collect(),
        }
    }

    /// Runs over `times` [s], the first of which is the start.
    ///
    /// `script` has a row of scenario signals for each time, and `recorder` takes a row of the
    /// recorded signals for each. `watch` may end it. Returns how many rows are good, and why they are not all.
    pub(crate) fn run(
        mut self,
        plan: &Plan,
        (times, script): (&[f64], &[f64]),
        mut recorder: Recorder<'_>,
        watch: &Watch,
    ) -> (usize, Result<(), Error>) {
        let done = self
            .initialize(plan, times, row(script, self.script, 0))
            .and_then(|()| self.record(&mut recorder, 0.0))
            .and_then(|()| self.look(0.0))
            .and_then(|()| self.go(times, script, &mut recorder, watch));
        let done = match done {
            Err(Error::Over { .. }) if recorder.good() == times.len() => Ok(()),
            done => done,
        };
        let last = times.last().copied().unwrap_or_default();
        (recorder.good(), done.and_then(|()| self.look(last)))
    }

    /// Takes all steps of a run.
    fn go(
        &mut self,
        times: &[f64],
        script: &[f64],
        recorder: &mut Recorder<'_>,
        watch: &Watch,
    ) -> Result<(), Error> {
        let mut begin = row(script, self.script, 0);
        for (k, pair) in times.windows(2).enumerate() {
            let &[time, next] = pair else { break };
            if watch.ends(k) {
                return Err(Error::Ended { time });
            }
            let end = row(script, self.script, k + 1);
            self.pass((time, next), (begin, end), recorder)?;
            if k == 0 && self.slopes.is_none() {
                self.still = begin
                    .iter()
                    .map(|value| value.to_bits())
                    .enumerate()
                    .collect();
            }
            if !self.still.iter().all(|signal| is_still(signal, end)) {
                self.release(end);
            }
            if (k + 1).is_multiple_of(rest::EVERY) {
                self.look(next)?;
            }
            begin = end;
        }
        Ok(())
    }

    /// Sets inputs in every step from now on whose signals change in a row of the scenario. The others keep what they
    /// were set to in the first step, as variables do.
    #[cold]
    fn release(&mut self, row: &[f64]) {
        self.still.retain(|signal| is_still(signal, row));
        let columns = 0..self.script;
        let still: Vec<bool> = columns
            .map(|column| self.still.iter().any(|(still, _)| *still == column))
            .collect();
        self.parts.iter_mut().for_each(|part| part.hold(&still));
    }

    /// Goes from one communication point [s] to the next and records it; an FMU may ask to end the simulation there.
    #[inline]
    fn pass(
        &mut self,
        (time, next): (f64, f64),
        script: (&[f64], &[f64]),
        recorder: &mut Recorder<'_>,
    ) -> Result<(), Error> {
        let step = (time, next - time);
        let Err(why) = self.advance(step, script) else {
            self.play(script.1);
            return self.record(recorder, next);
        };
        if is_over_after(&why, step) {
            self.play(script.1);
            self.record(recorder, next)?;
        }
        Err(why)
    }

    /// Passes initial values on until nothing changes.
    fn initialize(&mut self, plan: &Plan, times: &[f64], script: &[f64]) -> Result<(), Error> {
        let stop = times.last().copied().unwrap_or_default();
        for (part, component) in self.parts.iter_mut().zip(&plan.components) {
            part.initialize(&component.start, stop)?;
        }
        self.play(script);
        let Self { parts, world, .. } = self;
        parts
            .iter_mut()
            .try_for_each(|part| part.get_outputs(world))?;
        self.settle()?;
        let Self { parts, world, .. } = self;
        parts.iter_mut().try_for_each(|part| {
            part.start()?;
            part.get_outputs(world)
        })
    }

    fn settle(&mut self) -> Result<(), Error> {
        let mut changing = None;
        for _ in 0..self.parts.len() + SWEEPS {
            let before = self.world.clone();
            let Self { parts, world, .. } = self;
            for part in parts.iter_mut() {
                part.gather.gather_initial(world)?;
                part.set_inputs()?;
                part.get_outputs(world)?;
            }
            changing = self
                .world
                .iter()
                .zip(&before)
                .position(|(now, old)| moved(*now, *old));
            if changing.is_none() {
                return Ok(());
            }
        }
        let value = |values: &[f64], k: usize| values.get(k).copied().unwrap_or(f64::NAN);
        changing.map_or(Ok(()), |k| {
            Err(Error::Value {
                name: self.all.get(k).cloned().unwrap_or_default(),
                value: value(&self.world, k),
                time: 0.0,
                what: "it does not settle; the loop is algebraic",
            })
        })
    }

    /// Steps all components; over the step the scenario goes from one row to the next.
    #[inline(always)]
    fn advance(&mut self, (time, step): (f64, f64), script: (&[f64], &[f64])) -> Result<(), Error> {
        let Self { parts, world, .. } = self;
        if let Some(slopes) = &mut self.slopes {
            slopes.begin(parts, world, script, step)?;
            return along(slopes, self.coupling, parts, world, (time, step));
        }
        match self.coupling {
            Coupling::GaussSeidel => each(parts, (time, step), |part| {
                part.gather.gather(world, time)?;
                part.step(world, time, step)
            }),
            Coupling::Jacobi => {
                parts
                    .iter_mut()
                    .try_for_each(|part| part.gather.gather(world, time))?;
                each(parts, (time, step), |part| part.step(world, time, step))
            }
        }
    }

    /// Puts the scenario's signals into the world.
    fn play(&mut self, script: &[f64]) {
        self.world
            .iter_mut()
            .zip(script)
            .for_each(|(place, value)| *place = *value);
    }

    #[inline(always)]
    fn record(&self, recorder: &mut Recorder<'_>, time: f64) -> Result<(), Error> {
        if recorder.push(&self.world, self.kept.as_ref()) {
            return Ok(());
        }
        Err(self.no_number(time))
    }

    /// Looks at the outputs that are neither read nor recorded, at `time` [s].
    #[cold]
    fn look(&mut self, time: f64) -> Result<(), Error> {
        self.parts.iter_mut().try_for_each(|part| part.look(time))
    }

    /// The error of a world with a value that is no number.
    #[cold]
    fn no_number(&self, time: f64) -> Error {
        let bad = self
            .all
            .iter()
            .zip(&self.world)
            .find(|(_, value)| !value.is_finite());
        let (name, value) = bad.map_or(("a signal", f64::NAN), |(name, value)| {
            (name.as_str(), *value)
        });
        Error::no_number(name, value, time)
    }
}

/// Steps all components with inputs that go on within the step, where they can follow.
fn along(
    slopes: &mut Slopes,
    coupling: Coupling,
    parts: &mut [Part],
    world: &mut [f64],
    (time, step): (f64, f64),
) -> Result<(), Error> {
    match coupling {
        Coupling::GaussSeidel => each(parts, (time, step), |part| {
            slopes.feed(part, world, time)?;
            let done = part.step(world, time, step);
            slopes.after(part, world);
            done
        }),
        Coupling::Jacobi => {
            let mut all = parts.iter_mut();
            all.try_for_each(|part| slopes.feed(part, world, time))?;
            each(parts, (time, step), |part| part.step(world, time, step))
        }
    }
}

/// Lets components take a step; where one asks to end the simulation at its end, the others take it too.
#[inline]
fn each(
    parts: &mut [Part],
    step: (f64, f64),
    mut take: impl FnMut(&mut Part) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut parts = parts.iter_mut();
    let mut over = Ok(());
    while let Err(error) = parts.try_for_each(&mut take) {
        if !is_over_after(&error, step) {
            return Err(error);
        }
        over = over.and(Err(error));
    }
    over
}

/// Row `k` of a script of so many signals.
#[inline]
fn row(script: &[f64], count: usize, k: usize) -> &[f64] {
    let row = script.get(k * count..(k + 1) * count);
    row.unwrap_or_default()
}

/// Whether a signal of the scenario has its bits in a row, too.
#[inline]
fn is_still((column, bits): &(usize, u64), row: &[f64]) -> bool {
    row.get(*column)
        .is_some_and(|value| value.to_bits() == *bits)
}

fn moved(now: f64, before: f64) -> bool {
    now != before
        && !(now.is_nan() && before.is_nan())
        && (now - before).abs() > SETTLED * before.abs()
}
