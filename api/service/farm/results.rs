//! The finished tiles of jobs at the broker. The first result of a tile is the one: the broker refuses a second.

use super::connection::{Broker, reasons};
use super::names::{self, RESULTS};
use async_nats::jetstream::context::{PublishError, PublishErrorKind};
use async_nats::jetstream::message::PublishMessage;
use async_nats::jetstream::stream::{DirectGetError, DirectGetErrorKind, Stream};
use std::time::Duration;

/// What the broker says to a second result.
const SECOND: &str = "maximum messages per subject exceeded";
/// Time until a result that was not taken is sent again.
const RESEND_AFTER: Duration = Duration::from_millis(500);

/// The results.
#[derive(Debug, Clone)]
pub(crate) struct Results {
    broker: Broker,
    stream: Stream<()>,
}

/// What has become of a result.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Kept {
    /// It is the result.
    First,
    /// There was one, which is this.
    Second(Vec<u8>),
}

impl Results {
    /// The results at a broker.
    pub(crate) async fn open(broker: &Broker) -> Result<Self, String> {
        let stream = broker.stream.get_stream_no_info(RESULTS).await.map_err(|error| reasons(&error))?;
        Ok(Self { broker: broker.clone(), stream })
    }

    /// Keeps a result, however long the broker is away. An error says that it never will.
    pub(crate) async fn keep(&self, job: &str, tile: u32, bytes: &[u8]) -> Result<Kept, String> {
        let subject = names::result(job, tile);
        loop {
            let error = match self.publish(&subject, bytes).await {
                Ok(()) => return Ok(Kept::First),
                Err(error) => error,
            };
            if error.kind() == PublishErrorKind::MaxPayloadExceeded {
                return Err(format!("a tile of {} bytes is too large for the broker (max_payload)", bytes.len()));
            }
            if reasons(&error).contains(SECOND) {
                // It may have been deleted in the meantime.
                if let Ok(Some(stored)) = self.get(job, tile).await {
                    return Ok(if stored == bytes { Kept::First } else { Kept::Second(stored) });
                }
            } else {
                tracing::warn!(job, tile, error = reasons(&error), "a result is not taken; it is sent again");
            }
            tokio::time::sleep(RESEND_AFTER).await;
        }
    }

    async fn publish(&self, subject: &str, bytes: &[u8]) -> Result<(), PublishError> {
        let message = PublishMessage::build().payload(bytes.to_vec().into());
        self.broker.stream.send_publish(subject.to_owned(), message).await?.await?;
        Ok(())
    }

    /// The result of a tile, if there is one.
    pub(crate) async fn get(&self, job: &str, tile: u32) -> Result<Option<Vec<u8>>, String> {
        found(self.stream.direct_get_last_for_subject(names::result(job, tile)).await)
            .map(|message| message.map(|(_, bytes)| bytes))
    }

    /// The next result of a job after one of some sequence number, and its own.
    pub(crate) async fn next(&self, job: &str, after: u64) -> Result<Option<(u64, Vec<u8>)>, String> {
        found(self.stream.direct_get_next_for_subject(names::results(job), Some(after + 1)).await)
    }

    /// Deletes a result that is none: nobody can replace it.
    pub(crate) async fn delete(&self, job: &str, tile: u32) -> Result<(), String> {
        let purge = self.stream.purge().filter(names::result(job, tile)).await;
        purge.map(|_| ()).map_err(|error| reasons(&error))
    }

    /// Deletes all results of a job.
    pub(crate) async fn delete_all(&self, job: &str) -> Result<(), String> {
        let purge = self.stream.purge().filter(names::all_results(job)).await;
        purge.map(|_| ()).map_err(|error| reasons(&error))
    }
}

type Found = Result<async_nats::jetstream::message::StreamMessage, DirectGetError>;

fn found(answer: Found) -> Result<Option<(u64, Vec<u8>)>, String> {
    match answer {
        Ok(message) => Ok(Some((message.sequence, message.payload.to_vec()))),
        Err(error) if error.kind() == DirectGetErrorKind::NotFound => Ok(None),
        Err(error) => Err(reasons(&error)),
    }
}

/// Whether something was not published since the stream is full.
pub(crate) fn is_full(error: &PublishError) -> bool {
    error.kind() == PublishErrorKind::Other && reasons(error).contains("maximum messages exceeded")
}
