//! What lasts from step to step in the plant and is no variable: part of saved states.
//!
//! Every field is named, so that one which is added does not compile before somebody has decided what it is.

use super::table;
use dct_driveline::plant::mesh::Meshes;
use dct_driveline::plant::modes::Mode;
use dct_driveline::plant::{Plant, Work};
use fmi2_cosim::StateFields;

/// Visits the driveline, and the gears that were `refused` last, shape (2).
pub(super) fn visit(plant: &mut Plant, refused: &mut [i32; 2], fields: &mut dyn StateFields) {
    let Plant {
        x,
        modes,
        brake,
        gear,
        synchroniser,
        meshes: Meshes { load, output },
        temperature,
        work,
        stored_at_start,
        grade: _, // found again where the road is another one
    } = plant;
    let gears = gear.iter_mut().chain(refused);
    gears.for_each(|gear| fields.integer(gear));
    fields.reals(x.as_mut_slice());
    let shafts = synchroniser.iter_mut().chain(load);
    for mode in modes.iter_mut().chain([brake, output]).chain(shafts) {
        visit_mode(mode, fields);
    }
    visit_work(work, fields);
    fields.reals(temperature);
    fields.real(stored_at_start);
}

fn visit_mode(mode: &mut Mode, fields: &mut dyn StateFields) {
    let mut code = *mode as i32;
    fields.integer(&mut code);
    *mode = table::mode(code);
}

fn visit_work(work: &mut Work, fields: &mut dyn StateFields) {
    let Work {
        engine,
        load,
        friction,
        viscous,
        synchroniser,
        brake,
    } = work;
    fields.reals(friction);
    for value in [engine, viscous, synchroniser, load, brake] {
        fields.real(value);
    }
}
