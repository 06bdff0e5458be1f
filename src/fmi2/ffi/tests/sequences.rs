//! Random legal and illegal calls over every function and state, compared with the shadow.

use super::shadow::{COUNT, FIXED, GAIN, Kind, LATE, MODE, NONE, OPEN, Probe, Shadow, U, Y};
use super::*;
use crate::State;
use std::collections::BTreeSet;

pub(super) static PROBE: Library<Probe> = Library::empty();

/// Sequences, and calls in each: 100,000 calls, every function in every state many times.
const SEQUENCES: u64 = 500;
const CALLS: usize = 200;

/// xorshift64*: the same numbers on every machine.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let high = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33;
        usize::try_from(high).unwrap() % limit
    }

    pub(super) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// Now and then.
    pub(super) fn seldom(&mut self) -> bool {
        self.below(12) == 0
    }
}

/// An instance beside its shadow.
pub(super) struct Rig {
    pub(super) c: *mut c_void,
    pub(super) shadow: Shadow,
    /// Saved states that live, with what their shadows were.
    pub(super) saved: Vec<(*mut c_void, Shadow)>,
    /// A state that was freed last.
    pub(super) freed: *mut c_void,
    pub(super) random: Random,
}

/// Every call but `fmi2Instantiate` and `fmi2FreeInstance`.
const FUNCTIONS: &[Call] = Call::ALL;

impl Rig {
    fn new(seed: u64) -> Self {
        Self {
            c: instantiate_in(&PROBE, &guid::<Probe>(), true),
            shadow: Shadow::default(),
            saved: Vec::new(),
            freed: null_mut(),
            random: Random(seed * 2 + 1),
        }
    }

    /// Everything that makes up the instance, as bytes.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let status = PROBE.enter(self.c, Call::GetFMUstate, |i, _| {
            bytes = i.save()?.to_bytes();
            Ok(())
        });
        assert_eq!(status, Status::Ok);
        bytes
    }

    /// One random call; returns its function and the state it came in.
    fn call(&mut self) -> (Call, State) {
        let call = self.random.pick(FUNCTIONS);
        let (state, before) = (self.shadow.state, self.bytes());
        let saved = self.shadow.clone();
        lines();
        let legal = self.shadow.allows(&call.to_string());
        let (got, wanted) = self.perform(call);
        let wanted = if legal { wanted } else { Status::Error };
        if !legal {
            self.shadow = saved;
        }
        assert_eq!(got, wanted, "{call} in {state}: {:?}", lines());
        let logged = lines();
        assert_eq!(logged.len(), usize::from(got != Status::Ok), "{logged:?}");
        for (_, _, _, text) in logged {
            assert!(text.starts_with(&call.to_string()), "{text}");
        }
        let failed = self.shadow.state == State::Error && state != State::Error;
        if got != Status::Ok && !failed {
            assert!(
                self.bytes() == before,
                "{call} in {state} changed something"
            );
        }
        (call, state)
    }

    /// Makes a call; what it returned, and what it should return where it is legal.
    fn perform(&mut self, call: Call) -> (Status, Status) {
        match call {
            Call::SetDebugLogging => self.set_debug_logging(),
            Call::SetupExperiment => self.setup_experiment(),
            Call::EnterInitializationMode => {
                let got = PROBE.enter(self.c, call, |i, _| i.enter_initialization());
                (got, self.shadow.initialize())
            }
            Call::ExitInitializationMode => {
                let got = PROBE.enter(self.c, call, |i, log| i.exit_initialization(log));
                let wanted = self.shadow.initial_values();
                if wanted == Status::Ok {
                    self.shadow.state = State::StepComplete;
                }
                (got, wanted)
            }
            Call::Terminate => {
                self.shadow.state = State::Terminated;
                (PROBE.enter(self.c, call, |i, _| i.terminate()), Status::Ok)
            }
            Call::Reset => {
                self.shadow = Shadow::default();
                (PROBE.enter(self.c, call, |i, _| i.reset()), Status::Ok)
            }
            Call::DoStep => self.step(),
            Call::GetReal => self.get(Kind::Real),
            Call::GetInteger => self.get(Kind::Integer),
            Call::GetBoolean => self.get(Kind::Boolean),
            Call::SetReal => self.set(Kind::Real),
            Call::SetInteger => self.set(Kind::Integer),
            Call::SetBoolean => self.set(Kind::Boolean),
            Call::GetString | Call::SetString => self.strings(call),
            Call::SetRealInputDerivatives => self.set_derivative(),
            Call::GetRealOutputDerivatives => self.get_derivative(),
            Call::GetRealStatus => self.real_status(),
            Call::GetStatus
            | Call::GetIntegerStatus
            | Call::GetBooleanStatus
            | Call::GetStringStatus => (PROBE.status(self.c, call, 0), Status::Discard),
            Call::CancelStep => (PROBE.not_offered(self.c, call, "steps"), Status::Error),
            Call::GetDirectionalDerivative => self.directional_derivative(),
            _ => self.states(call),
        }
    }

    fn directional_derivative(&mut self) -> (Status, Status) {
        let unknown = self.random.pick(&[Y, Y, U, NONE]);
        let known = self.random.pick(&[U, U, Y, NONE]);
        let (references, mut value) = ((&raw const unknown, &raw const known), f64::NAN);
        // SAFETY: a live component; arrays of one.
        let got =
            unsafe { PROBE.directional_derivative(self.c, references, [1; 2], &1.0, &mut value) };
        if got == Status::Ok {
            assert_eq!(value, 0.0, "y depends on states only");
        }
        let wanted = match (unknown, known, self.shadow.state) {
            (Y, U, State::Initialization) => self.shadow.initial_values(),
            (Y, U, _) => Status::Ok,
            _ => Status::Error,
        };
        (got, wanted)
    }

    fn set_debug_logging(&mut self) -> (Status, Status) {
        let (known, unknown) = (c"logStatusError".as_ptr(), c"logAll".as_ptr());
        let other = c"logStatusDiscard".as_ptr();
        let cases: [(usize, &[*const c_char], Status); 5] = [
            (0, &[], Status::Ok),
            (2, &[known, other], Status::Ok),
            (2, &[known, unknown], Status::Error),
            (1, &[null()], Status::Error),
            (usize::MAX, &[known], Status::Error),
        ];
        let (count, names, wanted) = self.random.pick(&cases);
        // SAFETY: a live component; as many names as said, or a count that no one believes.
        let got = unsafe { PROBE.set_debug_logging(self.c, true, count, names.as_ptr()) };
        (got, wanted)
    }

    fn setup_experiment(&mut self) -> (Status, Status) {
        let start = self.random.pick(&[0.0, 0.0, 1.0, -1.0, f64::NAN]);
        let stops = [
            None,
            Some(2.0),
            Some(f64::INFINITY),
            Some(start),
            Some(f64::NAN),
        ];
        let stop = self.random.pick(&stops);
        let call = Call::SetupExperiment;
        let got = PROBE.enter(self.c, call, |i, _| i.setup_experiment(start, stop));
        let before = self.shadow.clone();
        let wanted = self.shadow.setup(start, stop);
        if wanted != Status::Ok {
            self.shadow = before;
        }
        (got, wanted)
    }

    fn step(&mut self) -> (Status, Status) {
        let now = self.shadow.time;
        let odd = [now + 0.1, f64::NAN, f64::INFINITY, -1e9, 1e300];
        let sizes = [
            0.0,
            -0.1,
            f64::NAN,
            f64::INFINITY,
            -f64::INFINITY,
            1e9,
            1e-300,
        ];
        let time = if self.random.seldom() {
            self.random.pick(&odd)
        } else {
            self.random.pick(&[now, now + 1e-10, now])
        };
        let size = if self.random.seldom() {
            self.random.pick(&sizes)
        } else {
            self.random.pick(&[0.1, 0.1 - 2e-12, 0.01, 1.0])
        };
        let got = PROBE.enter(self.c, Call::DoStep, |i, log| i.step(time, size, log));
        (got, self.shadow.step(time, size))
    }

    /// Up to 4 references, mostly of the right kind, with values, mostly in range.
    fn arguments(&mut self, kind: Kind) -> Vec<(u32, f64)> {
        let own: &[u32] = match kind {
            Kind::Real => &[FIXED, GAIN, U, U],
            Kind::Integer => &[COUNT, COUNT, MODE],
            _ => &[OPEN],
        };
        let odd = [Y, LATE, FIXED, COUNT, OPEN, NONE, u32::MAX];
        let values = [0.0, 1.0, 3.0, 5.0];
        let beyond = [-1.0, 9.5, 11.0, f64::NAN, f64::INFINITY, -f64::INFINITY];
        let mut one = || {
            let odd_one = self.random.seldom();
            let reference = self.random.pick(if odd_one { &odd } else { own });
            let bad = self.random.seldom();
            let value = self.random.pick(if bad { &beyond[..] } else { &values });
            (reference, value)
        };
        let mut arguments = vec![one(), one(), one(), one()];
        arguments.truncate(self.random.pick(&[0, 1, 1, 2, 3, 4]));
        arguments
    }

    fn set(&mut self, kind: Kind) -> (Status, Status) {
        let mut arguments = self.arguments(kind);
        for (_, value) in &mut arguments {
            *value = match kind {
                Kind::Real => *value,
                Kind::Integer => f64::from(integer(*value)),
                _ => f64::from(*value != 0.0),
            };
        }
        let references: Vec<_> = arguments.iter().map(|(reference, _)| *reference).collect();
        let reals: Vec<_> = arguments.iter().map(|(_, value)| *value).collect();
        let (count, broken) = self.count(references.len());
        let r = references.as_ptr();
        let got = match kind {
            // SAFETY: a live component; arrays of that length, or a count that no one believes.
            Kind::Real => unsafe { PROBE.set_reals(self.c, r, count, reals.as_ptr()) },
            _ => {
                let whole: Vec<_> = reals.iter().map(|value| integer(*value)).collect();
                let v = whole.as_ptr();
                match kind {
                    // SAFETY: as above.
                    Kind::Integer => unsafe { PROBE.set::<i32, c_int>(self.c, r, count, v, |v| v) },
                    // SAFETY: as above.
                    _ => unsafe { PROBE.set::<bool, c_int>(self.c, r, count, v, |v| v != 0) },
                }
            }
        };
        if broken {
            return (got, Status::Error);
        }
        (got, self.shadow.set(kind, &arguments))
    }

    /// The true count, or an absurd one.
    fn count(&mut self, count: usize) -> (usize, bool) {
        if self.random.below(40) == 0 {
            (self.random.pick(&[9, usize::MAX, usize::MAX / 8]), true)
        } else {
            (count, false)
        }
    }

    fn get(&mut self, kind: Kind) -> (Status, Status) {
        let mut references: Vec<_> = self.arguments(kind).iter().map(|(r, _)| *r).collect();
        let computed = if kind == Kind::Boolean { LATE } else { Y };
        if kind != Kind::Integer && self.random.below(2) == 0 {
            references.push(computed);
        }
        let (count, broken) = self.count(references.len());
        let (r, length) = (references.as_ptr(), references.len());
        let (mut reals, mut whole) = (vec![f64::NAN; length], vec![-7; length]);
        // SAFETY: a live component; arrays of that length, or a count that no one believes.
        let got = unsafe {
            match kind {
                Kind::Real => PROBE.get_reals(self.c, r, count, reals.as_mut_ptr()),
                Kind::Integer => {
                    PROBE.get_others::<i32, c_int>(self.c, r, count, whole.as_mut_ptr())
                }
                _ => PROBE.get_others::<bool, c_int>(self.c, r, count, whole.as_mut_ptr()),
            }
        };
        if broken {
            return (got, Status::Error);
        }
        let wanted = self.shadow.get(kind, &references);
        for (at, reference) in references.iter().enumerate() {
            let read = if kind == Kind::Real {
                reals[at]
            } else {
                f64::from(whole[at])
            };
            match got {
                Status::Ok if [Y, LATE].contains(reference) => assert!(read.is_finite()),
                Status::Ok => assert_eq!(Some(read), self.shadow.value(*reference)),
                _ => assert!(read.is_nan() || read == -7.0, "a refused getter wrote"),
            }
        }
        (got, wanted)
    }

    fn strings(&mut self, call: Call) -> (Status, Status) {
        let (count, wanted) = self.random.pick(&[(0, Status::Ok), (1, Status::Error)]);
        let mut text = c"0".as_ptr();
        let got = match call {
            // SAFETY: a live component; one reference, room for one string.
            Call::GetString => unsafe { PROBE.get_strings(self.c, &U, count, &mut text) },
            // SAFETY: a live component; one reference, one string.
            _ => unsafe { PROBE.set_strings(self.c, &U, count, &text) },
        };
        (got, wanted)
    }

    fn set_derivative(&mut self) -> (Status, Status) {
        let reference = self.random.pick(&[U, U, U, GAIN, Y, NONE]);
        let order = self.random.pick(&[1, 1, 1, 0, 2, -1]);
        let value = self.random.pick(&[0.0, 1.0, f64::NAN]);
        // SAFETY: a live component; arrays of one.
        let got = unsafe { PROBE.set_input_derivatives(self.c, &reference, 1, &order, &value) };
        if reference != U || order != 1 {
            return (got, Status::Error);
        }
        let legal = value.is_finite();
        (got, if legal { Status::Ok } else { Status::Discard })
    }

    fn get_derivative(&mut self) -> (Status, Status) {
        let reference = self.random.pick(&[Y, Y, U, NONE]);
        let order = self.random.pick(&[1, 1, 0, 2]);
        let mut value = f64::NAN;
        // SAFETY: a live component; arrays of one.
        let got =
            unsafe { PROBE.get_output_derivatives(self.c, &reference, 1, &order, &mut value) };
        let legal = reference == Y && order == 1;
        (got, if legal { Status::Ok } else { Status::Error })
    }

    fn real_status(&mut self) -> (Status, Status) {
        let (kind, mut time) = (self.random.pick(&[2, 2, 0, 1, 3, -1]), f64::NAN);
        // SAFETY: a live component; one number.
        let got = unsafe { PROBE.real_status(self.c, kind, &mut time) };
        if got == Status::Ok {
            assert_eq!(time, self.shadow.time);
        }
        (
            got,
            if kind == 2 {
                Status::Ok
            } else {
                Status::Discard
            },
        )
    }
}

/// The whole number below a small value; 7 for what is none.
fn integer(value: f64) -> c_int {
    let is_next_above = |number: &c_int| f64::from(*number) > value;
    (-9..=99).find(is_next_above).map_or(7, |number| number - 1)
}

#[test]
fn every_call_in_every_state_is_answered_as_the_standard_says() {
    let mut met = BTreeSet::new();
    for seed in 0..SEQUENCES {
        let mut rig = Rig::new(seed);
        for _ in 0..CALLS {
            let (call, state) = rig.call();
            met.insert((call.to_string(), state.to_string()));
        }
        rig.end();
    }
    assert_eq!(met.len(), FUNCTIONS.len() * State::ALL.len());
}
