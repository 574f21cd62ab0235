//! Why a command failed: one block of text on standard error, and the exit code.

use crate::service::error::StartError;
use std::fmt;
use std::io::{self, Write};
use std::process::ExitCode;
use strahl::render::Cancelled;
use strahl::scene::Problems;

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
            // If standard error is closed, nothing can be reported.
            let _ = writeln!(io::stderr().lock(), "{self}");
        }
        match self {
            Self::Usage(_) => ExitCode::from(2),
            Self::Interrupted => ExitCode::from(130),
            _ => ExitCode::from(1),
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
            Self::Input(what) | Self::Incomplete(what) => write!(f, "error: {what}"),
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
