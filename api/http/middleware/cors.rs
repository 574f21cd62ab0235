//! Which pages may use the service from a browser (CORS). It stands outside of keys and limits, so that a page can read
//! why it was refused.
//!
//! Cookies play no part: a page gets what any client gets that reaches the service and has a key. tower-http's layer
//! takes every OPTIONS for a preflight request; here those that are not still reach their handlers.

use crate::http::App;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// Headers of answers that pages may read.
const EXPOSED: &str = "Content-Disposition, Content-Location, ETag, Idempotency-Replayed, Link, Location, \
                       Preference-Applied, RateLimit, RateLimit-Policy, Render-Error, Render-Plan, Render-Rays, \
                       Render-Warnings, Repr-Digest, Retry-After, Server-Timing, WWW-Authenticate, X-Request-Id";
const METHODS: &str = "GET, HEAD, POST, QUERY, PUT, PATCH, DELETE";
/// Seconds a browser may remember the answer to a preflight request.
const MAX_AGE: &str = "7200";

/// Whose pages may ask.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Origins {
    /// Everybody's.
    Any,
    /// These, such as `https://example.org`; perhaps none.
    Listed(Vec<String>),
}

impl Origins {
    /// From the command line: `*`, `none`, or origins between commas.
    pub(crate) fn read(text: &str) -> Result<Self, &'static str> {
        match text.trim() {
            "*" => Ok(Self::Any),
            "none" => Ok(Self::Listed(Vec::new())),
            list => {
                let origins: Vec<_> = list.split(',').map(|origin| origin.trim().to_owned()).collect();
                let sound = |origin: &String| {
                    let host = origin.strip_prefix("https://").or_else(|| origin.strip_prefix("http://"));
                    host.is_some_and(|host| !host.is_empty() && host.bytes().all(|b| b.is_ascii_graphic() && b != b'/'))
                };
                let wrong = "expected *, none, or origins such as https://example.org, separated by commas";
                origins.iter().all(sound).then_some(Self::Listed(origins)).ok_or(wrong)
            }
        }
    }

    /// What `Access-Control-Allow-Origin` says to a request.
    fn allowed(&self, headers: &HeaderMap) -> Option<HeaderValue> {
        match self {
            Self::Any => Some(HeaderValue::from_static("*")),
            Self::Listed(origins) => {
                let origin = headers.get(header::ORIGIN)?;
                origins.iter().any(|known| known.as_bytes() == origin.as_bytes()).then(|| origin.clone())
            }
        }
    }
}

/// Answers preflight requests, and marks all other answers.
pub(crate) async fn cors(State(service): State<App>, request: Request, next: Next) -> Response {
    let origins = &service.access.origins;
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
    if matches!(origins, Origins::Listed(_)) {
        headers.append(header::VARY, HeaderValue::from_static("Origin"));
    }
    if let Some(allowed) = allowed {
        headers.insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, allowed);
        headers.insert(header::ACCESS_CONTROL_EXPOSE_HEADERS, HeaderValue::from_static(EXPOSED));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_read_and_matched_exactly() {
        let of = |origin: &'static str| HeaderMap::from_iter([(header::ORIGIN, HeaderValue::from_static(origin))]);
        let listed = Origins::read("https://a.org, http://localhost:3000").unwrap();
        assert_eq!(listed.allowed(&of("https://a.org")).unwrap(), "https://a.org");
        assert_eq!(listed.allowed(&of("https://a.org.evil")), None);
        assert_eq!(listed.allowed(&HeaderMap::new()), None);
        assert_eq!(Origins::read("*").unwrap().allowed(&HeaderMap::new()).unwrap(), "*");
        assert_eq!(Origins::read("none").unwrap().allowed(&of("https://a.org")), None);
        for wrong in ["", "a.org", "https://", "https://a.org/", "https://a.org, *"] {
            assert!(Origins::read(wrong).is_err(), "{wrong}");
        }
    }
}
