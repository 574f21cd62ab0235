//! Delivers what jobs leave behind: their pictures to the store, and messages about them to webhooks.
//!
//! What is to be delivered is in the records of jobs (`service/jobs/outbox.rs`), so that a process that ends loses none of it. A
//! message is written down before it is first sent, and all its attempts send the same text under the same id: a receiver that has
//! seen the id has seen the message. Each front of a farm has a delivery worker; the one whose write of the record comes first makes the
//! attempt.

pub(crate) mod key;
pub(crate) mod receiver;
pub(crate) mod signature;

use super::concurrency_limit::ConcurrencyLimit;
use super::jobs::outbox::{Delivery, DeliveryKind, DeliveryState};
use super::jobs::record::now;
use super::jobs::{Job, Jobs};
use super::limits::DeliverySettings;
use super::storage::objects::{ObjectError, Objects};
use key::FRAME;
use parking_lot::Mutex;
use receiver::{Message, Receivers, Refusal};
use sha2::{Digest, Sha256};
use signature::Secret;
use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;
use std::{fmt, io};
use tokio::sync::Notify;
use tokio::task::spawn_blocking;
use tokio::time::sleep;

/// Deliveries at one time, of all tenants.
const ALL: u32 = 64;
/// Time between two looks at what is to be delivered: jobs that end together are looked at together.
const BETWEEN_LOOKS: Duration = Duration::from_millis(20);
/// Longest time between them.
const LONGEST: Duration = Duration::from_secs(60);
/// Time until what came of an attempt is written down again, while it cannot be. Until then nothing is sent in its place.
const BETWEEN_WRITES: Duration = Duration::from_secs(1);
/// Digits of a frame's number.
const DIGITS: usize = 4;
/// Longest time between two attempts.
const LONGEST_WAIT: Duration = Duration::from_secs(3_600);

/// What the messages say, and who signs them.
pub(crate) trait MessageWriter: Send + Sync {
    /// The message about a job that has ended, as JSON.
    fn message(&self, job: &Arc<Job>) -> String;
    /// The secret that a tenant shares with its receiver.
    fn secret(&self, tenant: &str) -> Option<Secret>;
}

/// Delivers.
pub(crate) struct DeliveryWorker {
    jobs: Arc<Jobs>,
    store: Option<Objects>,
    receivers: Receivers,
    writer: Arc<dyn MessageWriter>,
    settings: DeliverySettings,
    places: ConcurrencyLimit<String>,
    /// Rings when a delivery has ended and leaves its place.
    free: Notify,
    /// Jobs whose delivery is on its way.
    under_way: Mutex<HashSet<String>>,
}

impl fmt::Debug for DeliveryWorker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DeliveryWorker")
            .field("store", &self.store)
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

impl DeliveryWorker {
    /// Delivers what these jobs leave behind.
    pub(crate) fn new(
        jobs: Arc<Jobs>,
        store: Option<Objects>,
        receivers: Receivers,
        writer: Arc<dyn MessageWriter>,
        settings: DeliverySettings,
    ) -> Arc<Self> {
        let (places, free, under_way) = (ConcurrencyLimit::default(), Notify::new(), Mutex::default());
        Arc::new(Self { jobs, store, receivers, writer, settings, places, free, under_way })
    }

    /// Works until it is dropped.
    pub(crate) async fn run(self: Arc<Self>) {
        loop {
            let next = self.look();
            tokio::select! {
                () = self.jobs.until_outgoing() => {}
                () = self.free.notified() => {}
                () = sleep(next) => {}
            }
            sleep(BETWEEN_LOOKS).await;
        }
    }

    /// Begins what is due and has a place; how long nothing else will be.
    fn look(self: &Arc<Self>) -> Duration {
        let (now, mut next) = (now(), LONGEST);
        for job in self.jobs.outgoing() {
            let (id, tenant, due) = {
                let record = job.record();
                let Some((_, delivery)) = record.next_delivery() else { continue };
                (record.id.clone(), record.tenant.clone(), delivery.next)
            };
            if due > now {
                next = next.min(Duration::from_millis(due - now));
                continue;
            }
            if self.places.taken() >= u64::from(ALL) || self.under_way.lock().contains(&id) {
                continue;
            }
            let Some(place) = self.places.enter(tenant, self.settings.webhook_parallel) else { continue };
            self.under_way.lock().insert(id.clone());
            let delivery_worker = Arc::clone(self);
            tokio::spawn(async move {
                delivery_worker.deliver(&job).await;
                delivery_worker.under_way.lock().remove(&id);
                drop(place);
                delivery_worker.free.notify_one();
            });
        }
        next
    }

    /// One attempt, and what came of it on disk.
    async fn deliver(&self, job: &Arc<Job>) {
        let Some(kind) = job.record().next_delivery().map(|(kind, _)| kind) else { return };
        if !self.begin(job, kind).await {
            return;
        }
        let (id, attempts) = {
            let mut record = job.record();
            let attempts = record.outbox.delivery(kind).map_or(0, |delivery| delivery.attempts);
            (record.id.clone(), attempts + 1)
        };
        let done = match kind {
            DeliveryKind::Picture => self.put_pictures(job).await,
            DeliveryKind::Message => self.send_message(job).await,
        };
        let what = kind.name();
        let pause = pause(self.settings.webhook_retry, &id, attempts);
        let (state, error, wait) = match done {
            Ok(()) => (DeliveryState::Delivered, None, pause),
            Err(Refusal::Later(why, wait)) if attempts < self.settings.webhook_attempts => {
                tracing::info!(job = id, attempts, why, "a {what} was not delivered and is tried again");
                (DeliveryState::Pending, Some(why), wait.max(pause))
            }
            Err(Refusal::Later(why, _) | Refusal::Never(why)) => {
                tracing::warn!(job = id, attempts, why, "a {what} is not delivered");
                (DeliveryState::Dead, Some(why), pause)
            }
        };
        let next = now() + u64::try_from(wait.as_millis()).unwrap_or(u64::MAX);
        let change = move |delivery: &mut Delivery| {
            delivery.attempts = attempts;
            match state {
                DeliveryState::Pending => (delivery.next, delivery.error) = (next, error.clone()),
                state => delivery.end(state, error.clone()),
            }
        };
        let end = |change| self.record(job, move |jobs, job| jobs.end_attempt(job, kind, change));
        while let Err(error) = end(change.clone()).await {
            tracing::error!(job = id, %error, "the state of a delivery cannot be written");
            sleep(BETWEEN_WRITES).await;
        }
    }

    /// Writes to the record of a job, on a thread that may wait for the disk or the broker. Each delivery has one at a time.
    async fn record<T: Send + 'static>(
        &self,
        job: &Arc<Job>,
        write: impl FnOnce(&Jobs, &Arc<Job>) -> io::Result<T> + Send + 'static,
    ) -> io::Result<T> {
        let (jobs, job) = (Arc::clone(&self.jobs), Arc::clone(job));
        spawn_blocking(move || write(&jobs, &job)).await.unwrap_or_else(|lost| Err(io::Error::other(lost)))
    }

    /// Whether this process makes an attempt. Its message is written down then.
    async fn begin(&self, job: &Arc<Job>, kind: DeliveryKind) -> bool {
        let is_written = job.record().outbox.webhook.as_ref().is_some_and(|webhook| webhook.message.is_some());
        let message = (kind == DeliveryKind::Message && !is_written).then(|| self.writer.message(job));
        match self.record(job, move |jobs, job| jobs.begin_delivery(job, kind, message.as_deref())).await {
            Ok(begun) => begun,
            Err(error) => {
                tracing::error!(job = job.record().id, %error, "the state of a delivery cannot be written");
                sleep(BETWEEN_WRITES).await;
                false
            }
        }
    }

    async fn send_message(&self, job: &Arc<Job>) -> Result<(), Refusal> {
        let (id, tenant, webhook) = {
            let record = job.record();
            (record.id.clone(), record.tenant.clone(), record.outbox.webhook.clone().unwrap_or_default())
        };
        let secret = self.writer.secret(&tenant).ok_or_else(|| {
            Refusal::Later("there is no secret any more to sign the message with".into(), Duration::ZERO)
        })?;
        let body = webhook.message.unwrap_or_default();
        tracing::info!(job = id, "a message is sent");
        self.receivers.send(&webhook.to, &Message { id: &format!("msg_{id}"), body: &body, secret: &secret }).await
    }

    /// Puts the picture into the store, or all frames of a sequence.
    async fn put_pictures(&self, job: &Arc<Job>) -> Result<(), Refusal> {
        let (name, frames) = {
            let record = job.record();
            (record.outbox.store.clone().unwrap_or_default().to, record.frames)
        };
        let Some(frames) = frames else { return self.put_picture(job, &name, None).await };
        for number in 0..frames.count {
            let name = name.replace(FRAME, &format!("{number:0DIGITS$}"));
            self.put_picture(job, &name, Some(number)).await?;
        }
        Ok(())
    }

    /// Puts the report into the store, and then the picture: who sees the picture finds the report.
    async fn put_picture(&self, job: &Arc<Job>, name: &str, frame: Option<u32>) -> Result<(), Refusal> {
        let never = |why: &str| Refusal::Never(why.to_owned());
        let store = self.store.as_ref().ok_or_else(|| never("the service has no --store any more"))?;
        let (jobs, of) = (Arc::clone(&self.jobs), Arc::clone(job));
        let find = move || frame.map_or_else(|| jobs.picture(&of), |number| jobs.frame(&of, number));
        let busy = || Refusal::Later("the service cannot read the picture now".into(), Duration::ZERO);
        let file = spawn_blocking(find).await.map_err(|_| busy())?.map_err(|_| busy())?;
        let file = file.ok_or_else(|| never("the picture is gone from the service"))?;
        if let Some(report) = &file.meta.report {
            store.put(&report_of(name), report.get().as_bytes().to_vec()).await.map_err(refusal)?;
        }
        store.put(name, file.bytes).await.map_err(refusal)
    }
}

/// The name of a picture's report in the store.
pub(crate) fn report_of(name: &str) -> String {
    format!("{name}.json")
}

fn refusal(error: ObjectError) -> Refusal {
    match error {
        ObjectError::Store(why) => Refusal::Later(why, Duration::ZERO),
        error => Refusal::Never(error.to_string()),
    }
}

/// The pause after so many attempts: four times as long each time, less up to half of it, by the job's id. So messages that failed
/// together are not sent again together.
fn pause(first: Duration, id: &str, attempts: u32) -> Duration {
    let longest = first.saturating_mul(4_u32.saturating_pow(attempts - 1)).min(LONGEST_WAIT);
    let digest = Sha256::digest(format!("{id} {attempts}"));
    let share = 0.5 + 0.5 * f64::from(digest[0]) / 255.0;
    longest.mul_f64(share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_grow_to_an_hour_and_differ_from_job_to_job() {
        let first = Duration::from_secs(5);
        for attempts in 1..100 {
            let longest = (5.0 * 4_f64.powi(attempts as i32 - 1)).min(3_600.0);
            let pauses: Vec<_> = (0..50).map(|i| pause(first, &format!("job {i}"), attempts).as_secs_f64()).collect();
            assert!(pauses.iter().all(|pause| (0.5 * longest..=longest).contains(pause)), "{attempts}: {pauses:?}");
            let (least, most) = pauses.iter().fold((f64::MAX, 0.0_f64), |(a, b), p| (a.min(*p), b.max(*p)));
            assert!(most - least > 0.3 * longest, "{attempts}: {pauses:?}");
        }
        assert_eq!(pause(first, "a", 3), pause(first, "a", 3));
    }
}
