//! `GET /v1/jobs/{id}/events`, `/v1/events?job=...`: events of jobs (Server-Sent Events).

use super::ID;
use crate::http::extract::named_job::{NamedJob, find, may_see};
use crate::http::prelude::*;
use crate::http::problem::ProblemSummary;
use crate::http::respond::event_stream::{HEARTBEAT, event_stream};
use crate::http::respond::events::streamed_event;
use crate::service::concurrency_limit::Permit;
use crate::service::jobs::record::{Record, State as JobState};
use crate::service::jobs::{Event, Job, Watcher, end_of};
use axum::Extension;
use axum::body::Body;
use axum::http::request::Parts;
use axum::response::sse;
use futures_util::stream;
use serde_json::json;
use std::collections::{HashSet, VecDeque};
use std::convert::Infallible;
use std::future::poll_fn;
use std::mem;
use std::task::Poll;
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// Time after which the key of who reads a stream is looked at again.
const BETWEEN_LOOKS: Duration = Duration::from_secs(1);
/// Time after which a browser connects again when the stream has ended.
const RETRY: Duration = Duration::from_secs(2);
/// Most jobs of one stream.
const MOST: usize = 32;
/// Most jobs of one that is about all of a tenant's.
const MOST_OPEN: usize = 10_000;

pub(super) fn routes() -> Vec<Route> {
    let stream = [Content::of("text/event-stream", |_| streamed_event())];
    let last = "The last event that was seen: the stream goes on after it.";
    let last_of_several = "The last event that was seen: the stream goes on after it, if it is of the same jobs in the same \
                           order.";
    let about_one = "What happens to a job, as it happens, until it has ended.";
    let about_several = "What happens to several jobs, in one stream, until all have ended: browsers open six connections to a \
                         host.\n\nWithout `job` it is what happens to all of yours, as long as the stream is open: first a snapshot of \
                         each that has not ended, then all events, and `created` and `removed` as jobs come and go. Ask for the \
                         list (`GET /v1/jobs`) whenever such a stream begins; it cannot be continued.";
    let events = "Events: snapshot, queued, started, preview, tile, progress, frame, succeeded, failed, canceled, shutdown, created, removed";
    vec![
        Route::get("/v1/jobs/{id}/events", of_job, ["jobEvents", "jobs", about_one])
            .needs(Scope::Read)
            .path("id", ID)
            .header("Last-Event-ID", last)
            .query(since)
            .answer(200, events, &stream)
            .answer(204, "The last event has been seen; nothing more will come", &[]),
        Route::get("/v1/events", of_jobs, ["events", "jobs", about_several])
            .needs(Scope::Read)
            .header("Last-Event-ID", last_of_several)
            .query(wanted)
            .answer(200, "Events as in the stream of each job; `job` says whose they are", &stream)
            .answer(204, "The last event of each has been seen; nothing more will come", &[]),
    ]
}

fn since(query: &mut Query) -> Option<String> {
    let since = query.text("since", "Likewise, for clients that cannot send headers.")?;
    if !since.split(',').all(|number| number.is_empty() || number.parse::<u64>().is_ok()) {
        query.wrong("since", "out-of-range", format!("expected the id of an event, got \"{since}\""));
    }
    Some(since)
}

/// What a stream is of.
struct Wanted {
    ids: Vec<String>,
    label: Option<String>,
    since: Option<String>,
}

fn wanted(query: &mut Query) -> Wanted {
    let mut ids = query.several("job", "The jobs' ids, at most 32: `job=...&job=...`. Without it: all of yours.", MOST);
    let label = query.text("label", "Of all of yours only those with this label.");
    if label.is_some() && !ids.is_empty() {
        query.wrong("label", "out-of-range", "it goes without job".into());
    }
    // A job that is named twice counts once.
    let mut known = HashSet::new();
    ids.retain(|id| known.insert(id.clone()));
    Wanted { ids, label, since: since(query) }
}

async fn of_job(
    State(app): State<App>,
    NamedJob { job, tenant }: NamedJob,
    request: Request,
) -> Result<Response, Problem> {
    let since = Query::read(request.uri(), since)?;
    stream_of(Reader::new(&app, tenant, request), since, vec![job])
}

async fn of_jobs(
    State(app): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    request: Request,
) -> Result<Response, Problem> {
    let Wanted { ids, label, since } = Query::read(request.uri(), wanted)?;
    let reader = Reader::new(&app, tenant, request);
    if ids.is_empty() {
        return stream_of_all(reader, label);
    }
    let mut jobs = Vec::with_capacity(ids.len());
    for id in &ids {
        jobs.push(find(&app, &reader.tenant, id).await?);
    }
    stream_of(reader, since, jobs)
}

/// Who reads a stream.
struct Reader {
    app: App,
    tenant: Arc<Tenant>,
    request: Parts,
    /// When its key was looked at.
    looked: Instant,
}

impl Reader {
    fn new(app: &App, tenant: Arc<Tenant>, request: Request) -> Self {
        Self { app: Arc::clone(app), tenant, request: request.into_parts().0, looked: Instant::now() }
    }

    /// Whether its key or capability still opens what it did when the stream began.
    fn is_known(&mut self) -> bool {
        if self.looked.elapsed() < BETWEEN_LOOKS {
            return true;
        }
        self.looked = Instant::now();
        let request = Request::from_parts(self.request.clone(), Body::empty());
        self.app.access.recheck(&self.tenant, &request).is_ok()
    }
}

/// The stream of events of some jobs.
fn stream_of(reader: Reader, since: Option<String>, jobs: Vec<Arc<Job>>) -> Result<Response, Problem> {
    let last = reader.request.headers.get("last-event-id").and_then(|id| id.to_str().ok()).map(str::to_owned);
    let seen = last.or(since).map_or_else(Vec::new, |id| numbers(&id));
    // An id with numbers of other jobs is of no use.
    let seen = if seen.len() == jobs.len() { seen } else { vec![None; jobs.len()] };
    if jobs.iter().zip(&seen).all(|(job, seen)| seen.is_some() && job.record().last_event == *seen) {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let jobs = jobs.into_iter().zip(seen).map(|(job, seen)| Watched::new(job, seen, true)).collect();
    answer(reader, jobs, None)
}

/// The stream of events of all jobs of a tenant.
fn stream_of_all(reader: Reader, label: Option<String>) -> Result<Response, Problem> {
    let (app, tenant) = (&reader.app, Arc::clone(&reader.tenant));
    let changes = app.service.jobs.changes();
    let newest = app.service.jobs.list(None, 1, |_| true).first().map(|job| job.record().id.clone());
    let known = HashSet::new();
    let mut all = All { app: Arc::clone(app), tenant, label, changes, looked: 0, newest, known };
    let mut watching = Vec::new();
    for job in all.open() {
        all.known.insert(job.record().id.clone());
        watching.push(Watched::new(job, None, false));
    }
    answer(reader, watching, Some(all))
}

fn answer(reader: Reader, jobs: Vec<Watched>, all: Option<All>) -> Result<Response, Problem> {
    let Reader { app, tenant, .. } = &reader;
    let permit = app.streams.enter(tenant.name.clone(), tenant.quotas.streams).ok_or_else(|| {
        let detail = format!("you have {} event streams open (streams of your tenant)", tenant.quotas.streams);
        Problem::new(Kind::RateLimited, detail).retry_after(5)
    })?;
    let draining = app.drain.watch();
    let watching = Watching { reader, draining, _permit: permit, jobs, all, news: VecDeque::new(), ended: false };
    let retry = stream::once(async { Ok::<_, Infallible>(sse::Event::default().retry(RETRY)) });
    let events = stream::StreamExt::chain(retry, stream::unfold(watching, Watching::step));
    Ok(event_stream(events))
}

/// The numbers of the last event of each job in an event's id.
fn numbers(id: &str) -> Vec<Option<u64>> {
    id.trim().split(',').map(|number| number.parse().ok()).collect()
}

/// A stream of events.
struct Watching {
    reader: Reader,
    jobs: Vec<Watched>,
    /// All jobs of a tenant, if it is about all.
    all: Option<All>,
    /// Jobs that came and went.
    news: VecDeque<sse::Event>,
    draining: watch::Receiver<bool>,
    /// Whether the service is about to end.
    ended: bool,
    _permit: Permit<String>,
}

impl Watching {
    /// The next event.
    async fn step(mut self) -> Option<(Result<sse::Event, Infallible>, Self)> {
        loop {
            if !self.reader.is_known() {
                return None;
            }
            if let Some(news) = self.news.pop_front() {
                return Some((Ok(news), self));
            }
            let next = self.jobs.iter_mut().find_map(|job| job.next.pop_front().map(|event| job.sent(event)));
            if let Some(event) = next {
                if self.all.is_some() {
                    return Some((Ok(event), self));
                }
                let seen: Vec<String> =
                    self.jobs.iter().map(|job| job.seen.map_or_else(String::new, |seq| seq.to_string())).collect();
                return Some((Ok(event.id(seen.join(","))), self));
            }
            if self.ended || (self.all.is_none() && self.jobs.iter().all(|job| job.ended)) {
                return None;
            }
            self.look();
            self.jobs.iter_mut().filter(|job| !job.ended).for_each(Watched::gather);
            if !self.news.is_empty() || self.jobs.iter().any(|job| !job.next.is_empty()) {
                continue;
            }
            if self.ring().await? {
                self.ended = true;
                let data = json!({ "reason": "draining", "retry_ms": RETRY.as_millis() });
                let sent = sse::Event::default().event("shutdown").data(data.to_string());
                return Some((Ok(sent), self));
            }
        }
    }

    /// Notes which jobs have come and gone.
    fn look(&mut self) {
        let Some(all) = &mut self.all else { return };
        self.jobs.retain(|job| !job.ended);
        let changes = *all.changes.borrow_and_update();
        if changes == all.looked {
            return;
        }
        all.looked = changes;
        let jobs = &all.app.service.jobs;
        let gone: Vec<String> = all.known.iter().filter(|id| jobs.find(id).is_none()).cloned().collect();
        for id in gone {
            all.known.remove(&id);
            for mut job in self.jobs.extract_if(.., |job| job.job.record().id == id) {
                let last = job.gather_all();
                self.news.extend(last.into_iter().map(|event| job.sent(event)));
            }
            self.news.push_back(sse::Event::default().event("removed").data(json!({ "job": id }).to_string()));
        }
        for job in all.open() {
            let record = job.record().clone();
            if all.known.insert(record.id.clone()) {
                let data = json!({
                    "job": record.id, "state": record.state, "priority": record.priority, "labels": record.labels,
                    "width": record.width, "height": record.height,
                });
                self.news.push_back(sse::Event::default().event("created").data(data.to_string()));
                self.jobs.push(Watched::new(job, None, false));
            }
        }
    }

    /// Waits for an event of any job. True if the service drains.
    async fn ring(&mut self) -> Option<bool> {
        // The channel of an ended job is always ready.
        let going_on = self.jobs.iter_mut().filter(|job| !job.ended);
        let mut bells: Vec<_> = going_on.map(|job| Box::pin(job.bell.changed())).collect();
        bells.extend(self.all.iter_mut().map(|all| Box::pin(all.changes.changed())));
        let any = poll_fn(|context| {
            let rung = bells.iter_mut().any(|bell| bell.as_mut().poll(context).is_ready());
            if rung { Poll::Ready(()) } else { Poll::Pending }
        });
        tokio::select! {
            () = any => Some(false),
            // A silent stream of a key that is gone ends, too.
            () = tokio::time::sleep(HEARTBEAT) => Some(false),
            begun = self.draining.wait_for(|draining| *draining) => begun.ok().map(|_| true),
        }
    }
}

/// All jobs of a tenant, or of all tenants for an operator.
struct All {
    app: App,
    tenant: Arc<Tenant>,
    label: Option<String>,
    changes: watch::Receiver<u64>,
    /// The last change that was looked at.
    looked: u64,
    /// The newest job when the stream began. Ids grow.
    newest: Option<String>,
    /// Jobs that were told of, until they are removed.
    known: HashSet<String>,
}

impl All {
    /// The jobs that have not ended, and all that are newer than the stream, the oldest first.
    fn open(&self) -> Vec<Arc<Job>> {
        let wanted = |record: &Record| {
            let has_label = self.label.as_ref().is_none_or(|label| record.labels.contains(label));
            let is_new = self.newest.as_ref().is_none_or(|newest| record.id > *newest);
            may_see(&self.tenant, record) && has_label && (is_new || !record.state.is_final())
        };
        let mut jobs = self.app.service.jobs.list(None, MOST_OPEN, wanted);
        jobs.reverse();
        jobs
    }
}

/// A job in a stream.
struct Watched {
    job: Arc<Job>,
    bell: watch::Receiver<u64>,
    /// Number of the last event that was sent, now or before the client reconnected.
    seen: Option<u64>,
    /// Number of the last event that was gathered.
    gathered: Option<u64>,
    next: VecDeque<Event>,
    ended: bool,
    /// Whether previews are wanted, which are rendered for those who look on.
    _watcher: Option<Watcher>,
}

impl Watched {
    fn new(job: Arc<Job>, seen: Option<u64>, looks: bool) -> Self {
        let ended = seen.is_some() && job.record().last_event == seen;
        let (bell, _watcher) = (job.events.bell(), looks.then(|| job.watch()));
        Self { job, bell, seen, gathered: seen, next: VecDeque::new(), ended, _watcher }
    }

    /// An event to be sent now.
    fn sent(&mut self, event: Event) -> sse::Event {
        self.ended |= is_last(event.name);
        self.seen = Some(event.seq);
        written(&self.job, event)
    }

    /// Collects the events since, or a snapshot of the job if they are not kept any more.
    fn gather(&mut self) {
        self.bell.mark_unchanged();
        if let Some(events) = self.gathered.and_then(|seen| self.job.events.since(seen)) {
            self.gathered = events.last().map(|event| event.seq).or(self.gathered);
            self.next.extend(events);
            return;
        }
        let record = self.job.record().clone();
        if !record.state.is_final() && self.gathered.is_some_and(|seen| self.job.events.may_lack(seen)) {
            // What follows comes to this front later.
            return;
        }
        let last = self.job.events.last();
        // A client that has seen the event before misses only the last one.
        let seq = record.last_event.map_or(last, |last| last - 1);
        let progress = self.job.progress();
        let snapshot = json!({
            "state": record.state, "width": record.width, "height": record.height, "tile": record.edge,
            "tiles_done": progress.done, "tiles_total": progress.total, "revision": self.job.revision(),
        });
        self.next.push_back(Event { seq, name: "snapshot", data: snapshot });
        self.gathered = Some(seq);
        self.next.extend(ending(&record));
    }

    /// All events that are left of a job that is gone. Its record may tell how it ended before its events do.
    fn gather_all(&mut self) -> VecDeque<Event> {
        self.gather();
        let ending = ending(&self.job.record()).filter(|ending| self.next.iter().all(|event| event.seq < ending.seq));
        self.next.extend(ending);
        mem::take(&mut self.next)
    }
}

/// The last event of a job that has ended.
fn ending(record: &Record) -> Option<Event> {
    let seq = record.last_event.filter(|_| record.state.is_final())?;
    Some(end_of(record, seq))
}

fn is_last(name: &str) -> bool {
    JobState::ALL.iter().any(|(known, state)| *known == name && state.is_final())
}

/// An event as it is sent: its number, its job, and the URL of what it is about.
fn written(job: &Job, event: Event) -> sse::Event {
    let Event { seq, name, mut data } = event;
    let record = job.record();
    let path = format!("/v1/jobs/{}", record.id);
    data["seq"] = seq.into();
    data["job"] = record.id.clone().into();
    match name {
        "preview" => data["url"] = format!("{path}/preview?rev={}", data["revision"]).into(),
        "tile" => {
            let url = format!("{path}/tile?x={}&y={}&w={}&h={}", data["x"], data["y"], data["w"], data["h"]);
            data["url"] = url.into();
        }
        "succeeded" => {
            data["url"] = format!("{path}/image").into();
            data["image_id"] = record.image_id.clone().into();
        }
        "failed" => {
            let failure = record.failure.as_ref();
            data["problem"] = json!(failure.map(ProblemSummary::of));
        }
        _ => {}
    }
    if let Some(data) = data.as_object_mut() {
        data.remove("failure");
    }
    sse::Event::default().event(name).data(data.to_string())
}
