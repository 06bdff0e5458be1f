//! `cosim_native`: the compiled master as a Python module, arrays in and out in bulk.
//!
//! ```python
//! names, rows, error, log = cosim_native.run([plan_as_json], times, script, threads=1)[0]
//! ```
//!
//! Who makes many runs keeps FMUs open ([`Fmus`]) and gives the same arrays again (`out`): memory that a process
//! has not had before costs more than what a run writes into it.

use cosim_master::{Error, Job, Libraries, Message, Plan, Run, Watch, run_into};
use numpy::{
    PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PySlice;
use std::num::NonZero;
use std::path::PathBuf;

/// Names of the recorded signals, their rows, why the rows are not all there, and what FMUs said.
type Made<'py> = (
    Vec<String>,
    Bound<'py, PyAny>,
    Option<(&'static str, String)>,
    Vec<(String, Vec<Said>)>,
);

/// A message: time [s], fmi2Status, category, text.
type Said = (f64, i32, String, String);

/// FMUs that stay open for later calls of `run`; a file that changes is not read again.
///
/// folder: where they are unpacked, each in a folder of its own that goes with this object; else where
/// temporary files are.
#[pyclass]
struct Fmus(Libraries);

#[pymethods]
impl Fmus {
    #[new]
    #[pyo3(signature = (folder = None))]
    fn new(folder: Option<PathBuf>) -> Self {
        Self(folder.map_or_else(Libraries::default, Libraries::below))
    }
}

/// Run closed loops, at most `threads` at a time; the same numbers for any number of threads.
///
/// plans: loops as JSON (`cosim_master::Plan`). times: communication points [s], shape (n,).
/// script: scenario signals, shape (n, number of signals), for all loops. out: for each plan an
/// array of shape (n, number of names) that takes its rows; without, new ones. fmus: `Fmus`, which are
/// used and added to. watch: called about twenty times a second with the number of steps made so far;
/// when it returns true, all runs end at their next communication point. Ctrl-C ends them too.
///
/// Returns for each plan: names, rows of shape (samples, names), and None or an error as a pair:
/// "run" (an FMU failed), "fmu" (one does not load), "ended" (by watch) or "configuration", and a
/// sentence; then pairs of component and messages (time [s], fmi2Status, category, text).
#[pyfunction]
#[pyo3(signature = (plans, times, script, threads = 1, *, out = None, fmus = None, watch = None))]
fn run<'py>(
    plans: Vec<String>,
    times: PyReadonlyArray1<'py, f64>,
    script: PyReadonlyArray2<'py, f64>,
    threads: usize,
    out: Option<Vec<Bound<'py, PyArray2<f64>>>>,
    fmus: Option<PyRefMut<'py, Fmus>>,
    watch: Option<Py<PyAny>>,
) -> PyResult<Vec<Made<'py>>> {
    if !script.is_c_contiguous() {
        return Err(value_error(
            "script must lie row by row: numpy.ascontiguousarray",
        ));
    }
    let py = times.py();
    let (times, script) = (times.as_slice()?, script.as_slice()?);
    let threads = NonZero::new(threads).ok_or_else(|| value_error("threads must be above 0"))?;
    let jobs = plans.iter().map(|text| job(text, times, script));
    let jobs: Vec<Job<'_>> = jobs.collect::<PyResult<_>>()?;
    let mut own = Libraries::default();
    let mut fmus = fmus;
    let libraries = fmus.as_mut().map_or(&mut own, |fmus| &mut fmus.0);
    // Opened here, once for all threads; what does not open is told by the run that needs it.
    let names = jobs
        .iter()
        .map(|job| Run::recorded(&job.plan, libraries).unwrap_or_default());
    let names: Vec<_> = names.collect();
    let tables = tables(py, out, times.len(), &names)?;
    let open = tables.iter().map(|table| Ok(table.try_readwrite()?));
    let open: Vec<_> = open.collect::<PyResult<_>>()?;
    let made = make(py, &jobs, open, libraries, threads, watch)?;
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

/// The arrays that take the rows: those that are given, or new ones.
fn tables<'py>(
    py: Python<'py>,
    out: Option<Vec<Bound<'py, PyArray2<f64>>>>,
    count: usize,
    names: &[Vec<String>],
) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
    let shapes = names.iter().map(|names| [count, names.len()]);
    let Some(out) = out else {
        // NumPy's own memory: it asks for large pages, so that filling it costs less.
        return Ok(shapes
            .map(|shape| PyArray2::<f64>::zeros(py, shape, false))
            .collect());
    };
    if out.iter().map(|table| table.dims()).ne(shapes) {
        let what =
            "out needs an array for each plan, with a row for each time, a column for each name";
        return Err(value_error(what));
    }
    Ok(out)
}

/// Makes all runs without holding the interpreter, which gets its turn from time to time.
fn make(
    py: Python<'_>,
    jobs: &[Job<'_>],
    mut open: Vec<PyReadwriteArray2<'_, f64>>,
    libraries: &Libraries,
    threads: NonZero<usize>,
    asked: Option<Py<PyAny>>,
) -> PyResult<Vec<cosim_master::Made>> {
    let rows = open.iter_mut().map(|table| table.as_slice_mut());
    let rows: Vec<&mut [f64]> = rows.collect::<Result<_, _>>()?;
    let (watch, mut failed) = (Watch::default(), Ok(()));
    let made = py.detach(|| {
        run_into(jobs, rows, libraries, threads, &watch, || {
            if failed.is_ok() {
                failed = ask(asked.as_ref(), &watch);
            }
        })
    });
    failed.map(|()| made)
}

/// Lets Python handle signals and say whether the runs are to end.
fn ask(asked: Option<&Py<PyAny>>, watch: &Watch) -> PyResult<()> {
    let answer = Python::attach(|py| {
        py.check_signals()?;
        let answer = asked.map(|asked| asked.bind(py).call1((watch.steps(),))?.is_truthy());
        answer.unwrap_or(Ok(false))
    });
    if !matches!(answer, Ok(false)) {
        watch.end();
    }
    answer.map(|_| ())
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
        Error::Ended { .. } => "ended",
        _ => "configuration",
    }
}

#[pymodule]
fn cosim_native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Fmus>()?;
    module.add_function(wrap_pyfunction!(run, module)?)
}
