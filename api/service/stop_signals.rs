//! The signals that end a process that serves: SIGTERM, SIGINT, and SIGHUP where its terminal closes.

use std::io::{self, IsTerminal, stdin};
use tokio::signal::unix::{Signal, SignalKind, signal};

/// They no longer end the process by themselves.
#[derive(Debug)]
pub(crate) struct StopSignals {
    terminate: Signal,
    interrupt: Signal,
    hangup: Signal,
    has_terminal: bool,
}

impl StopSignals {
    /// Watches them from now on.
    pub(crate) fn watch() -> io::Result<Self> {
        Ok(Self {
            terminate: signal(SignalKind::terminate())?,
            interrupt: signal(SignalKind::interrupt())?,
            hangup: signal(SignalKind::hangup())?,
            // One that has closed is none any more.
            has_terminal: stdin().is_terminal(),
        })
    }

    /// Waits for the next one and returns its name. Where no terminal closes, SIGHUP asks daemons to read their files again.
    pub(crate) async fn next(&mut self) -> &'static str {
        loop {
            tokio::select! {
                _ = self.terminate.recv() => return "SIGTERM",
                _ = self.interrupt.recv() => return "SIGINT",
                _ = self.hangup.recv() => {
                    if self.has_terminal {
                        return "SIGHUP";
                    }
                    tracing::info!("SIGHUP changes nothing: the file of keys is read again whenever it changes");
                }
            }
        }
    }
}
