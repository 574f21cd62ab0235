//! `GET /v1/jobs/{id}/events`: what happens to a job, as it happens (Server-Sent Events).

use super::super::App;
use super::super::parameters::Parameters;
use super::super::places::Place;
use super::super::problem::{Kind, Problem};
use super::Named;
use crate::jobs::record::State as JobState;
use crate::jobs::{Event, Job, Watcher};
use axum::extract::{Request, State};
use axum::http::{HeaderName, StatusCode, header};
use axum::response::sse::{self, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;

/// Silence after which a comment says that the stream is alive.
const HEARTBEAT: Duration = Duration::from_secs(15);
/// When a browser comes back after the stream has ended.
const RETRY: Duration = Duration::from_secs(2);

/// What happens to a job, as it happens, until it has ended.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/events", operation_id = "jobEvents", tag = "jobs",
    params(
        ("id" = String, Path, description = "The job's id."),
        ("Last-Event-ID" = Option<u64>, Header, description = "The last event that was seen: the stream goes on after it."),
        ("since" = Option<u64>, Query, description = "Likewise, for those who cannot send headers."),
    ),
    responses(
        (status = 200, description = "Events: snapshot, queued, started, preview, tile, progress, succeeded, failed, canceled, shutdown", body = String, content_type = "text/event-stream"),
        (status = 204, description = "The last event has been seen; nothing more will come"),
    ),
)]
pub(in crate::server) async fn job_events(
    State(service): State<App>,
    Named { job, tenant }: Named,
    request: Request,
) -> Result<Response, Problem> {
    let mut parameters = Parameters::of(request.uri())?;
    let since = parameters.number("since");
    parameters.finish()?;
    let last = request.headers().get("last-event-id").and_then(|id| id.to_str().ok()?.trim().parse().ok());
    let seen = last.or(since);
    if seen.is_some() && job.record().last_event == seen {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let place = service.streams.enter(tenant.name.clone(), tenant.quotas.streams).ok_or_else(|| {
        let detail = format!("you have {} event streams open (streams of your tenant)", tenant.quotas.streams);
        Problem::new(Kind::RateLimited, detail).retry_after(5)
    })?;
    let watching = Watching {
        bell: job.events.bell(),
        draining: service.drain.watch(),
        _watcher: job.watch(),
        _place: place,
        job,
        seen,
        next: VecDeque::new(),
        ended: false,
    };
    let retry = stream::once(async { Ok::<_, Infallible>(sse::Event::default().retry(RETRY)) });
    let events = stream::StreamExt::chain(retry, stream::unfold(watching, Watching::step));
    let headers = [(header::CACHE_CONTROL, "no-store"), (HeaderName::from_static("x-accel-buffering"), "no")];
    Ok((headers, Sse::new(events).keep_alive(KeepAlive::new().interval(HEARTBEAT))).into_response())
}

/// Somebody who watches a job.
struct Watching {
    job: Arc<Job>,
    bell: watch::Receiver<u64>,
    draining: watch::Receiver<bool>,
    /// Number of the last event that was seen, if any was.
    seen: Option<u64>,
    next: VecDeque<Event>,
    ended: bool,
    _watcher: Watcher,
    _place: Place<String>,
}

impl Watching {
    /// The next event.
    async fn step(mut self) -> Option<(Result<sse::Event, Infallible>, Self)> {
        loop {
            if let Some(event) = self.next.pop_front() {
                self.ended |= is_last(event.name);
                let sent = written(&self.job, event);
                return Some((Ok(sent), self));
            }
            if self.ended {
                return None;
            }
            self.gather();
            if !self.next.is_empty() {
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

    /// Waits until something happens; whether it is the end of the service.
    async fn ring(&mut self) -> Option<bool> {
        tokio::select! {
            rung = self.bell.changed() => rung.ok().map(|()| false),
            begun = self.draining.wait_for(|draining| *draining) => begun.ok().map(|_| true),
        }
    }

    /// What has happened since, or where the job stands if that cannot be told any more.
    fn gather(&mut self) {
        self.bell.mark_unchanged();
        if let Some(events) = self.seen.and_then(|seen| self.job.events.since(seen)) {
            self.seen = events.last().map(|event| event.seq).or(self.seen);
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
        self.seen = Some(seq);
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

/// An event as it goes over the wire: its number again, and where to find what it is about.
fn written(job: &Job, event: Event) -> sse::Event {
    let Event { seq, name, mut data } = event;
    let record = job.record();
    let path = format!("/v1/jobs/{}", record.id);
    data["seq"] = seq.into();
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
    sse::Event::default().id(seq.to_string()).event(name).data(data.to_string())
}
