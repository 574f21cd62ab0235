//! `POST /v1/scenes/validate`: all problems of a scene, without rendering it.

use crate::http::prelude::*;
use crate::http::respond::{Answer, to_json};
use crate::http::scene_job::{Question, ask};
use strahl::scene::{self};

pub(super) fn routes() -> Vec<Route> {
    let about = "Checks a scene without rendering it: all its problems, or none and perhaps warnings.";
    vec![Route::post("/v1/scenes/validate", validate, ["validateScene", "render", about]).about_scene().answer(
        200,
        "The scene is valid",
        &[Content::json::<ValidationResult<'_>>()],
    )]
}

/// The answer about a valid scene.
#[derive(Debug, Serialize, JsonSchema)]
struct ValidationResult<'a> {
    /// True. The answer about an invalid scene is a problem.
    valid: bool,
    /// Warnings about the scene.
    warnings: &'a [scene::Problem],
}

async fn validate(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    ask(app, request, |_, _| Ok(()), answer).await
}

fn answer(Question { app, work, sent, .. }: Question<'_>, (): ()) -> Result<Answer, Problem> {
    let ready = app.service.scenes.find(&work.workers, sent)?.ready;
    to_json(&app.service.memory, &ValidationResult { valid: true, warnings: &ready.scene.warnings })
}
