//! `GET /v1/jobs/{id}/events`, `/v1/events?job=...`: events of jobs (Server-Sent Events).

use super::ID;
use crate::http::extract::named_job::{NamedJob, find};
use crate::http::prelude::*;
use crate::http::problem::ProblemSummary;
use crate::service::concurrency_limit::Permit;
use crate::service::jobs::record::State as JobState;
use crate::service::jobs::{Event, Job, Watcher};
use axum::Extension;
use axum::http::HeaderName;
use axum::response::sse::{self, KeepAlive, Sse};
use futures_util::stream;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::poll_fn;
use std::task::Poll;
use std::time::Duration;
use tokio::sync::watch;

/// Silence after which a comment is sent, which shows that the stream is alive.
const HEARTBEAT: Duration = Duration::from_secs(15);
/// Time after which a browser connects again when the stream has ended.
const RETRY: Duration = Duration::from_secs(2);
/// Most jobs of one stream.
const MOST: usize = 32;

pub(super) fn routes() -> Vec<Route> {
    let stream = [Content::of("text/event-stream", |_| streamed_event())];
    let last = "The last event that was seen: the stream goes on after it.";
    let last_of_several = "The last event that was seen: the stream goes on after it, if it is of the same jobs in the same \
                           order.";
    let about_one = "What happens to a job, as it happens, until it has ended.";
    let about_several = "What happens to several jobs, in one stream, until all have ended: browsers open six connections to a \
                         host.";
    let events = "Events: snapshot, queued, started, preview, tile, progress, succeeded, failed, canceled, shutdown";
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
            .query(jobs_and_since)
            .answer(200, "Events as in the stream of each job; `job` says whose they are", &stream)
            .answer(204, "The last event of each has been seen; nothing more will come", &[]),
    ]
}

/// One of the Server-Sent Events of a stream (WHATWG HTML, 9.2). `axum` writes them.
fn streamed_event() -> Value {
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

fn since(query: &mut Query) -> Option<String> {
    query.text("since", "Likewise, for clients that cannot send headers.")
}

fn jobs_and_since(query: &mut Query) -> (Vec<String>, Option<String>) {
    (query.several("job", "The jobs' ids, at most 32: `job=...&job=...`.", MOST), since(query))
}

async fn of_job(
    State(app): State<App>,
    NamedJob { job, tenant }: NamedJob,
    request: Request,
) -> Result<Response, Problem> {
    let since = Query::read(request.uri(), since)?;
    stream_of(&app, &tenant, request.headers(), since, vec![job])
}

async fn of_jobs(
    State(app): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    request: Request,
) -> Result<Response, Problem> {
    let (ids, since) = Query::read(request.uri(), jobs_and_since)?;
    let jobs = ids.iter().map(|id| find(&app, &tenant, id)).collect::<Result<_, _>>()?;
    stream_of(&app, &tenant, request.headers(), since, jobs)
}

/// The stream of events of some jobs.
fn stream_of(
    app: &App,
    tenant: &Tenant,
    headers: &HeaderMap,
    since: Option<String>,
    jobs: Vec<Arc<Job>>,
) -> Result<Response, Problem> {
    let last = headers.get("last-event-id").and_then(|id| id.to_str().ok()).map(str::to_owned);
    let seen = last.or(since).map_or_else(Vec::new, |id| numbers(&id));
    // An id with numbers of other jobs is of no use.
    let seen = if seen.len() == jobs.len() { seen } else { vec![None; jobs.len()] };
    if jobs.iter().zip(&seen).all(|(job, seen)| seen.is_some() && job.record().last_event == *seen) {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let permit = app.streams.enter(tenant.name.clone(), tenant.quotas.streams).ok_or_else(|| {
        let detail = format!("you have {} event streams open (streams of your tenant)", tenant.quotas.streams);
        Problem::new(Kind::RateLimited, detail).retry_after(5)
    })?;
    let watching = Watching {
        draining: app.drain.watch(),
        _permit: permit,
        jobs: jobs.into_iter().zip(seen).map(|(job, seen)| Watched::new(job, seen)).collect(),
        ended: false,
    };
    let retry = stream::once(async { Ok::<_, Infallible>(sse::Event::default().retry(RETRY)) });
    let events = stream::StreamExt::chain(retry, stream::unfold(watching, Watching::step));
    let headers = [(header::CACHE_CONTROL, "no-store"), (HeaderName::from_static("x-accel-buffering"), "no")];
    Ok((headers, Sse::new(events).keep_alive(KeepAlive::new().interval(HEARTBEAT))).into_response())
}

/// The numbers of the last event of each job in an event's id.
fn numbers(id: &str) -> Vec<Option<u64>> {
    id.trim().split(',').map(|number| number.parse().ok()).collect()
}

/// A stream of events.
struct Watching {
    jobs: Vec<Watched>,
    draining: watch::Receiver<bool>,
    /// Whether the service is about to end.
    ended: bool,
    _permit: Permit<String>,
}

impl Watching {
    /// The next event.
    async fn step(mut self) -> Option<(Result<sse::Event, Infallible>, Self)> {
        loop {
            let next = self.jobs.iter_mut().find_map(|job| job.next.pop_front().map(|event| job.sent(event)));
            if let Some(event) = next {
                let seen: Vec<String> =
                    self.jobs.iter().map(|job| job.seen.map_or_else(String::new, |seq| seq.to_string())).collect();
                return Some((Ok(event.id(seen.join(","))), self));
            }
            if self.ended || self.jobs.iter().all(|job| job.ended) {
                return None;
            }
            self.jobs.iter_mut().filter(|job| !job.ended).for_each(Watched::gather);
            if self.jobs.iter().any(|job| !job.next.is_empty()) {
                continue;
            }
            if self.ring().await? {
                self.ended = true;
                let data = json!({ "reason": "draining", "retry_ms": 5_000 });
                let sent = sse::Event::default().event("shutdown").data(data.to_string());
                return Some((Ok(sent), self));
            }
        }
    }

    /// Waits for an event of any job. True if the service drains.
    async fn ring(&mut self) -> Option<bool> {
        // The channel of an ended job is always ready.
        let going_on = self.jobs.iter_mut().filter(|job| !job.ended);
        let mut bells: Vec<_> = going_on.map(|job| Box::pin(job.bell.changed())).collect();
        let any = poll_fn(|context| {
            let rung = bells.iter_mut().any(|bell| bell.as_mut().poll(context).is_ready());
            if rung { Poll::Ready(()) } else { Poll::Pending }
        });
        tokio::select! {
            () = any => Some(false),
            begun = self.draining.wait_for(|draining| *draining) => begun.ok().map(|_| true),
        }
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
    _watcher: Watcher,
}

impl Watched {
    fn new(job: Arc<Job>, seen: Option<u64>) -> Self {
        let ended = seen.is_some() && job.record().last_event == seen;
        let (bell, _watcher) = (job.events.bell(), job.watch());
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
        let last = self.job.events.last();
        let record = self.job.record().clone();
        // A client that has seen the event before misses only the last one.
        let seq = record.last_event.map_or(last, |last| last - 1);
        let progress = self.job.progress();
        let snapshot = json!({
            "state": record.state, "width": record.width, "height": record.height, "tile": record.edge,
            "tiles_done": progress.done, "tiles_total": progress.total, "revision": self.job.revision(),
        });
        self.next.push_back(Event { seq, name: "snapshot", data: snapshot });
        self.gathered = Some(seq);
        if let (Some(seq), true) = (record.last_event, record.state.is_final()) {
            let data = json!({ "stats": record.stats, "failure": record.failure });
            let name = if record.state == JobState::Expired { JobState::Succeeded } else { record.state }.name();
            self.next.push_back(Event { seq, name, data });
        }
    }
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
