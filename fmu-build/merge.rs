//! FMUs of one model, each for other platforms, become one.

use crate::archive::{DESCRIPTION, members};
use crate::content::{Members, with_dependencies};
use crate::{Error, Result, package};
use std::path::{Path, PathBuf};

/// Writes the FMU that holds the libraries of all of `fmus` to `path`, which may be one of them.
///
/// # Errors
/// When a file is no FMU, or two differ in a member that both have: they must be of one build.
pub fn merge(fmus: &[PathBuf], path: &Path) -> Result<()> {
    let mut merged: Vec<(String, Vec<u8>, &PathBuf)> = Vec::new();
    for fmu in fmus {
        let mut found = with_dependencies(members(fmu)?);
        found.sort_by_key(|(name, _)| name != DESCRIPTION); // where it differs the rest does
        for (name, bytes) in found {
            match merged.iter().find(|(other, ..)| *other == name) {
                None => merged.push((name, bytes, fmu)),
                Some((_, same, _)) if *same == bytes || is_about_libraries(&name) => {}
                Some((_, _, first)) => {
                    return Err(Error::Unlike {
                        member: name,
                        fmus: [(*first).clone(), fmu.clone()],
                    });
                }
            }
        }
    }
    let all: Members = merged
        .into_iter()
        .map(|(name, bytes, _)| (name, bytes))
        .collect();
    package(path, with_dependencies(all))
}

/// The one file that is written anew from the libraries themselves.
fn is_about_libraries(name: &str) -> bool {
    name == crate::content::DEPENDENCIES
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn fmu(name: &str, members: &[(&str, &str)]) -> PathBuf {
        let path = std::env::temp_dir().join(format!("merge-{}-{name}.fmu", std::process::id()));
        let members = members
            .iter()
            .map(|(name, text)| ((*name).into(), (*text).into()));
        package(&path, members.collect()).unwrap();
        path
    }

    #[test]
    fn libraries_are_joined_in_any_order_and_the_rest_stays() {
        let one = fmu(
            "one",
            &[
                ("modelDescription.xml", "m"),
                ("binaries/linux64/A.so", "l"),
            ],
        );
        let other = fmu(
            "other",
            &[("modelDescription.xml", "m"), ("binaries/win64/A.dll", "w")],
        );
        let merged = fmu("merged", &[]);
        merge(&[one.clone(), other.clone()], &merged).unwrap();
        let names: Vec<_> = members(&merged)
            .unwrap()
            .into_iter()
            .map(|(name, _)| name)
            .collect();
        assert_eq!(
            names[..2],
            ["binaries/linux64/A.so", "binaries/win64/A.dll"]
        );
        assert_eq!(names.len(), 4);
        let forward = fs::read(&merged).unwrap();
        merge(&[other.clone(), one.clone()], &merged).unwrap();
        assert!(forward == fs::read(&merged).unwrap());
        merge(&[merged.clone(), one.clone()], &merged).unwrap();
        assert!(forward == fs::read(&merged).unwrap());
        for path in [one, other, merged] {
            fs::remove_file(path).unwrap();
        }
    }

    #[test]
    fn another_model_is_refused_by_name() {
        let of = |guid| {
            [
                ("documentation/a.txt", guid),
                ("modelDescription.xml", guid),
            ]
        };
        let one = fmu("a", &of("guid 1"));
        let other = fmu("b", &of("guid 2"));
        let error = merge(&[one.clone(), other.clone()], &one)
            .unwrap_err()
            .to_string();
        assert!(error.contains("differ in modelDescription.xml"), "{error}");
        assert_eq!(members(&one).unwrap().len(), 2, "the first FMU was changed");
        for path in [one, other] {
            fs::remove_file(path).unwrap();
        }
    }
}
