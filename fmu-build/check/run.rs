//! Loads the library, goes through its life cycle and reads every start value.

use super::Report;
use super::native::{Binary, Instance, Refused, Transition, take_messages};
use super::parsed::{Description, Kind, ScalarVariable};
use crate::Result;
use std::fmt;
use std::path::Path;

pub(super) fn check(
    library: &Path,
    folder: &Path,
    description: &Description,
    report: &mut Report,
) -> Result<()> {
    let binary = match Binary::load(library) {
        Ok(binary) => binary,
        Err(error) => {
            report.error("2.3", format!("the library cannot be loaded: {error}"));
            return Ok(());
        }
    };
    let missing = binary.missing();
    for name in &missing {
        report.error("2.1.1", format!("the library does not export {name}"));
    }
    if missing.is_empty() {
        check_texts(&binary, report)?;
        check_instances(&binary, folder, description, report)?;
    }
    Ok(())
}

fn check_texts(binary: &Binary, report: &mut Report) -> Result<()> {
    for (function, expected) in [
        ("fmi2GetVersion", "2.0"),
        ("fmi2GetTypesPlatform", "default"),
    ] {
        let found = binary.text(function)?;
        if found != expected {
            report.error(
                "2.1.4",
                format!("{function} returns {found:?}, not {expected:?}"),
            );
        }
    }
    Ok(())
}

fn check_instances(
    binary: &Binary,
    folder: &Path,
    description: &Description,
    report: &mut Report,
) -> Result<()> {
    let resources = resource_uri(folder);
    if binary
        .instantiate("not the guid of any model", &resources)?
        .is_some()
    {
        report.error(
            "2.1.5",
            "an instance is made though the GUID is not that of the description",
        );
    }
    take_messages();
    let Some(instance) = binary.instantiate(&description.guid, &resources)? else {
        let messages = take_messages().join("; ");
        report.error(
            "2.1.5",
            format!("no instance with the description's GUID: {messages}"),
        );
        return Ok(());
    };
    check_life(&instance, description, "", report)?;
    if accepted(instance.call(Transition::Reset)?, report) {
        check_life(&instance, description, " after fmi2Reset", report)?;
    }
    Ok(())
}

/// From instantiated or reset to terminated; `stage` tells which in findings.
fn check_life(
    instance: &Instance<'_>,
    description: &Description,
    stage: &str,
    report: &mut Report,
) -> Result<()> {
    if !accepted(instance.setup_experiment(0.0)?, report)
        || !accepted(instance.call(Transition::EnterInitializationMode)?, report)
    {
        return Ok(());
    }
    report.compared = 0;
    for variable in description.variables() {
        check_start(instance, variable, stage, report)?;
    }
    if accepted(instance.call(Transition::ExitInitializationMode)?, report) {
        accepted(instance.call(Transition::Terminate)?, report);
    }
    Ok(())
}

fn check_start(
    instance: &Instance<'_>,
    variable: &ScalarVariable,
    stage: &str,
    report: &mut Report,
) -> Result<()> {
    let Some((kind, attributes)) = variable.kind() else {
        return Ok(());
    };
    let read = match read(instance, kind, variable.value_reference)? {
        Ok(read) => read,
        Err(refused) => {
            accepted::<()>(Err(refused), report);
            return Ok(());
        }
    };
    let exact = variable.initial.as_deref() == Some("exact")
        || matches!(variable.causality.as_str(), "input" | "parameter");
    let Some(start) = attributes.start.as_ref().filter(|_| exact) else {
        return Ok(());
    };
    report.compared += 1;
    if !read.equals(start) {
        let name = &variable.name;
        let text = format!("{name} starts at {read}{stage}, the description says {start}");
        report.error("2.2.7", text);
    }
    Ok(())
}

/// A value as read from the library.
enum Value {
    Real(f64),
    Integer(i32),
    Boolean(bool),
    String(String),
}

impl Value {
    /// Whether `text` of a description means exactly this value.
    fn equals(&self, text: &str) -> bool {
        match self {
            Self::Real(value) => text
                .trim()
                .parse::<f64>()
                .is_ok_and(|start| start.to_bits() == value.to_bits()),
            Self::Integer(value) => text.trim().parse() == Ok(*value),
            Self::Boolean(value) => matches!(text.trim(), "true" | "1") == *value,
            Self::String(value) => text == value,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Real(value) => write!(f, "{value:?}"),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Boolean(value) => write!(f, "{value}"),
            Self::String(value) => write!(f, "{value:?}"),
        }
    }
}

fn read(
    instance: &Instance<'_>,
    kind: Kind,
    reference: u32,
) -> Result<std::result::Result<Value, Refused>> {
    Ok(match kind {
        Kind::Real => instance.real(reference)?.map(Value::Real),
        Kind::Integer => instance.integer(reference)?.map(Value::Integer),
        Kind::Boolean => instance.boolean(reference)?.map(Value::Boolean),
        Kind::String => instance.string(reference)?.map(Value::String),
    })
}

/// Whether a call was carried out; if not, reports it with what the FMU logged.
fn accepted<T>(result: std::result::Result<T, Refused>, report: &mut Report) -> bool {
    let messages = take_messages().join("; ");
    let Err(Refused { function, status }) = result else {
        return true;
    };
    report.error(
        "2.1",
        format!("{function} returns fmi2Status {status}: {messages}"),
    );
    false
}

/// `file:///…` of the folder `resources`, blanks and other special characters encoded.
pub(super) fn resource_uri(folder: &Path) -> String {
    let path = folder
        .join("resources")
        .to_string_lossy()
        .replace('\\', "/");
    let mut uri = String::from(if path.starts_with('/') {
        "file://"
    } else {
        "file:///"
    });
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b':' | b'-' | b'.' | b'_' | b'~' => {
                uri.push(char::from(byte));
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_compared_to_the_last_bit() {
        assert!(Value::Real(0.1 + 0.2).equals("0.30000000000000004"));
        assert!(!Value::Real(0.1 + 0.2).equals("0.3"));
        assert!(Value::Boolean(true).equals("1"));
        assert!(!Value::Integer(2).equals("3"));
    }

    #[test]
    fn resources_are_named_by_an_encoded_uri() {
        assert_eq!(
            resource_uri(Path::new("/a b/ö")),
            "file:///a%20b/%C3%B6/resources"
        );
    }
}
