//! Independent runs on several threads.

use crate::error::Error;
use crate::library::Libraries;
use crate::plan::Plan;
use crate::run::Run;
use cosim_raw::Message;
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

/// How many rows are good, why they are not all, and what the FMUs said.
pub type Made = (usize, Option<Error>, Told);

/// Makes all runs, at most `threads` at a time; `done` gets each with its number, in any order.
///
/// The runs are the same, to the last bit, for any number of threads.
pub fn run_all(
    jobs: &[Job<'_>],
    libraries: &Libraries,
    threads: NonZero<usize>,
    done: impl Fn(usize, Outcome) + Sync,
) {
    let jobs: Vec<_> = jobs.iter().enumerate().collect();
    share(jobs, libraries, threads, |(number, job), libraries| {
        done(number, one(job, libraries));
    });
}

/// Makes all runs into rows that are there already, large enough for every one of them.
///
pub fn run_into(
    jobs: &[Job<'_>],
    rows: Vec<&mut [f64]>,
    libraries: &Libraries,
    threads: NonZero<usize>,
) -> Vec<Made> {
    let mut made: Vec<Made> = jobs.iter().map(|_| Made::default()).collect();
    let work = jobs.iter().zip(rows).zip(&mut made).collect();
    share(
        work,
        libraries,
        threads,
        |((job, rows), made), libraries| {
            *made = match Run::new(&job.plan, libraries) {
                Ok(run) => make(run, job, rows),
                Err(error) => (0, Some(error), vec![]),
            };
        },
    );
    made
}

/// Gives pieces of work to threads, each when it has done its last one.
fn share<Piece: Send>(
    pieces: Vec<Piece>,
    libraries: &Libraries,
    threads: NonZero<usize>,
    one: impl Fn(Piece, &mut Libraries) + Sync,
) {
    let extra = 1..threads.get().min(pieces.len());
    let next = Mutex::new(pieces.into_iter());
    let take = || next.lock().ok().and_then(|mut pieces| pieces.next());
    let work = || {
        let mut libraries = libraries.clone();
        while let Some(piece) = take() {
            one(piece, &mut libraries);
        }
    };
    thread::scope(|scope| {
        for _ in extra {
            scope.spawn(work);
        }
        work();
    });
}

/// Makes one run.
fn one(job: &Job<'_>, libraries: &mut Libraries) -> Outcome {
    let run = match Run::new(&job.plan, libraries) {
        Ok(run) => run,
        Err(error) => {
            return Outcome {
                names: vec![],
                rows: vec![],
                error: Some(error),
                log: vec![],
            };
        }
    };
    let names = run.names();
    let mut rows = vec![0.0; job.times.len() * names.len()];
    let (good, error, log) = make(run, job, &mut rows);
    rows.truncate(good * names.len());
    Outcome {
        names,
        rows,
        error,
        log,
    }
}

fn make(run: Run, job: &Job<'_>, rows: &mut [f64]) -> Made {
    let logs = run.logs();
    let (good, done) = run.run(&job.plan, job.times, job.script, rows);
    let log = logs.into_iter().map(|(name, log)| (name, log.messages()));
    (good, done.err(), log.collect())
}
