//! `POST /v1/explain`: which effects a scene calls for, why, and what they should take, with one setting or several.

use crate::http::contract::scene_reference;
use crate::http::extract::body_part::BodyPart;
use crate::http::extract::bounded::{BoundedList, SettingsObject};
use crate::http::extract::json_body;
use crate::http::extract::variation::form_of;
use crate::http::prelude::*;
use crate::http::respond::{Answer, to_json};
use crate::http::scene_job::{Question, ask, ask_image};
use crate::http::state::AppState;
use crate::service::error::Error;
use crate::service::pictures::render::{self, RenderSpec};
use crate::service::pictures::report::{Analyzed, measured};
use crate::service::requests::pictures::image_of;
use crate::service::scenes::cache::Found;
use crate::service::scenes::prepared::{Loading, PreparedScene, planned};
use crate::service::scenes::sent_scene::{Form, SentScene};
use crate::service::scheduler::admission::Work;
use serde_json::value::RawValue;
use serde_json::{Map, Value};
use strahl::film::{FileFormat, Region};
use strahl::plan::Plan;
use strahl::plan::depth::Depth;
use strahl::plan::estimate::Estimate;
use strahl::scene::{Description, Format};

/// Most settings of one request.
const MOST: usize = 32;

pub(super) fn routes() -> Vec<Route> {
    let about = "Which effects the scene calls for, why, and what they should take.\n\n\
                 `analyze` renders the picture, within the limits of any, and adds what they took, and what \
                 leaving each out saves. A body `{\"scene\": {...}, \"settings\": [{...}, ...]}` has the answer `several`: the plan of \
                 the scene as it is, and the estimates of up to 32 settings over it.";
    let about_image = "The plan of a known image, in the pixels of its zoom.";
    vec![
        Route::post("/v1/explain", explain, ["explain", "render", about]).about_scene().query(analyze).answer(
            200,
            "The plan",
            &[Content::json::<ExplainAnswer<'_>>()],
        ),
        Route::get("/v1/images/{image}/explain", of_image, ["imagePlan", "pictures", about_image])
            .needs(Scope::Read)
            .path("image", "An image id.")
            .query(analyze)
            .answer(200, "The plan", &[Content::json::<ExplainAnswer<'_>>()]),
    ]
}

/// The plan of a scene, with `actual` if the picture was rendered, or the estimates of several settings.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
enum ExplainAnswer<'a> {
    Analyzed(Analyzed<'a>),
    Planned(&'a Plan),
    SettingsEstimates(SettingsEstimates<'a>),
}

/// A scene and several settings.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Settings<'a> {
    /// The scene.
    #[serde(borrow)]
    #[schemars(schema_with = "scene_reference")]
    scene: &'a RawValue,
    /// Settings that replace the scene's, by the names of the query parameters.
    #[schemars(with = "Vec<Map<String, Value>>")]
    settings: BoundedList<SettingsObject, MOST>,
}

/// The estimates of several settings.
#[derive(Debug, Serialize, JsonSchema)]
struct SettingsEstimates<'a> {
    /// The plan of the scene as it is.
    plan: &'a Plan,
    /// One for each of the settings, in their order.
    estimates: Vec<SettingEstimate>,
}

/// What a picture with some settings should take.
#[derive(Debug, Serialize, JsonSchema)]
struct SettingEstimate {
    /// The settings.
    settings: Map<String, Value>,
    /// Rays and milliseconds.
    estimate: Option<Estimate>,
    /// Depth of the recursion.
    depth: Depth,
    /// The id of the picture, if it has one.
    image_id: Option<String>,
}

async fn explain(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    ask(app, request, |query, _| Ok(analyze(query)), answer).await
}

async fn of_image(State(app): State<App>, Path(image): Path<String>, request: Request) -> Result<Response, Problem> {
    let answer = |app: &AppState, work: &Work, ready: &Arc<PreparedScene>, analyze| {
        plan(app, work, ready, Loading::default(), analyze)
    };
    ask_image(app, image, request, analyze, answer).await
}

fn analyze(query: &mut Query) -> bool {
    let about = "Whether to render the picture, too, and put its actual figures beside the estimates.";
    query.flag("analyze", about).unwrap_or(false)
}

fn answer(question: Question<'_>, analyze: bool) -> Result<Answer, Problem> {
    let Question { app, work, sent, .. } = question;
    if *sent.form == Form::JSON && json_body::begins_with(sent.text, ["scene", "settings"]) {
        return several(question, analyze);
    }
    let limits = &app.service.settings.answers;
    let accept = |scene: &Description| if analyze { limits.check_unbuilt(scene, None) } else { Ok(()) };
    let Found { ready, loading, .. } = app.service.scenes.find_if(&work.workers, sent, &accept)?;
    plan(app, work, &ready, loading, analyze)
}

/// The plan of a scene.
fn plan(
    app: &AppState,
    work: &Work,
    ready: &PreparedScene,
    loading: Loading,
    analyze: bool,
) -> Result<Answer, Problem> {
    let region = Region::whole(ready.scene.width, ready.scene.height);
    if analyze {
        app.service.settings.answers.check(region, ready.scene.samples)?;
    }
    let (plan, pilot) = planned(ready, region, &work.workers, &work.control).map_err(Error::from)?;
    if !analyze {
        return to_json(&app.service.memory, &ExplainAnswer::Planned(&plan));
    }
    let _share = app.service.room_for_picture(ready, region.pixels(), render::PIXEL_BYTES)?;
    let shot = RenderSpec::of(&ready.scene, region, FileFormat::Png8);
    let made = render::make(work.started, ready, loading, &shot, &work.workers, &work.control, None, None);
    let cost = made.map_err(Error::from)?.report.cost;
    let plan = measured((plan, pilot), &cost, ready, region, &work.workers, &work.control).map_err(Error::from)?;
    to_json(&app.service.memory, &ExplainAnswer::Analyzed(Analyzed { plan: &plan, actual: &cost }))
}

fn several(Question { app, work, sent, tenant }: Question<'_>, analyze: bool) -> Result<Answer, Problem> {
    let invalid = |detail: String| Problem::new(Kind::InvalidRequest, detail);
    if analyze {
        return Err(invalid("analyze is of one setting: render the pictures instead".into()));
    }
    let Settings { scene, settings } =
        json_body::read(sent.text, r#"the body is {"scene": {...}, "settings": [{...}, ...]}"#)?;
    if settings.count > MOST {
        return Err(invalid(format!("{} settings are too many; one request has at most {MOST}", settings.count)));
    }
    let over = |(i, own): (usize, &SettingsObject)| {
        let mut query = Query::given(own.0.clone(), format!("/settings/{i}"));
        let overrides = query.settings(Format::Json).over(&sent.overrides);
        query.finish().map(|()| overrides)
    };
    let overrides = settings.kept.iter().enumerate().map(over).collect::<Result<Vec<_>, Problem>>()?;
    let (form, text) = form_of(&app.service, tenant, scene.get().as_bytes())?;
    let part = BodyPart::of(sent.text, "/scene".into(), scene);
    let sent = SentScene::new(text, &form, &sent.overrides);
    let all = [&[sent.overrides], &overrides[..]].concat();
    let scenes = app.service.scenes.find_several(&work.workers, &sent, &all).map_err(|error| part.error(error))?;
    let mut plans = Vec::new();
    for ready in &scenes {
        let region = Region::whole(ready.scene.width, ready.scene.height);
        plans.push(planned(ready, region, &work.workers, &work.control).map_err(Error::from)?.0);
    }
    let each = settings.kept.into_iter().zip(scenes.iter().zip(&plans).skip(1)).map(|(settings, (ready, plan))| {
        SettingEstimate {
            settings: settings.0,
            estimate: plan.estimate,
            depth: plan.depth.clone(),
            image_id: image_of(ready).map(|image| image.to_string()),
        }
    });
    let estimates = each.collect();
    to_json(&app.service.memory, &ExplainAnswer::SettingsEstimates(SettingsEstimates { plan: &plans[0], estimates }))
}
