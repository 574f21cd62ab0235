//! Why a command failed: one block of text on standard error, and the exit code.

use super::output;
use crate::service::error::StartError;
use std::fmt;
use std::io;
use std::process::ExitCode;
use strahl::render::Cancelled;
use strahl::scene::Problems;

/// Exit codes of commands that managers of farms run, as in `sysexits.h`. The first three are not worth another try.
/// The scene or a tile is not valid.
pub(super) const BAD_DATA: u8 = 65;
/// An input is not there.
pub(super) const NO_INPUT: u8 = 66;
/// The output cannot be made where it is to be.
pub(super) const NO_OUTPUT: u8 = 73;
/// Another time, or on another machine, it may go well.
pub(super) const TRY_AGAIN: u8 = 75;

/// Why a command failed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The arguments contradict each other or the scene. Exit code 2, as for clap's own errors.
    Usage(String),
    /// A file cannot be read or written, or the service does not answer. Exit code 1.
    Input(String),
    /// The scene has problems. Exit code 1.
    Scene {
        /// File name, or `standard input`.
        name: String,
        /// What is wrong with it.
        problems: Problems,
    },
    /// A task of a farm's manager has failed, which decides by the exit code whether to try it again.
    Task {
        /// The exit code.
        code: u8,
        /// What has failed.
        what: String,
    },
    /// The output is incomplete, and contains the reasons. Exit code 1.
    Incomplete(String),
    /// The reader of the output has closed it. Exit code 1.
    OutputClosed,
    /// Ctrl-C. Exit code 130, as shells expect after SIGINT.
    Interrupted,
}

impl Failure {
    /// Writes the message to standard error, and returns the exit code.
    pub(crate) fn tell(&self) -> ExitCode {
        if !matches!(self, Self::OutputClosed) {
            output::say(&self.to_string());
        }
        match self {
            Self::Usage(_) => ExitCode::from(2),
            Self::Interrupted => ExitCode::from(130),
            Self::Task { code, .. } => ExitCode::from(*code),
            _ => ExitCode::from(1),
        }
    }

    /// A task has failed.
    pub(super) fn task(code: u8, what: String) -> Self {
        Self::Task { code, what }
    }

    /// The same, of a command that a manager runs.
    pub(super) fn of_task(self) -> Self {
        match self {
            Self::Scene { .. } => Self::Task { code: BAD_DATA, what: self.to_string().replacen("error: ", "", 1) },
            Self::Input(what) => Self::Task { code: TRY_AGAIN, what },
            other => other,
        }
    }

    /// Standard output or a file could not be written.
    pub(crate) fn writing(name: &str, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::OutputClosed,
            _ => Self::Input(format!("{name} cannot be written: {error}")),
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Interrupted
    }
}

impl From<StartError> for Failure {
    fn from(error: StartError) -> Self {
        match error {
            StartError::Settings(what) => Self::Usage(what),
            StartError::Machine(what) => Self::Input(what),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(what) => write!(f, "error: {what}\n\nFor more information, try '--help'."),
            Self::Input(what) | Self::Incomplete(what) | Self::Task { what, .. } => write!(f, "error: {what}"),
            Self::Scene { name, problems } => {
                match problems.0.len() {
                    1 => write!(f, "error: {name} has a problem")?,
                    _ => write!(f, "error: {name} has {} problems", problems.count())?,
                }
                let (reported, more) = problems.reported();
                reported.iter().try_for_each(|problem| write!(f, "\n  {problem}"))?;
                if more > 0 { write!(f, "\n  and {more} more") } else { Ok(()) }
            }
            Self::OutputClosed => f.write_str("error: the output was closed"),
            Self::Interrupted => f.write_str("interrupted"),
        }
    }
}
