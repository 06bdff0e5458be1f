//! `documentation/externalDependencies.txt`: what a machine must have to load the libraries.

use crate::binary::Binary;
use std::fmt::Write as _;
use std::path::Path;

pub(crate) const MEMBER: &str = "documentation/externalDependencies.txt";

/// The text for these members of an FMU; its libraries are among them.
pub(crate) fn text(members: &[(String, Vec<u8>)]) -> String {
    let mut text = String::from(
        "The libraries of this FMU need what is listed here and nothing else: no file of the\n\
         machine, no environment variable, no licence server.\n",
    );
    for (name, bytes) in members
        .iter()
        .filter(|(name, _)| name.starts_with("binaries/"))
    {
        if let (Some(platform), Some(binary)) = (platform(name), Binary::read(bytes)) {
            let _ = writeln!(text, "\n{platform}: {}", needs(&binary));
        }
    }
    text
}

fn platform(member: &str) -> Option<String> {
    let folder = Path::new(member).parent()?.file_name()?;
    Some(folder.to_string_lossy().into_owned())
}

fn needs(binary: &Binary) -> String {
    let mut needs = binary.libraries.join(", ");
    if let Some(version) = &binary.glibc {
        let _ = write!(needs, "; glibc {version} or newer");
    }
    needs
}
