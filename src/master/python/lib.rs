//! `cosim_native`: the compiled master as a Python module, arrays in and out in bulk.
//!
//! ```python
//! names, rows, error = cosim_native.run([plan_as_json], times, script, threads=1)[0]
//! ```

use cosim_master::{Error, Job, Libraries, Outcome, Plan, run_all};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::num::NonZero;
use std::sync::Mutex;

/// Names of the signals, their rows, and why the rows are not all there.
type Made<'py> = (
    Vec<String>,
    Bound<'py, PyArray2<f64>>,
    Option<(&'static str, String)>,
);

/// Run closed loops, at most `threads` at a time; the same numbers for any number of threads.
///
/// plans: loops as JSON (`cosim_master::Plan`). times: communication points [s], shape (n,).
/// script: scenario signals, shape (n, number of signals), for all loops.
///
/// Returns for each plan: names, rows of shape (samples, names), and None or an error as a pair:
/// "run" (an FMU failed), "fmu" (one does not load) or "configuration", and a sentence.
#[pyfunction]
#[pyo3(signature = (plans, times, script, threads = 1))]
fn run<'py>(
    py: Python<'py>,
    plans: Vec<String>,
    times: PyReadonlyArray1<'py, f64>,
    script: PyReadonlyArray2<'py, f64>,
    threads: usize,
) -> PyResult<Vec<Made<'py>>> {
    let (times, script) = (times.as_slice()?, script.as_slice()?);
    let threads = NonZero::new(threads).ok_or_else(|| value_error("threads must be above 0"))?;
    let jobs = plans.iter().map(|text| {
        let plan: Plan =
            serde_json::from_str(text).map_err(|error| value_error(&error.to_string()))?;
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
    });
    let jobs: Vec<Job<'_>> = jobs.collect::<PyResult<_>>()?;
    let outcomes = py.detach(|| outcomes(&jobs, threads));
    outcomes
        .into_iter()
        .map(|outcome| made(py, outcome?))
        .collect()
}

fn value_error(what: &str) -> PyErr {
    PyValueError::new_err(what.to_owned())
}

fn outcomes(jobs: &[Job<'_>], threads: NonZero<usize>) -> Vec<PyResult<Outcome>> {
    let slots: Vec<Mutex<Option<Outcome>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let mut libraries = Libraries::default();
    for component in jobs.iter().flat_map(|job| &job.plan.components) {
        // What does not open is told by the run that needs it.
        let _ = libraries.open(&component.fmu);
    }
    run_all(jobs, &libraries, threads, |number, outcome| {
        if let Some(Ok(mut slot)) = slots.get(number).map(Mutex::lock) {
            *slot = Some(outcome);
        }
    });
    let lost = || value_error("a run was lost");
    let made = slots
        .into_iter()
        .map(|slot| slot.into_inner().ok().flatten());
    made.map(|outcome| outcome.ok_or_else(lost)).collect()
}

fn made(py: Python<'_>, outcome: Outcome) -> PyResult<Made<'_>> {
    let width = outcome.names.len();
    let samples = outcome.rows.len().checked_div(width).unwrap_or_default();
    let rows = numpy::PyArray1::from_vec(py, outcome.rows).reshape([samples, width])?;
    debug_assert_eq!(rows.shape(), [samples, width]);
    let error = outcome.error.map(|error| (kind(&error), error.to_string()));
    Ok((outcome.names, rows, error))
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
