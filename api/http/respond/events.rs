//! Answers that tell what is found as it is found: Server-Sent Events (WHATWG HTML, 9.2).
//!
//! The work is dropped with the answer, so a client that goes away cancels it.

use crate::http::problem::{Problem, ProblemSummary};
use crate::http::respond::event_stream::event_stream;
use crate::service::error::Error;
use axum::response::Response;
use axum::response::sse;
use futures_util::stream;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::pin::Pin;
use tokio::sync::mpsc::Receiver;

/// The name of an event, and its data.
pub(crate) type Event = (&'static str, Value);

type Outcome<T> = Pin<Box<dyn Future<Output = Result<T, Error>> + Send>>;

/// What is found and how it ends.
struct Finding<F, T> {
    found: Receiver<F>,
    /// None once it has ended.
    outcome: Option<Outcome<T>>,
    told: fn(F) -> Event,
    finished: fn(T) -> Vec<Event>,
    ready: VecDeque<Event>,
}

/// Tells what is found until the outcome is there. Work that fails before anything is found is refused as any other.
pub(crate) async fn events<F: Send + 'static, T: Send + 'static>(
    found: Receiver<F>,
    outcome: Outcome<T>,
    told: fn(F) -> Event,
    finished: fn(T) -> Vec<Event>,
) -> Result<Response, Problem> {
    let mut finding = Finding { found, outcome: Some(outcome), told, finished, ready: VecDeque::new() };
    finding.next().await?;
    let events = stream::unfold(finding, |mut finding| async {
        if finding.ready.is_empty()
            && let Err(error) = finding.next().await
        {
            finding.ready.push_back(("failed", json!({ "problem": ProblemSummary::from(error) })));
        }
        let (name, data) = finding.ready.pop_front()?;
        Some((Ok::<_, Infallible>(sse::Event::default().event(name).data(data.to_string())), finding))
    });
    Ok(event_stream(events))
}

impl<F, T> Finding<F, T> {
    /// Waits for the next finding, or for the end.
    async fn next(&mut self) -> Result<(), Error> {
        let Some(outcome) = &mut self.outcome else { return Ok(()) };
        let ended = tokio::select! {
            biased;
            Some(found) = self.found.recv() => {
                self.ready.push_back((self.told)(found));
                return Ok(());
            }
            ended = outcome => ended,
        };
        self.outcome = None;
        self.ready.extend((self.finished)(ended?));
        Ok(())
    }
}

/// One event of a stream, for the contract.
pub(crate) fn streamed_event() -> Value {
    let text = |about: &str| json!({ "type": ["string", "null"], "description": about });
    json!({
        "type": "object",
        "description": "One of the Server-Sent Events of a stream (WHATWG HTML, 9.2).",
        "properties": {
            "id": text("What `Last-Event-ID` and `since` name."),
            "event": text("Its name."),
            "data": text("A JSON object."),
            "retry": {
                "type": ["integer", "null"], "format": "int64",
                "description": "Milliseconds to wait before connecting again.",
            },
        },
    })
}
