//! `POST /v1/tradeoff`: what accuracy costs for a scene, as JSON or as a page, within `?seconds=`.

use crate::http::extract::accept;
use crate::http::extract::scene_request::{self, SceneRequest};
use crate::http::prelude::*;
use crate::http::respond::events::{Event, events, streamed_event};
use crate::http::respond::{Answer, body, to_json};
use crate::http::state::AppState;
use crate::service::error::Error;
use crate::service::scenes::cache::Built;
use crate::service::scenes::sent_scene::SentScene;
use crate::service::scheduler::admission::Work;
use crate::service::scheduler::task::Class;
use crate::service::tradeoff::progress::{Progress, Watch};
use crate::service::tradeoff::{Outcome, Stopped, measure};
use serde_json::json;
use strahl::film::Region;
use strahl::tradeoff::Tradeoff;
use strahl::tradeoff::page::page;
use tokio::sync::mpsc;

/// Findings that wait for a client.
const WAITING: usize = 64;

/// Default time limit in seconds.
const SECONDS: f64 = 10.0;

/// Bytes for each pixel of the picture that is measured: the references, those to choose from, and the one that is rendered.
const PIXEL_BYTES: u64 = 260;

/// Form of the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Form {
    Json,
    Html,
    /// What is found, as it is found.
    Events,
}

/// Forms by media type. Of equally acceptable ones the first is used.
const FORMS: [(&str, Form); 3] =
    [("application/json", Form::Json), ("text/html", Form::Html), ("text/event-stream", Form::Events)];

pub(super) fn routes() -> Vec<Route> {
    let about = "What accuracy costs for a scene: many settings, their errors and times.\n\nAs `text/event-stream` what is found \
                 comes as it is found: `reference` and `point` for each size of pictures, then `front` for each front, then `done` \
                 with the report, or `failed` with a problem.";
    vec![
        Route::post("/v1/tradeoff", tradeoff, ["tradeoff", "render", about])
            .query(|query| query.seconds(None))
            .query(form)
            .about_scene()
            .answer(
                200,
                "The report",
                &[
                    Content::json::<Tradeoff>(),
                    Content::text("text/html"),
                    Content::of("text/event-stream", |_| streamed_event()),
                ],
            ),
    ]
}

async fn tradeoff(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let most = app.service.settings.answers.tradeoff_seconds();
    let extra = move |query: &mut Query, headers: &HeaderMap| {
        let seconds = query.seconds(Some(most)).unwrap_or(SECONDS.min(most));
        let form = form(query).map_or_else(|| accept::best(headers, &FORMS), Ok)?;
        Ok((seconds, form))
    };
    let SceneRequest { form: sent_as, overrides, extra: (seconds, form), tenant, body, .. } =
        scene_request::read(&app, request, extra).await?;
    let (sender, found) = mpsc::channel(WAITING);
    let work = {
        let app = Arc::clone(&app);
        // Those who do not read miss what is found, and nobody waits for them.
        let watch = move |progress| drop(sender.try_send(progress));
        move |work: &Work| {
            let sent = SentScene::new(body.as_ref(), &sent_as, &overrides);
            measured(&app, work, &sent, seconds, &watch)
        }
    };
    let task = tenant.task(Class::Renders);
    let mut response = if form == Form::Events {
        let service = Arc::clone(&app.service);
        let outcome = Box::pin(async move { service.run(task, work).await.map(|done| done.value) });
        events(found, outcome, told, finished).await?
    } else {
        let outcome = app.service.run(task, work).await?.value;
        written(&app, form, &outcome)?.into_response()
    };
    response.headers_mut().insert(header::VARY, HeaderValue::from_static("Accept"));
    Ok(response)
}

fn form(query: &mut Query) -> Option<Form> {
    query.word("format", "Format of the report, whatever `Accept` says.")
}

/// Measures what accuracy costs for a scene.
fn measured(
    app: &AppState,
    work: &Work,
    sent: &SentScene<'_>,
    seconds: f64,
    watch: Watch<'_>,
) -> Result<Outcome, Error> {
    // Scenes in the cache have no description, which is needed to change settings.
    let scenes = &app.service.scenes;
    let limits = &app.service.settings.answers;
    let built = scenes.build(&work.workers, sent, &|scene| limits.check_unbuilt(scene, None))?;
    let Built { loaded, original: _original, mut share } = built;
    let region = Region::whole(loaded.scene.width, loaded.scene.height);
    limits.check(region, loaded.scene.samples)?;
    // The scene in both precisions, and pictures of all settings and references.
    let built = share.bytes().max(loaded.scene.bytes() as u64);
    share.grow(3 * built + region.pixels() * PIXEL_BYTES)?;
    let (workers, control) = (&work.workers, &work.control);
    let measured =
        measure(loaded, &scenes.files(Some(workers.tenant())), work.started, seconds, workers, control, watch);
    measured.map_err(|stopped| match stopped {
        Stopped::Cancelled => Error::Cancelled,
        Stopped::Refused(problems) => Error::Scene(problems),
    })
}

fn written(app: &AppState, form: Form, outcome: &Outcome) -> Result<Answer, Problem> {
    let (memory, Outcome { tradeoff, thumbnails }) = (&app.service.memory, outcome);
    match form {
        Form::Html => {
            let page = memory.metered(page(tradeoff, thumbnails).into_bytes())?;
            Ok(Answer::new("text/html; charset=utf-8", body(page)))
        }
        Form::Json | Form::Events => to_json(memory, tradeoff),
    }
}

/// Something that was found, as an event.
fn told(progress: Progress) -> Event {
    let name = match progress {
        Progress::Reference(_) => "reference",
        Progress::Point(_) => "point",
    };
    (name, json!(progress))
}

/// The events at the end.
fn finished(Outcome { tradeoff, .. }: Outcome) -> Vec<Event> {
    let fronts = tradeoff.fronts.iter().map(|front| ("front", json!(front)));
    fronts.chain([("done", json!(tradeoff))]).collect()
}
