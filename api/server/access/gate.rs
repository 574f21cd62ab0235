//! The gate before the handlers: first who asks, then whether they may, and whether they have not asked too often.

use super::allowance::Left;
use super::{Access, Capability};
use crate::server::App;
use crate::server::cost::Cost;
use crate::server::problem::{Kind, Problem};
use crate::server::tenant::{Scope, Tenant};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::time::{Instant, SystemTime};

/// Puts the tenant into the request's extensions. A request without a key has none where keys are asked for; a key or a
/// capability that is not good is refused, whatever it was shown for.
pub(crate) async fn identify(
    State(service): State<App>,
    mut request: Request,
    next: Next,
) -> Result<Response, Problem> {
    if let Some(tenant) = service.access.tenant(&request)? {
        request.extensions_mut().insert(tenant);
    }
    Ok(next.run(request).await)
}

/// Lets those through who may do such a thing, and charges them for it.
pub(crate) async fn require(scope: Scope, request: Request, next: Next) -> Result<Response, Problem> {
    let tenant = request.extensions().get::<Arc<Tenant>>().map(Arc::clone).ok_or_else(|| {
        let detail = "this service asks for a key: send Authorization: Bearer rk_...";
        Problem::new(Kind::Unauthorized, detail)
    })?;
    if !tenant.may(scope) {
        let detail = format!("this key lacks the scope {}, which {} asks for", scope.name(), request.uri().path());
        return Err(Problem::new(Kind::Forbidden, detail).with("scope", scope.name().into()));
    }
    let Some(allowance) = &tenant.allowance else {
        return Ok(next.run(request).await);
    };
    let mut response = match allowance.enter(Instant::now()) {
        Ok(()) => next.run(request).await,
        Err(seconds) => {
            let detail = format!(
                "{} has used up its {} units for this minute (units_per_minute)",
                tenant.name,
                allowance.per_minute()
            );
            Problem::new(Kind::RateLimited, detail).retry_after(seconds).into_response()
        }
    };
    if let Some(cost) = response.extensions().get::<Cost>() {
        allowance.charge(cost.rays, Instant::now());
    }
    tell(allowance.left(Instant::now()), response.headers_mut());
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

impl Access {
    /// Whose request this is; nobody's where keys are asked for and none is shown.
    fn tenant(&self, request: &Request) -> Result<Option<Arc<Tenant>>, Problem> {
        let keys = self.keys();
        if let Some(capability) = request.extensions().get::<Capability>() {
            let signers = keys.as_ref().and_then(|keys| keys.signers.as_ref()).unwrap_or(&self.own);
            let name = capability.check(signers, request, now())?;
            let Some(keys) = &keys else { return Ok(Some(Arc::clone(&self.anonymous))) };
            let gone = || Problem::new(Kind::Forbidden, "the tenant of this capability is no longer in the key file");
            return keys.reader(&name).ok_or_else(gone).map(Some);
        }
        let Some(keys) = keys else { return Ok(Some(Arc::clone(&self.anonymous))) };
        let Some(header) = request.headers().get(header::AUTHORIZATION) else { return Ok(None) };
        let presented = header.to_str().ok().and_then(|text| {
            let (scheme, key) = text.split_once(' ')?;
            scheme.eq_ignore_ascii_case("bearer").then(|| key.trim())
        });
        let refused =
            || Problem::new(Kind::Unauthorized, "this key is not known here: it is Authorization: Bearer rk_...");
        presented.and_then(|key| keys.tenant(key)).ok_or_else(refused).map(Some)
    }

    /// A capability for one thing of a tenant's.
    pub(crate) fn sign(&self, id: &str, tenant: &str, expires: u64) -> String {
        let keys = self.keys();
        keys.as_ref().and_then(|keys| keys.signers.as_ref()).unwrap_or(&self.own).sign(id, tenant, expires)
    }
}

/// Seconds since 1970.
pub(crate) fn now() -> u64 {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |since| since.as_secs())
}
