//! An importer that does what a script says, right or wrong, and keeps a digest of what it sees.

mod saved;

use crate::script::Script;
use core::ffi::{CStr, c_char, c_int, c_void};
use core::ptr::{null, null_mut, without_provenance_mut};
use fmi2_cosim::ffi::{Callbacks, Library};
use fmi2_cosim::{Call, Model, Status, guid};
use std::cell::Cell;
use std::ffi::CString;

/// Calls of a script at most.
const CALLS: usize = 96;
/// Arrays are a little longer than the longest count that is not refused.
const MORE: usize = 4;

thread_local! {
    /// FNV-1a of everything an importer sees.
    static DIGEST: Cell<u64> = const { Cell::new(0) };
}

fn see(bytes: &[u8]) {
    let fold = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
    DIGEST.set(bytes.iter().fold(DIGEST.get(), fold));
}

/// Stable Rust cannot define a variadic function: this is an importer without variable arguments.
unsafe extern "C" fn listen(
    _: *mut c_void,
    _: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
) {
    see(&status.to_le_bytes());
    for text in [category, format] {
        // SAFETY: the shell passes NUL-terminated strings.
        see(unsafe { CStr::from_ptr(text) }.to_bytes());
    }
}

/// Instances and states of one library, live and dead ones.
pub struct Importer<M: Model> {
    library: &'static Library<M>,
    /// The GUID, as C wants it.
    guid: CString,
    components: Vec<*mut c_void>,
    states: Vec<*mut c_void>,
    /// References, reals, integers that are read and written.
    references: Vec<u32>,
    reals: Vec<f64>,
    integers: Vec<c_int>,
    texts: Vec<*const c_char>,
}

/// Runs a script twice and demands the same answers: nothing may stay from the first time.
pub fn play_twice<M: Model>(library: &'static Library<M>, script: &[u8]) {
    let [first, second] = [0; 2].map(|_| play(library, script));
    assert_eq!(first, second, "the second run saw something else");
}

fn play<M: Model>(library: &'static Library<M>, script: &[u8]) -> u64 {
    DIGEST.set(0xcbf2_9ce4_8422_2325);
    let room = M::VARIABLES.len() + MORE;
    let mut importer = Importer {
        library,
        guid: CString::new(guid::<M>()).unwrap_or_default(),
        components: Vec::new(),
        states: Vec::new(),
        references: vec![0; room],
        reals: vec![0.0; room],
        integers: vec![0; room],
        texts: vec![null(); room],
    };
    importer.instantiate(&mut Script(&[]));
    let mut script = Script(script);
    for _ in 0..CALLS {
        if script.is_over() {
            break;
        }
        importer.call(&mut script);
    }
    importer.end();
    DIGEST.get()
}

impl<M: Model> Importer<M> {
    fn instantiate(&mut self, script: &mut Script<'_>) {
        let listen: unsafe extern "C" fn(_, _, _, _, _) = listen;
        let callbacks = [listen as *const c_void, null(), null(), null(), null()];
        let given = if script.seldom() {
            null()
        } else {
            callbacks.as_ptr()
        };
        let name = if script.seldom() {
            null()
        } else {
            c"fuzzed".as_ptr()
        };
        let guid = if script.seldom() {
            c"{}"
        } else {
            self.guid.as_c_str()
        };
        let kind = if script.seldom() { script.integer() } else { 1 };
        let log = script.byte() < 200;
        // SAFETY: strings end with NUL; five pointers are what the headers call the callbacks.
        let component = unsafe {
            let (guid, given) = (guid.as_ptr(), given.cast::<Callbacks>());
            self.library.instantiate(name, kind, guid, name, given, log)
        };
        see(&[u8::from(component.is_null())]);
        self.components.push(component);
    }

    /// An instance, mostly the first; now and then a dead one, a state, or nothing.
    fn component(&self, script: &mut Script<'_>) -> *mut c_void {
        if script.seldom() {
            let odd = [null_mut(), without_provenance_mut(script.below(256))];
            let all = self.components.iter().chain(&self.states).chain(&odd);
            return script.pick(&all.copied().collect::<Vec<_>>());
        }
        self.components[0]
    }

    fn state(&self, script: &mut Script<'_>) -> *mut c_void {
        let odd = [null_mut(), self.components[0]];
        let all: Vec<_> = self.states.iter().chain(&odd).copied().collect();
        script.pick(&all)
    }

    /// Fills the references; returns a count that fits them, or one that is refused.
    fn arguments(&mut self, script: &mut Script<'_>) -> usize {
        let count = script.below(4);
        let whole = script.seldom();
        let rows = u32::try_from(M::VARIABLES.len()).unwrap_or(u32::MAX);
        for (at, reference) in (0..rows).zip(&mut self.references) {
            *reference = if whole { at } else { 0 };
        }
        for reference in self.references.iter_mut().take(count) {
            let high = u32::from(script.byte());
            *reference = if script.seldom() {
                high << 24
            } else {
                (high * 256 + u32::from(script.byte())) % rows
            };
        }
        if script.seldom() {
            script.pick(&[usize::MAX, M::VARIABLES.len() + 1, 1 << 40])
        } else if whole {
            M::VARIABLES.len()
        } else {
            count
        }
    }

    fn call(&mut self, script: &mut Script<'_>) {
        let status = match script.below(40) {
            0 => return self.instantiate(script),
            1 => return self.free_instance(script),
            2..5 => self.start(script),
            5..10 => self.steps(script),
            10 => self.life_cycle(script),
            11..14 => self.life_cycle(script),
            14..24 => self.set(script),
            24..30 => self.get(script),
            30..36 => self.with_states(script),
            36..38 => self.derivatives(script),
            _ => self.rest(script),
        };
        see(&[status as u8]);
        assert!(status != Status::Fatal, "the model panicked");
    }

    fn free_instance(&mut self, script: &mut Script<'_>) {
        let component = self.component(script);
        if component != self.components[0] || script.seldom() {
            // SAFETY: an instance or something that is refused.
            unsafe { self.library.free_instance(component) };
        }
    }

    fn start(&mut self, script: &mut Script<'_>) -> Status {
        let c = self.component(script);
        let library = self.library;
        let setup = library.enter(c, Call::SetupExperiment, |i, _| {
            i.setup_experiment(0.0, None)
        });
        let enter = library.enter(c, Call::EnterInitializationMode, |i, _| {
            i.enter_initialization()
        });
        see(&[setup as u8, enter as u8]);
        library.enter(c, Call::ExitInitializationMode, |i, log| {
            i.exit_initialization(log)
        })
    }

    fn life_cycle(&self, script: &mut Script<'_>) -> Status {
        let (c, library) = (self.component(script), self.library);
        match script.below(5) {
            0 => {
                let stop = (script.byte() < 128).then(|| script.real());
                let start = script.real();
                library.enter(c, Call::SetupExperiment, |i, _| {
                    i.setup_experiment(start, stop)
                })
            }
            1 => library.enter(c, Call::EnterInitializationMode, |i, _| {
                i.enter_initialization()
            }),
            2 => library.enter(c, Call::ExitInitializationMode, |i, log| {
                i.exit_initialization(log)
            }),
            3 => library.enter(c, Call::Terminate, |i, _| i.terminate()),
            _ => library.enter(c, Call::Reset, |i, _| i.reset()),
        }
    }

    fn steps(&self, script: &mut Script<'_>) -> Status {
        const SIZES: [f64; 8] = [1e-3, 1e-2, 0.1, 1e-6, 1e-4, 2e-3, 0.050_000_1, 1.0];
        let (c, mut now) = (self.component(script), 0.0);
        // SAFETY: an instance or something that is refused; a number of our own.
        let known = unsafe { self.library.real_status(c, 2, &mut now) };
        see(&[known as u8]);
        let size = if script.seldom() {
            script.real()
        } else {
            script.pick(&SIZES)
        };
        let time = if script.seldom() { script.real() } else { now };
        let mut status = self.step(c, time, size);
        for k in 1..=script.below(8) {
            now = k as f64 * size + time;
            status = self.step(c, now, size);
        }
        status
    }

    fn step(&self, c: *mut c_void, time: f64, size: f64) -> Status {
        self.library
            .enter(c, Call::DoStep, |i, log| i.step(time, size, log))
    }

    fn set(&mut self, script: &mut Script<'_>) -> Status {
        let (c, count, library) = (self.component(script), self.arguments(script), self.library);
        let few = count.min(4);
        let references = self.references.as_ptr();
        // SAFETY: an instance or something that is refused; arrays longer than any count that is not.
        unsafe {
            match script.below(8) {
                0 => {
                    self.integers
                        .iter_mut()
                        .take(few)
                        .for_each(|v| *v = script.integer());
                    let values = self.integers.as_ptr();
                    library.set::<i32, c_int>(c, references, count, values, |value| value)
                }
                1 => {
                    self.integers
                        .iter_mut()
                        .take(few)
                        .for_each(|v| *v = script.integer());
                    let values = self.integers.as_ptr();
                    library.set::<bool, c_int>(c, references, count, values, |value| value != 0)
                }
                2 => {
                    self.texts.fill(c"text".as_ptr());
                    library.set_strings(c, references, count, self.texts.as_ptr())
                }
                _ => {
                    self.reals
                        .iter_mut()
                        .take(few)
                        .for_each(|v| *v = script.real());
                    let values = self.reals.as_ptr();
                    library.set_reals(c, references, count, values)
                }
            }
        }
    }

    fn get(&mut self, script: &mut Script<'_>) -> Status {
        let (c, count, library) = (self.component(script), self.arguments(script), self.library);
        let references = self.references.as_ptr();
        // SAFETY: as above.
        unsafe {
            match script.below(8) {
                0 => library.get_others::<i32, c_int>(
                    c,
                    references,
                    count,
                    self.integers.as_mut_ptr(),
                ),
                1 => library.get_others::<bool, c_int>(
                    c,
                    references,
                    count,
                    self.integers.as_mut_ptr(),
                ),
                2 => library.get_strings(c, references, count, self.texts.as_mut_ptr()),
                _ => {
                    let values = self.reals.as_mut_ptr();
                    let status = library.get_reals(c, references, count, values);
                    if status == Status::Ok {
                        self.look_at(count);
                    }
                    status
                }
            }
        }
    }

    fn look_at(&self, count: usize) {
        for value in self.reals.iter().take(count) {
            assert!(value.is_finite(), "an importer was handed {value}");
            see(&value.to_bits().to_le_bytes());
        }
    }

    fn derivatives(&mut self, script: &mut Script<'_>) -> Status {
        let (c, count, library) = (self.component(script), self.arguments(script), self.library);
        let references = self.references.as_ptr();
        let order = if script.seldom() { script.integer() } else { 1 };
        self.integers.fill(order);
        self.reals
            .iter_mut()
            .take(4)
            .for_each(|value| *value = script.real());
        let orders = self.integers.as_ptr();
        // SAFETY: as above.
        unsafe {
            match script.below(3) {
                0 => {
                    library.set_input_derivatives(c, references, count, orders, self.reals.as_ptr())
                }
                1 => {
                    let values = self.reals.as_mut_ptr();
                    library.get_output_derivatives(c, references, count, orders, values)
                }
                _ => {
                    let known = self.references.get(1..).unwrap_or_default().as_ptr();
                    let knowns = script.below(4);
                    let (direction, to) = (self.reals.clone(), self.reals.as_mut_ptr());
                    let counts = [count, knowns];
                    let given = direction.as_ptr();
                    library.directional_derivative(c, (references, known), counts, given, to)
                }
            }
        }
    }

    fn rest(&mut self, script: &mut Script<'_>) -> Status {
        let (c, library, kind) = (self.component(script), self.library, script.integer());
        match script.below(3) {
            0 => library.status(c, Call::GetStatus, kind),
            1 => library.not_offered(c, Call::CancelStep, "asynchronous steps"),
            _ => {
                let names = [
                    c"logStatusError".as_ptr(),
                    c"logEvents".as_ptr(),
                    c"all".as_ptr(),
                    null(),
                ];
                let count = script.pick(&[0, 1, 2, 3, 4, usize::MAX]);
                // SAFETY: an instance or something that is refused; names up to any count that is not.
                unsafe { library.set_debug_logging(c, kind > 0, count, names.as_ptr()) }
            }
        }
    }

    /// Frees everything, through an instance that is surely alive.
    fn end(mut self) {
        self.instantiate(&mut Script(&[]));
        let Some(&alive) = self.components.last() else {
            return;
        };
        for state in &mut self.states {
            // SAFETY: a live instance; a state or something that is refused.
            let status = unsafe { self.library.free_state(alive, state) };
            see(&[status as u8]);
        }
        for component in self.components {
            // SAFETY: an instance, or one that was freed, which is refused.
            unsafe { self.library.free_instance(component) };
        }
    }
}
