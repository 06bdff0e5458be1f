//! A plan: steps that run one after the other, each announced as `[3/9] …` and timed.

use crate::words::Words;
use std::fmt;
use std::process::{Command, Stdio};
use std::time::Instant;

/// One step: what it is for and what it does.
pub struct Step {
    title: String,
    action: Box<Action>,
}

/// What a step does; it is told where its words go, and may be done in another thread.
type Action = dyn FnOnce(&Words) -> Result<(), Failure> + Send;

impl Step {
    /// A step that calls a function, which is told where its words go.
    pub fn new(
        title: impl Into<String>,
        action: impl FnOnce(&Words) -> Result<(), Failure> + Send + 'static,
    ) -> Self {
        Self {
            title: title.into(),
            action: Box::new(action),
        }
    }

    /// A step that runs commands until one fails.
    pub fn commands(title: impl Into<String>, commands: Vec<Command>) -> Self {
        Self::new(title, move |words| {
            let mut commands = commands.into_iter();
            commands.try_for_each(|command| execute(words, command))
        })
    }
}

/// Why a command of xtask ended early.
#[derive(Debug)]
pub enum Failure {
    /// The command line makes no sense.
    Usage(String),
    /// A program returned a failure, or could not be started.
    Command {
        /// As one would type it at the project's root.
        line: String,
        /// Exit status, or why it could not be started.
        what: String,
    },
    /// Another step failed while this one ran beside it.
    Stopped,
    /// Something is missing that only the user can install.
    Missing {
        /// What is missing.
        what: String,
        /// The line that installs it.
        remedy: String,
    },
    /// A file could not be read or written.
    File {
        /// The file.
        path: std::path::PathBuf,
        /// What the operating system said.
        error: std::io::Error,
    },
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(what) => write!(f, "{what}"),
            Self::Command { line, what } => {
                write!(f, "{what}; to repeat this alone:\n\n  {line}\n")
            }
            Self::Stopped => write!(f, "stopped, for another step failed"),
            Self::Missing { what, remedy } => {
                write!(f, "{what} is missing; to install it:\n\n  {remedy}\n")
            }
            Self::File { path, error } => write!(f, "{}: {error}", path.display()),
        }
    }
}

/// Runs the steps in order, for all to see, and stops at the first that fails.
///
/// Nothing is printed after the last step, so a test runner's summary stays the last line.
pub fn run(steps: Vec<Step>) -> Result<(), Failure> {
    work(steps, &Words::Shown)
}

/// The same with the words somewhere else.
pub fn work(steps: Vec<Step>, words: &Words) -> Result<(), Failure> {
    let total = steps.len();
    let mut previous: Option<Instant> = None;
    for (index, Step { title, action }) in steps.into_iter().enumerate() {
        if let Some(started) = previous {
            words.say(format_args!(
                "      {:.1} s",
                started.elapsed().as_secs_f64()
            ));
        }
        words.say(format_args!("[{}/{total}] {title}", index + 1));
        previous = Some(Instant::now());
        action(words)?;
    }
    Ok(())
}

/// Runs a command; its output goes where the words go.
pub fn execute(words: &Words, mut command: Command) -> Result<(), Failure> {
    words.give_to(&mut command)?;
    let status = command.stdin(Stdio::null()).status();
    let what = match status {
        Ok(status) if status.success() => return Ok(()),
        Ok(status) => format!("the command ended with {status}"),
        Err(error) => format!("the command could not be started ({error})"),
    };
    Err(Failure::Command {
        line: line(&command),
        what,
    })
}

/// Whether a command succeeds; its output is not shown.
pub fn succeeds(command: &mut Command) -> bool {
    let quiet = command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}

/// The command as one would type it in a POSIX shell, environment included.
pub fn line(command: &Command) -> String {
    let environment = command.get_envs().filter_map(|(name, value)| {
        value.map(|value| format!("{}={}", name.display(), quoted(&value.to_string_lossy())))
    });
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let words = words.map(|word| quoted(&word.to_string_lossy()));
    environment.chain(words).collect::<Vec<_>>().join(" ")
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_command_is_shown_as_one_would_type_it() {
        let mut command = Command::new("false");
        command
            .args(["--with", "two words", "it's"])
            .env("LIBCLANG_PATH", "/a b");
        let failure = execute(&Words::Shown, command).unwrap_err().to_string();
        assert!(failure.contains(r"LIBCLANG_PATH='/a b' false --with 'two words' 'it'\''s'"));
        assert!(failure.contains("exit status: 1"));
    }

    #[test]
    fn a_program_that_does_not_exist_is_named() {
        let command = Command::new("no-such-program");
        let failure = execute(&Words::Shown, command).unwrap_err().to_string();
        assert!(failure.contains("could not be started") && failure.contains("no-such-program"));
    }

    #[test]
    fn steps_after_a_failing_one_do_not_run() {
        let fails = Step::new("fails", |_| Err(Failure::Usage("on purpose".into())));
        let never = Step::new("never", |_| unreachable!());
        assert!(matches!(run(vec![fails, never]), Err(Failure::Usage(_))));
    }
}
