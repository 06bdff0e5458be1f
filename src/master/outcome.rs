//! What comes of a run.

use crate::error::Error;
use cosim_raw::Message;

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Names of the recorded signals.
    pub names: Vec<String>,
    /// Rows of them, one after the other.
    pub rows: Vec<f64>,
    /// Why they are not all there.
    pub error: Option<Error>,
    /// Messages of each FMU, by its component's name.
    pub log: Told,
}

/// Messages of each FMU of a run, by its component's name.
pub type Told = Vec<(String, Vec<Message>)>;
