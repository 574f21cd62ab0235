//! What a connection is doing: which one may be closed for another, and whether its client has gone.

use axum::body::{Body, Bytes};
use axum::http::{Request, Response, Version};
use http_body_util::BodyExt;
use hyper::body::Body as _;
use parking_lot::Mutex;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tokio::io::Interest;
use tokio::net::TcpStream;
use tokio::sync::Notify;
use tokio::time::sleep;

/// The readiness that reports a half-closed socket. Other systems report data by it, too.
#[cfg(any(target_os = "linux", target_os = "android"))]
const NO_MORE: Interest = Interest::PRIORITY;
#[cfg(not(any(target_os = "linux", target_os = "android")))]
const NO_MORE: Interest = Interest::READABLE;
/// How long a client that sends no more waits for its answer before it is asked whether it still listens.
const GRACE: Duration = Duration::from_millis(5);
/// What it is asked: an interim answer, which every client of HTTP/1.1 skips.
const ARE_YOU_THERE: &[u8] = b"HTTP/1.1 100 Continue\r\n\r\n";

/// What a connection is doing.
#[derive(Debug)]
pub(crate) struct Activity {
    state: Mutex<State>,
    /// Whether bytes wait for the client to read.
    blocked: AtomicBool,
    closing: Notify,
}

#[derive(Debug, Clone, Copy)]
enum State {
    /// It has no request since then.
    Idle(Instant),
    /// A request is worked on. Clients of HTTP/1.0 know no interim answers.
    Working { interim: bool },
    /// The answer goes out. A stream has no end that is known.
    Answering { stream: bool },
}

impl Default for Activity {
    fn default() -> Self {
        Self { state: Mutex::new(State::Idle(Instant::now())), blocked: AtomicBool::default(), closing: Notify::new() }
    }
}

impl Activity {
    /// A request has come.
    pub(crate) fn begin<B>(self: &Arc<Self>, request: &Request<B>) -> InFlight {
        *self.state.lock() = State::Working { interim: request.version() >= Version::HTTP_11 };
        InFlight(Arc::clone(self))
    }

    /// When the connection became idle. None while a request is in flight, or the client has bytes to read.
    pub(crate) fn idle_since(&self) -> Option<Instant> {
        match *self.state.lock() {
            State::Idle(since) if !self.is_blocked() => Some(since),
            _ => None,
        }
    }

    /// Notes whether bytes of an answer wait to be sent.
    pub(crate) fn set_blocked(&self, blocked: bool) {
        self.blocked.store(blocked, Ordering::Relaxed);
    }

    /// Closes the connection.
    pub(crate) fn close(&self) {
        self.closing.notify_one();
    }

    /// Waits until the connection is of no use any more; says why.
    pub(crate) async fn ended(&self, socket: &TcpStream) -> &'static str {
        tokio::select! {
            () = self.closing.notified() => "an idle connection was closed for a new one",
            () = self.client_left(socket) => "the client has closed the connection",
        }
    }

    /// Waits until the client has gone, rather than only said that it sends no more.
    async fn client_left(&self, socket: &TcpStream) {
        loop {
            let is_open = socket.ready(NO_MORE).await.is_ok_and(|ready| !ready.is_read_closed());
            sleep(GRACE).await;
            let state = *self.state.lock();
            match state {
                _ if is_open || self.is_blocked() => {}
                State::Working { interim: true } => {
                    // A socket that was closed completely answers anything with a reset.
                    let _ = socket.try_write(ARE_YOU_THERE);
                    let _ = socket.ready(Interest::ERROR).await;
                    return;
                }
                State::Working { interim: false } | State::Answering { stream: true } => return,
                // The answer ends by itself, or fails; and so does a connection without a request.
                State::Idle(_) | State::Answering { stream: false } => {}
            }
        }
    }

    fn is_blocked(&self) -> bool {
        self.blocked.load(Ordering::Relaxed)
    }
}

/// A request until its answer has been handed over, or given up.
#[derive(Debug)]
pub(crate) struct InFlight(Arc<Activity>);

impl InFlight {
    /// The answer is there. Its body holds the request until all of it has been handed over.
    pub(crate) fn answer(
        self,
        response: Response<Body>,
    ) -> Response<impl hyper::body::Body<Data = Bytes, Error = axum::Error>> {
        let stream = response.body().size_hint().exact().is_none();
        *self.0.state.lock() = State::Answering { stream };
        response.map(|body| {
            body.map_err(move |error| {
                let _in_flight = &self;
                error
            })
        })
    }
}

impl Drop for InFlight {
    fn drop(&mut self) {
        *self.0.state.lock() = State::Idle(Instant::now());
    }
}
