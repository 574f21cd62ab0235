//! The fronts of the farm: each says every few seconds that it is there, and each sees who is gone.
//!
//! No clocks are compared. A front counts its own beats as they come back from the broker: another one is gone if four of them
//! have come since its last. While the broker is silent, or a front is stopped, nobody is thought to be gone.

use super::connection::{Broker, RETRY_AFTER, reasons};
use super::names::{self, FRONT_AGE, FRONTS};
use async_nats::jetstream::kv::{Operation, Store};
use async_nats::{HeaderMap, StatusCode};
use futures_util::StreamExt;
use parking_lot::Mutex;
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::timeout;
use uuid::Uuid;

/// Time between two beats.
const BEAT: Duration = FRONT_AGE.checked_div(3).expect("it is not 0");
/// A front is gone that has been silent for so many beats.
const SILENT: u64 = 4;
/// Bytes of an answer in one message, of which the broker takes 1 MiB.
const PART: usize = 512 << 10;
/// The header that says how many messages follow the first one of an answer.
const PARTS: &str = "Farm-Parts";

/// The fronts as this one sees them.
#[derive(Debug, Clone)]
pub(crate) struct Fronts {
    /// Who this one is: a new id for each process.
    pub(crate) id: String,
    broker: Broker,
    bucket: Store,
    beats: Arc<Mutex<Beats>>,
}

#[derive(Debug, Default)]
struct Beats {
    /// Own beats that have come back.
    own: u64,
    /// How many there were at the last beat of each front; none of one that has left.
    seen: HashMap<String, Option<u64>>,
}

impl Beats {
    fn is_alive(&self, front: &str) -> bool {
        match self.seen.get(front) {
            Some(None) => false,
            Some(Some(seen)) => self.own - seen < SILENT,
            // One that this front has never heard of has until then, too.
            None => self.own < SILENT,
        }
    }
}

impl Fronts {
    /// Joins them under a new id.
    pub(crate) async fn join(broker: &Broker) -> Result<Self, String> {
        let bucket = broker.stream.get_key_value(FRONTS).await.map_err(|error| reasons(&error))?;
        let id = Uuid::now_v7().simple().to_string();
        Ok(Self { id, broker: broker.clone(), bucket, beats: Arc::default() })
    }

    /// The time of the broker, in milliseconds since 1970.
    pub(crate) async fn time(&self) -> Result<u64, String> {
        self.beat().await?;
        let beat = self.bucket.entry(&self.id).await.map_err(|error| reasons(&error))?;
        let nanoseconds = beat.map_or(0, |beat| beat.created.unix_timestamp_nanos());
        Ok(u64::try_from(nanoseconds / 1_000_000).unwrap_or(0))
    }

    async fn beat(&self) -> Result<(), String> {
        self.bucket.put(&self.id, self.id.clone().into()).await.map(drop).map_err(|error| reasons(&error))
    }

    /// Says that this front is there, and calls `beaten` after each beat, for ever.
    pub(crate) async fn live(self, mut beaten: impl FnMut() + Send + 'static) {
        let beating = self.clone();
        tokio::spawn(async move {
            loop {
                if let Err(error) = beating.beat().await {
                    tracing::debug!(error, "the broker does not hear this front");
                }
                tokio::time::sleep(BEAT).await;
            }
        });
        loop {
            if let Err(error) = self.follow(&mut beaten).await {
                tracing::warn!(error, "the fronts cannot be watched; it is tried again");
            }
            tokio::time::sleep(RETRY_AFTER).await;
        }
    }

    async fn follow(&self, beaten: &mut (impl FnMut() + Send)) -> Result<(), String> {
        let mut watch = self.bucket.watch_with_history(">").await.map_err(|error| reasons(&error))?;
        while let Some(entry) = watch.next().await {
            let entry = entry.map_err(|error| reasons(&error))?;
            let is_own = entry.key == self.id;
            {
                let mut beats = self.beats.lock();
                beats.own += u64::from(is_own && entry.operation == Operation::Put);
                let now = (entry.operation == Operation::Put).then_some(beats.own);
                let own = beats.own;
                // Those that are gone are forgotten after a while: they have ids that nobody else gets.
                beats.seen.retain(|_, seen| seen.is_some_and(|seen| own - seen < 1_000));
                beats.seen.insert(entry.key, now);
            }
            beaten();
        }
        Err("the watch has ended".into())
    }

    /// Whether a front is there.
    pub(crate) fn is_alive(&self, front: &str) -> bool {
        front == self.id || self.beats.lock().is_alive(front)
    }

    /// Whether there is another front than this one and some others.
    pub(crate) fn has_other(&self, fronts: &[String]) -> bool {
        let beats = self.beats.lock();
        let is_other = |front: &&String| **front != self.id && !fronts.contains(front);
        beats.seen.keys().filter(is_other).any(|front| beats.is_alive(front))
    }

    /// This front ends: others need not wait for its beats.
    pub(crate) async fn leave(&self) {
        // If it fails they wait.
        let _ = timeout(BEAT, self.bucket.delete(&self.id)).await;
    }

    /// Asks another front. None if it does not answer in time.
    pub(crate) async fn ask(&self, front: &str, question: Vec<u8>, patience: Duration) -> Option<(Vec<u8>, Vec<u8>)> {
        timeout(patience, self.asked(front, question)).await.ok()?
    }

    async fn asked(&self, front: &str, question: Vec<u8>) -> Option<(Vec<u8>, Vec<u8>)> {
        let client = &self.broker.client;
        let inbox = client.new_inbox();
        let mut answers = client.subscribe(inbox.clone()).await.ok()?;
        client.publish_with_reply(names::front(front), inbox, question.into()).await.ok()?;
        let first = answers.next().await?;
        if first.status == Some(StatusCode::NO_RESPONDERS) {
            return None;
        }
        let parts: usize = first.headers.as_ref()?.get(PARTS)?.as_str().parse().ok()?;
        let mut body = Vec::new();
        for _ in 0..parts {
            body.extend_from_slice(&answers.next().await?.payload);
        }
        Some((first.payload.to_vec(), body))
    }

    /// Answers other fronts, for ever.
    pub(crate) async fn answer<A>(self, answer: impl Fn(Vec<u8>) -> A + Send + Sync + 'static)
    where
        A: Future<Output = (Vec<u8>, Vec<u8>)> + Send + 'static,
    {
        let answer = Arc::new(answer);
        loop {
            if let Ok(mut questions) = self.broker.client.subscribe(names::front(&self.id)).await {
                while let Some(question) = questions.next().await {
                    let Some(inbox) = question.reply else { continue };
                    let (client, answer) = (self.broker.client.clone(), Arc::clone(&answer));
                    tokio::spawn(async move {
                        let (head, body) = answer(question.payload.to_vec()).await;
                        let mut headers = HeaderMap::new();
                        headers.insert(PARTS, body.len().div_ceil(PART).to_string());
                        // Who has asked and hears nothing asks again.
                        let _ = client.publish_with_headers(inbox.clone(), headers, head.into()).await;
                        for part in body.chunks(PART) {
                            let _ = client.publish(inbox.clone(), part.to_vec().into()).await;
                        }
                    });
                }
            }
            tokio::time::sleep(RETRY_AFTER).await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_front_is_gone_after_four_own_beats_and_never_while_there_are_none() {
        let mut beats = Beats::default();
        beats.seen.insert("other".into(), Some(0));
        for own in 0..6 {
            beats.own = own;
            assert_eq!([beats.is_alive("other"), beats.is_alive("stranger")], [own < 4; 2]);
        }
        beats.seen.insert("other".into(), Some(5));
        assert!(beats.is_alive("other"));
        beats.seen.insert("other".into(), None);
        assert!(!beats.is_alive("other"), "it has left");
    }
}
