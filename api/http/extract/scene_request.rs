//! Requests about a scene: a content type, a query, and the scene as the body.

use super::body;
use super::query::Query;
use super::variation::{self, is_variation};
use crate::http::auth::tenant::Tenant;
use crate::http::problem::Problem;
use crate::http::state::AppState;
use crate::service::memory_budget::MeteredBytes;
use crate::service::scenes::sent_scene::Form;
use axum::extract::Request;
use axum::http::request::Parts;
use axum::http::{HeaderMap, Method};
use std::sync::Arc;
use strahl::scene::{Format, Overrides};

/// A request, read completely and checked except for the scene.
#[derive(Debug)]
pub(crate) struct SceneRequest<P> {
    /// What the body is.
    pub(crate) form: Form,
    /// Settings that replace the scene's.
    pub(crate) overrides: Overrides,
    /// Parameters of this kind of request only.
    pub(crate) extra: P,
    /// The tenant.
    pub(crate) tenant: Arc<Tenant>,
    /// The request's method.
    pub(crate) method: Method,
    /// Its headers.
    pub(crate) headers: HeaderMap,
    /// The scene, or what is different in a variation of one.
    pub(crate) body: MeteredBytes,
}

/// Reads a request. `extra` reads the parameters of this kind of request only.
pub(crate) async fn read<P>(
    app: &AppState,
    request: Request,
    extra: impl FnOnce(&mut Query, &HeaderMap) -> Result<P, Problem>,
) -> Result<SceneRequest<P>, Problem> {
    let (parts, body) = request.into_parts();
    match check(app, &parts, extra) {
        Ok((declared, overrides, extra)) => {
            let tenant = Tenant::of(&parts.extensions);
            let body = body::read(app, &tenant, &parts.headers, body).await?;
            let format = body::check_content(declared, body.as_ref())?;
            let Parts { method, headers, .. } = parts;
            let is_json = format == Format::Json;
            let (form, body) = if body::declares_variation(&headers) || is_json && is_variation(body.as_ref()) {
                let (service, sender) = (Arc::clone(&app.service), Arc::clone(&tenant));
                let read = move || -> Result<_, Problem> {
                    let (form, patch) = variation::read(&service, &sender, body.as_ref())?;
                    Ok((form, service.memory.metered(patch.to_vec())?))
                };
                app.service.storage_threads.run(&tenant.name, read).await??
            } else {
                (Form::Whole(format), body)
            };
            Ok(SceneRequest { form, overrides, extra, tenant, method, headers, body })
        }
        Err(problem) => {
            body::discard(app, &parts.headers, body).await;
            Err(problem)
        }
    }
}

fn check<P>(
    app: &AppState,
    parts: &Parts,
    extra: impl FnOnce(&mut Query, &HeaderMap) -> Result<P, Problem>,
) -> Result<(Option<Format>, Overrides, P), Problem> {
    app.drain.accepts_work()?;
    let declared = body::declared_format(&parts.headers)?;
    let mut query = Query::of(&parts.uri)?;
    let overrides = query.settings(declared.unwrap_or(Format::Json));
    let extra = extra(&mut query, &parts.headers)?;
    query.finish()?;
    Ok((declared, overrides, extra))
}
