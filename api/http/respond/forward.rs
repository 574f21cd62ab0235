//! Requests about a job that another front of the farm works on: what it has in memory only, that front answers.

use crate::http::auth::tenant::{Scope, Tenant};
use crate::http::extract::prefer::Prefer;
use crate::http::problem::{Kind, Problem};
use crate::http::state::App;
use crate::service::jobs::Job;
use axum::body::{Body, to_bytes};
use axum::extract::Request;
use axum::http::{HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

/// Longest wait for another front: its requests may wait as long as clients prefer, and the answer takes its way.
const PATIENCE: Duration = Prefer::LONGEST.saturating_add(Duration::from_secs(3));
/// Bytes of an answer.
const MOST: usize = 256 << 20;
/// Headers that are sent on: they say which preview is wanted.
const SENT: [HeaderName; 2] = [header::IF_NONE_MATCH, HeaderName::from_static("prefer")];

/// What a front asks another one.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Question {
    /// The job's id.
    pub(crate) job: String,
    /// What is asked for: the last part of the path.
    pub(crate) what: String,
    query: String,
    headers: Vec<(String, String)>,
    tenant: String,
    weight: u32,
    scopes: Vec<Scope>,
}

/// The head of an answer.
#[derive(Debug, Serialize, Deserialize)]
struct Head {
    status: u16,
    headers: Vec<(String, String)>,
}

/// Marks a request that comes from another front, which is sent on no further.
#[derive(Debug, Clone, Copy)]
struct Forwarded;

/// Forwards a request to the front that works on a job, and gives its answer. `None` if this front or no other works on it, or the other does not answer.
pub(crate) fn forward_to_owner(
    app: &App,
    job: &Arc<Job>,
    tenant: &Tenant,
    what: &str,
    request: &Request,
) -> impl Future<Output = Option<Response>> + Send + use<> {
    let question = Question::of(app, job, tenant, what, request);
    let app = Arc::clone(app);
    async move {
        let (front, question) = question?;
        let (head, body) = app.service.jobs.ask_front(&front, question, PATIENCE).await?;
        let Head { status, headers } = serde_json::from_slice(&head).ok()?;
        let mut answer = Response::builder().status(status);
        for (name, value) in headers {
            answer = answer.header(name, value);
        }
        answer.body(super::body(app.service.memory.metered(body).ok()?)).ok()
    }
}

impl Question {
    /// The front to ask, and the question as it is sent.
    fn of(app: &App, job: &Arc<Job>, tenant: &Tenant, what: &str, request: &Request) -> Option<(String, Vec<u8>)> {
        if request.extensions().get::<Forwarded>().is_some() {
            return None;
        }
        let front = app.service.jobs.front_of(job)?;
        let sent = |name: &HeaderName| {
            let values: Vec<_> =
                request.headers().get_all(name).iter().filter_map(|value| value.to_str().ok()).collect();
            (!values.is_empty()).then(|| (name.to_string(), values.join(", ")))
        };
        let question = Self {
            job: job.record().id.clone(),
            what: what.to_owned(),
            query: request.uri().query().unwrap_or_default().to_owned(),
            headers: SENT.iter().filter_map(sent).collect(),
            tenant: tenant.name.clone(),
            weight: tenant.weight,
            scopes: tenant.scopes.clone(),
        };
        Some((front, serde_json::to_vec(&question).ok()?))
    }

    /// The request that it was, and the tenant that asks.
    pub(crate) fn request(&self) -> Option<(Request, Arc<Tenant>)> {
        let tenant = Tenant::from_front(&self.tenant, self.weight, &self.scopes);
        let mut request = Request::builder().uri(format!("/?{}", self.query)).body(Body::empty()).ok()?;
        for (name, value) in &self.headers {
            let name = SENT.iter().find(|sent| sent.as_str() == name)?.clone();
            request.headers_mut().insert(name, HeaderValue::from_str(value).ok()?);
        }
        request.extensions_mut().insert(Forwarded);
        Some((request, Arc::new(tenant)))
    }
}

/// An answer as it is sent to the front that has asked.
pub(crate) async fn packed(answer: Response) -> (Vec<u8>, Vec<u8>) {
    let (mut parts, body) = answer.into_parts();
    let body: Vec<u8> = match to_bytes(body, MOST).await {
        Ok(body) => body.into(),
        Err(_) => {
            let detail = "the answer of the front that works on the job is too large to be sent on";
            let (refused, body) = Problem::new(Kind::Saturated, detail).retry_after(5).into_response().into_parts();
            parts = refused;
            to_bytes(body, MOST).await.map(Vec::from).unwrap_or_default()
        }
    };
    let readable =
        |(name, value): (&HeaderName, &HeaderValue)| Some((name.to_string(), value.to_str().ok()?.to_owned()));
    let head = Head { status: parts.status.as_u16(), headers: parts.headers.iter().filter_map(readable).collect() };
    (serde_json::to_vec(&head).unwrap_or_default(), body)
}

/// The answer to a request of another front that this version does not know.
pub(crate) fn unknown() -> Problem {
    Problem::new(Kind::NotFound, "this front knows nothing of it")
}
