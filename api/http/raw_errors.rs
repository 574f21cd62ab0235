//! Turns hyper's own answers into problem documents. Hyper answers requests that are not HTTP, or have too large a head, with a
//! status without a body, and handlers never see them.

use super::problem::{Kind, Problem};
use crate::http::middleware::request_log::request_id;
use axum::http::HeaderMap;
use std::io::{self, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

/// A stream that adds a problem document to hyper's own answers.
#[derive(Debug)]
pub(crate) struct RawErrors<S> {
    stream: S,
    /// What is sent in place of hyper's answer.
    pending: Vec<u8>,
}

impl<S: AsyncWrite + Unpin> RawErrors<S> {
    /// Wraps a stream.
    pub(crate) fn new(stream: S) -> Self {
        Self { stream, pending: Vec::new() }
    }

    fn poll_pending(&mut self, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        while !self.pending.is_empty() {
            let written = ready!(Pin::new(&mut self.stream).poll_write(context, &self.pending))?;
            if written == 0 {
                return Poll::Ready(Err(io::ErrorKind::WriteZero.into()));
            }
            self.pending.drain(..written);
        }
        Poll::Ready(Ok(()))
    }

    /// Replaces these bytes if they are an answer of hyper's own.
    fn replace(&mut self, bytes: &[u8]) -> bool {
        let Some(problem) = given_up(bytes) else { return false };
        let id = request_id(&HeaderMap::new());
        let (status, body) = (problem.status(), problem.document(&id));
        tracing::info!(request = %id, status = status.as_u16(), "a request that is no HTTP was refused");
        self.pending = format!(
            "HTTP/1.1 {status}\r\ncontent-type: application/problem+json\r\ncontent-length: {}\r\ncache-control: no-store\r\n\
             x-content-type-options: nosniff\r\nx-request-id: {id}\r\nconnection: close\r\n\r\n{body}",
            body.len()
        )
        .into_bytes();
        true
    }
}

/// The problem in an answer of hyper's own. Answers of handlers differ, since their problems have bodies.
fn given_up(bytes: &[u8]) -> Option<Problem> {
    let status = bytes.strip_prefix(b"HTTP/1.1 4")?;
    if !bytes.ends_with(b"\r\n\r\n") || !bytes.windows(19).any(|part| part == b"content-length: 0\r\n") {
        return None;
    }
    let (kind, detail) = match status.get(..2)? {
        b"00" => (Kind::MalformedRequest, "the request's line or a header is not HTTP/1.1"),
        b"14" => (Kind::UriTooLong, "the request's URI is too long: scenes go into the body"),
        b"31" => (Kind::HeadersTooLarge, "there are more than 100 headers, or more than 64 KiB of them"),
        _ => return None,
    };
    Some(Problem::new(kind, detail))
}

impl<S: AsyncRead + Unpin> AsyncRead for RawErrors<S> {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, into: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, into)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for RawErrors<S> {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        ready!(self.poll_pending(context))?;
        if self.replace(bytes) {
            return Poll::Ready(Ok(bytes.len()));
        }
        Pin::new(&mut self.stream).poll_write(context, bytes)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        ready!(self.poll_pending(context))?;
        if let [head] = bytes
            && self.replace(head)
        {
            return Poll::Ready(Ok(head.len()));
        }
        Pin::new(&mut self.stream).poll_write_vectored(context, bytes)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        ready!(self.poll_pending(context))?;
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        ready!(self.poll_pending(context))?;
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
