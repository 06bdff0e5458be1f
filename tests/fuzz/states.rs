//! Bytes that claim to be a saved state: raw ones, and payloads under a checksum that fits them.
#![no_main]

use dct_models::{ClutchControl, Observer, Plant};
use fmi2_cosim::{Call, Instance, Log, Model, Saved};
use fmu_fuzz::script::Script;
use std::sync::OnceLock;

/// Magic, version, GUID, length of the payload; the checksum; the payload.
const CHECKSUM: usize = 36;
const PAYLOAD: usize = CHECKSUM + 16;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else {
        return;
    };
    match first % 3 {
        0 => restore::<Plant>(&PLANT, first / 3, bytes),
        1 => restore::<Observer>(&OBSERVER, first / 3, bytes),
        _ => restore::<ClutchControl>(&CONTROL, first / 3, bytes),
    }
});

/// States after 0 to 3 steps, made once.
type Sound = OnceLock<[Vec<u8>; 4]>;

static PLANT: Sound = OnceLock::new();
static OBSERVER: Sound = OnceLock::new();
static CONTROL: Sound = OnceLock::new();

fn restore<M: Model>(sound: &Sound, how: u8, bytes: &[u8]) {
    let sound = sound.get_or_init(|| [0, 1, 2, 3].map(|steps| started::<M>(steps).to_bytes()));
    let state = if how.is_multiple_of(2) {
        patched(sound, bytes)
    } else {
        bytes.to_vec()
    };
    let Ok(saved) = Saved::<M>::from_bytes(&state) else {
        return;
    };
    // A field that is in the payload twice is what its second copy says.
    let written = saved.to_bytes();
    let again = Saved::<M>::from_bytes(&written).map(|again| again.to_bytes());
    assert!(again == Ok(written), "what is read is not what was written");
    let mut instance = Instance::<M>::default();
    assert!(instance.restore(&saved).is_ok());
    run_on(&mut instance);
}

/// Whatever the state is, the instance answers.
fn run_on<M: Model>(instance: &mut Instance<M>) {
    let mut ignore = |_, _: core::fmt::Arguments<'_>| {};
    let mut log = Log::new(&mut ignore);
    for _ in 0..3 {
        let rows = 0..u32::try_from(M::VARIABLES.len()).unwrap_or(0);
        for reference in rows {
            if let Ok(values) = instance.get::<f64>(&[reference], &mut log) {
                values.for_each(drop);
            }
        }
        if instance.permit(Call::DoStep).is_ok() {
            let _ = instance.step(instance.time(), 0.01, &mut log);
        } else {
            let _ = instance.exit_initialization(&mut log);
            let _ = instance.enter_initialization();
        }
    }
}

/// A sound state with fields overwritten, and the checksum made anew.
fn patched(sound: &[Vec<u8>; 4], bytes: &[u8]) -> Vec<u8> {
    let mut script = Script(bytes);
    let mut state = sound[script.below(4)].clone();
    while !script.is_over() {
        let at = usize::from(script.byte()) * 256 + usize::from(script.byte());
        let value = script.real().to_bits().to_le_bytes();
        let room = state.len() - PAYLOAD;
        let whole = script.pick(&[1, 4, 8, 8]);
        for (k, byte) in value.iter().enumerate().take(whole) {
            state[PAYLOAD + (at + k) % room] = *byte;
        }
    }
    let sum = fnv(&state[PAYLOAD..]).to_le_bytes();
    state[CHECKSUM..PAYLOAD].copy_from_slice(&sum);
    state
}

fn started<M: Model>(steps: usize) -> Saved<M> {
    let mut ignore = |_, _: core::fmt::Arguments<'_>| {};
    let mut log = Log::new(&mut ignore);
    let mut instance = Instance::<M>::default();
    let started = instance
        .setup_experiment(0.0, None)
        .and_then(|()| instance.enter_initialization())
        .and_then(|()| instance.exit_initialization(&mut log));
    assert!(started.is_ok());
    for _ in 0..steps {
        assert!(instance.step(instance.time(), 0.01, &mut log).is_ok());
    }
    instance.save().unwrap_or_else(|error| panic!("{error}"))
}

/// FNV-1a in 128 bits, as draft-eastlake-fnv has it.
fn fnv(bytes: &[u8]) -> u128 {
    let fold = |hash: u128, byte: &u8| {
        (hash ^ u128::from(*byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b)
    };
    bytes
        .iter()
        .fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d, fold)
}
