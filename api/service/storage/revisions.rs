//! Values of which each write names the revision that it replaces.

use std::io;

/// Why a value was not written.
#[derive(Debug)]
pub(crate) enum Refused {
    /// Another process has written it since, or removed it.
    Changed,
    /// It cannot be written now.
    Failed(io::Error),
}

impl From<io::Error> for Refused {
    fn from(error: io::Error) -> Self {
        Self::Failed(error)
    }
}

impl From<Refused> for io::Error {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Changed => Self::new(io::ErrorKind::ResourceBusy, "another process has changed it at this moment"),
            Refused::Failed(error) => error,
        }
    }
}
