//! `POST /v1/tradeoff`: what accuracy costs for a scene, as JSON or as a page, within `?seconds=`.

use super::explain::{Answer, ask, to_json};
use super::render::gone;
use crate::http::App;
use crate::http::Service;
use crate::http::contract::bodies::Bytes;
use crate::http::contract::generated::{Scene, Tradeoff as Report};
use crate::http::contract::queries;
use crate::http::extract::accept;
use crate::http::extract::query::Parameters;
use crate::http::problem::Problem;
use crate::service::scheduler::admission::Work;
use crate::service::tradeoff::{Outcome, Stopped, measure};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;
use strahl::film::Region;
use strahl::scene::{Format, Overrides, load_with};
use strahl::tradeoff::page::page;

/// Seconds it takes where nobody says how many.
const SECONDS: f64 = 10.0;

/// How an answer is written.
#[derive(Debug, Clone, Copy)]
enum Form {
    Json,
    Html,
}

/// Forms by name and media type; of equally acceptable ones the first is taken.
const FORMS: [(&str, &str, Form); 2] = [("json", "application/json", Form::Json), ("html", "text/html", Form::Html)];

/// What accuracy costs for a scene: many settings, their errors and times.
#[utoipa::path(
    post, path = "/v1/tradeoff", operation_id = "tradeoff", tag = "render",
    params(queries::Measure, queries::Settings),
    request_body(
        description = "The scene; NFF plain or gzip",
        content((Scene = "application/json"), (String = "text/x-nff"), (Bytes = "application/gzip"))
    ),
    responses((status = 200, description = "The report", content((Report = "application/json"), (String = "text/html")))),
)]
pub(crate) async fn tradeoff(State(service): State<App>, request: Request) -> Result<Response, Problem> {
    let most = service.limits.tradeoff_seconds();
    let extra = move |parameters: &mut Parameters, headers: &HeaderMap| {
        let seconds = parameters.seconds(most).unwrap_or(SECONDS.min(most));
        Ok((seconds, form(parameters, headers)?))
    };
    let mut response = ask(service, request, extra, answer).await?;
    response.headers_mut().insert(header::VARY, HeaderValue::from_static("Accept"));
    Ok(response)
}

fn form(parameters: &mut Parameters, headers: &HeaderMap) -> Result<Form, Problem> {
    let named = parameters.choice("format", &FORMS.map(|(name, _, form)| (name, Some(form))), None);
    named.map_or_else(|| accept::best(headers, &FORMS.map(|(_, media_type, form)| (media_type, form))), Ok)
}

fn answer(
    service: &Service,
    job: &Work,
    bytes: &[u8],
    format: Format,
    overrides: &Overrides,
    (seconds, form): (f64, Form),
) -> Result<Answer, Problem> {
    // Kept scenes have no description any more, and settings are put over this one.
    let files = service.scenes.files();
    let loaded = job
        .workers
        .work(|| load_with(bytes, format, overrides, files))
        .map_err(|_| gone())?
        .map_err(|problems| Problem::scene(&problems))?;
    service.limits.check(&loaded.scene, Region::whole(loaded.scene.width, loaded.scene.height))?;
    let measured = measure(loaded, files, job.started, seconds, &job.workers, &job.control);
    let Outcome { tradeoff, thumbnails } = measured.map_err(|stopped| match stopped {
        Stopped::Cancelled => gone(),
        Stopped::Refused(problems) => Problem::scene(&problems),
    })?;
    match form {
        Form::Json => to_json(&tradeoff),
        Form::Html => Ok(("text/html; charset=utf-8", page(&tradeoff, &thumbnails).into_bytes())),
    }
}
