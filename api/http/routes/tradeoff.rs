//! `POST /v1/tradeoff`: what accuracy costs for a scene, as JSON or as a page, within `?seconds=`.

use crate::http::extract::accept;
use crate::http::prelude::*;
use crate::http::respond::{Answer, body, to_json};
use crate::http::scene_job::{Question, ask};
use crate::service::error::Error;
use crate::service::tradeoff::{Outcome, Stopped, measure};
use strahl::film::Region;
use strahl::tradeoff::Tradeoff;
use strahl::tradeoff::page::page;

/// Default time limit in seconds.
const SECONDS: f64 = 10.0;

/// Bytes for each pixel of the picture that is measured: the references, those to choose from, and the one that is rendered.
const PIXEL_BYTES: u64 = 260;

/// Form of the answer.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Form {
    Json,
    Html,
}

/// Forms by media type. Of equally acceptable ones the first is used.
const FORMS: [(&str, Form); 2] = [("application/json", Form::Json), ("text/html", Form::Html)];

pub(super) fn routes() -> Vec<Route> {
    let about = "What accuracy costs for a scene: many settings, their errors and times.";
    vec![
        Route::post("/v1/tradeoff", tradeoff, ["tradeoff", "render", about])
            .query(|query| query.seconds(None))
            .query(form)
            .about_scene()
            .answer(200, "The report", &[Content::json::<Tradeoff>(), Content::text("text/html")]),
    ]
}

async fn tradeoff(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let most = app.service.settings.answers.tradeoff_seconds();
    let extra = move |query: &mut Query, headers: &HeaderMap| {
        let seconds = query.seconds(Some(most)).unwrap_or(SECONDS.min(most));
        let form = form(query).map_or_else(|| accept::best(headers, &FORMS), Ok)?;
        Ok((seconds, form))
    };
    let mut response = ask(app, request, extra, answer).await?;
    response.headers_mut().insert(header::VARY, HeaderValue::from_static("Accept"));
    Ok(response)
}

fn form(query: &mut Query) -> Option<Form> {
    query.word("format", "Format of the report, whatever `Accept` says.")
}

fn answer(Question { app, work, sent }: Question<'_>, (seconds, form): (f64, Form)) -> Result<Answer, Problem> {
    // Scenes in the cache have no description, which is needed to change settings.
    let scenes = &app.service.scenes;
    let limits = &app.service.settings.answers;
    let loaded = scenes.build(
        &work.workers,
        sent,
        |scene| limits.check_unbuilt(scene, None),
        |loaded, share| (loaded, share),
    )?;
    let (loaded, mut share) = loaded;
    let region = Region::whole(loaded.scene.width, loaded.scene.height);
    limits.check(region, loaded.scene.samples)?;
    // The scene in both precisions, and pictures of all settings and references.
    let memory = &app.service.memory;
    share.grow(3 * share.bytes() + region.pixels() * PIXEL_BYTES)?;
    let measured = measure(loaded, scenes.files(), work.started, seconds, &work.workers, &work.control);
    let Outcome { tradeoff, thumbnails } = measured.map_err(|stopped| match stopped {
        Stopped::Cancelled => Error::Cancelled,
        Stopped::Refused(problems) => Error::Scene(problems),
    })?;
    match form {
        Form::Json => to_json(memory, &tradeoff),
        Form::Html => {
            Ok(("text/html; charset=utf-8", body(memory.metered(page(&tradeoff, &thumbnails).into_bytes())?)))
        }
    }
}
