//! CORS: which pages may use the service from a browser. It comes before keys and limits, so that a page can read why it was
//! refused.
//!
//! Cookies play no part: a page gets what any client gets that reaches the service and has a key. Where none is needed, only
//! pages of this machine get anything, unless told otherwise. tower-http's layer
//! takes every OPTIONS for a preflight request; here those that are not still reach their handlers.

use crate::http::settings::Origins;
use crate::http::state::App;
use axum::extract::{Request, State};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// Headers of answers that pages may read.
const EXPOSED: &str = "Accept-Encoding, Accept-Patch, Content-Disposition, Content-Location, ETag, Idempotency-Replayed, Link, \
                       Location, Preference-Applied, Preview-Revision, RateLimit, RateLimit-Policy, Render-Error, Render-Plan, \
                       Render-Rays, Render-Warnings, Repr-Digest, Retry-After, Server-Timing, WWW-Authenticate, X-Request-Id";
const METHODS: &str = "GET, HEAD, POST, QUERY, PUT, PATCH, DELETE";
/// Seconds for which a browser may cache the answer to a preflight request.
const MAX_AGE: &str = "7200";

/// Answers preflight requests, and adds CORS headers to all other answers.
pub(crate) async fn cors(State(app): State<App>, request: Request, next: Next) -> Response {
    let origins = &app.origins;
    let allowed = origins.allowed(request.headers());
    let preflight =
        *request.method() == Method::OPTIONS && request.headers().contains_key(header::ACCESS_CONTROL_REQUEST_METHOD);
    let mut response = if preflight {
        let wanted = request.headers().get(header::ACCESS_CONTROL_REQUEST_HEADERS).cloned();
        let mut response = StatusCode::NO_CONTENT.into_response();
        if allowed.is_some() {
            let headers = response.headers_mut();
            headers.insert(header::ACCESS_CONTROL_ALLOW_METHODS, HeaderValue::from_static(METHODS));
            headers.insert(header::ACCESS_CONTROL_MAX_AGE, HeaderValue::from_static(MAX_AGE));
            if let Some(wanted) = wanted {
                headers.insert(header::ACCESS_CONTROL_ALLOW_HEADERS, wanted);
            }
        }
        response
    } else {
        next.run(request).await
    };
    let headers = response.headers_mut();
    if *origins != Origins::Any {
        headers.append(header::VARY, HeaderValue::from_static("Origin"));
    }
    if let Some(allowed) = allowed {
        headers.insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, allowed);
        headers.insert(header::ACCESS_CONTROL_EXPOSE_HEADERS, HeaderValue::from_static(EXPOSED));
    }
    response
}
