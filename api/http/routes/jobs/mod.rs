//! `/v1/jobs`: renders in the background, with their events and previews.

mod change;
mod events;
mod frames;
mod look;
mod preview;
mod status;
mod submit;

use crate::http::extract::named_job::{NamedJob, find};
use crate::http::prelude::*;
use crate::http::respond::forward::{Question, packed, unknown};

/// Description of the id in paths of jobs.
const ID: &str = "The job's id.";

pub(super) fn routes() -> Vec<Route> {
    let groups =
        [submit::routes, status::routes, change::routes, look::routes, frames::routes, preview::routes, events::routes];
    groups.into_iter().flat_map(|routes: fn() -> Vec<Route>| routes()).collect()
}

/// The answer to another front, about a job that this one works on.
pub(super) async fn answer_front(app: App, question: Vec<u8>) -> (Vec<u8>, Vec<u8>) {
    let answer = match answered(app, &question).await {
        Ok(answer) => answer,
        Err(problem) => problem.into_response(),
    };
    packed(answer).await
}

async fn answered(app: App, question: &[u8]) -> Result<Response, Problem> {
    let question: Question = serde_json::from_slice(question).map_err(|_| unknown())?;
    let (request, tenant) = question.request().ok_or_else(unknown)?;
    let job = NamedJob { job: find(&app, &tenant, &question.job).await?, tenant };
    match question.what.as_str() {
        "preview" => preview::preview(State(app), job, request).await,
        "tile" => look::tile(State(app), job, request).await,
        "look" => look::look(State(app), job, request).await,
        _ => Err(unknown()),
    }
}
