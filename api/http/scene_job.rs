//! Requests about a scene that are answered by one piece of work on the pool.

use super::extract::query::Query;
use super::extract::scene_request::{self, SceneRequest};
use super::problem::Problem;
use super::respond::Answer;
use super::state::{App, AppState};
use crate::service::scenes::cache::SentScene;
use crate::service::scheduler::admission::Work;
use crate::service::scheduler::task::Class;
use axum::extract::Request;
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;

/// What is needed for the answer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Question<'a> {
    /// The state that handlers share.
    pub(crate) app: &'a AppState,
    /// The threads that render.
    pub(crate) work: &'a Work,
    /// The scene that was sent.
    pub(crate) sent: &'a SentScene<'a>,
}

/// Reads a request, queues it, and answers it. `extra` reads the parameters that only this kind of request has.
pub(crate) async fn ask<P: Send + 'static>(
    app: App,
    request: Request,
    extra: impl FnOnce(&mut Query, &HeaderMap) -> Result<P, Problem>,
    answer: impl FnOnce(Question<'_>, P) -> Result<Answer, Problem> + Send + 'static,
) -> Result<Response, Problem> {
    let SceneRequest { format, overrides, extra, tenant, body, .. } = scene_request::read(&app, request, extra).await?;
    let work = {
        let app = Arc::clone(&app);
        move |work: &Work| {
            let sent = SentScene::new(body.as_ref(), format, &overrides);
            answer(Question { app: &app, work, sent: &sent }, extra)
        }
    };
    let (media_type, body) = app.service.run(tenant.task(Class::Renders), work).await?.value;
    Ok(([(header::CONTENT_TYPE, media_type)], body).into_response())
}
