//! Requests about a scene, sent or known by the id of its image, that are answered by one piece of work on the pool.

use super::auth::tenant::Tenant;
use super::extract::query::Query;
use super::extract::scene_request::{self, SceneRequest};
use super::problem::Problem;
use super::respond::Answer;
use super::respond::image::image_id;
use super::state::{App, AppState};
use crate::service::error::Error;
use crate::service::pictures::spec::size_of;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scenes::sent_scene::SentScene;
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
    /// Who asks.
    pub(crate) tenant: &'a Tenant,
}

/// Reads a request, queues it, and answers it. `extra` reads the parameters that only this kind of request has.
pub(crate) async fn ask<P: Send + 'static>(
    app: App,
    request: Request,
    extra: impl FnOnce(&mut Query, &HeaderMap) -> Result<P, Problem>,
    answer: impl FnOnce(Question<'_>, P) -> Result<Answer, Problem> + Send + 'static,
) -> Result<Response, Problem> {
    let SceneRequest { form, overrides, extra, tenant, body, .. } = scene_request::read(&app, request, extra).await?;
    let task = tenant.task(Class::Renders);
    let work = {
        let app = Arc::clone(&app);
        move |work: &Work| {
            let sent = SentScene::new(body.as_ref(), &form, &overrides);
            answer(Question { app: &app, work, sent: &sent, tenant: &tenant }, extra)
        }
    };
    Ok(app.service.run(task, work).await?.value.into_response())
}

/// Answers a question about the pixels of a known image. `extra` reads the parameters of this kind of question.
pub(crate) async fn ask_image<P: Send + 'static>(
    app: App,
    id: String,
    request: Request,
    extra: impl FnOnce(&mut Query) -> P,
    answer: impl FnOnce(&AppState, &Work, &Arc<PreparedScene>, P) -> Result<Answer, Problem> + Send + 'static,
) -> Result<Response, Problem> {
    app.drain.accepts_work()?;
    let image = image_id(&id)?;
    let extra = Query::read(request.uri(), extra)?;
    let task = Tenant::of(request.extensions()).task(Class::Renders);
    let work = {
        let app = Arc::clone(&app);
        move |work: &Work| {
            let unknown = || Error::UnknownScene(image.scene.clone());
            let ready = app.service.known_scene(work, &image.scene)?.ready;
            // Beyond the size of images neighbouring pixels have the same rays.
            size_of(&ready.scene, image.zoom).ok_or_else(unknown)?;
            let opened = ready.opened(image.zoom).ok_or_else(unknown)?;
            answer(&app, work, &opened, extra)
        }
    };
    let answer = app.service.run(task, work).await?.value;
    Ok(([(header::CACHE_CONTROL, "no-cache")], answer).into_response())
}
