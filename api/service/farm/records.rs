//! Values that all fronts write: a bucket at the broker in which each write names the revision that it replaces. Each front
//! watches it once, so that it answers from memory.

use super::connection::{Broker, RETRY_AFTER, reasons};
use super::names::REMOVED_AGE;
use crate::service::error::not_reachable;
use crate::service::storage::revisions::Refused;
use async_nats::connection::State;
use async_nats::jetstream::kv::{CreateErrorKind, Operation, Store, UpdateError, UpdateErrorKind};
use futures_util::StreamExt;
use std::collections::HashSet;
use std::error::Error;
use std::io;
use std::time::Duration;
use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::time::timeout;

/// How long the broker may take for one value.
const ANSWER: Duration = Duration::from_secs(5);
/// How long what was written may take to come back.
const ECHO: Duration = Duration::from_secs(2);
/// Silence after which there is nothing more to be heard at first: what was left may have been removed meanwhile.
const SILENCE: Duration = Duration::from_secs(3);
/// Time between two looks whether there is a connection.
const LOOK: Duration = Duration::from_millis(20);

/// A bucket.
#[derive(Debug)]
pub(crate) struct Records {
    broker: Broker,
    bucket: Store,
    runtime: Handle,
    /// All revisions up to this one have been heard of.
    heard: watch::Sender<u64>,
}

/// What a front hears of a bucket.
#[derive(Debug)]
pub(crate) enum News<'a> {
    /// A value was written.
    Written {
        /// Its key.
        key: &'a str,
        /// The value.
        value: &'a [u8],
        /// Its revision.
        revision: u64,
    },
    /// A value was removed.
    Removed(&'a str),
    /// These are the keys of all that there is. What is not among them was removed.
    All(HashSet<String>),
}

impl Records {
    /// Opens a bucket that is there.
    pub(crate) async fn open(broker: &Broker, name: &str, runtime: &Handle) -> Result<Self, String> {
        let bucket = broker.stream.get_key_value(name).await.map_err(|error| reasons(&error))?;
        let (broker, runtime) = (broker.clone(), runtime.clone());
        Ok(Self { broker, bucket, runtime, heard: watch::Sender::new(0) })
    }

    /// Writes a value whose key no other write has; its revision. What fails is removed once the broker answers.
    pub(crate) fn create(&self, key: &str, value: Vec<u8>) -> Result<u64, Refused> {
        self.create_or_take_back(key, value, None)
    }

    /// The same for a key that others may write: only what is still this value is removed.
    pub(crate) fn claim(&self, key: &str, value: Vec<u8>) -> Result<u64, Refused> {
        self.create_or_take_back(key, value.clone(), Some(value))
    }

    fn create_or_take_back(&self, key: &str, value: Vec<u8>, only: Option<Vec<u8>>) -> Result<u64, Refused> {
        let written = self.wait(self.bucket.create(key, value.into())).map_err(Refused::Failed);
        let written = written.and_then(|written| {
            written.map_err(|error| match error.kind() {
                CreateErrorKind::AlreadyExists => Refused::Changed,
                _ => failed(&error),
            })
        });
        if matches!(written, Err(Refused::Failed(_))) {
            self.take_back(key.to_owned(), only);
        }
        written
    }

    /// Removes a value whose answer did not come in time, once the broker answers: its writer was told that there is none. A job may
    /// have begun by then, and ends.
    fn take_back(&self, key: String, only: Option<Vec<u8>>) {
        let (broker, bucket) = (self.broker.clone(), self.bucket.clone());
        self.runtime.spawn(async move {
            let mut looks = 0;
            // Twice: servers of a cluster may answer before they have what was written before.
            while looks < 2 {
                connected(&broker).await;
                match bucket.entry(&key).await {
                    Ok(Some(entry))
                        if entry.operation == Operation::Put
                            && only.as_ref().is_none_or(|only| entry.value == only) =>
                    {
                        let removed = bucket.purge_expect_revision_with_ttl(&key, entry.revision, REMOVED_AGE).await;
                        if removed.is_ok() {
                            tracing::warn!(key, "a write came late to the broker, and was taken back");
                        }
                    }
                    Ok(_) => looks += 1,
                    Err(_) => {}
                }
                tokio::time::sleep(RETRY_AFTER).await;
            }
        });
    }

    /// Writes a value instead of the one of a revision; its own revision.
    pub(crate) fn replace(&self, key: &str, value: Vec<u8>, revision: u64) -> Result<u64, Refused> {
        self.wait(self.bucket.update(key, value.into(), revision))?.map_err(refused)
    }

    /// A value as it is now, and its revision.
    pub(crate) fn get(&self, key: &str) -> io::Result<Option<(Vec<u8>, u64)>> {
        let found = self.wait(self.bucket.entry(key))?.map_err(|error| not_reachable(reasons(&error)))?;
        let there = found.filter(|entry| entry.operation == Operation::Put);
        Ok(there.map(|entry| (entry.value.to_vec(), entry.revision)))
    }

    /// Removes the value of a revision.
    pub(crate) fn remove(&self, key: &str, revision: u64) -> Result<(), Refused> {
        self.wait(self.bucket.purge_expect_revision_with_ttl(key, revision, REMOVED_AGE))?.map_err(refused)
    }

    /// Removes the value of a revision some time, if it is still there.
    pub(crate) fn drop_later(&self, key: String, revision: u64) {
        let bucket = self.bucket.clone();
        self.runtime.spawn(async move {
            // If it fails the value goes when it is old.
            let _ = bucket.delete_expect_revision(key, Some(revision)).await;
        });
    }

    fn wait<T>(&self, work: impl Future<Output = T>) -> io::Result<T> {
        let silent = || not_reachable("the broker does not answer");
        // What is asked for while there is no connection would be sent with the next one, long after its caller has been refused.
        let work = async {
            connected(&self.broker).await;
            work.await
        };
        self.runtime.block_on(async { timeout(ANSWER, work).await }).map_err(|_| silent())
    }

    /// Waits until all revisions up to one have been heard of, for a while.
    pub(crate) fn wait_for(&self, revision: u64) {
        self.runtime.block_on(self.wait_until(revision));
    }

    /// Whether a revision was heard of in time. Who was not told answers with what it knows.
    async fn wait_until(&self, revision: u64) -> bool {
        let mut heard = self.heard.subscribe();
        let come = heard.wait_for(|heard| *heard >= revision);
        matches!(timeout(ECHO, come).await, Ok(Ok(_)))
    }

    /// Waits until all that was written before has been heard of, for a while; whether it has.
    pub(crate) async fn catch_up(&self) -> bool {
        match timeout(ECHO, self.bucket.stream.get_info()).await {
            Ok(Ok(info)) => self.wait_until(info.state.last_sequence).await,
            _ => false,
        }
    }

    /// The same on a thread that is none of a runtime.
    pub(crate) fn catch_up_here(&self) -> bool {
        self.runtime.block_on(self.catch_up())
    }

    /// Hears of all that there is, and then of each change, for ever.
    pub(crate) async fn follow(&self, mut hear: impl FnMut(News<'_>) + Send) {
        loop {
            if let Err(error) = self.follow_once(&mut hear).await {
                tracing::warn!(error, bucket = self.bucket.name, "a bucket cannot be watched; it is tried again");
            }
            tokio::time::sleep(RETRY_AFTER).await;
        }
    }

    async fn follow_once(&self, hear: &mut (impl FnMut(News<'_>) + Send)) -> Result<(), String> {
        let text = |error: &dyn Error| error.to_string();
        let state = self.bucket.stream.get_info().await.map_err(|error| text(&error))?.state;
        let mut news = self.bucket.watch_with_history(">").await.map_err(|error| text(&error))?;
        let mut all = Some(HashSet::new());
        if state.messages == 0 {
            hear(News::All(all.take().unwrap_or_default()));
            self.hear_up_to(state.last_sequence);
        }
        loop {
            let next = match &mut all {
                None => news.next().await,
                Some(keys) => match timeout(SILENCE, news.next()).await {
                    Ok(next) => next,
                    Err(_) => {
                        hear(News::All(std::mem::take(keys)));
                        all = None;
                        self.hear_up_to(state.last_sequence);
                        continue;
                    }
                },
            };
            let Some(entry) = next else { return Err("the watch has ended".into()) };
            let entry = entry.map_err(|error| text(&error))?;
            match entry.operation {
                Operation::Put => {
                    if let Some(keys) = &mut all {
                        keys.insert(entry.key.clone());
                    }
                    hear(News::Written { key: &entry.key, value: &entry.value, revision: entry.revision });
                }
                Operation::Delete | Operation::Purge => hear(News::Removed(&entry.key)),
            }
            if entry.seen_current
                && let Some(keys) = all.take()
            {
                hear(News::All(keys));
                self.hear_up_to(state.last_sequence);
            }
            if all.is_none() {
                self.hear_up_to(entry.revision);
            }
        }
    }

    fn hear_up_to(&self, revision: u64) {
        self.heard.send_modify(|heard| *heard = revision.max(*heard));
    }
}

/// Waits until there is a connection.
async fn connected(broker: &Broker) {
    while broker.client.connection_state() != State::Connected {
        tokio::time::sleep(LOOK).await;
    }
}

fn refused(error: UpdateError) -> Refused {
    if error.kind() == UpdateErrorKind::WrongLastRevision { Refused::Changed } else { failed(&error) }
}

fn failed(error: &(dyn Error + 'static)) -> Refused {
    Refused::Failed(not_reachable(reasons(error)))
}
