//! Authorization: the tenant of a request, the scopes of its key, and its rate limit.

use crate::http::auth::rate_limit::Left;
use crate::http::auth::tenant::{Scope, Tenant};
use crate::http::problem::{Kind, Problem};
use crate::http::state::App;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::time::Instant;

/// Puts the tenant into the request's extensions. A request without a key has no tenant if the service needs keys. A wrong
/// key or capability is refused, also on paths that need none.
pub(crate) async fn identify(State(app): State<App>, mut request: Request, next: Next) -> Result<Response, Problem> {
    if let Some(tenant) = app.access.tenant(&request)? {
        request.extensions_mut().insert(tenant);
    }
    Ok(next.run(request).await)
}

/// Refuses requests whose key lacks a scope, and charges the tenant unless they are free. Rays are charged where they are traced.
pub(crate) async fn require(scope: Scope, is_free: bool, request: Request, next: Next) -> Result<Response, Problem> {
    let tenant = request.extensions().get::<Arc<Tenant>>().map(Arc::clone).ok_or_else(|| {
        let detail = "this service asks for a key: send Authorization: Bearer rk_...";
        Problem::new(Kind::Unauthorized, detail)
    })?;
    if !tenant.may(scope) {
        let detail = format!("this key lacks the scope {}, which {} asks for", scope.name(), request.uri().path());
        return Err(Problem::new(Kind::Forbidden, detail).with_scope(scope.name()));
    }
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
