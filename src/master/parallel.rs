//! Independent runs on several threads.

use crate::error::Error;
use crate::library::Libraries;
use crate::live::Live;
use crate::outcome::{Outcome, Told};
use crate::plan::Plan;
use crate::recorder::{Recorder, Rows, Seen, open};
use crate::run::Run;
use crate::watch::Watch;
use std::num::NonZero;
use std::sync::Mutex;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// How often the caller is given a chance while threads make runs.
const BEAT: Duration = Duration::from_millis(50);

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

/// How many rows are good, why they are not all, and what the FMUs said.
pub type Made = (usize, Option<Error>, Told);

/// Makes all runs, at most `threads` at a time; `done` gets each with its number, in any order, and
/// `watch` may end them.
///
/// The runs are the same, to the last bit, for any number of threads.
pub fn run_all(
    jobs: &[Job<'_>],
    libraries: &Libraries,
    threads: NonZero<usize>,
    watch: &Watch,
    done: impl Fn(usize, Outcome) + Sync,
) {
    let jobs: Vec<_> = jobs.iter().enumerate().collect();
    let each = |(number, job), libraries: &mut Libraries| done(number, one(job, libraries, watch));
    share(jobs, libraries, threads, each, || {});
}

/// Makes all runs into rows that are there already, large enough for every one of them.
///
/// `beat` is called in this thread some times a second, until all are made.
pub fn run_into(
    jobs: &[Job<'_>],
    rows: Vec<&mut [f64]>,
    libraries: &Libraries,
    threads: NonZero<usize>,
    watch: &Watch,
    beat: impl FnMut(),
) -> Vec<Made> {
    let mut made: Vec<Made> = jobs.iter().map(|_| Made::default()).collect();
    let work = jobs.iter().zip(rows).zip(&mut made).collect();
    let each = |((job, rows), made): ((&Job<'_>, _), &mut Made), libraries: &mut Libraries| {
        let live = Live::default();
        *made = match Run::new(&job.plan, libraries, &live) {
            Ok(run) => make(run, job, Rows::Own(rows), watch, &live),
            Err(error) => (0, Some(error), vec![]),
        };
    };
    share(work, libraries, threads, each, beat);
    made
}

/// Gives pieces of work to threads, each when it has done its last one.
fn share<Piece: Send>(
    pieces: Vec<Piece>,
    libraries: &Libraries,
    threads: NonZero<usize>,
    one: impl Fn(Piece, &mut Libraries) + Sync,
    mut beat: impl FnMut(),
) {
    let count = threads.get().min(pieces.len());
    let next = Mutex::new(pieces.into_iter());
    let take = || next.lock().ok().and_then(|mut pieces| pieces.next());
    let work = |_working: mpsc::Sender<()>| {
        let mut libraries = libraries.clone();
        while let Some(piece) = take() {
            one(piece, &mut libraries);
        }
    };
    let (working, all) = mpsc::channel();
    thread::scope(|scope| {
        let work = &work;
        for working in vec![working; count] {
            scope.spawn(move || work(working));
        }
        while all.recv_timeout(BEAT) == Err(RecvTimeoutError::Timeout) {
            beat();
        }
    });
}

/// Makes one run in this thread, which others can look at by `live`.
pub fn run_seen(job: &Job<'_>, libraries: &mut Libraries, watch: &Watch, live: &Live) -> Outcome {
    let run = match Run::new(&job.plan, libraries, live) {
        Ok(run) => run,
        Err(error) => return failed(error, live),
    };
    let names = run.names();
    let rows = vec![0.0; job.times.len() * names.len()];
    *open(&live.seen) = Seen {
        names,
        rows,
        good: 0,
    };
    let made = make(run, job, Rows::Seen(&live.seen), watch, live);
    let Seen { names, rows, .. } = std::mem::take(&mut *open(&live.seen));
    outcome(names, rows, made)
}

/// Makes one run.
fn one(job: &Job<'_>, libraries: &mut Libraries, watch: &Watch) -> Outcome {
    let live = Live::default();
    let run = match Run::new(&job.plan, libraries, &live) {
        Ok(run) => run,
        Err(error) => return failed(error, &live),
    };
    let names = run.names();
    let mut rows = vec![0.0; job.times.len() * names.len()];
    let made = make(run, job, Rows::Own(&mut rows), watch, &live);
    outcome(names, rows, made)
}

/// What came of a run: its good rows only.
fn outcome(names: Vec<String>, mut rows: Vec<f64>, (good, error, log): Made) -> Outcome {
    rows.truncate(good * names.len());
    Outcome {
        names,
        rows,
        error,
        log,
    }
}

fn failed(error: Error, live: &Live) -> Outcome {
    Outcome {
        names: vec![],
        rows: vec![],
        error: Some(error),
        log: live.log(),
    }
}

fn make(run: Run, job: &Job<'_>, rows: Rows<'_>, watch: &Watch, live: &Live) -> Made {
    let recorder = Recorder::new(rows, run.width());
    let (good, done) = run.run(&job.plan, (job.times, job.script), recorder, watch);
    (good, done.err(), live.log())
}
