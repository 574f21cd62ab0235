//! Events of jobs: the front that works on a job publishes them, and every front hears them all, in order.
//!
//! They are not acknowledged one by one. Each has a number, so a front sees what is missing, and its clients get a snapshot.

use super::connection::{Broker, RETRY_AFTER, reasons};
use super::names::{self, EVENTS};
use async_nats::jetstream::consumer::{DeliverPolicy, pull};
use futures_util::StreamExt;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::borrow::Cow;
use tokio::sync::mpsc::{Receiver, Sender, channel};

/// Version of the messages.
const VERSION: u32 = 1;
/// Events that may wait for the connection. More are lost, and seen to be missing.
const WAITING: usize = 10_000;

/// Publishes events.
#[derive(Debug, Clone)]
pub(crate) struct Publisher(Sender<(String, Vec<u8>)>);

/// An event as it is sent.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SentEvent<'a> {
    v: u32,
    /// Its number.
    pub(crate) seq: u64,
    /// Its kind.
    pub(crate) name: Cow<'a, str>,
    /// Its contents.
    pub(crate) data: Cow<'a, Value>,
}

impl Publisher {
    /// Publishes what it is told from now on.
    pub(crate) fn start(broker: &Broker) -> Self {
        let (sender, events) = channel(WAITING);
        tokio::spawn(publish(broker.clone(), events));
        Self(sender)
    }

    /// Publishes an event of a job. It does not wait.
    pub(crate) fn tell(&self, job: &str, seq: u64, name: &str, data: &Value) {
        let event = SentEvent { v: VERSION, seq, name: name.into(), data: Cow::Borrowed(data) };
        let json = serde_json::to_vec(&event).unwrap_or_default();
        if self.0.try_send((names::events(job), json)).is_err() {
            tracing::debug!(job, seq, "an event is lost: too many wait for the broker");
        }
    }
}

async fn publish(broker: Broker, mut events: Receiver<(String, Vec<u8>)>) {
    while let Some((subject, json)) = events.recv().await {
        if let Err(error) = broker.client.publish(subject, json.into()).await {
            tracing::debug!(error = reasons(&error), "an event is lost");
        }
    }
}

/// Hears the events of all jobs, those of the last hour first, for ever.
pub(crate) async fn follow(broker: Broker, mut hear: impl FnMut(&str, SentEvent<'_>) + Send) {
    let mut after = 0;
    loop {
        if let Err(error) = follow_once(&broker, &mut after, &mut hear).await {
            tracing::warn!(error, "events cannot be heard; it is tried again");
        }
        tokio::time::sleep(RETRY_AFTER).await;
    }
}

async fn follow_once(
    broker: &Broker,
    after: &mut u64,
    hear: &mut (impl FnMut(&str, SentEvent<'_>) + Send),
) -> Result<(), String> {
    let stream = broker.stream.get_stream_no_info(EVENTS).await.map_err(|error| reasons(&error))?;
    let deliver_policy = match *after {
        0 => DeliverPolicy::All,
        last => DeliverPolicy::ByStartSequence { start_sequence: last + 1 },
    };
    let config = pull::OrderedConfig { deliver_policy, ..pull::OrderedConfig::default() };
    let consumer = stream.create_consumer(config).await.map_err(|error| reasons(&error))?;
    let mut messages = consumer.messages().await.map_err(|error| reasons(&error))?;
    while let Some(message) = messages.next().await {
        let message = message.map_err(|error| error.to_string())?;
        *after = message.info().map_err(|error| error.to_string())?.stream_sequence;
        let event = serde_json::from_slice::<SentEvent<'_>>(&message.payload);
        // Another version may say more, or it in another way.
        if let (Some(job), Ok(event)) = (names::job_of_events(&message.subject), event)
            && event.v == VERSION
        {
            hear(job, event);
        }
    }
    Err("the messages have ended".into())
}
