//! `resources/`: what a model reads at run time, from the folder of that name beside its `Cargo.toml`.

use super::Members;
use crate::outside::Fault;
use crate::{Error, Result, Untrusted};
use std::fs;
use std::path::Path;

/// The folder, in the package and in the FMU.
const FOLDER: &str = "resources";

/// Every file under `resources` of a package. Names with a dot before them are left out: they belong to editors and
/// to version control. A link is refused, as it would mean something else in the FMU than here.
pub(super) fn members(package: &Path, needed: bool) -> Result<Members> {
    let folder = package.join(FOLDER);
    let mut members = Members::new();
    if folder.is_dir() {
        collect(&folder, FOLDER, &mut members)?;
    }
    if needed && members.is_empty() {
        let said = "there are none".into();
        return Err(Error::Outside(Fault::Resources { folder, said }));
    }
    Ok(members)
}

fn collect(folder: &Path, name: &str, members: &mut Members) -> Result<()> {
    for entry in fs::read_dir(folder).map_err(Error::io(folder))? {
        let entry = entry.map_err(Error::io(folder))?;
        let (path, kind) = (entry.path(), entry.file_type());
        let kind = kind.map_err(Error::io(&path))?;
        let own = entry.file_name();
        let shown = || own.to_string_lossy().into_owned();
        let own = own
            .to_str()
            .ok_or_else(|| Untrusted::NotUtf8(shown()).of(&path))?;
        let name = format!("{name}/{own}");
        if own.starts_with('.') {
            continue;
        }
        if kind.is_dir() {
            collect(&path, &name, members)?;
        } else if kind.is_file() {
            members.push((name, fs::read(&path).map_err(Error::io(&path))?));
        } else {
            return Err(Untrusted::Link(name).of(&path));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_packed_and_links_and_a_missing_folder_are_refused() {
        let package = std::env::temp_dir().join(format!("resources-{}", std::process::id()));
        let folder = package.join(FOLDER);
        fs::create_dir_all(folder.join("maps")).unwrap();
        assert!(members(&package, false).unwrap().is_empty());
        let told = members(&package, true).unwrap_err().to_string();
        assert!(told.contains("reads files of its FMU, but"), "{told}");
        for (name, text) in [("maps/loss.csv", "1"), ("b.txt", "2"), (".gitkeep", "")] {
            fs::write(folder.join(name), text).unwrap();
        }
        let mut found = members(&package, true).unwrap();
        found.sort();
        let expected = [("resources/b.txt", "2"), ("resources/maps/loss.csv", "1")];
        assert_eq!(
            found,
            expected.map(|(name, text)| (name.into(), text.into()))
        );
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("/etc", folder.join("etc")).unwrap();
            let told = members(&package, true).unwrap_err().to_string();
            assert!(
                told.contains("\"resources/etc\" is a symbolic link"),
                "{told}"
            );
        }
        fs::remove_dir_all(&package).unwrap();
    }
}
