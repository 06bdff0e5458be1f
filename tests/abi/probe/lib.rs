//! The FMU library of the probe.

mod model;
use model::Probe;

fmi2_cosim::export!(Probe);
