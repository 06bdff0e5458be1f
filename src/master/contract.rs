//! What a plant shows to the other FMUs: the description of DctPlant, which mapping files refer to.

use crate::description::Description;
use crate::error::Error;
use crate::unit::Unit;

/// Written by `cargo fmu describe`.
const PLANT: &str = include_str!("../../modelDescription/DctPlant.xml");

/// The variables that a supplier's plant may stand for.
pub fn plant() -> Result<Description, Error> {
    Description::parse(PLANT).map_err(|what| Error::Usage(format!("DctPlant.xml: {what}")))
}

/// The SI unit of a variable; the unit 1 where it has none.
pub fn unit(contract: &Description, name: &str) -> Unit {
    let variable = contract.find(name);
    let unit = variable.and_then(|variable| variable.unit.clone());
    unit.unwrap_or_else(|| Unit::named("1", [0; 8]))
}
