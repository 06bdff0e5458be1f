//! The method that is chosen at run time.

use crate::Params;
use crate::observer::encoder::Encoders;
use crate::observer::leap::Leaps;
use crate::observer::shift::Shift;
use crate::observer::{
    Calibrating, Energy, Estimate, Kalman, Lyapunov, Observer, Paper, Sample, Settings, Visit, made,
};

/// Methods of estimation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// (19), (27), (29) as printed.
    #[default]
    Paper = 1,
    /// The paper's observer with gains that carry its proof.
    Lyapunov = 2,
    /// Physical energy as Lyapunov function, on the three measured speeds.
    Energy = 3,
    /// Kalman filter: a slipping clutch moves with its force, an engaged one with the damper.
    Kalman = 4,
    /// Kalman filter that learns errors of engine torque, inertias, drive shaft and wheel speed.
    Calibrating = 5,
}

impl Method {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 5] = [
        Self::Paper,
        Self::Lyapunov,
        Self::Energy,
        Self::Kalman,
        Self::Calibrating,
    ];
}

/// An observer of any method: the states of all of them side by side, so it needs no allocation and
/// its size does not depend on the method.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Selected {
    /// The method that acts; takes effect with [`Observer::start`].
    pub method: Method,
    inputs: Inputs,
    paper: Paper,
    lyapunov: Lyapunov,
    energy: Energy,
    kalman: Kalman,
    calibrating: Calibrating,
}

impl Selected {
    /// An observer of `method`, not started.
    pub fn new(method: Method) -> Self {
        Self {
            method,
            ..Self::default()
        }
    }

    /// Ticks per revolution that were recognised in ω_e, ω_c1, ω_c2, ω_w and are not told [1], shape (4); 0 without.
    pub fn recognised_ticks(&self) -> [f64; 4] {
        self.inputs.encoders.recognised()
    }

    /// Whether a step may recognise ticks, or find that what it took for ticks is none.
    pub fn may_count(&self) -> bool {
        self.inputs.encoders.may_count()
    }

    /// Which speeds the last sample left as they were, as it had them leap.
    pub fn leaps(&self) -> &Leaps {
        &self.inputs.leaps
    }

    fn parts(&mut self) -> (&mut Inputs, &mut dyn Observer) {
        let acting: &mut dyn Observer = match self.method {
            Method::Paper => &mut self.paper,
            Method::Lyapunov => &mut self.lyapunov,
            Method::Energy => &mut self.energy,
            Method::Kalman => &mut self.kalman,
            Method::Calibrating => &mut self.calibrating,
        };
        (&mut self.inputs, acting)
    }
}

impl Observer for Selected {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        *self = Self::new(self.method);
        let (inputs, acting) = self.parts();
        inputs.start(acting, p, settings, sample)
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        made(|y| self.step_to(p, settings, sample, h, y))
    }

    fn step_to(
        &mut self,
        p: &Params,
        settings: &Settings,
        sample: &Sample,
        h: f64,
        y: &mut Estimate,
    ) {
        let (inputs, acting) = self.parts();
        inputs.step_to(acting, p, settings, (sample, h), y);
    }

    fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            inputs,
            paper,
            lyapunov,
            energy,
            kalman,
            calibrating,
            method: _,
        } = self;
        inputs.visit(visit);
        paper.visit(visit);
        lyapunov.visit(visit);
        energy.visit(visit);
        kalman.visit(visit);
        calibrating.visit(visit);
    }
}

/// What a sample passes before a method sees it: speeds that leap, counted speeds, and which gears are in.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inputs {
    leaps: Leaps,
    encoders: Encoders,
    shift: Shift,
}

impl Inputs {
    /// Starts the observer `acting` with the gears that are preselected, which are in.
    pub fn start(
        &mut self,
        acting: &mut dyn Observer,
        p: &Params,
        settings: &Settings,
        sample: &Sample,
    ) -> Estimate {
        self.leaps.start(sample);
        self.encoders.start(sample);
        self.shift.start(sample);
        acting.start(&p.in_gears(sample.gear), settings, sample)
    }

    /// Advances the observer `acting` by `h` [s] with the speeds that are counted and the gears that are in.
    pub fn step(
        &mut self,
        acting: &mut dyn Observer,
        p: &Params,
        settings: &Settings,
        sample: &Sample,
        h: f64,
    ) -> Estimate {
        made(|y| self.step_to(acting, p, settings, (sample, h), y))
    }

    /// [`Self::step`], whose estimate is written to `y`; `h` stands beside the sample.
    pub fn step_to(
        &mut self,
        acting: &mut dyn Observer,
        p: &Params,
        settings: &Settings,
        (sample, h): (&Sample, f64),
        y: &mut Estimate,
    ) {
        let (encoders, shift) = (&self.encoders, &self.shift);
        let held = self.leaps.step(sample, h, || {
            let mut freedom = encoders.scatter(settings, sample, h);
            for i in (0..2).filter(|i| shift.is_on_its_way(p, sample, *i)) {
                freedom[1 + i] = f64::INFINITY;
            }
            freedom
        });
        let sample = held.as_ref().unwrap_or(sample);
        let counted = self.encoders.step(settings, sample, h);
        let (sample, settings) = match &counted {
            Some((sample, settings)) => (sample, settings),
            None => (sample, settings),
        };
        let sample = self.shift.step(p, sample, h);
        if p.gears_add_inertia() {
            step_in_gears(acting, p, settings, (&sample, h), y);
        } else {
            acting.step_to(p, settings, &sample, h, y);
        }
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            leaps,
            encoders,
            shift,
        } = self;
        leaps.visit(visit);
        encoders.visit(visit);
        shift.visit(visit);
    }
}

/// The vehicle is large: it has a place of its own only where it is another one.
#[inline(never)]
fn step_in_gears(
    acting: &mut dyn Observer,
    p: &Params,
    settings: &Settings,
    (sample, h): (&Sample, f64),
    y: &mut Estimate,
) {
    acting.step_to(&p.in_gears(sample.gear), settings, sample, h, y);
}

#[cfg(test)]
mod tests {
    use super::{Method, Observer as _, Selected};
    use crate::Params;
    use crate::observer::{Sample, Settings};
    use crate::params::Actuation;

    #[test]
    fn an_estimate_is_the_same_wherever_it_is_written() {
        let slips = Sample {
            t_e: 100.0,
            omega_e: 200.0,
            omega_c: [180.0, 115.0],
            omega_w: 10.0,
            actuation: [5e-3, 0.0].map(|position| Actuation {
                position,
                ..Actuation::default()
            }),
            gear: [1, 2],
            ..Sample::default()
        };
        let none = Sample {
            t_e: f64::NAN,
            ..slips
        };
        let (p, settings) = (Params::TABLE_1, Settings::CASE_1);
        for method in Method::ALL {
            let mut observer = Selected::new(method);
            let mut y = observer.start(&p, &settings, &slips);
            let mut other = observer;
            for (k, sample) in [slips, slips, none, slips, none, none, slips]
                .iter()
                .enumerate()
            {
                let expected = observer.step(&p, &settings, sample, 1e-3);
                other.step_to(&p, &settings, sample, 1e-3, &mut y);
                assert_eq!(y, expected, "{method:?}, step {k}");
            }
        }
    }
}
