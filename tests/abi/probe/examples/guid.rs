//! Prints the GUID of the probe: it has no model description from which a test could read it.

#[path = "../model.rs"]
mod model;

use std::io::{self, Write as _};

fn main() -> io::Result<()> {
    writeln!(io::stdout(), "{}", fmi2_cosim::guid::<model::Probe>())
}
