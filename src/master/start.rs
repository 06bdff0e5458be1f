//! Start values: what a user may write, and the number that travels.

use crate::description::{Family, Variable};
use crate::plan::Value;
use crate::suggest::did_you_mean;

/// A start value as the number that travels; the error says what is wrong with it.
pub fn number(variable: &Variable, value: &Value) -> Result<f64, String> {
    match (variable.family, value) {
        (Family::Boolean, Value::Boolean(value)) => Ok(f64::from(u8::from(*value))),
        (Family::Real, Value::Number(value)) => Ok(*value),
        (Family::Integer, Value::Number(value)) if value.fract() == 0.0 => Ok(*value),
        (Family::Integer, Value::Text(item)) => {
            let known = variable.items.iter().find(|(name, _)| name == item);
            let names: Vec<&str> = variable
                .items
                .iter()
                .map(|(name, _)| name.as_str())
                .collect();
            let number = known.map(|(_, number)| f64::from(*number));
            number.ok_or_else(|| {
                let hint = did_you_mean(item, names.iter().copied());
                format!("has no item '{item}' ({}){hint}", names.join(", "))
            })
        }
        (family, value) => Err(format!("is {family:?}{}, got {value}", unit(variable))),
    }
}

/// The unit of a variable as a sentence has it.
fn unit(variable: &Variable) -> String {
    match variable.unit_name.as_str() {
        "" => String::new(),
        name => format!(" [{name}]"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::Causality;

    fn variable(family: Family) -> Variable {
        Variable {
            name: "x".into(),
            reference: 0,
            family,
            causality: Causality::Other,
            items: vec![("open".into(), 1), ("shut".into(), 2)],
            unit: None,
            unit_name: String::new(),
            start: None,
            continuous: true,
        }
    }

    #[test]
    fn a_start_value_has_the_type_of_its_variable() {
        for (family, value, expected) in [
            (Family::Real, Value::Number(1.5), Some(1.5)),
            (Family::Integer, Value::Number(2.0), Some(2.0)),
            (Family::Integer, Value::Number(1.5), None),
            (Family::Integer, Value::Text("shut".into()), Some(2.0)),
            (Family::Integer, Value::Text("ajar".into()), None),
            (Family::Boolean, Value::Boolean(true), Some(1.0)),
            (Family::Boolean, Value::Number(1.0), None),
            (Family::Real, Value::Text("1".into()), None),
        ] {
            assert_eq!(
                number(&variable(family), &value).ok(),
                expected,
                "{family:?} {value:?}"
            );
        }
    }

    #[test]
    fn an_unknown_item_is_answered_with_the_known_ones() {
        let told = number(&variable(Family::Integer), &Value::Text("ajar".into()));
        assert_eq!(told.unwrap_err(), "has no item 'ajar' (open, shut)");
    }
}
