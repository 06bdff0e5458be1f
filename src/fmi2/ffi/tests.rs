//! What an importer sees at the C boundary, on a model that can be made to panic.

use super::*;
use crate::{Experiment, Failure, StateFields, Unit, Variable};
use core::cell::{Cell, RefCell};
use core::ptr::null;

mod resources;
mod saved;
mod sequences;
mod shadow;
mod strings;

/// x grows by `u` per second; u above 100 makes it panic, which the table does not know.
#[derive(Clone, Default)]
struct Fuse {
    u: f64,
    x: f64,
}

impl Model for Fuse {
    const NAME: &'static str = "Fuse";
    const DESCRIPTION: &'static str = "A fuse";
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 1.0,
        step: 0.1,
    };
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::input("u", Unit::ONE, |m: &mut Self| &mut m.u, "Input").min(0.0),
        Variable::output("x", Unit::ONE, |m: &mut Self| &mut m.x, "Output").depends_on(&[]),
    ];

    fn initialize(&mut self, _: f64, log: &mut Log<'_>) -> Result<(), Failure> {
        self.x = 0.0;
        log.event(format_args!("100 % #ready#"));
        Ok(())
    }

    fn step(&mut self, _: f64, step: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        assert!(self.u <= 100.0, "the fuse blew");
        self.x += step * self.u;
        Ok(())
    }

    fn hidden_state(&mut self, _: &mut dyn StateFields) {}
}

const U: u32 = 0;
const X: u32 = 1;

static FMU: Library<Fuse> = Library::empty();

/// One call of the logger: environment, status, category, text.
type Line = (usize, c_int, String, String);

thread_local! {
    static LINES: RefCell<Vec<Line>> = const { RefCell::new(Vec::new()) };
    /// What the logger calls back with, and what it gets.
    static AGAIN: Cell<*mut c_void> = const { Cell::new(null_mut()) };
    static ANSWERS: RefCell<Vec<Status>> = const { RefCell::new(Vec::new()) };
}

/// Stable Rust cannot define a variadic function: this is an importer without variable arguments.
unsafe extern "C" fn listen(
    environment: *mut c_void,
    _: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
) {
    // SAFETY: the shell passes NUL-terminated strings.
    let text = |pointer| unsafe { text(pointer) }.unwrap().to_str().unwrap().into();
    let line = (environment.addr(), status, text(category), text(format));
    LINES.with_borrow_mut(|lines| lines.push(line));
    let again = AGAIN.get();
    if !again.is_null() {
        let answers = [step(again, 0.0), set_u(again, 1.0)];
        free(again);
        ANSWERS.with_borrow_mut(|all| all.extend(answers));
    }
}

const ENVIRONMENT: usize = 0x5a;

fn instantiate_with(guid: &str, logging_on: bool) -> *mut c_void {
    instantiate_in(&FMU, guid, logging_on)
}

fn instantiate_in<M: Model>(fmu: &'static Library<M>, guid: &str, logging_on: bool) -> *mut c_void {
    instantiate_at(fmu, guid, null(), logging_on)
}

fn instantiate_at<M: Model>(
    fmu: &'static Library<M>,
    guid: &str,
    resources: *const c_char,
    logging_on: bool,
) -> *mut c_void {
    let listen: unsafe extern "C" fn(_, _, _, _, _) = listen;
    // SAFETY: a C caller passes the named arguments alike, variadic or not, on every platform the
    // tests run on.
    let logger = unsafe { core::mem::transmute::<*const (), Logger>(listen as *const ()) };
    let callbacks = Callbacks {
        logger: Some(logger),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        environment: without_provenance_mut(ENVIRONMENT),
    };
    let guid = CString::new(guid).unwrap();
    // SAFETY: strings end with NUL; `callbacks` dies after the call, as the contract allows.
    unsafe {
        fmu.instantiate(
            c"f".as_ptr(),
            1,
            guid.as_ptr(),
            resources,
            &callbacks,
            logging_on,
        )
    }
}

fn fuse() -> *mut c_void {
    instantiate_with(&guid::<Fuse>(), true)
}

/// A fuse at its first communication point.
fn running() -> *mut c_void {
    let c = fuse();
    let setup = FMU.enter(c, Call::SetupExperiment, |i, _| {
        i.setup_experiment(0.0, None)
    });
    let entered = FMU.enter(c, Call::EnterInitializationMode, |i, _| {
        i.enter_initialization()
    });
    let left = FMU.enter(c, Call::ExitInitializationMode, |i, log| {
        i.exit_initialization(log)
    });
    assert_eq!([setup, entered, left], [Status::Ok; 3]);
    c
}

fn set_u(c: *mut c_void, u: f64) -> Status {
    // SAFETY: a live component or one that is refused; arrays of one.
    unsafe { FMU.set_reals(c, &U, 1, &u) }
}

fn x(c: *mut c_void) -> f64 {
    let mut x = f64::NAN;
    // SAFETY: a live component; arrays of one.
    let status = unsafe { FMU.get_reals(c, &X, 1, &mut x) };
    assert_eq!(status, Status::Ok);
    x
}

fn step(c: *mut c_void, time: f64) -> Status {
    FMU.step(c, time, 0.1)
}

fn free(c: *mut c_void) {
    // SAFETY: a live component.
    unsafe { FMU.free_instance(c) }
}

fn lines() -> Vec<Line> {
    LINES.take()
}

#[test]
fn a_panic_is_fatal_logged_and_poisons_its_instance_alone() {
    let (c, other) = (running(), running());
    lines();
    assert_eq!(set_u(c, 101.0), Status::Ok);
    assert_eq!(step(c, 0.0), Status::Fatal);
    let logged = lines();
    assert_eq!(logged.len(), 1);
    assert_eq!((logged[0].1, logged[0].2.as_str()), (4, "logStatusFatal"));
    for _ in 0..2 {
        assert_eq!(set_u(c, 1.0), Status::Fatal);
        assert_eq!(step(c, 0.0), Status::Fatal);
        // SAFETY: a live component; arrays of one.
        let got = unsafe { FMU.get_reals(c, &X, 1, &mut 0.0) };
        assert_eq!(got, Status::Fatal);
        assert_eq!(FMU.enter(c, Call::Reset, |i, _| i.reset()), Status::Fatal);
    }
    assert_eq!(set_u(other, 1.0), Status::Ok);
    assert_eq!(step(other, 0.0), Status::Ok);
    [c, other].into_iter().for_each(free);
}

#[test]
fn every_one_of_many_instances_sets_steps_and_gets() {
    let all: Vec<_> = (0..200_u8)
        .map(|number| (running(), f64::from(number) / 2.0))
        .collect();
    for &(c, u) in &all {
        assert_eq!([set_u(c, u), step(c, 0.0)], [Status::Ok; 2]);
    }
    for (c, u) in all {
        assert_eq!(x(c), 0.1 * u);
        free(c);
        assert_eq!(step(c, 0.1), Status::Error);
    }
}

#[test]
fn messages_are_finished_texts_with_the_importers_environment() {
    let c = running();
    let (environment, status, category, text) = lines().remove(0);
    assert_eq!((environment, status), (ENVIRONMENT, 0));
    assert_eq!(category, "logEvents");
    assert_eq!(text, "100 %% ##ready##");
    assert_eq!(set_u(c, -1.0), Status::Discard);
    let (_, status, category, text) = lines().remove(0);
    assert_eq!((status, category.as_str()), (2, "logStatusDiscard"));
    assert_eq!(text, "fmi2SetReal: u = -1 is below 0");
    free(c);
}

#[test]
fn only_enabled_categories_are_logged() {
    let c = running();
    lines();
    let names = [c"logStatusError".as_ptr()];
    // SAFETY: a live component; one string.
    let status = unsafe { FMU.set_debug_logging(c, true, 1, names.as_ptr()) };
    assert_eq!(status, Status::Ok);
    assert_eq!(set_u(c, -1.0), Status::Discard);
    assert_eq!(step(c, 7.0), Status::Error);
    let categories: Vec<_> = lines().into_iter().map(|line| line.2).collect();
    assert_eq!(categories, ["logStatusError"]);
    free(c);
}

#[test]
fn a_foreign_guid_makes_no_instance_and_says_so_even_with_logging_off() {
    assert!(instantiate_with("{00000000-0000-0000-0000-000000000000}", false).is_null());
    assert!(lines()[0].3.contains("GUID"));
}

#[test]
fn null_and_foreign_pointers_are_refused() {
    let c = running();
    let mut state = null_mut();
    // SAFETY: a live component; NULL and swapped pointers are what is tested, and both are live.
    unsafe {
        assert_eq!(step(null_mut(), 0.0), Status::Error);
        assert_eq!(FMU.get_state(c, &mut state), Status::Ok);
        assert_eq!(step(state, 0.0), Status::Error);
        assert_eq!(FMU.set_state(c, c), Status::Error);
        assert_eq!(FMU.set_state(c, null_mut()), Status::Error);
        let mut component = c;
        assert_eq!(FMU.free_state(c, &mut component), Status::Error);
        assert_eq!(component, c);
        assert_eq!(FMU.set_reals(c, null(), 1, &1.0), Status::Error);
        assert_eq!(FMU.set_reals(c, &U, 1, null()), Status::Error);
        assert_eq!(FMU.free_state(c, &mut state), Status::Ok);
        assert!(state.is_null());
        assert_eq!(FMU.free_state(c, &mut state), Status::Ok);
    }
    assert_eq!(step(c, 0.0), Status::Ok);
    free(c);
    free(null_mut());
}

#[test]
fn an_instance_that_was_freed_is_refused_however_often_it_comes_back() {
    let c = running();
    free(c);
    lines();
    let other = running();
    for _ in 0..3 {
        assert_eq!(step(c, 0.0), Status::Error);
        free(c);
    }
    assert_eq!(step(other, 0.0), Status::Ok);
    free(other);
}

#[test]
fn a_state_in_place_of_its_address_is_freed_once_and_never_followed() {
    let c = running();
    let mut state = null_mut();
    // SAFETY: a live component and a place of our own; what is no address is what is tested.
    unsafe {
        assert_eq!(FMU.get_state(c, &mut state), Status::Ok);
        assert_eq!(FMU.free_state(c, state.cast()), Status::Ok);
        assert_eq!(FMU.set_state(c, state), Status::Error);
        assert_eq!(FMU.free_state(c, &mut state), Status::Error);
    }
    free(c);
}

#[test]
fn a_state_that_was_freed_is_refused() {
    let c = running();
    let mut state = null_mut();
    // SAFETY: a live component; places of our own.
    unsafe {
        assert_eq!(FMU.get_state(c, &mut state), Status::Ok);
        let kept = state;
        assert_eq!(FMU.free_state(c, &mut state), Status::Ok);
        let (mut freed, mut size) = (kept, 0);
        assert_eq!(FMU.free_state(c, &mut freed), Status::Error);
        assert_eq!(FMU.get_state(c, &mut freed), Status::Error);
        assert_eq!(FMU.state_size(c, kept, &mut size), Status::Error);
        assert_eq!(freed, kept);
    }
    assert_eq!(FMU.set_state(c, state), Status::Error);
    assert_eq!(step(c, 0.0), Status::Ok);
    free(c);
}

#[test]
fn the_logger_may_not_call_the_instance_that_calls_it() {
    let c = running();
    lines();
    AGAIN.set(c);
    assert_eq!(set_u(c, -1.0), Status::Discard);
    AGAIN.set(null_mut());
    assert_eq!(lines().len(), 1);
    assert_eq!(ANSWERS.take(), [Status::Error; 2]);
    assert_eq!(step(c, 0.0), Status::Ok);
    free(c);
}

#[test]
fn the_logger_may_call_another_instance() {
    let (c, other) = (running(), running());
    AGAIN.set(other);
    assert_eq!(set_u(c, -1.0), Status::Discard);
    AGAIN.set(null_mut());
    assert_eq!(ANSWERS.take(), [Status::Ok; 2]);
    assert_eq!(step(other, 0.0), Status::Error);
    free(c);
}

#[test]
fn threads_that_share_an_instance_by_mistake_are_let_in_one_at_a_time() {
    let c = running().addr();
    let calls = || {
        let c = without_provenance_mut(c);
        (0..10_000).map(|_| set_u(c, 1.0)).collect::<Vec<_>>()
    };
    let all: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(calls)).collect();
        threads
            .into_iter()
            .flat_map(|t| t.join().unwrap())
            .collect()
    });
    let known = [Status::Ok, Status::Error];
    assert!(all.iter().all(|status| known.contains(status)));
    assert!(all.contains(&Status::Ok));
    free(without_provenance_mut(c));
}

#[test]
fn a_state_goes_through_bytes_into_another_instance() {
    let (c, other) = (running(), fuse());
    assert_eq!(set_u(c, 2.0), Status::Ok);
    assert_eq!(step(c, 0.0), Status::Ok);
    let (mut state, mut copy, mut size) = (null_mut(), null_mut(), 0);
    // SAFETY: live components; `bytes` has the size that was asked for.
    unsafe {
        assert_eq!(FMU.get_state(c, &mut state), Status::Ok);
        assert_eq!(FMU.state_size(c, state, &mut size), Status::Ok);
        let mut bytes = vec![0; size];
        let short = FMU.serialize_state(c, state, bytes.as_mut_ptr(), size - 1);
        assert_eq!(short, Status::Error);
        let status = FMU.serialize_state(c, state, bytes.as_mut_ptr(), size);
        assert_eq!(status, Status::Ok);
        let status = FMU.deserialize_state(other, bytes.as_ptr(), size, &mut copy);
        assert_eq!(status, Status::Ok);
        assert_eq!(FMU.set_state(other, copy), Status::Ok);
    }
    for c in [c, other] {
        assert_eq!(step(c, 0.1), Status::Ok);
        assert_eq!(x(c).to_bits(), (0.1 * 2.0 + 0.1 * 2.0_f64).to_bits());
    }
    // SAFETY: live states of live components.
    unsafe {
        assert_eq!(FMU.free_state(c, &mut state), Status::Ok);
        assert_eq!(FMU.free_state(other, &mut copy), Status::Ok);
    }
    [c, other].into_iter().for_each(free);
}
