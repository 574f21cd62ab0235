//! Why the service refuses something, or fails. HTTP makes problem documents of these.

use std::any::Any;
use strahl::render::Cancelled;
use strahl::scene::Problems;

/// Why a request is not answered.
#[derive(Debug, Clone)]
pub(crate) enum Error {
    /// The scene has problems.
    Scene(Problems),
    /// No scene has this id, or none has it any more.
    UnknownScene(String),
    /// Pictures of this scene have no ids; says why.
    NoIds(&'static str),
    /// The request asks for something outside of the picture, or beyond the renderer's numbers.
    OutOfRange(String),
    /// The picture is more work than one answer or one job may take.
    Limit {
        /// The limit's name.
        name: &'static str,
        /// Its value.
        max: u64,
        /// What is over it, and what to do.
        detail: String,
    },
    /// The scene is larger than the memory or the disk that is set aside for scenes.
    TooLarge(&'static str),
    /// There is no room now.
    Busy {
        /// What there is no room in.
        detail: String,
        /// Seconds until there should be room.
        retry_after: u32,
    },
    /// The tenant has as much as it may have now.
    TenantBusy {
        /// What it has.
        detail: String,
        /// Seconds until it should have less.
        retry_after: u32,
    },
    /// The work took too long.
    Deadline(String),
    /// The client has gone or was answered already, so nobody reads this.
    Cancelled,
    /// The service has failed; its log says why.
    Internal(&'static str),
}

impl From<Problems> for Error {
    fn from(problems: Problems) -> Self {
        Self::Scene(problems)
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
    /// Its settings do not make sense.
    Settings(String),
    /// The machine does not let it: a port, a folder, a thread.
    Machine(String),
}

/// The text of a panic, for the log only.
pub(crate) fn panic_text(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".to_owned())
}
