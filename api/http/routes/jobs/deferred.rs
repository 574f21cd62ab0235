//! `POST /v1/render` with `Prefer: respond-async` or `wait=N`: the render becomes a job, and the answer is the picture if
//! it is done in time, else the job.

use super::pictures::picture_of;
use super::submit::{Claimed, Wanted, accept, accepted, claim};
use super::until_final;
use crate::http::App;
use crate::http::extract::prefer::Prefer;
use crate::http::extract::scene_request;
use crate::http::extract::scene_request::SceneRequest;
use crate::http::problem::Problem;
use crate::service::jobs::record::State;
use crate::service::scheduler::task::PRIORITY;
use axum::extract::Request;
use axum::response::Response;
use std::time::Duration;

/// Renders as a job.
pub(crate) async fn render_later(service: App, request: Request, prefer: Prefer) -> Result<Response, Problem> {
    let headers = request.headers().clone();
    let query = request.uri().query().unwrap_or_default().to_owned();
    let SceneRequest { format, overrides, extra: output, tenant, method, body, .. } =
        scene_request::read(&service, request, |parameters, headers| parameters.picture_format(headers)).await?;
    // The query is part of what is submitted.
    let whole = [query.as_bytes(), b"\n", body.as_ref()].concat();
    let job = match claim(&service, &tenant, &headers, &whole)? {
        Claimed::Before(job) => return Ok(accepted(&service, &job, true, prefer).await),
        Claimed::Now(claim) => {
            let scene = body.as_ref().to_vec();
            drop((body, whole));
            let wanted = Wanted { scene, format, overrides, output, priority: PRIORITY, labels: Vec::new() };
            accept(&service, &tenant, wanted, claim).await?
        }
    };
    until_final(&service, &job, prefer.wait.unwrap_or(Duration::ZERO)).await;
    if job.record().state == State::Succeeded {
        return picture_of(&service, &tenant, &method, &headers, &job).await;
    }
    Ok(accepted(&service, &job, false, prefer).await)
}
