//! Sequences of calls at the C boundary of the three FMUs, right and wrong ones.
#![no_main]

use dct_models::{ClutchControl, Observer, Plant};
use fmi2_cosim::ffi::Library;
use fmu_fuzz::importer;

static PLANT: Library<Plant> = Library::empty();
static OBSERVER: Library<Observer> = Library::empty();
static CONTROL: Library<ClutchControl> = Library::empty();

libfuzzer_sys::fuzz_target!(|script: &[u8]| {
    let Some((model, script)) = script.split_first() else {
        return;
    };
    match model % 3 {
        0 => importer::play_twice(&PLANT, script),
        1 => importer::play_twice(&OBSERVER, script),
        _ => importer::play_twice(&CONTROL, script),
    }
});
