//! Metrics for Prometheus, at `/metrics` of the admin listener.
//!
//! The request log counts every request by the status of its answer, and by the [`Cost`] in it if something was rendered.
//! Jobs report when they end. Gauges are read when Prometheus asks (`gauges.rs`). There are no labels for tenants, since there
//! may be thousands.

mod farm;
mod gauges;
pub(crate) mod render_cost;

use crate::service::jobs::JobObserver;
use crate::service::jobs::outbox::{DeliveryKind, DeliveryState};
use crate::service::jobs::record::{Record, State};
use crate::service::requests::Service;
use crate::service::scheduler::task::Class;
use axum::http::{Method, StatusCode};
use axum::response::Response;
use farm::FarmFigures;
use gauges::{Gauges, Label, lane};
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::encoding::text::{encode_eof, encode_registry};
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::metrics::info::Info;
use prometheus_client::registry::Registry;
use render_cost::Cost;
use std::time::Duration;

/// Upper ends of the buckets, in seconds: from a cached picture to a long job.
const SECONDS: [f64; 16] =
    [0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 300.0, 3_600.0];

/// All metrics.
#[derive(Debug)]
pub(crate) struct Metrics {
    registry: Registry,
    gauges: Gauges,
    farm: FarmFigures,
    requests: Family<RequestLabels, Counter>,
    request_seconds: Family<[(&'static str, String); 1], Histogram>,
    renders: Family<[(&'static str, &'static str); 2], Counter>,
    render_seconds: Family<Label, Histogram>,
    queue_seconds: Family<Label, Histogram>,
    encode_seconds: Family<Label, Histogram>,
    rays: Family<Label, Counter>,
    shed: Family<Label, Counter>,
    deliveries: Family<[(&'static str, &'static str); 2], Counter>,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct RequestLabels {
    route: String,
    method: &'static str,
    status: u16,
}

fn histogram() -> Histogram {
    Histogram::new(SECONDS)
}

impl Default for Metrics {
    fn default() -> Self {
        let mut metrics = Self {
            registry: Registry::with_prefix("strahl"),
            gauges: Gauges::default(),
            farm: FarmFigures::default(),
            requests: Family::default(),
            request_seconds: Family::new_with_constructor(histogram),
            renders: Family::default(),
            render_seconds: Family::new_with_constructor(histogram),
            queue_seconds: Family::new_with_constructor(histogram),
            encode_seconds: Family::new_with_constructor(histogram),
            rays: Family::default(),
            shed: Family::default(),
            deliveries: Family::default(),
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
        to.register("renders", "Renders and jobs, by how they ended", self.renders.clone());
        to.register("render_seconds", "Seconds that renders took, without waiting", self.render_seconds.clone());
        to.register("queue_seconds", "Seconds that renders waited", self.queue_seconds.clone());
        to.register("encode_seconds", "Seconds that writing pictures took", self.encode_seconds.clone());
        to.register("rays", "Rays traced for pictures", self.rays.clone());
        to.register("shed", "Requests refused for lack of room or allowance", self.shed.clone());
        let help = "Attempts to deliver messages and pictures of jobs, by what came of them";
        to.register("deliveries", help, self.deliveries.clone());
        self.gauges.register(to);
    }

    /// Counts an answered request.
    pub(crate) fn answered(&self, route: &str, method: &Method, response: &Response, took: Duration) {
        let status = response.status();
        let labels = RequestLabels { route: route.to_owned(), method: known(method), status: status.as_u16() };
        self.requests.get_or_create(&labels).inc();
        self.request_seconds.get_or_create(&[("route", route.to_owned())]).observe(took.as_secs_f64());
        let Some(class) = class_of(route) else { return };
        if let Some(cost) = response.extensions().get::<Cost>() {
            self.rendered(class, cost);
        } else if !status.is_success() && !status.is_redirection() {
            self.count_ended(class, outcome(status));
        }
    }

    /// Counts a request that was refused because the service is full or the tenant over its limits.
    pub(crate) fn shed(&self, reason: &'static str) {
        self.shed.get_or_create(&[("reason", reason)]).inc();
    }

    /// Counts a client that has disconnected before its answer.
    pub(crate) fn left(&self, route: &str) {
        if let Some(class) = class_of(route) {
            self.count_ended(class, "canceled");
        }
    }

    /// Counts a rendered picture.
    pub(crate) fn rendered(&self, class: Class, cost: &Cost) {
        self.count_ended(class, "ok");
        self.rays.get_or_create(&lane(class)).inc_by(cost.rays);
        self.render_seconds.get_or_create(&lane(class)).observe(cost.render.as_secs_f64());
        self.queue_seconds.get_or_create(&lane(class)).observe(cost.queue.as_secs_f64());
        self.encode_seconds.get_or_create(&[("format", cost.format)]).observe(cost.encode.as_secs_f64());
    }

    /// Counts an ended render: `ok`, `refused`, `failed`, `deadline` or `canceled`.
    fn count_ended(&self, class: Class, outcome: &'static str) {
        self.renders.get_or_create(&[("lane", class.name()), ("outcome", outcome)]).inc();
    }

    /// All metrics as OpenMetrics text.
    pub(crate) fn text(&self, service: &Service, streams: u64) -> String {
        self.gauges.read(service, streams);
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = encode_registry(&mut text, &self.registry);
        if let Some(farm) = &service.farm {
            self.farm.write(farm, &mut text);
        }
        let _ = encode_eof(&mut text);
        text
    }
}

impl JobObserver for Metrics {
    fn ended(&self, record: &Record, state: State) {
        let stats = &record.stats;
        match state {
            State::Succeeded => {
                let duration = |ms: f64| Duration::try_from_secs_f64(ms / 1e3).unwrap_or_default();
                let cost = Cost {
                    rays: stats.rays,
                    queue: duration(stats.queue_ms),
                    render: duration(stats.bvh_ms + stats.render_ms + stats.encode_ms),
                    encode: duration(stats.encode_ms),
                    format: record.spec.output.names().0,
                };
                self.rendered(Class::Jobs, &cost);
            }
            State::Canceled => self.count_ended(Class::Jobs, "canceled"),
            _ if record.failure.as_ref().is_some_and(|failure| failure.slug == "render-deadline") => {
                self.count_ended(Class::Jobs, "deadline");
            }
            _ => self.count_ended(Class::Jobs, "failed"),
        }
    }

    fn attempted(&self, kind: DeliveryKind, state: DeliveryState) {
        let outcome = match state {
            DeliveryState::Pending => "retried",
            DeliveryState::Delivered => "delivered",
            DeliveryState::Dead => "dead",
        };
        self.deliveries.get_or_create(&[("what", kind.name()), ("outcome", outcome)]).inc();
    }
}

/// The class of renders for a path, if it renders.
fn class_of(route: &str) -> Option<Class> {
    match route {
        "/v1/render" | "/v1/images/{image}" => Some(Class::Renders),
        "/v1/render/tile"
        | "/iiif/3/{image}/{region}/{size}/{rotation}/{file}"
        | "/dzi/{folder}/{level}/{tile}"
        | "/xyz/{image}/{z}/{x}/{y}" => Some(Class::Tiles),
        _ => None,
    }
}

/// Name of a known method. Clients could make up any number of others.
fn known(method: &Method) -> &'static str {
    const KNOWN: [&str; 8] = ["GET", "HEAD", "POST", "QUERY", "PUT", "PATCH", "DELETE", "OPTIONS"];
    KNOWN.into_iter().find(|name| *name == method.as_str()).unwrap_or("other")
}

fn outcome(status: StatusCode) -> &'static str {
    match status {
        StatusCode::GATEWAY_TIMEOUT => "deadline",
        StatusCode::SERVICE_UNAVAILABLE => "refused",
        status if status.is_server_error() => "failed",
        _ => "refused",
    }
}
