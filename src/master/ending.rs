//! What ends `cosim run` from outside: Ctrl-C, SIGTERM and a time limit.

use cosim_master::{Error, Watch};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::path::Path;
use std::process::exit;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::thread::{sleep, spawn};
use std::time::Duration;
use tempfile::TempDir;

/// A call into an FMU that takes longer than this past the limit hangs.
const GRACE: Duration = Duration::from_secs(2);

/// Exit code of a run that took too long.
const LATE: u8 = 5;

/// Exit code of a run that a signal ended: that of Ctrl-C, as a shell reports it.
const INTERRUPTED: u8 = 130;

/// What may end a run, and what did; with a folder for unpacked FMUs, which goes with it.
pub struct Ending {
    /// The run.
    pub watch: Watch,
    /// Number of the last signal.
    signal: Arc<AtomicUsize>,
    returned: Arc<AtomicBool>,
    limit: Option<f64>,
    folder: TempDir,
}

impl Ending {
    /// From now on signals and the limit [s] end runs at their next communication point; a second signal ends
    /// the process.
    pub fn begin(limit: Option<f64>) -> Result<Self, Error> {
        let folder = tempfile::Builder::new().prefix("cosim-").tempdir();
        let ending = Self {
            watch: Watch::default(),
            signal: Arc::default(),
            returned: Arc::default(),
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
        if let Some(seconds) = limit {
            ending.wait(seconds);
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

    fn wait(&self, seconds: f64) {
        let (switch, returned) = (self.watch.switch(), self.returned.clone());
        let folder = self.folder().to_owned();
        let limit = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        spawn(move || {
            sleep(limit);
            switch.store(true, Relaxed);
            sleep(GRACE);
            if !returned.load(Relaxed) {
                eprintln!("cosim: an FMU does not return, {seconds} s are over (--timeout)");
                // What cannot be removed stays with the other temporary files.
                let _ = std::fs::remove_dir_all(folder);
                exit(LATE.into());
            }
        });
    }

    /// Where FMUs may be unpacked.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The run has returned: its results are written, however long that takes.
    pub fn returned(&self) {
        self.returned.store(true, Relaxed);
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
}
