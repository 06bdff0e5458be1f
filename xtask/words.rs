//! Where steps say what they do: for all to see, or, beside other steps, into a file that is shown later.

use crate::plan::Failure;
use std::fmt;
use std::fs::File;
use std::io::{self, Write as _};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Where a step's words go, and those of its commands.
#[derive(Debug)]
pub enum Words {
    /// To the terminal.
    Shown,
    /// To a file.
    Kept {
        /// The file.
        file: File,
        /// Set when nothing more shall be started.
        stopped: Arc<AtomicBool>,
    },
}

impl Words {
    /// A line.
    pub fn say(&self, line: fmt::Arguments<'_>) {
        match self {
            Self::Shown => println!("{line}"),
            Self::Kept { file, .. } => {
                let mut file = file;
                let _ = writeln!(file, "{line}"); // a full disc is told by what the step makes
            }
        }
    }

    /// Makes a command say its words here too.
    ///
    /// # Errors
    /// When nothing more shall be started, or the system has no more files.
    pub fn give_to(&self, command: &mut Command) -> Result<(), Failure> {
        let Self::Kept { file, stopped } = self else {
            return Ok(());
        };
        if stopped.load(Ordering::Relaxed) {
            return Err(Failure::Stopped);
        }
        let both = file
            .try_clone()
            .and_then(|out| Ok((out, file.try_clone()?)));
        let (out, error) = both.map_err(|error: io::Error| Failure::File {
            path: "words of a step".into(),
            error,
        })?;
        command.stdout(out).stderr(error);
        Ok(())
    }
}
