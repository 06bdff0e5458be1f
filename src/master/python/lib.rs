//! `cosim_native`: the compiled master as a Python module, arrays in and out in bulk.
//!
//! ```python
//! names, rows, error, log = cosim_native.run([plan_as_json], times, script, threads=1)[0]
//! ```

use cosim_master::{Error, Job, Libraries, Message, Plan, Run, run_into};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PySlice;
use std::num::NonZero;

/// Names of the recorded signals, their rows, why the rows are not all there, and what FMUs said.
type Made<'py> = (
    Vec<String>,
    Bound<'py, PyAny>,
    Option<(&'static str, String)>,
    Vec<(String, Vec<Said>)>,
);

/// A message: time [s], fmi2Status, category, text.
type Said = (f64, i32, String, String);

/// Run closed loops, at most `threads` at a time; the same numbers for any number of threads.
///
/// plans: loops as JSON (`cosim_master::Plan`). times: communication points [s], shape (n,).
/// script: scenario signals, shape (n, number of signals), for all loops.
///
/// Returns for each plan: names, rows of shape (samples, names), and None or an error as a pair:
/// "run" (an FMU failed), "fmu" (one does not load) or "configuration", and a sentence; then pairs of
/// component and messages (time [s], fmi2Status, category, text).
#[pyfunction]
#[pyo3(signature = (plans, times, script, threads = 1))]
fn run<'py>(
    py: Python<'py>,
    plans: Vec<String>,
    times: PyReadonlyArray1<'py, f64>,
    script: PyReadonlyArray2<'py, f64>,
    threads: usize,
) -> PyResult<Vec<Made<'py>>> {
    if !script.is_c_contiguous() {
        return Err(value_error(
            "script must lie row by row: numpy.ascontiguousarray",
        ));
    }
    let (times, script) = (times.as_slice()?, script.as_slice()?);
    let threads = NonZero::new(threads).ok_or_else(|| value_error("threads must be above 0"))?;
    let jobs = plans.iter().map(|text| job(text, times, script));
    let jobs: Vec<Job<'_>> = jobs.collect::<PyResult<_>>()?;
    let mut libraries = Libraries::default();
    // Opened here, once for all threads; what does not open is told by the run that needs it.
    let names = jobs
        .iter()
        .map(|job| Run::recorded(&job.plan, &mut libraries).unwrap_or_default());
    let names: Vec<_> = names.collect();
    // NumPy's own memory: it asks for large pages, so that filling it costs less.
    let tables: Vec<_> = names
        .iter()
        .map(|names| PyArray2::<f64>::zeros(py, [times.len(), names.len()], false))
        .collect();
    let mut open: Vec<_> = tables.iter().map(|table| table.readwrite()).collect();
    let rows = open.iter_mut().map(|table| table.as_slice_mut());
    let rows: Vec<&mut [f64]> = rows.collect::<Result<_, _>>()?;
    let made = py.detach(|| run_into(&jobs, rows, &libraries, threads));
    drop(open);
    let all = names.into_iter().zip(tables).zip(made);
    all.map(|((names, table), (good, error, log))| {
        let rows = table.get_item(PySlice::new(py, 0, isize::try_from(good)?, 1))?;
        let error = error.map(|error| (kind(&error), error.to_string()));
        let log = log
            .into_iter()
            .map(|(name, all)| (name, all.into_iter().map(said).collect()));
        Ok((names, rows, error, log.collect()))
    })
    .collect()
}

fn job<'a>(text: &str, times: &'a [f64], script: &'a [f64]) -> PyResult<Job<'a>> {
    let plan: Plan = serde_json::from_str(text).map_err(|error| value_error(&error.to_string()))?;
    if script.len() != times.len() * plan.script.len() {
        return Err(value_error(
            "script needs a row for each time, a column for each signal",
        ));
    }
    Ok(Job {
        plan,
        times,
        script,
    })
}

fn said(message: Message) -> Said {
    let Message {
        time,
        status,
        category,
        text,
    } = message;
    (time, status, category, text)
}

fn value_error(what: &str) -> PyErr {
    PyValueError::new_err(what.to_owned())
}

fn kind(error: &Error) -> &'static str {
    match error {
        error if error.is_at_run_time() => "run",
        error if error.is_of_an_fmu() => "fmu",
        _ => "configuration",
    }
}

#[pymodule]
fn cosim_native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(run, module)?)
}
