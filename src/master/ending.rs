//! What ends `cosim run` from outside: Ctrl-C, SIGTERM and a time limit.

use cosim_master::{Error, Watch};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::{flag, low_level};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A call into an FMU that takes longer than this past the end hangs.
const GRACE: Duration = Duration::from_secs(2);

/// How often is looked whether a run is to end.
const BEAT: Duration = Duration::from_millis(20);

/// Exit code of a run that took too long.
const LATE: u8 = 5;

/// Exit code of a run that a signal ended: that of Ctrl-C, as a shell reports it.
const INTERRUPTED: u8 = 130;

/// What may end a run, and what did; with a folder for unpacked FMUs, which goes with it.
pub struct Ending {
    /// The run.
    pub watch: Arc<Watch>,
    /// Number of the last signal.
    signal: Arc<AtomicUsize>,
    begin: Instant,
    limit: Option<f64>,
    folder: TempDir,
}

impl Ending {
    /// From now on signals and the limit [s] end runs at their next communication point; a second signal ends
    /// the process.
    pub fn begin(limit: Option<f64>) -> Result<Self, Error> {
        let folder = tempfile::Builder::new().prefix("cosim-").tempdir();
        let ending = Self {
            watch: Arc::default(),
            signal: Arc::default(),
            begin: Instant::now(),
            limit,
            folder: folder.map_err(|error| Error::File {
                path: std::env::temp_dir(),
                error,
            })?,
        };
        for signal in [SIGINT, SIGTERM] {
            let told = ending.listen(signal);
            told.map_err(|error| Error::Usage(format!("signal {signal}: {error}")))?;
        }
        Ok(ending)
    }

    fn listen(&self, signal: i32) -> std::io::Result<()> {
        let switch = self.watch.switch();
        flag::register_conditional_shutdown(signal, INTERRUPTED.into(), switch.clone())?;
        let number = usize::try_from(signal).unwrap_or_default();
        flag::register_usize(signal, self.signal.clone(), number)?;
        flag::register(signal, switch).map(|_| ())
    }

    /// What another thread makes, which ends it when that is due; none where it does not return.
    pub fn awaited<T>(&self, made: &Receiver<T>) -> Option<T> {
        let mut ended = None;
        loop {
            match made.recv_timeout(BEAT) {
                Ok(made) => return Some(made),
                Err(RecvTimeoutError::Disconnected) => return None,
                Err(RecvTimeoutError::Timeout) => {}
            }
            let late = |limit| self.begin.elapsed().as_secs_f64() > limit;
            if self.limit.is_some_and(late) {
                self.watch.end();
            }
            if self.watch.is_ended() {
                let since: &mut Instant = ended.get_or_insert_with(Instant::now);
                if since.elapsed() > GRACE {
                    return None;
                }
            }
        }
    }

    /// Where FMUs may be unpacked.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Exit code and cause of a run that was ended.
    pub fn cause(&self) -> (u8, String) {
        let signal = i32::try_from(self.signal.load(Relaxed));
        match (signal, self.limit) {
            (Ok(SIGINT), _) => (INTERRUPTED, "interrupted by Ctrl-C".into()),
            (Ok(SIGTERM), _) => (INTERRUPTED, "interrupted by SIGTERM".into()),
            (_, limit) => {
                let limit = limit.unwrap_or_default();
                (LATE, format!("not finished after {limit} s (--timeout)"))
            }
        }
    }

    /// Ends the process at once, beside a thread that is still within an FMU: nothing of the FMU is called again.
    pub fn leave(self, code: u8) -> ! {
        // What cannot be removed stays with the other temporary files.
        let _ = self.folder.close();
        low_level::exit(code.into())
    }
}
