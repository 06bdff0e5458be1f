//! What an FMU is made of: a model, the package of its library, and what else goes into the file.

use crate::about::About;
use crate::drive::{Driven, Part};
use crate::icon::{self, Icon};
use crate::library::Target;
use crate::parameters::{self, ParameterSet, Values};
use crate::port::{self, Port, Terminal};
use crate::table::Sheet;
use crate::{Result, describe, library, variables_md};
use fmi2_cosim::{Experiment, Model};
use std::path::Path;

/// A model and the package of its FMU library.
pub struct Entry {
    /// `modelIdentifier`, and the name of the FMU and of its description.
    pub name: &'static str,
    /// Cargo package whose dynamic library implements it.
    pub package: &'static str,
    /// Folder of that package or of its workspace; `None`: this workspace.
    folder: Option<&'static str>,
    /// Writes the text of its `modelDescription.xml`.
    pub describe: fn() -> Result<String>,
    /// Writes its section of `VARIABLES.md`.
    pub table: fn() -> Result<String>,
    /// What its documentation page shows of its table.
    pub(crate) sheet: fn() -> Result<Sheet>,
    /// Prose of its documentation page.
    pub(crate) about: About,
    /// `model.png`.
    pub(crate) icon: Icon,
    /// Parameter sets in its FMU.
    pub(crate) sets: fn() -> Result<Vec<ParameterSet>>,
    /// Experiment with reference results in its FMU.
    pub(crate) smoke: Option<Smoke>,
    /// Measures what its documentation page shows of its accuracy.
    pub(crate) figures: Option<fn() -> Result<Figures>>,
    /// Makes an instance of the model, with its files from the folder of its package.
    pub(crate) part: fn(&Path) -> Result<Box<dyn Part>>,
    /// Whether the model reads files of its FMU: those under `resources` beside its `Cargo.toml`.
    pub(crate) resources: bool,
    /// Writes some parameters with their values as a parameter set.
    pub(crate) given: fn(&str, Values<'_>) -> Result<String>,
    /// Lists its inputs and outputs.
    pub ports: fn() -> Vec<Port>,
    /// Its default experiment.
    pub experiment: Experiment,
    /// Bundles of its ports.
    terminals: &'static [Terminal],
}

impl Entry {
    /// The entry of model `M`, whose library is made by the cargo package `package`.
    #[must_use]
    pub const fn of<M: Model>(package: &'static str) -> Self {
        Self {
            name: M::NAME,
            package,
            folder: None,
            describe: describe::<M>,
            table: variables_md::section::<M>,
            sheet: Sheet::of_model::<M>,
            about: About::NOTHING,
            icon: icon::BLOCK,
            sets: || Ok(Vec::new()),
            smoke: None,
            figures: None,
            part: Driven::<M>::loaded,
            resources: M::RESOURCES,
            given: parameters::given::<M>,
            ports: port::ports::<M>,
            experiment: M::EXPERIMENT,
            terminals: &[],
        }
    }

    /// Says where cargo finds the package: `env!("CARGO_MANIFEST_DIR")` of a package outside this
    /// workspace.
    #[must_use]
    pub const fn at(mut self, folder: &'static str) -> Self {
        self.folder = Some(folder);
        self
    }

    /// Gives it terminals; those without a member in its table are left out.
    #[must_use]
    pub const fn terminals(mut self, terminals: &'static [Terminal]) -> Self {
        self.terminals = terminals;
        self
    }

    /// Gives its documentation page prose: purpose, equations, validity.
    #[must_use]
    pub const fn about(mut self, about: About) -> Self {
        self.about = about;
        self
    }

    /// Gives it a picture; without one `model.png` shows a block.
    #[must_use]
    pub const fn icon(mut self, icon: Icon) -> Self {
        self.icon = icon;
        self
    }

    /// Puts parameter sets into its FMU; [`parameters::set`] writes one.
    #[must_use]
    pub const fn parameter_sets(mut self, sets: fn() -> Result<Vec<ParameterSet>>) -> Self {
        self.sets = sets;
        self
    }

    /// Puts an experiment with reference results into its FMU.
    #[must_use]
    pub const fn smoke(mut self, smoke: Smoke) -> Self {
        self.smoke = Some(smoke);
        self
    }

    /// Measures figures for its documentation page whenever that is written: none is ever typed.
    #[must_use]
    pub const fn figures(mut self, figures: fn() -> Result<Figures>) -> Self {
        self.figures = Some(figures);
        self
    }

    /// Its terminals that have a member among its ports, with the names of those.
    pub(crate) fn present_terminals(&self) -> Vec<(&'static Terminal, Vec<&'static str>)> {
        port::present(self.terminals, &(self.ports)())
    }

    /// The text of its `terminalsAndIcons.xml`, if it has a terminal.
    pub(crate) fn terminals_text(&self) -> Option<String> {
        port::terminals(self.terminals, &(self.ports)())
    }

    /// Builds its library for a target and returns the bytes.
    ///
    /// # Errors
    /// When cargo fails or the package makes no dynamic library.
    pub fn library(&self, target: &Target) -> Result<Vec<u8>> {
        library::build(self.package, self.folder(), target)
    }

    /// Folder in which cargo finds the package.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.map_or(library::workspace(), Path::new)
    }
}

/// A short drive that an importer can repeat to see that it runs the FMU as it was meant.
#[derive(Clone, Copy)]
pub struct Smoke {
    /// One sentence.
    pub description: &'static str,
    /// Writes the inputs: CSV, column `time` [s], then one per input. Between two rows Reals lie on the
    /// straight line, others stay.
    pub inputs: fn() -> Result<String>,
    /// Parameters with values other than their start values.
    pub parameters: &'static [(&'static str, f64)],
    /// Communication step [s].
    pub step: f64,
    /// The reference results have every `every`th communication point.
    pub every: u32,
}

/// A table of measured figures for a documentation page.
pub struct Figures {
    /// What they are and how they are measured.
    pub caption: String,
    /// Heads of the columns.
    pub columns: Vec<&'static str>,
    /// One line each.
    pub rows: Vec<Vec<String>>,
}
