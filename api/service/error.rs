//! Errors of the service. HTTP turns them into problem documents.

use std::any::Any;
use std::fmt;
use std::io;
use strahl::render::Cancelled;
use strahl::scene::{NotLoaded, Problems};

/// Why a request is not answered.
#[derive(Debug, Clone)]
pub(crate) enum Error {
    /// The scene has problems.
    Scene(Problems),
    /// There is no scene with this id, or no longer.
    UnknownScene(String),
    /// An asset has other bytes than its name says.
    OtherBytes {
        /// The SHA-256 of its name.
        expected: String,
        /// The SHA-256 that it has.
        hash: String,
    },
    /// Pictures of this scene have no ids, for a reason.
    NoIds(&'static str),
    /// The request asks for something outside of the picture, or beyond the precision of its numbers.
    OutOfRange(String),
    /// Something else needs what was to be deleted.
    InUse(String),
    /// The picture is more work than one answer or one job may take.
    Limit {
        /// The limit's name.
        name: &'static str,
        /// Its value.
        max: u64,
        /// What exceeds it, and what to do.
        detail: String,
    },
    /// The scene is larger than the memory or disk space for scenes.
    TooLarge(&'static str),
    /// The service is full.
    Busy {
        /// What is full.
        detail: String,
        /// Seconds after which to try again.
        retry_after: u32,
    },
    /// The tenant has reached a limit of its own.
    TenantBusy {
        /// Which limit.
        detail: String,
        /// Seconds after which to try again.
        retry_after: u32,
    },
    /// The work took too long.
    Deadline(String),
    /// The request was cancelled, and no client reads the answer.
    Cancelled,
    /// The service has failed; its log says why.
    Internal(&'static str),
}

impl Error {
    /// What has to be read or written cannot be. `what` says what cannot be done without it.
    pub(crate) fn io(what: &'static str, error: &io::Error) -> Self {
        tracing::error!(%error, "{what}");
        if is_full(error) {
            let detail = format!("{what}: the disk of the service is full, and its operator has to make room");
            return Self::Busy { detail, retry_after: 60 };
        }
        if error.kind() == io::ErrorKind::NotConnected {
            let detail = format!("{what}: the farm's broker or its store does not answer; the service's log says why");
            return Self::Busy { detail, retry_after: 5 };
        }
        if error.kind() == io::ErrorKind::ResourceBusy {
            return Self::Busy { detail: format!("{what}: {error}"), retry_after: 1 };
        }
        if is_temporary(error) {
            let detail = format!("{what}: the folders of the service cannot be used now, and its operator has to look");
            return Self::Busy { detail, retry_after: 30 };
        }
        Self::Internal(what)
    }
}

impl From<Problems> for Error {
    fn from(problems: Problems) -> Self {
        Self::Scene(problems)
    }
}

impl From<NotLoaded<Self>> for Error {
    fn from(error: NotLoaded<Self>) -> Self {
        match error {
            NotLoaded::Problems(problems) => Self::Scene(problems),
            NotLoaded::Refused(error) => error,
        }
    }
}

impl From<Cancelled> for Error {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Why the service does not start.
#[derive(Debug)]
pub(crate) enum StartError {
    /// Its settings are not valid.
    Settings(String),
    /// A port, a folder or a thread is not available.
    Machine(String),
}

/// Whether there was no room on the disk for what was to be written: it can be written once there is.
pub(crate) fn is_full(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded)
}

/// An error of what several machines share: the broker and the store of a farm.
pub(crate) fn not_reachable(why: impl fmt::Display) -> io::Error {
    io::Error::new(io::ErrorKind::NotConnected, why.to_string())
}

/// Whether the same may succeed another time: it is the disk, the volume or the network that fails, and not what is written or
/// has been read.
pub(crate) fn is_temporary(error: &io::Error) -> bool {
    use io::ErrorKind::{InvalidData, InvalidFilename, InvalidInput, IsADirectory, UnexpectedEof};
    !matches!(error.kind(), InvalidData | InvalidFilename | InvalidInput | IsADirectory | UnexpectedEof)
}

/// The text of a panic, for the log only.
pub(crate) fn panic_text(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".to_owned())
}
