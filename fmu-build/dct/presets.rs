//! The presets of this workspace's models as parameter files, read back to be sure of them.

use crate::parameters::{ParameterSet, set};
use crate::{Result, library};
use dct_models::presets::{PRESETS, Parametrised, Preset};
use dct_models::{ClutchControl, Observer, Plant};
use std::path::PathBuf;

/// Every parameter file of `examples/closed_loop/parameters` with its text.
///
/// # Errors
/// When a number is not finite.
pub(super) fn files() -> Result<Vec<(PathBuf, String)>> {
    let folder = library::workspace().join("examples/closed_loop/parameters");
    let components = [
        ("plant", presets::<Plant>()?),
        ("observer", shared::<Observer>()?),
        ("control", positions::<ClutchControl>()?),
    ];
    let files = components.into_iter().flat_map(|(component, sets)| {
        let folder = folder.clone();
        let path = move |name| folder.join(format!("{name}_{component}.ssv"));
        sets.into_iter().map(move |set| (path(set.name), set.text))
    });
    Ok(files.collect())
}

/// All presets for model `M`.
pub(super) fn presets<M: Parametrised>() -> Result<Vec<ParameterSet>> {
    PRESETS.iter().map(of_preset::<M>).collect()
}

/// The presets that differ in more than what the plant alone knows.
pub(super) fn shared<M: Parametrised>() -> Result<Vec<ParameterSet>> {
    let presets = PRESETS.iter().filter(|preset| !preset.of_plant);
    presets.map(of_preset::<M>).collect()
}

/// The presets whose clutches a position moves: a control that moves positions has no other.
pub(super) fn positions<M: Parametrised>() -> Result<Vec<ParameterSet>> {
    let by_position = |preset: &&Preset| {
        let clutches = preset.params.clutch.iter();
        !preset.of_plant && clutches.clone().all(|one| one.piston_area == 0.0)
    };
    let presets = PRESETS.iter().filter(by_position);
    presets.map(of_preset::<M>).collect()
}

fn of_preset<M: Parametrised>(preset: &Preset) -> Result<ParameterSet> {
    Ok(ParameterSet {
        name: preset.name.into(),
        title: preset.title.into(),
        text: text::<M>(preset)?,
    })
}

/// The parameter set of a preset for model `M`.
///
/// # Errors
/// When a number is not finite.
pub(super) fn text<M: Parametrised>(preset: &Preset) -> Result<String> {
    let mut model = M::of_preset(preset);
    set(preset.name, preset.title, &mut model, M::describes_vehicle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::read;
    use fmi2_cosim::Access;

    fn check<M: Parametrised>(preset: &Preset) -> M {
        let written = text::<M>(preset).unwrap();
        let mut back: M = read(&written).unwrap();
        let mut meant = M::of_preset(preset);
        let rows = M::VARIABLES.iter().filter(|row| M::describes_vehicle(row));
        let mut count = 0;
        for row in rows {
            let same = match row.access {
                Access::Real(field) => field(&mut back).to_bits() == field(&mut meant).to_bits(),
                Access::Boolean(field) => field(&mut back) == field(&mut meant),
                Access::Integer(field) | Access::Enumeration(field, _) => {
                    field(&mut back) == field(&mut meant)
                }
                Access::String(field) => field(&mut back) == field(&mut meant),
            };
            assert!(same, "{}", row.name);
            count += 1;
        }
        assert!(count > 40, "{count} parameters");
        back
    }

    #[test]
    fn every_preset_reads_back_bit_for_bit() {
        for preset in &PRESETS {
            let mut plant: Plant = check(preset);
            assert_eq!(plant.vehicle(), preset.params, "no parameter is missing");
            check::<Observer>(preset);
            check::<ClutchControl>(preset);
        }
    }

    #[test]
    fn a_set_that_does_not_fit_says_why() {
        let set =
            |inner: &str| format!("<ParameterSet><Parameters>{inner}</Parameters></ParameterSet>");
        let cases = [
            (
                "<Parameter name=\"no.such\"><Real value=\"1\"/></Parameter>",
                "no.such",
            ),
            (
                "<Parameter name=\"engine.inertia\"><Real value=\"x\"/></Parameter>",
                "engine.inertia = x",
            ),
            (
                "<Parameter name=\"engine.inertia\"><Real/></Parameter>",
                "attribute value",
            ),
            ("<Parameter", ""),
        ];
        for (inner, expected) in cases {
            let error = read::<Plant>(&set(inner)).err().expect(inner).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
