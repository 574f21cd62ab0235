//! Authorization: the tenant of a request, the scopes of its key, and its rate limit.

use crate::http::auth::capability::Capability;
use crate::http::auth::rate_limit::Left;
use crate::http::auth::tenant::{Scope, Tenant};
use crate::http::problem::{Kind, Problem};
use crate::http::state::{App, AppState};
use crate::service::ANONYMOUS;
use crate::service::concurrency_limit::Permit;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Answers that took at least this long are authorized again before they are sent.
const RECHECK_AFTER: Duration = Duration::from_secs(1);

/// Puts the tenant into the request's extensions. A request without a key has no tenant if the service needs keys. A wrong
/// key or capability is refused, also on paths that need none.
pub(crate) async fn identify(State(app): State<App>, mut request: Request, next: Next) -> Result<Response, Problem> {
    let Some(tenant) = app.access.tenant(&request)? else { return Ok(next.run(request).await) };
    let _place = request_permit(&app, &tenant)?;
    request.extensions_mut().insert(Arc::clone(&tenant));
    let (parts, body) = request.into_parts();
    let is_read = matches!(parts.method, Method::GET | Method::HEAD);
    let may_lose_it = app.access.needs_keys() || parts.extensions.get::<Capability>().is_some();
    let asked = (is_read && may_lose_it).then(|| parts.clone());
    let began = Instant::now();
    let response = next.run(Request::from_parts(parts, body)).await;
    if let Some(asked) = asked.filter(|_| began.elapsed() >= RECHECK_AFTER) {
        app.access.recheck(&tenant, &Request::from_parts(asked, Body::empty()))?;
    }
    Ok(response)
}

/// A place among the requests of a tenant, from the end of the head to the beginning of the answer. They have half of all connections, so
/// that bodies that are never sent, and answers that are long waited for, keep no other tenant out. Without keys there are no tenants.
fn request_permit(app: &AppState, tenant: &Tenant) -> Result<Permit<String>, Problem> {
    let most = if tenant.name == ANONYMOUS { u32::MAX } else { (app.max_connections / 2).max(1) };
    app.requests.enter(tenant.name.clone(), most).ok_or_else(|| {
        let detail = format!("{most} requests of your tenant are being answered: send more when some have ended");
        Problem::new(Kind::RateLimited, detail).retry_after(1)
    })
}

/// Refuses requests whose key lacks a scope, and charges the tenant unless they are free. Rays are charged where they are traced.
pub(crate) async fn require(scope: Scope, is_free: bool, request: Request, next: Next) -> Result<Response, Problem> {
    let tenant = Tenant::required(request.extensions())?;
    tenant.require(scope, request.uri().path())?;
    let Some(rate_limit) = &tenant.rate_limit else {
        return Ok(next.run(request).await);
    };
    let entered = if is_free { Ok(()) } else { rate_limit.enter(Instant::now()) };
    let mut response = match entered {
        Ok(()) => next.run(request).await,
        Err(seconds) => {
            let detail = format!(
                "{} has used up its {} units for this minute (units_per_minute)",
                tenant.name, rate_limit.per_minute
            );
            Problem::new(Kind::RateLimited, detail).retry_after(seconds).into_response()
        }
    };
    tell(rate_limit.left(Instant::now()), response.headers_mut());
    Ok(response)
}

/// The headers of draft-ietf-httpapi-ratelimit-headers-10.
fn tell(left: Left, headers: &mut HeaderMap) {
    let Left { per_minute, units, full_in } = left;
    for (name, value) in [
        ("ratelimit-policy", format!("\"tenant\";q={per_minute};w=60")),
        ("ratelimit", format!("\"tenant\";r={units};t={full_in}")),
    ] {
        // Numbers are ASCII.
        if let Ok(value) = HeaderValue::from_str(&value) {
            headers.insert(HeaderName::from_static(name), value);
        }
    }
}
