//! Independent runs on several threads.

use crate::error::Error;
use crate::fmu::Libraries;
use crate::plan::Plan;
use crate::run::Run;
use std::num::NonZero;
use std::sync::Mutex;
use std::thread;

/// One run that is to be made.
#[derive(Debug, Clone)]
pub struct Job<'a> {
    /// The loop.
    pub plan: Plan,
    /// Communication points [s].
    pub times: &'a [f64],
    /// Scenario signals, a row for each time.
    pub script: &'a [f64],
}

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Names of all signals.
    pub names: Vec<String>,
    /// Rows of all signals, one after the other.
    pub rows: Vec<f64>,
    /// Why they are not all there.
    pub error: Option<Error>,
}

/// Makes all runs, at most `threads` at a time; `done` gets each with its number, in any order.
///
/// The runs are the same, to the last bit, for any number of threads.
pub fn run_all(
    jobs: &[Job<'_>],
    libraries: &Libraries,
    threads: NonZero<usize>,
    done: impl Fn(usize, Outcome) + Sync,
) {
    let next = Mutex::new(jobs.iter().enumerate());
    let take = || next.lock().ok().and_then(|mut jobs| jobs.next());
    let work = || {
        let mut libraries = libraries.clone();
        while let Some((number, job)) = take() {
            done(number, one(job, &mut libraries));
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads.get().min(jobs.len()) {
            scope.spawn(work);
        }
        work();
    });
}

/// Makes one run.
pub fn one(job: &Job<'_>, libraries: &mut Libraries) -> Outcome {
    let run = match Run::new(&job.plan, libraries) {
        Ok(run) => run,
        Err(error) => {
            return Outcome {
                names: vec![],
                rows: vec![],
                error: Some(error),
            };
        }
    };
    let names = run.names().to_vec();
    let mut rows = vec![0.0; job.times.len() * names.len()];
    let (good, done) = run.run(&job.plan, job.times, job.script, &mut rows);
    rows.truncate(good * names.len());
    Outcome {
        names,
        rows,
        error: done.err(),
    }
}
