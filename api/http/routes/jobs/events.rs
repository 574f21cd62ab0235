//! `GET /v1/jobs/{id}/events`, `/v1/events?job=...`: what happens to jobs, as it happens (Server-Sent Events).

use crate::http::App;
use crate::http::auth::tenant::Tenant;
use crate::http::concurrency_limit::Permit;
use crate::http::contract::bodies::StreamedEvent;
use crate::http::extract::named_job::Named;
use crate::http::extract::named_job::find;
use crate::http::extract::query::Parameters;
use crate::http::problem::{Kind, Problem};
use crate::service::jobs::record::State as JobState;
use crate::service::jobs::{Event, Job, Watcher};
use axum::Extension;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, StatusCode, header};
use axum::response::sse::{self, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::poll_fn;
use std::sync::Arc;
use std::task::Poll;
use std::time::Duration;
use tokio::sync::watch;

/// Silence after which a comment says that the stream is alive.
const HEARTBEAT: Duration = Duration::from_secs(15);
/// When a browser comes back after the stream has ended.
const RETRY: Duration = Duration::from_secs(2);
/// Jobs of one stream.
const MOST: usize = 32;

/// What happens to a job, as it happens, until it has ended.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/events", operation_id = "jobEvents", tag = "jobs",
    params(
        ("id" = String, Path, description = "The job's id."),
        ("Last-Event-ID" = Option<String>, Header, description = "The last event that was seen: the stream goes on after it."),
        ("since" = Option<String>, Query, description = "Likewise, for those who cannot send headers."),
    ),
    responses(
        (status = 200, description = "Events: snapshot, queued, started, preview, tile, progress, succeeded, failed, canceled, shutdown", body = StreamedEvent, content_type = "text/event-stream"),
        (status = 204, description = "The last event has been seen; nothing more will come"),
    ),
)]
pub(crate) async fn job_events(
    State(service): State<App>,
    Named { job, tenant }: Named,
    request: Request,
) -> Result<Response, Problem> {
    let mut parameters = Parameters::of(request.uri())?;
    let since = parameters.text("since");
    parameters.finish()?;
    stream_of(&service, &tenant, request.headers(), since, vec![job])
}

/// What happens to several jobs, in one stream, until all have ended: browsers open six connections to a host.
#[utoipa::path(
    get, path = "/v1/events", operation_id = "events", tag = "jobs",
    params(
        ("job" = Vec<String>, Query, description = "The jobs' ids, at most 32: `job=...&job=...`."),
        ("Last-Event-ID" = Option<String>, Header, description = "The last event that was seen: the stream goes on after it, if it is of the same jobs in the same order."),
        ("since" = Option<String>, Query, description = "Likewise, for those who cannot send headers."),
    ),
    responses(
        (status = 200, description = "Events as in the stream of each job; `job` says whose they are", body = StreamedEvent, content_type = "text/event-stream"),
        (status = 204, description = "The last event of each has been seen; nothing more will come"),
    ),
)]
pub(crate) async fn events(
    State(service): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    request: Request,
) -> Result<Response, Problem> {
    let mut parameters = Parameters::of(request.uri())?;
    let ids = parameters.several("job", MOST);
    let since = parameters.text("since");
    parameters.finish()?;
    let jobs = ids.iter().map(|id| find(&service, &tenant, id)).collect::<Result<_, _>>()?;
    stream_of(&service, &tenant, request.headers(), since, jobs)
}

/// The stream of some jobs' events.
fn stream_of(
    service: &App,
    tenant: &Tenant,
    headers: &HeaderMap,
    since: Option<String>,
    jobs: Vec<Arc<Job>>,
) -> Result<Response, Problem> {
    let last = headers.get("last-event-id").and_then(|id| id.to_str().ok()).map(str::to_owned);
    let seen = last.or(since).map_or_else(Vec::new, |id| numbers(&id));
    // Numbers of other jobs say nothing about these.
    let seen = if seen.len() == jobs.len() { seen } else { vec![None; jobs.len()] };
    if jobs.iter().zip(&seen).all(|(job, seen)| seen.is_some() && job.record().last_event == *seen) {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let place = service.streams.enter(tenant.name.clone(), tenant.quotas.streams).ok_or_else(|| {
        let detail = format!("you have {} event streams open (streams of your tenant)", tenant.quotas.streams);
        Problem::new(Kind::RateLimited, detail).retry_after(5)
    })?;
    let watching = Watching {
        draining: service.drain.watch(),
        _place: place,
        jobs: jobs.into_iter().zip(seen).map(|(job, seen)| Watched::new(job, seen)).collect(),
        ended: false,
    };
    let retry = stream::once(async { Ok::<_, Infallible>(sse::Event::default().retry(RETRY)) });
    let events = stream::StreamExt::chain(retry, stream::unfold(watching, Watching::step));
    let headers = [(header::CACHE_CONTROL, "no-store"), (HeaderName::from_static("x-accel-buffering"), "no")];
    Ok((headers, Sse::new(events).keep_alive(KeepAlive::new().interval(HEARTBEAT))).into_response())
}

/// The number of the last event of each job, as an event's id says it.
fn numbers(id: &str) -> Vec<Option<u64>> {
    id.trim().split(',').map(|number| number.parse().ok()).collect()
}

/// Somebody who watches jobs.
struct Watching {
    jobs: Vec<Watched>,
    draining: watch::Receiver<bool>,
    /// Whether the service is about to end.
    ended: bool,
    _place: Permit<String>,
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

    /// Waits until something happens to any of them; whether it is the end of the service.
    async fn ring(&mut self) -> Option<bool> {
        // An ended job's last event has been heard, and rings for ever.
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

/// A job that somebody watches.
struct Watched {
    job: Arc<Job>,
    bell: watch::Receiver<u64>,
    /// Number of the last event that was sent or seen before, if any was.
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

    /// An event that goes out now.
    fn sent(&mut self, event: Event) -> sse::Event {
        self.ended |= is_last(event.name);
        self.seen = Some(event.seq);
        written(&self.job, event)
    }

    /// What has happened since, or where the job stands if that cannot be told any more.
    fn gather(&mut self) {
        self.bell.mark_unchanged();
        if let Some(events) = self.gathered.and_then(|seen| self.job.events.since(seen)) {
            self.gathered = events.last().map(|event| event.seq).or(self.gathered);
            self.next.extend(events);
            return;
        }
        let last = self.job.events.last();
        let record = self.job.record().clone();
        // Who has seen this much has missed nothing but the last event.
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

/// An event as it goes over the wire: its number, its job, and where to find what it is about.
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
            data["problem"] = failure.map_or(Value::Null, |failure| Kind::document(&failure.slug, &failure.detail));
        }
        _ => {}
    }
    if let Some(data) = data.as_object_mut() {
        data.remove("failure");
    }
    sse::Event::default().event(name).data(data.to_string())
}
