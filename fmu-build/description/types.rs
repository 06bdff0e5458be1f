//! `TypeDefinitions`: the enumerations that some variable uses, each once.

use crate::{Error, Result};
use fmi2_cosim::{Access, Enumeration, Variable};
use serde::Serialize;

#[derive(Serialize)]
pub(super) struct TypeDefinitions {
    #[serde(rename = "SimpleType")]
    types: Vec<SimpleType>,
}

#[derive(Serialize)]
struct SimpleType {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@description")]
    description: &'static str,
    #[serde(rename = "Enumeration")]
    enumeration: EnumerationType,
}

#[derive(Serialize)]
struct EnumerationType {
    #[serde(rename = "Item")]
    items: Vec<ItemElement>,
}

#[derive(Serialize)]
struct ItemElement {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@value")]
    value: i32,
    #[serde(rename = "@description")]
    description: &'static str,
}

/// `None` when no variable is an enumeration. Two enumerations cannot have one name.
pub(super) fn definitions<M>(rows: &[Variable<M>]) -> Result<Option<TypeDefinitions>> {
    let mut used: Vec<&'static Enumeration> = Vec::new();
    for row in rows {
        let Access::Enumeration(_, kind) = row.access else {
            continue;
        };
        match used.iter().find(|other| other.name == kind.name) {
            None => used.push(kind),
            Some(other) if *other == kind => {}
            Some(_) => {
                return Err(Error::TwoMeanings(["enumeration", kind.name, row.name]));
            }
        }
    }
    let types: Vec<_> = used.into_iter().map(element).collect();
    Ok((!types.is_empty()).then_some(TypeDefinitions { types }))
}

fn element(kind: &'static Enumeration) -> SimpleType {
    let items = kind.items.iter().map(|item| ItemElement {
        name: item.name,
        value: item.value,
        description: item.description,
    });
    SimpleType {
        name: kind.name,
        description: kind.description,
        enumeration: EnumerationType {
            items: items.collect(),
        },
    }
}
