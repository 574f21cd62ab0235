//! What this front hears of the jobs of a farm: their records as any front writes them, the events of those that other fronts
//! work on, and which fronts are there. So it answers for all of them, and goes on with those of a front that is gone.

use super::event_log::Event;
use super::files::Files;
use super::job::Job;
use super::record::{Record, State};
use super::registry::Registry;
use super::shared::Shared;
use super::transitions::end_of;
use super::{JobObserver, Jobs};
use crate::service::error::StartError;
use crate::service::farm::Farm;
use crate::service::farm::events::{self, SentEvent};
use crate::service::farm::records::News;
use crate::service::limits::JobLimits;
use crate::service::scenes::cache::SceneCache;
use crate::service::scheduler::pool::Pool;
use crate::service::storage::folder::Folder;
use serde_json::Value;
use std::collections::HashSet;
use std::sync::atomic::Ordering;
use std::sync::{Arc, mpsc};
use std::time::Duration;

/// How long a front waits at its start for all records.
const FIRST_WAIT: Duration = Duration::from_secs(60);
/// Time until the end of a job is told without the events that lead to it, if they have not come by then.
const LATE: Duration = Duration::from_secs(1);
/// Names of events that other fronts tell of. How a job ended is in its record.
const NAMES: [&str; 5] = ["started", "preview", "tile", "progress", "frame"];

impl Jobs {
    /// Joins the fronts of a farm. Only what this one renders itself is in the folder meanwhile.
    pub(super) fn join(
        folder: &mut Folder,
        limits: JobLimits,
        pool: Arc<Pool>,
        cache: Arc<SceneCache>,
        farm: Arc<Farm>,
        observer: Arc<dyn JobObserver>,
    ) -> Result<Arc<Self>, StartError> {
        let unusable = |error: String| StartError::Machine(format!("the farm's jobs cannot be read: {error}"));
        let files = Files::shared(&farm, &folder.path).map_err(|error| unusable(error.to_string()))?;
        folder.mark()?;
        let shared = Arc::new(Shared::open(&farm).map_err(unusable)?);
        let registry = Registry { loading: true, ..Registry::default() };
        let (broker, runtime) = (farm.broker.clone(), farm.runtime.clone());
        let records = Box::new(Arc::clone(&shared));
        let jobs =
            Self::new(pool, cache, Some(farm), observer, records, Some(Arc::clone(&shared)), files, limits, registry);
        let jobs = Arc::new(jobs);
        let (all, all_heard) = mpsc::sync_channel(1);
        runtime.spawn({
            let (jobs, shared) = (Arc::clone(&jobs), Arc::clone(&shared));
            async move {
                let hear = |news: News<'_>| {
                    let is_all = matches!(news, News::All(_));
                    jobs.hear(news);
                    if is_all {
                        // Nobody waits for the second one.
                        let _ = all.try_send(());
                    }
                };
                shared.records.follow(hear).await;
            }
        });
        let come = all_heard.recv_timeout(FIRST_WAIT);
        come.map_err(|_| unusable("the broker does not send them".into()))?;
        runtime.spawn({
            let jobs = Arc::clone(&jobs);
            events::follow(broker, move |job, event| jobs.hear_event(job, event))
        });
        runtime.spawn({
            let (jobs, fronts) = (Arc::clone(&jobs), shared.fronts.clone());
            fronts.clone().live(move || {
                jobs.registry.lock().line_up_orphans(|front| fronts.is_alive(front));
                jobs.open_next();
                // A front that is gone may have been about to deliver something.
                jobs.bell.notify_one();
            })
        });
        Ok(jobs)
    }

    /// Waits until this front knows what others have told before, for a while.
    pub(crate) async fn catch_up(&self) -> bool {
        match &self.shared {
            Some(shared) => shared.records.catch_up().await,
            None => true,
        }
    }

    /// The front that works on a job, if it is another one.
    pub(crate) fn front_of(&self, job: &Arc<Job>) -> Option<String> {
        let record = job.record();
        let front = record.front.as_ref().filter(|_| record.state == State::Running)?;
        (Some(front.as_str()) != self.records.front() && self.records.is_alive(front)).then(|| front.clone())
    }

    /// Asks another front. None if it does not answer in time.
    pub(crate) async fn ask_front(
        &self,
        front: &str,
        question: Vec<u8>,
        patience: Duration,
    ) -> Option<(Vec<u8>, Vec<u8>)> {
        self.shared.as_ref()?.fronts.ask(front, question, patience).await
    }

    /// Answers other fronts, as long as it is polled.
    pub(crate) async fn answer_fronts<A>(&self, answer: impl Fn(Vec<u8>) -> A + Send + Sync + 'static)
    where
        A: Future<Output = (Vec<u8>, Vec<u8>)> + Send + 'static,
    {
        if let Some(shared) = &self.shared {
            shared.fronts.clone().answer(answer).await;
        }
    }

    /// Tells other fronts that this one is gone.
    pub(crate) async fn leave(&self) {
        if let Some(shared) = &self.shared {
            shared.fronts.leave().await;
        }
    }

    fn hear(self: &Arc<Self>, news: News<'_>) {
        match news {
            News::Written { key, value, revision } => match serde_json::from_slice(value) {
                Ok(record) => self.hear_record(record, revision),
                Err(error) => tracing::warn!(key, %error, "a job's record cannot be read"),
            },
            News::Removed(key) => self.vanished(id_of(key)),
            News::All(keys) => {
                let ids: HashSet<&str> = keys.iter().map(|key| id_of(key)).collect();
                let gone: Vec<String> = {
                    let mut registry = self.registry.lock();
                    registry.loading = false;
                    let all = registry.jobs.keys().chain(registry.leaving.keys());
                    all.filter(|id| !ids.contains(id.as_str())).cloned().collect()
                };
                gone.iter().for_each(|id| self.vanished(id));
                // What led to the ends of those jobs is not heard any more.
                let known: Vec<_> = self.registry.lock().jobs.values().map(Arc::clone).collect();
                known.iter().for_each(|job| self.tell_end(job, true));
                self.open_next();
            }
        }
    }

    fn hear_record(self: &Arc<Self>, record: Record, revision: u64) {
        let known = {
            let registry = self.registry.lock();
            registry.jobs.get(&record.id).or_else(|| registry.leaving.get(&record.id)).map(Arc::clone)
        };
        let of = |job: &Arc<Job>| {
            let record = job.record();
            (record.state, record.front.clone())
        };
        let state = known.as_ref().map(of);
        let job = known.unwrap_or_else(|| {
            self.registry.lock().find_or_add(record.clone(), revision, self.publisher(), &self.files)
        });
        let is_other = state != Some((record.state, record.front.clone()));
        self.adopt(&job, record, revision);
        self.tell_end(&job, false);
        if is_other {
            self.open_next();
        }
    }

    fn hear_event(&self, id: &str, event: SentEvent<'_>) {
        let Some(job) = self.find(id) else { return };
        let Some(name) = NAMES.into_iter().find(|name| *name == event.name) else { return };
        let is_here = self.registry.lock().is_open(&job);
        if is_here || (job.record().state.is_final() && event.seq <= job.events.last()) {
            return;
        }
        let number = |field: &str| event.data[field].as_u64();
        match name {
            "tile" => job.done.store(number("tiles_done").unwrap_or(0) as usize, Ordering::Relaxed),
            "progress" => job.hear_progress(
                number("tiles_done").unwrap_or(0) as usize,
                number("rays"),
                event.data["eta_ms"].as_f64(),
                number("revision"),
            ),
            "preview" => job.hear_preview(number("revision")),
            "frame" => job.hear_frame(number("frames_done").unwrap_or(0) as u32),
            _ => {}
        }
        job.events.hear(Event { seq: event.seq, name, data: Value::clone(&event.data) });
        self.tell_end(&job, false);
    }

    /// Tells those who watch a job here how it ended, after all that was told before; `late` if that has not come in time.
    fn tell_end(&self, job: &Job, late: bool) {
        let record = job.record().clone();
        let Some(seq) = record.last_event.filter(|_| record.state.is_final()) else { return };
        let last = job.events.last();
        if last + 1 == seq || (late && last < seq) {
            job.events.hear(end_of(&record, seq));
        }
    }

    /// Called once a second.
    pub(super) fn tell_late_ends(&self) {
        if self.records.front().is_none() {
            return;
        }
        let is_late = |job: &&Arc<Job>| {
            let left = *job.left.lock();
            let Record { last_event: seq, state, .. } = *job.record();
            state.is_final() && seq > Some(job.events.last()) && left.is_some_and(|left| left.elapsed() >= LATE)
        };
        let late: Vec<_> = self.registry.lock().jobs.values().filter(is_late).map(Arc::clone).collect();
        late.iter().for_each(|job| self.tell_end(job, true));
    }
}

/// The job of a key.
fn id_of(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}
