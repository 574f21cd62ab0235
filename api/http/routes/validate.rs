//! `POST /v1/scenes/validate`: all problems of a scene, without rendering it.

use crate::http::auth::tenant::Scope;
use crate::http::contract::{Body, Content, Route};
use crate::http::problem::Problem;
use crate::http::respond::{Answer, to_json};
use crate::http::scene_job::{Question, ask};
use crate::http::state::App;
use axum::extract::{Request, State};
use axum::response::Response;
use schemars::JsonSchema;
use serde::Serialize;
use strahl::scene::{self, Format};

pub(super) fn routes() -> Vec<Route> {
    let about = "Checks a scene without rendering it: all its problems, or none and perhaps warnings.";
    vec![
        Route::post("/v1/scenes/validate", validate, ["validateScene", "render", about])
            .needs(Scope::Render)
            .query(|query| {
                query.settings(Format::Json);
            })
            .body(Body::scene())
            .answer(200, "The scene is valid", &[Content::json::<Valid<'_>>()]),
    ]
}

/// A valid scene.
#[derive(Debug, Serialize, JsonSchema)]
struct Valid<'a> {
    /// True; a scene that is not valid is answered with a problem.
    valid: bool,
    /// What the author should know.
    warnings: &'a [scene::Problem],
}

async fn validate(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    ask(app, request, |_, _| Ok(()), answer).await
}

fn answer(Question { app, work, sent }: Question<'_>, (): ()) -> Result<Answer, Problem> {
    let ready = app.service.scenes.find(&work.workers, sent)?.ready;
    to_json(&Valid { valid: true, warnings: &ready.scene.warnings })
}
