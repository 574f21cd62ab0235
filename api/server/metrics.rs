//! Numbers for Prometheus, at `/metrics` of the admin listener.
//!
//! The envelope counts every request, by the status of its response, and by the [`Cost`] that is in it if something
//! was rendered. Tenants are no labels: there may be thousands.

use super::Service;
use super::cost::Cost;
use axum::http::{Method, StatusCode};
use axum::response::Response;
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::metrics::info::Info;
use prometheus_client::registry::Registry;
use std::sync::atomic::AtomicU64;
use std::time::Duration;

/// Upper ends of the buckets, in seconds: from a cached picture to the longest render.
const SECONDS: [f64; 14] = [0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0];

type Seconds = Counter<f64, AtomicU64>;

/// All numbers.
#[derive(Debug)]
pub(super) struct Metrics {
    registry: Registry,
    requests: Family<RequestLabels, Counter>,
    request_seconds: Family<RouteLabels, Histogram>,
    renders: Family<OutcomeLabels, Counter>,
    render_seconds: Histogram,
    queue_seconds: Histogram,
    encode_seconds: Family<FormatLabels, Histogram>,
    rays: Counter,
    shed: Family<ReasonLabels, Counter>,
    canceled_seconds: Seconds,
    running: Gauge,
    waiting: Gauge,
    scene_cache_bytes: Gauge,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct RequestLabels {
    route: String,
    method: String,
    status: u16,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct RouteLabels {
    route: String,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OutcomeLabels {
    lane: &'static str,
    outcome: &'static str,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct FormatLabels {
    format: &'static str,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct ReasonLabels {
    reason: &'static str,
}

fn histogram() -> Histogram {
    Histogram::new(SECONDS)
}

impl Default for Metrics {
    fn default() -> Self {
        let mut metrics = Self {
            registry: Registry::with_prefix("strahl"),
            requests: Family::default(),
            request_seconds: Family::new_with_constructor(histogram),
            renders: Family::default(),
            render_seconds: histogram(),
            queue_seconds: histogram(),
            encode_seconds: Family::new_with_constructor(histogram),
            rays: Counter::default(),
            shed: Family::default(),
            canceled_seconds: Seconds::default(),
            running: Gauge::default(),
            waiting: Gauge::default(),
            scene_cache_bytes: Gauge::default(),
        };
        metrics.register();
        metrics
    }
}

impl Metrics {
    fn register(&mut self) {
        let build = Info::new(vec![("version", env!("CARGO_PKG_VERSION"))]);
        let to = &mut self.registry;
        to.register("build", "The program", build);
        to.register("http_requests", "Requests answered", self.requests.clone());
        let help = "Seconds from a request's headers to its answer's";
        to.register("http_request_duration_seconds", help, self.request_seconds.clone());
        to.register("renders", "Renders asked for, by how they ended", self.renders.clone());
        to.register("render_seconds", "Seconds that renders took, without waiting", self.render_seconds.clone());
        to.register("queue_seconds", "Seconds that renders waited", self.queue_seconds.clone());
        to.register("encode_seconds", "Seconds that writing pictures took", self.encode_seconds.clone());
        to.register("rays", "Rays traced for answers", self.rays.clone());
        to.register("shed", "Requests refused for lack of room or allowance", self.shed.clone());
        let help = "Seconds that renders ran whose clients went away";
        to.register("canceled_work_seconds", help, self.canceled_seconds.clone());
        to.register("renders_running", "Renders under way", self.running.clone());
        to.register("queue_depth", "Renders that wait", self.waiting.clone());
        to.register("scene_cache_bytes", "Bytes of scenes that are kept", self.scene_cache_bytes.clone());
    }

    /// A request has been answered.
    pub(super) fn answered(&self, route: &str, method: &Method, response: &Response, took: Duration) {
        let status = response.status();
        let labels = RequestLabels { route: route.to_owned(), method: known(method), status: status.as_u16() };
        self.requests.get_or_create(&labels).inc();
        let labels = RouteLabels { route: route.to_owned() };
        self.request_seconds.get_or_create(&labels).observe(took.as_secs_f64());
        if let Some(cost) = response.extensions().get::<Cost>() {
            self.rendered("interactive", cost);
        } else if is_render(route) && !status.is_success() {
            self.ended("interactive", outcome(status));
        }
    }

    /// A request was refused for lack of room or allowance.
    pub(super) fn shed(&self, reason: &'static str) {
        self.shed.get_or_create(&ReasonLabels { reason }).inc();
    }

    /// A client went away before its answer.
    pub(super) fn left(&self, route: &str, took: Duration) {
        if is_render(route) {
            self.ended("interactive", "canceled");
            self.canceled_seconds.inc_by(took.as_secs_f64());
        }
    }

    /// A picture was made.
    pub(super) fn rendered(&self, lane: &'static str, cost: &Cost) {
        self.ended(lane, "ok");
        self.rays.inc_by(cost.rays);
        self.render_seconds.observe(cost.render.as_secs_f64());
        self.queue_seconds.observe(cost.queue.as_secs_f64());
        self.encode_seconds.get_or_create(&FormatLabels { format: cost.format }).observe(cost.encode.as_secs_f64());
    }

    /// Work on a job has ended in this process.
    pub(super) fn worked(&self, outcome: &'static str, rays: u64) {
        self.ended("jobs", outcome);
        self.rays.inc_by(rays);
    }

    /// A render has ended: `ok`, `refused`, `failed`, `deadline`, `canceled` or `suspended`.
    pub(super) fn ended(&self, lane: &'static str, outcome: &'static str) {
        self.renders.get_or_create(&OutcomeLabels { lane, outcome }).inc();
    }

    /// Everything as OpenMetrics text.
    pub(super) fn text(&self, service: &Service) -> String {
        let count = |count: usize| i64::try_from(count).unwrap_or(i64::MAX);
        self.running.set(count(service.queue.running()));
        self.waiting.set(count(service.queue.waiting()));
        self.scene_cache_bytes.set(i64::try_from(service.scenes.bytes()).unwrap_or(i64::MAX));
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = encode(&mut text, &self.registry);
        text
    }
}

/// Paths whose answers are pictures made for them.
fn is_render(route: &str) -> bool {
    route.starts_with("/v1/render")
}

/// Methods come from clients, who could make up any number of them.
fn known(method: &Method) -> String {
    match method.as_str() {
        name @ ("GET" | "HEAD" | "POST" | "QUERY" | "PUT" | "PATCH" | "DELETE" | "OPTIONS") => name.to_owned(),
        _ => "other".to_owned(),
    }
}

fn outcome(status: StatusCode) -> &'static str {
    match status {
        StatusCode::GATEWAY_TIMEOUT => "deadline",
        StatusCode::SERVICE_UNAVAILABLE => "refused",
        status if status.is_server_error() => "failed",
        _ => "refused",
    }
}
