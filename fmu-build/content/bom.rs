//! The bill of materials: every package in the library, as CycloneDX 1.5 in JSON.

use super::date;
use super::packages::{Linked, Package};
use crate::{Error, Result};
use serde_json::{Value, json};

/// Where it lies: `extra` has one folder per domain, its name reversed.
pub(crate) const MEMBER: &str = "extra/org.cyclonedx/bom.cdx.json";

/// The text. Without a date unless one is given, so that two builds give the same bytes.
pub(crate) fn text(model: &str, linked: &Linked) -> Result<String> {
    let all = std::iter::once(&linked.root).chain(&linked.others);
    let mut metadata = json!({
        "tools": { "components": [{
            "type": "application", "name": "fmu-build", "version": env!("CARGO_PKG_VERSION"),
        }] },
        "component": {
            "type": "library", "bom-ref": "fmu", "name": model, "version": linked.root.version,
            "description": linked.root.description,
        },
    });
    if let Some(date) = date::given()? {
        metadata["timestamp"] = json!(date);
    }
    let graph = all.clone().map(|package| {
        let links = package
            .links
            .iter()
            .map(|(name, version)| reference(name, version));
        json!({ "ref": package.reference(), "dependsOn": links.collect::<Vec<_>>() })
    });
    let top = json!({ "ref": "fmu", "dependsOn": [linked.root.reference(), "rust-std"] });
    let document = json!({
        "$schema": "http://cyclonedx.org/schema/bom-1.5.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": without_nulls(metadata),
        "components": all.map(component).chain([standard_library(linked)]).collect::<Vec<_>>(),
        "dependencies": std::iter::once(top).chain(graph).collect::<Vec<_>>(),
    });
    let text = serde_json::to_string_pretty(&document);
    let text = text.map_err(|error| Error::Metadata {
        said: error.to_string(),
    })?;
    Ok(text + "\n")
}

fn component(package: &Package) -> Value {
    let hashes = package.checksum.as_ref();
    let hashes = hashes.map(|sum| json!([{ "alg": "SHA-256", "content": sum }]));
    let repository = package.repository.as_ref();
    let repository = repository.map(|url| json!([{ "type": "vcs", "url": url }]));
    let licenses = package.license.as_ref();
    // The slash is cargo's former way to write OR.
    let licenses = licenses.map(|spdx| json!([{ "expression": spdx.replace('/', " OR ") }]));
    without_nulls(json!({
        "type": "library",
        "bom-ref": package.reference(),
        "name": package.name,
        "version": package.version,
        "description": package.description,
        "licenses": licenses,
        "hashes": hashes,
        "externalReferences": repository,
        "purl": package.reference(),
    }))
}

/// No package of crates.io: it comes with the compiler.
fn standard_library(linked: &Linked) -> Value {
    json!({
        "type": "library",
        "bom-ref": "rust-std",
        "name": "rust-std",
        "version": linked.standard_library,
        "description": "The Rust standard library, linked statically.",
        "licenses": [{ "expression": "MIT OR Apache-2.0" }],
        "externalReferences": [{ "type": "vcs", "url": "https://github.com/rust-lang/rust" }],
    })
}

impl Package {
    fn reference(&self) -> String {
        reference(&self.name, &self.version)
    }
}

/// The package URL, which names a package in the world.
fn reference(name: &str, version: &str) -> String {
    format!("pkg:cargo/{name}@{version}")
}

/// Leaves out what is not known.
fn without_nulls(value: Value) -> Value {
    match value {
        Value::Object(fields) => {
            let known = fields.into_iter().filter(|(_, value)| !value.is_null());
            Value::Object(
                known
                    .map(|(name, value)| (name, without_nulls(value)))
                    .collect(),
            )
        }
        other => other,
    }
}
