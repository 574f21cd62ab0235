//! What all requests about a scene share: a content type, parameters, and the scene itself as the body.

use super::body::{self, Held};
use super::query::Parameters;
use crate::http::Service;
use crate::http::auth::tenant::Tenant;
use crate::http::problem::{Kind, Problem};
use axum::extract::Request;
use axum::http::request::Parts;
use axum::http::{HeaderMap, Method};
use std::sync::Arc;
use strahl::scene::{Format, Overrides};

/// A request, read completely and checked except for the scene.
#[derive(Debug)]
pub(crate) struct SceneRequest<P> {
    /// The format of the scene.
    pub(crate) format: Format,
    /// Settings put over the scene's.
    pub(crate) overrides: Overrides,
    /// The parameters that only some requests take.
    pub(crate) extra: P,
    /// Who asks.
    pub(crate) tenant: Arc<Tenant>,
    /// The request's method.
    pub(crate) method: Method,
    /// Its headers.
    pub(crate) headers: HeaderMap,
    /// The scene.
    pub(crate) body: Held,
}

/// Reads a request; `further` takes the parameters that only this kind of request has.
pub(crate) async fn read<P>(
    service: &Service,
    request: Request,
    extra: impl FnOnce(&mut Parameters, &HeaderMap) -> Result<P, Problem>,
) -> Result<SceneRequest<P>, Problem> {
    let (parts, body) = request.into_parts();
    match check(service, &parts, extra) {
        Ok((format, overrides, extra)) => {
            let body = body::read(service, &parts.headers, body).await?;
            let tenant = Tenant::of(&parts.extensions);
            let Parts { method, headers, .. } = parts;
            Ok(SceneRequest { format, overrides, extra, tenant, method, headers, body })
        }
        Err(problem) => {
            body::discard(service, &parts.headers, body).await;
            Err(problem)
        }
    }
}

fn check<P>(
    service: &Service,
    parts: &Parts,
    extra: impl FnOnce(&mut Parameters, &HeaderMap) -> Result<P, Problem>,
) -> Result<(Format, Overrides, P), Problem> {
    if service.drain.has_begun() {
        return Err(Problem::new(Kind::Draining, "the service is about to stop and takes no new work").retry_after(1));
    }
    let format = body::scene_format(&parts.headers)?;
    let mut parameters = Parameters::of(&parts.uri)?;
    let overrides = parameters.overrides(format);
    let extra = extra(&mut parameters, &parts.headers)?;
    parameters.finish()?;
    Ok((format, overrides, extra))
}
