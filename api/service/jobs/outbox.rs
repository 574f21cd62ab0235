//! What is delivered after the end of a job: its picture to the store, and a message about it to a receiver.
//!
//! The state of both is part of the job's record, so that it outlives what the job outlives. The record that says how a job
//! ended also says that there is something to deliver: no end of the process comes between the two. In a farm the front whose
//! name is in the record makes the attempt; if it is gone another one does.

use super::Jobs;
use super::job::Job;
use super::record::{Record, State, now};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::io;
use std::sync::Arc;

/// What is delivered after a job.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Outbox {
    /// Its picture, to a name in the store.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) store: Option<Delivery>,
    /// A message, to a URL.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) webhook: Option<Delivery>,
}

/// One delivery.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Delivery {
    /// The name or the URL.
    pub(crate) to: String,
    /// How far it is.
    pub(crate) state: DeliveryState,
    /// Attempts so far.
    #[serde(default)]
    pub(crate) attempts: u32,
    /// When it is tried next, in milliseconds since 1970.
    #[serde(default)]
    pub(crate) next: u64,
    /// When it was delivered or given up.
    #[serde(default)]
    pub(crate) ended: Option<u64>,
    /// Why the last attempt failed.
    #[serde(default)]
    pub(crate) error: Option<String>,
    /// The message, from before its first attempt to its end: all attempts send the same one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) message: Option<String>,
    /// In a farm: the front that makes an attempt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) front: Option<String>,
}

/// How far a delivery is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum DeliveryState {
    /// The job has not ended, or the next attempt is still to come.
    #[default]
    Pending,
    /// It has arrived.
    Delivered,
    /// It was given up; `error` says why.
    Dead,
}

/// The two deliveries of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DeliveryKind {
    /// Of its picture.
    Picture,
    /// Of the message.
    Message,
}

impl DeliveryKind {
    /// What is delivered, in a word.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Picture => "picture",
            Self::Message => "message",
        }
    }
}

impl Delivery {
    /// A delivery that is to be made.
    pub(crate) fn to(place: String) -> Self {
        Self { to: place, ..Self::default() }
    }

    /// It has arrived, or was given up.
    pub(crate) fn end(&mut self, state: DeliveryState, error: Option<String>) {
        (self.state, self.error, self.ended, self.message) = (state, error, Some(now()), None);
    }

    fn is_pending(&self) -> bool {
        self.state == DeliveryState::Pending
    }
}

impl Outbox {
    /// One of the two, if the job has it.
    pub(crate) fn delivery(&mut self, kind: DeliveryKind) -> Option<&mut Delivery> {
        match kind {
            DeliveryKind::Picture => self.store.as_mut(),
            DeliveryKind::Message => self.webhook.as_mut(),
        }
    }
}

impl Record {
    /// What is delivered next, if anything is: the message after the picture, as it says where that is.
    pub(crate) fn next_delivery(&self) -> Option<(DeliveryKind, &Delivery)> {
        let Outbox { store, webhook } = &self.outbox;
        let has_picture = matches!(self.state, State::Succeeded | State::Expired);
        let picture = store.as_ref().filter(|_| has_picture).map(|delivery| (DeliveryKind::Picture, delivery));
        let message =
            webhook.as_ref().filter(|_| self.state.is_final()).map(|delivery| (DeliveryKind::Message, delivery));
        [picture, message].into_iter().flatten().find(|(_, delivery)| delivery.is_pending())
    }
}

impl Jobs {
    /// Jobs that have ended and have something to deliver, which no other front is about.
    pub(crate) fn outgoing(&self) -> Vec<Arc<Job>> {
        let registry = self.registry.lock();
        let is_free =
            |job: &&Arc<Job>| job.record().next_delivery().is_some_and(|(_, delivery)| self.is_free(delivery));
        registry.outgoing.iter().filter_map(|id| registry.jobs.get(id)).filter(is_free).map(Arc::clone).collect()
    }

    /// Waits until a job has something to deliver that was not among them before.
    pub(crate) async fn until_outgoing(&self) {
        self.bell.notified().await;
    }

    /// Makes this process the one that makes an attempt that is due, and writes its message down. False if another one does, or
    /// has done so.
    pub(crate) fn begin_delivery(&self, job: &Arc<Job>, kind: DeliveryKind, message: Option<&str>) -> io::Result<bool> {
        let front = self.records.front();
        if front.is_none() && message.is_none() {
            return Ok(true);
        }
        self.change(job, |record| {
            let is_due = |delivery: &Delivery| delivery.next <= now() && self.is_free(delivery);
            if record.next_delivery().is_none_or(|(next, delivery)| next != kind || !is_due(delivery)) {
                return false;
            }
            let Some(delivery) = record.outbox.delivery(kind) else { return false };
            delivery.front = front.map(str::to_owned);
            // Another front may have sent it before.
            delivery.message = delivery.message.take().or_else(|| message.map(str::to_owned));
            true
        })
    }

    /// Changes the state of a delivery after an attempt, which is written down when this returns. What another front is about,
    /// since it has not heard of this one for long, is left to it.
    pub(crate) fn end_attempt(
        &self,
        job: &Arc<Job>,
        kind: DeliveryKind,
        change: impl Fn(&mut Delivery),
    ) -> io::Result<()> {
        let changed = self.change(job, |record| {
            let is_mine =
                |delivery: &&mut Delivery| delivery.is_pending() && delivery.front.as_deref() == self.records.front();
            let Some(delivery) = record.outbox.delivery(kind).filter(is_mine) else { return false };
            delivery.front = None;
            change(delivery);
            true
        });
        if changed? {
            let state = job.record().outbox.delivery(kind).map_or(DeliveryState::Dead, |delivery| delivery.state);
            self.observer.attempted(kind, state);
        }
        Ok(())
    }

    /// Whether no other front makes an attempt.
    fn is_free(&self, delivery: &Delivery) -> bool {
        let is_other = |front: &str| Some(front) != self.records.front() && self.records.is_alive(front);
        !delivery.front.as_deref().is_some_and(is_other)
    }
}
