//! The crates that can be published are packed and built from their packages, without a warning.

use crate::plan::{Failure, Step, line};
use crate::setup::Project;

/// The crates that a model of one's own needs, and the models of this workspace.
const PUBLISHABLE: [&str; 4] = ["fmi2-cosim", "dct-driveline", "dct-models", "fmu-build"];

/// Packs the crates, unpacks them elsewhere and builds them there.
pub fn step(project: &Project) -> Step {
    let project = project.clone();
    Step::new("packages of the crates that can be published", move || {
        pack(&project)
    })
}

/// cargo has no switch that turns its warnings into errors, so they are looked for.
fn pack(project: &Project) -> Result<(), Failure> {
    let mut command = project.cargo(&["package", "--allow-dirty", "--offline"]);
    command.args(PUBLISHABLE.iter().flat_map(|name| ["--package", name]));
    let what = match command.output() {
        Err(error) => format!("cargo could not be started ({error})"),
        Ok(done) => match complaint(
            done.status.success(),
            &String::from_utf8_lossy(&done.stderr),
        ) {
            None => return Ok(()),
            Some(what) => what,
        },
    };
    Err(Failure::Command {
        line: line(&command),
        what,
    })
}

/// All that cargo said when it failed, else its first warning.
fn complaint(success: bool, said: &str) -> Option<String> {
    let warning = said.lines().find(|line| line.starts_with("warning"));
    if success {
        warning.map(str::to_owned)
    } else {
        Some(format!("{said}\ncargo package failed"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_a_complaint_and_progress_is_none() {
        let said = "   Packaging a v0.1.0\nwarning: manifest has no description\n";
        let warning = complaint(true, said).unwrap();
        assert_eq!(warning, "warning: manifest has no description");
        assert_eq!(complaint(true, "   Packaging a v0.1.0\n"), None);
        assert!(
            complaint(false, "error: no\n")
                .unwrap()
                .contains("error: no")
        );
    }
}
