//! Steps that run beside others: on two cores one may compile while the other links or tests.

use crate::plan::{Failure, Step, work};
use crate::words::Words;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Instant;

/// Runs `steps` beside the steps `others`, then shows all they said, and fails where one of them did.
/// Until then their words are in `log`.
///
/// Those that run beside may neither need what the others make nor write where they do; cargo itself
/// takes turns in a target folder.
pub fn beside(name: &str, log: PathBuf, steps: Vec<Step>, others: Vec<Step>) -> Vec<Step> {
    let count = steps.len();
    let running = Arc::new(Mutex::new(None));
    let started = Arc::clone(&running);
    let title = format!("{name}: {count} steps beside the next {}", others.len());
    let begin = Step::new(title, move |_| {
        put(&started, Running::start(steps, log)?);
        Ok(())
    });
    let end = Step::new(format!("{name}: what was done beside"), move |words| {
        take(&running).map_or(Ok(()), |running| running.finish(words))
    });
    [begin].into_iter().chain(others).chain([end]).collect()
}

type Shared = Mutex<Option<Running>>;

fn put(shared: &Shared, running: Running) {
    if let Ok(mut place) = shared.lock() {
        *place = Some(running);
    }
}

fn take(shared: &Shared) -> Option<Running> {
    shared.lock().ok()?.take()
}

/// Steps in a thread of their own. Dropped, when another step has failed, they start nothing more.
struct Running {
    thread: Option<JoinHandle<Result<(), Failure>>>,
    stopped: Arc<AtomicBool>,
    log: PathBuf,
}

impl Running {
    fn start(steps: Vec<Step>, log: PathBuf) -> Result<Self, Failure> {
        let folder = log.parent().unwrap_or(Path::new("."));
        let file = fs::create_dir_all(folder).and_then(|()| File::create(&log));
        let file = with_path(&log, file)?;
        let stopped = Arc::new(AtomicBool::new(false));
        let words = Words::Kept {
            file,
            stopped: Arc::clone(&stopped),
        };
        Ok(Self {
            thread: Some(thread::spawn(move || timed(steps, &words))),
            stopped,
            log,
        })
    }

    fn finish(mut self, words: &Words) -> Result<(), Failure> {
        let outcome = self.wait();
        let said = with_path(&self.log, fs::read(&self.log))?;
        words.say(format_args!(
            "{}",
            String::from_utf8_lossy(&said).trim_end()
        ));
        outcome
    }

    /// What became of the steps; a panic goes on here.
    fn wait(&mut self) -> Result<(), Failure> {
        let ended = self.thread.take().map(JoinHandle::join);
        match ended {
            Some(Ok(outcome)) => outcome,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(()),
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stopped.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // the step that failed is the one to tell of
        }
    }
}

/// Does them and tells how long all of it took.
fn timed(steps: Vec<Step>, words: &Words) -> Result<(), Failure> {
    let started = Instant::now();
    let outcome = work(steps, words);
    let seconds = started.elapsed().as_secs_f64();
    words.say(format_args!("      {seconds:.1} s in all"));
    outcome
}

fn with_path<T>(path: &Path, done: io::Result<T>) -> Result<T, Failure> {
    done.map_err(|error| Failure::File {
        path: path.into(),
        error,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan;
    use std::process::Command;
    use std::sync::mpsc;

    fn log(test: &str) -> PathBuf {
        let name = format!("xtask-{test}-{}.log", std::process::id());
        std::env::temp_dir().join(name)
    }

    fn fails() -> Step {
        Step::commands("fails", vec![Command::new("false")])
    }

    #[test]
    fn steps_run_at_the_same_time() {
        let (here, there) = (mpsc::channel(), mpsc::channel());
        let meet = |out: mpsc::Sender<()>, come: mpsc::Receiver<()>| {
            Step::new("meets", move |_| {
                let _ = out.send(());
                let met = come.recv();
                met.map_err(|_| Failure::Usage("nobody came".into()))
            })
        };
        let one = meet(here.0, there.1);
        let other = meet(there.0, here.1);
        let log = log("meeting");
        plan::run(beside("a meeting", log.clone(), vec![one], vec![other])).unwrap();
        fs::remove_file(log).unwrap();
    }

    #[test]
    fn a_failure_beside_is_told_and_what_was_said_is_kept() {
        let mut echo = Command::new("echo");
        echo.arg("what it said");
        let steps = vec![Step::commands("echo", vec![echo]), fails()];
        let log = log("failure");
        let failure = plan::run(beside("a failure", log.clone(), steps, vec![])).unwrap_err();
        assert!(failure.to_string().contains("exit status: 1"), "{failure}");
        let said = fs::read_to_string(&log).unwrap();
        fs::remove_file(log).unwrap();
        assert!(said.starts_with("[1/2] echo\nwhat it said\n"), "{said}");
        assert!(said.contains("[2/2] fails\n"), "{said}");
    }

    #[test]
    fn a_failure_here_stops_what_runs_beside() {
        let endless = Step::new("endless", |words| {
            loop {
                words.give_to(&mut Command::new("true"))?;
                thread::yield_now();
            }
        });
        let log = log("stopped");
        let steps = beside("what is stopped", log.clone(), vec![endless], vec![fails()]);
        let failure = plan::run(steps).unwrap_err();
        assert!(matches!(failure, Failure::Command { .. }), "{failure}");
        fs::remove_file(log).unwrap();
    }
}
