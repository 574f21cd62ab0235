//! The socket of a client. A client that stops reading its answer is cut off, since the answer's memory is wanted elsewhere;
//! and a large answer goes out a part at a time, so that hundreds of them do not keep a small one waiting.

use super::activity::Activity;
use smallvec::SmallVec;
use std::io::{self, IoSlice};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::{Sleep, sleep};

/// Bytes that are written before other connections have their turn: copying them takes some 50 microseconds. The system
/// takes up to 4 MiB at a time, and with 300 such answers a small render waited for 2.6 seconds.
const PART: usize = 256 << 10;

/// A TCP stream whose writes fail when nothing has gone out for a while.
#[derive(Debug)]
pub(crate) struct ClientSocket {
    stream: Arc<TcpStream>,
    activity: Arc<Activity>,
    patience: Duration,
    /// Runs while a write waits for the client.
    waiting: Option<Pin<Box<Sleep>>>,
    /// Bytes written since others had their turn.
    written: usize,
}

impl ClientSocket {
    /// Gives each write so much time.
    pub(crate) fn new(stream: Arc<TcpStream>, activity: Arc<Activity>, patience: Duration) -> Self {
        Self { stream, activity, patience, waiting: None, written: 0 }
    }

    /// Writes when the client is ready, and the other connections have had their turn.
    fn poll_send(
        &mut self,
        context: &mut Context<'_>,
        mut send: impl FnMut(&TcpStream) -> io::Result<usize>,
    ) -> Poll<io::Result<usize>> {
        if self.written >= PART {
            self.written = 0;
            self.activity.set_blocked(true);
            context.waker().wake_by_ref();
            return Poll::Pending;
        }
        loop {
            let ready = self.stream.poll_write_ready(context)?;
            if ready.is_pending() {
                return self.out_of_patience(context);
            }
            match send(&self.stream) {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                sent => {
                    self.written += sent.as_ref().copied().unwrap_or(0);
                    self.waiting = None;
                    self.activity.set_blocked(false);
                    return Poll::Ready(sent);
                }
            }
        }
    }

    /// An error once the client has not read for too long.
    fn out_of_patience<T>(&mut self, context: &mut Context<'_>) -> Poll<io::Result<T>> {
        self.activity.set_blocked(true);
        let patience = self.patience;
        ready!(self.waiting.get_or_insert_with(|| Box::pin(sleep(patience))).as_mut().poll(context));
        Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "the client does not read its answer")))
    }
}

impl AsyncRead for ClientSocket {
    fn poll_read(self: Pin<&mut Self>, context: &mut Context<'_>, into: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        loop {
            ready!(self.stream.poll_read_ready(context))?;
            match self.stream.try_read(into.initialize_unfilled()) {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                read => return Poll::Ready(read.map(|bytes| into.advance(bytes))),
            }
        }
    }
}

impl AsyncWrite for ClientSocket {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        self.poll_send(context, |stream| stream.try_write(&bytes[..bytes.len().min(PART)]))
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let mut left = PART;
        let mut part = SmallVec::<[IoSlice<'_>; 8]>::new();
        for slice in bytes {
            let length = slice.len().min(left);
            part.push(IoSlice::new(&slice[..length]));
            left -= length;
            if left == 0 {
                break;
            }
        }
        self.poll_send(context, |stream| stream.try_write_vectored(&part))
    }

    fn is_write_vectored(&self) -> bool {
        true
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    /// The socket is dropped right after this, which closes it.
    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}
