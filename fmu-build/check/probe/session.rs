//! A loaded FMU, ready to be instantiated and run over and over.

use super::super::native::{Binary, Instance};
use super::super::parsed::Description;
use crate::Result;
use std::path::Path;

/// A loaded library with its description.
pub(super) struct Session<'a> {
    pub binary: &'a Binary,
    pub description: &'a Description,
    resources: String,
}

impl<'a> Session<'a> {
    pub(super) fn new(binary: &'a Binary, description: &'a Description, folder: &Path) -> Self {
        Self {
            binary,
            description,
            resources: resource_uri(folder),
        }
    }

    /// An instance, if the FMU makes one for this GUID.
    pub(super) fn instantiated_with(&self, guid: &str) -> Result<Option<Instance<'a>>> {
        self.binary.instantiate(guid, &self.resources)
    }

    /// Where time begins [s].
    pub(super) fn start(&self) -> f64 {
        self.description.experiment.start.unwrap_or(0.0)
    }
}

/// `file:///…` of the folder `resources`, blanks and other special characters encoded.
pub(in super::super) fn resource_uri(folder: &Path) -> String {
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
    fn resources_are_named_by_an_encoded_uri() {
        assert_eq!(
            resource_uri(Path::new("/a b/ö")),
            "file:///a%20b/%C3%B6/resources"
        );
    }
}
