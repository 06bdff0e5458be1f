//! `UnitDefinitions`: the units that some variable uses, each once, in the order of the table.

use super::number::finite;
use crate::{Error, Result};
use fmi2_cosim::{Access, Unit, Variable};
use serde::Serialize;

#[derive(Serialize)]
pub(super) struct UnitDefinitions {
    #[serde(rename = "Unit")]
    units: Vec<UnitElement>,
}

#[derive(Serialize)]
struct UnitElement {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "BaseUnit")]
    base: BaseUnit,
    #[serde(rename = "DisplayUnit")]
    display: Vec<DisplayUnitElement>,
}

/// Exponents of the SI base units; those that are zero are not written.
#[derive(Serialize)]
struct BaseUnit {
    #[serde(rename = "@kg", skip_serializing_if = "is_zero")]
    kg: i8,
    #[serde(rename = "@m", skip_serializing_if = "is_zero")]
    m: i8,
    #[serde(rename = "@s", skip_serializing_if = "is_zero")]
    s: i8,
    #[serde(rename = "@A", skip_serializing_if = "is_zero")]
    ampere: i8,
    #[serde(rename = "@K", skip_serializing_if = "is_zero")]
    kelvin: i8,
    #[serde(rename = "@mol", skip_serializing_if = "is_zero")]
    mol: i8,
    #[serde(rename = "@cd", skip_serializing_if = "is_zero")]
    cd: i8,
    #[serde(rename = "@rad", skip_serializing_if = "is_zero")]
    rad: i8,
}

#[derive(Serialize)]
struct DisplayUnitElement {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@factor")]
    factor: String,
    #[serde(rename = "@offset", skip_serializing_if = "Option::is_none")]
    offset: Option<String>,
}

/// `None` when no variable has a unit. Two units cannot have one name, for a variable tells its unit by that.
pub(super) fn definitions<M>(rows: &[Variable<M>]) -> Result<Option<UnitDefinitions>> {
    let units = used(&rows.iter().collect::<Vec<_>>());
    for row in rows
        .iter()
        .filter(|row| matches!(row.access, Access::Real(_)))
    {
        if !units.contains(&row.unit) {
            return Err(Error::TwoMeanings(["unit", row.unit.name, row.name]));
        }
    }
    let units = units.iter().map(element).collect::<Result<Vec<_>>>()?;
    Ok((!units.is_empty()).then_some(UnitDefinitions { units }))
}

/// The units of the Real variables among `rows`, each once, in their order.
pub(crate) fn used<M>(rows: &[&Variable<M>]) -> Vec<Unit> {
    let mut used: Vec<Unit> = Vec::new();
    for row in rows {
        if matches!(row.access, Access::Real(_)) && used.iter().all(|u| u.name != row.unit.name) {
            used.push(row.unit);
        }
    }
    used
}

fn element(unit: &Unit) -> Result<UnitElement> {
    let [kg, m, s, ampere, kelvin, mol, cd, rad] = unit.exponents;
    let base = BaseUnit {
        kg,
        m,
        s,
        ampere,
        kelvin,
        mol,
        cd,
        rad,
    };
    let display = unit.display.iter().map(|shown| {
        let offset = (shown.offset != 0.0).then(|| finite(shown.name, "offset", shown.offset));
        Ok(DisplayUnitElement {
            name: shown.name,
            factor: finite(shown.name, "factor", shown.factor)?,
            offset: offset.transpose()?,
        })
    });
    Ok(UnitElement {
        name: unit.name,
        base,
        display: display.collect::<Result<_>>()?,
    })
}

fn is_zero<T: PartialEq + Default>(exponent: &T) -> bool {
    *exponent == T::default()
}
