//! `POST /v1/explain`: which effects a scene calls for, why, and what they should take.

use crate::http::prelude::*;
use crate::http::respond::{Answer, to_json};
use crate::http::scene_job::{Question, ask};
use crate::service::error::Error;
use crate::service::pictures::render::{self, RenderSpec};
use crate::service::pictures::report::{Analyzed, measured};
use crate::service::scenes::cache::Found;
use crate::service::scenes::prepared::planned;
use strahl::film::{FileFormat, Region};
use strahl::plan::Plan;
use strahl::scene::Description;

pub(super) fn routes() -> Vec<Route> {
    let about = "Which effects the scene calls for, why, and what they should take.\n\n\
                 `analyze` renders the picture, within the limits of any, and adds what they took, and what \
                 leaving each out saves.";
    vec![Route::post("/v1/explain", explain, ["explain", "render", about]).about_scene().query(analyze).answer(
        200,
        "The plan",
        &[Content::json::<Explained<'_>>()],
    )]
}

/// The plan of a scene, with `actual` if the picture was rendered.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
enum Explained<'a> {
    Analyzed(Analyzed<'a>),
    Planned(&'a Plan),
}

async fn explain(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    ask(app, request, |query, _| Ok(analyze(query)), answer).await
}

fn analyze(query: &mut Query) -> bool {
    let about = "Whether to render the picture, too, and put its actual figures beside the estimates.";
    query.flag("analyze", about).unwrap_or(false)
}

fn answer(Question { app, work, sent }: Question<'_>, analyze: bool) -> Result<Answer, Problem> {
    let limits = &app.service.settings.answers;
    let accept = |scene: &Description| if analyze { limits.check_unbuilt(scene, None) } else { Ok(()) };
    let Found { ready, loading, .. } = app.service.scenes.find_if(&work.workers, sent, accept)?;
    let region = Region::whole(ready.scene.width, ready.scene.height);
    if analyze {
        limits.check(region, ready.scene.samples)?;
    }
    let (plan, pilot) = planned(&ready, region, &work.workers, &work.control).map_err(Error::from)?;
    if !analyze {
        return to_json(&app.service.memory, &Explained::Planned(&plan));
    }
    let _share = app.service.room_for_picture(&ready, region.pixels(), render::PIXEL_BYTES)?;
    let shot = RenderSpec::of(&ready.scene, region, FileFormat::Png8);
    let made = render::make(work.started, &ready, loading, &shot, &work.workers, &work.control);
    let cost = made.map_err(Error::from)?.report.cost;
    let plan = measured((plan, pilot), &cost, &ready, region, &work.workers, &work.control).map_err(Error::from)?;
    to_json(&app.service.memory, &Explained::Analyzed(Analyzed { plan: &plan, actual: &cost }))
}
