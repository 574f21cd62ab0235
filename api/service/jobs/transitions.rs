//! What becomes of a job: this process takes it, lets it go, or ends it, and others may do the same. A change counts once it is
//! written where records live, and is written against the record as it was.

use super::event_log::{Event, before_life};
use super::job::{Job, Stopped};
use super::outbox::DeliveryState;
use super::record::{Failure, Record, State, now};
use super::{CRASHES, Jobs};
use crate::service::clock::milliseconds;
use crate::service::error::is_temporary;
use crate::service::storage::revisions::Refused;
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

/// How often a record is changed again after another front has changed it first.
const TRIES: u32 = 100;
/// Time for a front with more memory to come, if there is none.
const FOR_A_LARGER_FRONT: Duration = Duration::from_secs(60);
/// Time until the end of a job is written again, while it cannot be.
const BETWEEN_WRITES: Duration = Duration::from_secs(1);

impl Jobs {
    /// Changes a record where records live, and then here. False if `change` says that it does not apply: it is asked again when
    /// another front has changed the record.
    pub(super) fn change(&self, job: &Arc<Job>, change: impl Fn(&mut Record) -> bool) -> io::Result<bool> {
        let _turn = job.changing.lock();
        for _ in 0..TRIES {
            let (mut record, revision) = job.stored();
            if !change(&mut record) {
                return Ok(false);
            }
            // The record of a forgotten job is gone.
            let is_gone = job.forgotten.load(Ordering::SeqCst);
            match if is_gone { Ok(revision + 1) } else { self.records.replace(&record, revision) } {
                Ok(revision) => {
                    self.adopt(job, record, revision);
                    return Ok(true);
                }
                Err(Refused::Changed) => match self.records.current(&record)? {
                    Some((current, revision)) => self.adopt(job, current, revision),
                    None => {
                        self.vanished(&record.id);
                        return Ok(false);
                    }
                },
                Err(Refused::Failed(error)) => return Err(error),
            }
        }
        Err(Refused::Changed.into())
    }

    /// Takes over a record that was written, here or elsewhere.
    pub(super) fn adopt(&self, job: &Arc<Job>, record: Record, revision: u64) {
        let mut registry = self.registry.lock();
        let Some(before) = job.adopt(record, revision) else { return };
        registry.follow(job, &before, &self.files);
        let record = job.record().clone();
        if registry.is_open(job) && (record.state.is_final() || !self.is_mine(&record)) {
            job.stop(Stopped::Taken);
        }
        drop(registry);
        if record.lives != before.lives {
            job.events.begin(record.lives);
        }
        if record.state.is_final() {
            *job.left.lock() = Some(Instant::now());
        }
        job.events.ring();
        if record.next_delivery().is_some() {
            self.bell.notify_one();
        }
    }

    /// Whether this process works on a job, or nobody does where no other could.
    pub(super) fn is_mine(&self, record: &Record) -> bool {
        record.front.as_deref() == self.records.front()
    }

    /// Makes this process the one that works on a job. False if another does, or the job has ended.
    pub(super) fn begin(&self, job: &Arc<Job>) -> io::Result<bool> {
        let done = job.done.load(Ordering::Relaxed) as u64;
        let front = self.records.front();
        let change = |record: &mut Record| {
            // An answer of the broker may have been lost: then this front has it already.
            let is_other = |owner: &str| Some(owner) != front && self.records.is_alive(owner);
            if record.state.is_final() || record.front.as_deref().is_some_and(is_other) {
                return false;
            }
            if let Some(front) = front {
                if record.state == State::Running && record.front.as_deref() != Some(front) {
                    record.count_crash(done);
                }
                record.front = Some(front.to_owned());
                record.lives += 1;
                // If this one goes, too, another one is waited for again.
                if !record.refused.iter().any(|refused| refused == front) {
                    record.refused_at = None;
                }
            }
            record.state = State::Running;
            if record.started.is_none() {
                let started = now();
                record.started = Some(started);
                record.stats.queue_ms = started.saturating_sub(record.created) as f64;
            }
            true
        };
        let is_mine = loop {
            match self.change(job, change) {
                Err(error) if (front.is_some() || is_temporary(&error)) && !job.control().is_cancelled() => {
                    tracing::error!(job = job.record().id, %error, "a record cannot be written");
                    job.waits.store(true, Ordering::Relaxed);
                    thread::sleep(BETWEEN_WRITES);
                }
                done => break done?,
            }
        };
        job.waits.store(false, Ordering::Relaxed);
        if let (Some(_), true) = (front, is_mine) {
            let record = job.record();
            tracing::info!(job = record.id, life = record.lives, "this front begins");
        }
        Ok(is_mine)
    }

    /// Lets another process go on with a job: what is kept of it suffices. It waits again, since this end of the process is not
    /// the job's fault.
    pub(super) fn suspend(&self, job: &Arc<Job>) {
        let suspended = self.change(job, |record| {
            let is_mine = self.is_mine(record) && !record.state.is_final();
            (record.state, record.front) = (State::Queued, None);
            is_mine
        });
        if let Err(error) = suspended {
            tracing::error!(%error, "a record cannot be written");
        }
    }

    /// Lets a front with more memory go on with a job. False if there is none that has not refused it, too, and none has come for
    /// some time: a larger one may only be starting again.
    pub(super) fn pass_on(&self, job: &Arc<Job>) -> bool {
        let Some(front) = self.records.front() else { return false };
        let change = |record: &mut Record| {
            if !self.is_mine(record) || record.state.is_final() {
                return false;
            }
            if !record.refused.iter().any(|refused| refused == front) {
                record.refused.push(front.to_owned());
            }
            record.refused_at.get_or_insert_with(now);
            (record.state, record.front) = (State::Queued, None);
            self.is_for_others(record)
        };
        loop {
            match self.change(job, change) {
                Ok(true) => {
                    let job = &job.record().id;
                    tracing::warn!(job, "this front has too little memory for a job, and leaves it to others");
                    return true;
                }
                Ok(false) => return false,
                Err(error) if job.control().is_cancelled() => {
                    tracing::error!(%error, "a record cannot be written");
                    return false;
                }
                Err(error) => tracing::error!(%error, "a record cannot be written"),
            }
            thread::sleep(BETWEEN_WRITES);
        }
    }

    /// Whether a job is left to other fronts, since this one has too little memory for it.
    pub(super) fn is_for_others(&self, record: &Record) -> bool {
        let is_refused = |front: &str| record.refused.iter().any(|refused| refused == front);
        let is_new =
            || record.refused_at.is_some_and(|at| now().saturating_sub(at) < FOR_A_LARGER_FRONT.as_millis() as u64);
        self.records.front().is_some_and(is_refused) && (self.records.has_other(&record.refused) || is_new())
    }

    /// Writes the final state of a job that this process works on, and tells observer and watchers. It counts only if no other
    /// front has taken the job. False if it has not been written.
    pub(super) fn finish(&self, job: &Arc<Job>, state: State, failure: Option<Failure>) -> bool {
        let change = |record: &mut Record| {
            let is_mine = self.is_mine(record) && !record.state.is_final();
            self.end_record(job, record, state, failure.clone());
            is_mine
        };
        let life = job.record().lives;
        let has_ended_in = |life: u64| {
            let record = job.record();
            record.lives == life && record.state.is_final()
        };
        let mut is_doubtful = false;
        loop {
            let error = match self.change(job, change) {
                Ok(true) => break,
                // It was written, and only the answer was lost.
                Ok(false) if is_doubtful && has_ended_in(life) => break,
                Ok(false) => {
                    tracing::info!(job = job.record().id, "a job was taken by another front");
                    return false;
                }
                Err(error) => error,
            };
            tracing::error!(job = job.record().id, %error, "a record cannot be written");
            is_doubtful = true;
            if self.records.front().is_none() && !is_temporary(&error) {
                // It has ended all the same, until the service is started again.
                let (mut record, revision) = job.stored();
                change(&mut record);
                self.adopt(job, record, revision + 1);
                break;
            }
            if self.registry.lock().closing {
                return false;
            }
            job.waits.store(true, Ordering::Relaxed);
            thread::sleep(BETWEEN_WRITES);
        }
        job.waits.store(false, Ordering::Relaxed);
        self.ended(job);
        true
    }

    /// Ends a job that this process does not work on. False if it has ended already.
    pub(super) fn end(&self, job: &Arc<Job>, state: State) -> io::Result<bool> {
        let has_ended = self.change(job, |record| {
            let goes_on = !record.state.is_final();
            self.end_record(job, record, state, None);
            goes_on
        })?;
        if has_ended {
            self.ended(job);
        }
        Ok(has_ended)
    }

    /// The final record of a job.
    fn end_record(&self, job: &Job, record: &mut Record, state: State, failure: Option<Failure>) {
        let last = if self.is_mine(record) {
            job.events.last()
        } else {
            // Another front may be about to publish events: those of a later life come after all of them.
            record.lives += 1;
            before_life(record.lives)
        };
        record.state = state;
        record.finished = Some(now());
        record.ended = Some(self.records.time());
        record.failure = failure;
        record.last_event = Some(last + 1);
        record.stats.rays = record.stats.rays.max(job.rays.load(Ordering::Relaxed));
        let leaves_files = state != State::Succeeded;
        if let Some(store) = record.outbox.store.as_mut().filter(|_| leaves_files) {
            store.end(DeliveryState::Dead, Some("the job has no picture".into()));
        }
        record.front = self.records.front().filter(|_| leaves_files).map(str::to_owned);
    }

    /// A job has been ended by this process.
    pub(super) fn ended(&self, job: &Job) {
        let record = job.record().clone();
        self.files.remove_tiles_of(std::slice::from_ref(&record.id));
        if let Some(farm) = &self.farm {
            farm.forget_results(&record.id);
        }
        if let (false, Some(begun)) = (record.state == State::Succeeded, *job.begun.lock()) {
            self.canceled.fetch_add(milliseconds(begun) as u64, Ordering::Relaxed);
        }
        self.observer.ended(&record, record.state);
        tracing::info!(job = record.id, state = record.state.name(), "a job has ended");
        job.events.hear(end_of(&record, record.last_event.unwrap_or_default()));
    }
}

/// The last event of a job, and its number. Every front makes it from the record.
pub(crate) fn end_of(record: &Record, seq: u64) -> Event {
    let data = serde_json::json!({ "stats": record.stats, "failure": record.failure });
    // It had succeeded before it expired.
    let state = if record.state == State::Expired { State::Succeeded } else { record.state };
    Event { seq, name: state.name(), data }
}

/// Why a job is given up that no process gets on with.
pub(super) fn abandoned() -> Failure {
    let detail = format!("the service ended {} times while it rendered this job, without a new tile", CRASHES + 1);
    Failure { slug: "abandoned".into(), detail }
}
