//! What an FMU holds beside its libraries: description, documentation, licences, bill of materials.

mod bom;
mod date;
mod dependencies;
mod licenses;
mod ls_ref;
mod packages;
mod resources;

pub(crate) use dependencies::MEMBER as DEPENDENCIES;

use crate::{Entry, Result, icon, page};

/// Names in the archive with their contents.
pub(crate) type Members = Vec<(String, Vec<u8>)>;

/// Everything of the FMU of `entry` that is the same on every platform.
pub(crate) fn members(entry: &Entry) -> Result<Members> {
    let linked = packages::linked(entry.package, entry.folder())?;
    let mut members = vec![
        text("modelDescription.xml", dated((entry.describe)()?)?),
        text("documentation/index.html", page::page(entry)?),
        text(bom::MEMBER, bom::text(entry.name, &linked)?),
    ];
    if let Some(terminals) = entry.terminals_text() {
        members.push(text("terminalsAndIcons/terminalsAndIcons.xml", terminals));
    }
    members.push((icon::MEMBER.into(), icon::png(entry.icon)?));
    members.extend(resources::members(&linked.root.folder, entry.resources)?);
    members.extend(ls_ref::members(entry)?);
    members.extend(licenses::members(entry.name, &linked)?);
    Ok(members)
}

/// The members with the file about what their libraries need; one they had is replaced.
pub(crate) fn with_dependencies(mut members: Members) -> Members {
    members.retain(|(name, _)| name != dependencies::MEMBER);
    let needs = dependencies::text(&members);
    members.push(text(dependencies::MEMBER, needs));
    members
}

fn text(name: &str, contents: String) -> (String, Vec<u8>) {
    (name.into(), contents.into_bytes())
}

/// The description with the date of the build, if one is given.
fn dated(description: String) -> Result<String> {
    const NEXT: &str = " variableNamingConvention=";
    Ok(match date::given()? {
        None => description,
        Some(date) => {
            let attribute = format!(" generationDateAndTime=\"{date}\"{NEXT}");
            description.replacen(NEXT, &attribute, 1)
        }
    })
}
