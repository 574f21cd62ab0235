//! Checks the `Host` and `Origin` of requests to a service without keys, and the `Host` of all to the admin listener.
//!
//! Without keys every client that can reach the service can use it, and so can every page in a browser on this machine. CORS
//! keeps pages of other origins from reading answers, but requests such as `POST cancel` are sent all the same, and a page
//! whose name resolves to this machine (DNS rebinding) has the same origin. So both are refused here.

use super::request_log::{add_headers, request_id};
use crate::http::auth::client::Ends;
use crate::http::host::Host;
use crate::http::problem::{Kind, Problem};
use crate::http::state::{App, AppState};
use axum::extract::{Request, State};
use axum::http::{Version, header};
use axum::middleware::Next;
use axum::response::Response;

/// Puts the host into the request's extensions, and refuses requests that are not meant for this service.
pub(crate) async fn check_host(State(app): State<App>, mut request: Request, next: Next) -> Result<Response, Problem> {
    let host = host_of(&request)?;
    if !app.access.needs_keys() {
        check_reached(&app, &request, host.as_ref())?;
        check_origin(&app, &request, host.as_ref())?;
    }
    if let Some(host) = host {
        request.extensions_mut().insert(host);
    }
    Ok(next.run(request).await)
}

/// Refuses requests to the admin listener, which never asks for a key, under a name that is not its own, where it listens on
/// loopback. A page can give its own name this machine's address, but it cannot be at an address: so Prometheus may use any, also
/// that of a forwarded port. Where other machines reach the listener they may use any name: its figures are open to them.
pub(crate) async fn check_admin_host(State(app): State<App>, request: Request, next: Next) -> Response {
    let is_loopback = request.extensions().get::<Ends>().is_none_or(|ends| ends.service.is_loopback());
    let refused = match host_of(&request) {
        Ok(Some(host)) if is_loopback && host.address().is_none() && !is_own_name(&app, &host) => misdirected(
            &format!("the admin listener answers to localhost, to addresses and to --public-url, not to {host}"),
        ),
        Ok(_) => return next.run(request).await,
        Err(malformed) => malformed,
    };
    // There is no request log before the admin listener that would write it.
    let id = request_id(request.headers());
    let mut response = refused.answer(&id);
    add_headers(&mut response, &id);
    response
}

/// The host that a request is for (RFC 9112 section 3.2); only HTTP/1.0 may leave it out.
fn host_of(request: &Request) -> Result<Option<Host>, Problem> {
    let malformed = |detail: &str| Problem::new(Kind::MalformedRequest, detail);
    let mut headers = request.headers().get_all(header::HOST).iter();
    let host = match (headers.next(), headers.next()) {
        (None, _) if request.version() < Version::HTTP_11 => None,
        (None, _) => return Err(malformed("a request of HTTP/1.1 has a Host header")),
        (Some(_), Some(_)) => return Err(malformed("there is more than one Host header")),
        (Some(host), None) => Some(host.to_str().unwrap_or_default()),
    };
    // The address in the request line takes precedence over the header.
    let host = request.uri().authority().map(|authority| authority.as_str()).or(host);
    let wrong = || malformed("the Host header is a name or an address, and perhaps a port, such as localhost:8080");
    host.map(|host| Host::read(host).ok_or_else(wrong)).transpose()
}

fn check_reached(app: &AppState, request: &Request, host: Option<&Host>) -> Result<(), Problem> {
    let here = request.extensions().get::<Ends>().map(|ends| ends.service);
    let is_own = |host: &Host| is_own_name(app, host) || host.address().is_some_and(|address| Some(address) == here);
    match host {
        Some(host) if !is_own(host) => Err(misdirected(&format!(
            "a service without keys answers to localhost, to its own address and to --public-url, not to {host}"
        ))),
        _ => Ok(()),
    }
}

fn is_own_name(app: &AppState, host: &Host) -> bool {
    host.is_loopback() || app.public_host().is_some_and(|public| host.has_name_of(&public))
}

fn misdirected(answers_to: &str) -> Problem {
    let detail = format!("{answers_to}: a page of another site could use it under such a name");
    Problem::new(Kind::MisdirectedRequest, detail)
}

/// Browsers send an `Origin` with every request of a page that may change something.
fn check_origin(app: &AppState, request: &Request, host: Option<&Host>) -> Result<(), Problem> {
    let Some(origin) = request.headers().get(header::ORIGIN).filter(|_| !request.method().is_safe()) else {
        return Ok(());
    };
    let text = origin.to_str().unwrap_or_default();
    let page = Host::of_url(text);
    let is_own = page.is_some() && (page.as_ref() == host || page == app.public_host());
    if is_own || app.origins.allowed(request.headers()).is_some() {
        return Ok(());
    }
    let detail =
        format!("pages of {text} may change nothing in a service without keys, unless --cors-origin names them");
    Err(Problem::new(Kind::Forbidden, detail))
}
