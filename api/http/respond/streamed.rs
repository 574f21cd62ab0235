//! A picture in parts, from coarse to fine, each sent when it is there: `multipart/mixed`.
//!
//! The render is dropped with the answer, so a client that goes away cancels it. One that reads slowly misses passes; nobody
//! waits for it.

use super::multipart::{self, END_OF_PART};
use super::picture::Shared;
use super::repr_digest;
use crate::http::problem::{Problem, ProblemSummary};
use crate::service::error::Error;
use crate::service::memory_budget::MeteredBytes;
use crate::service::pictures::file::PictureFile;
use crate::service::pictures::passes::{Pass, Passes};
use axum::body::{Body, Bytes};
use axum::http::{HeaderName, header};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::pending;
use std::pin::Pin;
use std::sync::Arc;
use strahl::film::{FileFormat, Region};
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::RecvError;

/// The picture at the end.
pub(crate) type Finished = Pin<Box<dyn Future<Output = Result<Arc<PictureFile>, Error>> + Send>>;

/// The bytes of a pass, which other clients have, too.
struct SharedPng(Arc<MeteredBytes>);

impl AsRef<[u8]> for SharedPng {
    fn as_ref(&self) -> &[u8] {
        self.0.as_ref().as_ref()
    }
}

/// What is still to be sent.
struct Parts {
    passes: Receiver<Pass>,
    /// None once it is there.
    picture: Option<Finished>,
    format: FileFormat,
    /// Number of the next pass.
    pass: u32,
    ready: VecDeque<Bytes>,
}

/// The answer. A request that fails before its first part is refused as any other.
pub(crate) async fn streamed(
    (newest, passes): Passes,
    picture: Finished,
    format: FileFormat,
) -> Result<Response, Problem> {
    let mut parts = Parts { passes, picture: Some(picture), format, pass: 0, ready: VecDeque::new() };
    match newest {
        Some(pass) => parts.add_pass(pass),
        None => parts.next().await?,
    }
    let chunks = stream::unfold(parts, |mut parts| async {
        if parts.ready.is_empty()
            && parts.picture.is_some()
            && let Err(error) = parts.next().await
        {
            let problem = ProblemSummary::from(error);
            parts.add("application/json", json!({ "problem": problem }).to_string().into());
            parts.ready.push_back(multipart::end());
        }
        let chunk = parts.ready.pop_front()?;
        Some((Ok::<_, Infallible>(chunk), parts))
    });
    let headers = [
        (header::CONTENT_TYPE, multipart::MEDIA_TYPE),
        (header::CACHE_CONTROL, "no-store"),
        (header::VARY, "Accept"),
        (HeaderName::from_static("x-accel-buffering"), "no"),
    ];
    Ok((headers, Body::from_stream(chunks)).into_response())
}

/// The next pass; none comes where they have ended. A client that reads slowly misses those that it lags behind.
async fn next_pass(passes: &mut Receiver<Pass>) -> Pass {
    loop {
        match passes.recv().await {
            Ok(pass) => return pass,
            Err(RecvError::Lagged(_)) => {}
            Err(RecvError::Closed) => pending().await,
        }
    }
}

impl Parts {
    /// Waits for the next pass or for the picture.
    async fn next(&mut self) -> Result<(), Error> {
        let Some(picture) = &mut self.picture else { return Ok(()) };
        let finished = tokio::select! {
            biased;
            finished = picture => finished,
            pass = next_pass(&mut self.passes) => {
                self.add_pass(pass);
                return Ok(());
            }
        };
        self.picture = None;
        self.add_picture(&finished?);
        Ok(())
    }

    fn add_pass(&mut self, Pass { scale, region: Region { x, y, width, height }, eta_ms, png }: Pass) {
        let eta_ms = eta_ms.map(f64::round);
        let head = json!({
            "pass": self.pass, "scale": scale, "x": x, "y": y, "w": width, "h": height, "eta_ms": eta_ms, "final": false,
        });
        self.pass += 1;
        self.add("application/json", head.to_string().into());
        self.add("image/png", Bytes::from_owner(SharedPng(png)));
    }

    fn add_picture(&mut self, file: &Arc<PictureFile>) {
        let head = json!({
            "pass": self.pass, "scale": 1, "eta_ms": 0, "final": true, "image_id": file.meta.image,
            "repr_digest": repr_digest(&file.digest),
        });
        self.add("application/json", head.to_string().into());
        self.add(self.format.names().1, Bytes::from_owner(Shared(Arc::clone(file))));
        let report = json!({ "report": file.meta.report.as_ref().map_or(Value::Null, |report| json!(report)) });
        self.add("application/json", report.to_string().into());
        self.ready.push_back(multipart::end());
    }

    fn add(&mut self, media_type: &str, bytes: Bytes) {
        self.ready.extend([multipart::begin(media_type, bytes.len()), bytes, END_OF_PART]);
    }
}
