//! Prints the GUID of the probe: it has no model description from which a test could read it.

use std::io::{self, Write as _};

fn main() -> io::Result<()> {
    writeln!(io::stdout(), "{}", fmi2_cosim::guid::<abi_probe::Probe>())
}
