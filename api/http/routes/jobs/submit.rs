//! `POST /v1/jobs`: submits a job.

use crate::http::contract::{example_scene, scene_reference};
use crate::http::extract::bounded::{BoundedList, SettingsObject};
use crate::http::extract::prefer::Prefer;
use crate::http::extract::variation::form_of;
use crate::http::extract::{body, json_body};
use crate::http::prelude::*;
use crate::http::respond::job::{JobView, until_final};
use crate::http::respond::submission::{Claimed, accepted, claim, submitted, wishes_of};
use crate::http::state::AppState;
use crate::service::deliveries::key::KeyTemplate;
use crate::service::jobs::Job;
use crate::service::memory_budget::MeteredBytes;
use crate::service::requests::jobs::WantedJob;
use crate::service::scenes::sent_scene::Form;
use crate::service::scheduler::task::PRIORITY;
use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::json;
use serde_json::value::RawValue;
use strahl::film::FileFormat;
use strahl::scene::{Format, Overrides};
use strahl::sequence::{FRAMES, Sequence};

/// Most labels of a job, and most characters of a label.
const LABELS: [usize; 2] = [16, 64];

const JSON_SAYS_ALL: &str = "a job in JSON says this in its body: `{\"scene\": ..., \"settings\": {\"width\": 640}, \
                             \"output\": {\"format\": \"png\", \"bits\": 16}}`";

pub(super) fn routes() -> Vec<Route> {
    let about = "Submits a job: a render in the background, which survives a restart of the service.";
    let key = "A name for this submission: sent again with it, the same body gives the same job.";
    vec![
        Route::post("/v1/jobs", submit, ["submitJob", "jobs", about])
            .needs(Scope::Jobs)
            .header("Idempotency-Key", key)
            .header("Prefer", "`wait=20` waits up to 20 seconds for the job to end.")
            .query(|query| query.settings(Format::Json))
            .query(Query::output)
            .query(file_parameters)
            .body(job_body())
            .answer(202, "The job", &[Content::json::<JobView>()])
            .answer_header("Location", "The job's path."),
    ]
}

/// A request for a job.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JobRequest<'a> {
    /// The scene.
    #[serde(borrow)]
    #[schemars(schema_with = "scene_reference")]
    scene: &'a RawValue,
    /// Frames of the scene: a sequence. Default: a single picture.
    frames: Option<Sequence>,
    /// Settings that replace the scene's, by the names of the query parameters of `POST /v1/render`.
    #[serde(default)]
    #[schemars(schema_with = "overrides")]
    settings: SettingsObject,
    /// Format of the picture, by the names of the query parameters of `POST /v1/render`.
    #[serde(default)]
    #[schemars(schema_with = "output")]
    output: SettingsObject,
    /// Priority among the tenant's jobs, from 0 to 100, 50 by default.
    #[schemars(range(min = 0, max = 100))]
    priority: Option<u8>,
    /// Labels, by which jobs can be listed.
    #[serde(default)]
    #[schemars(with = "Vec<String>", length(max = 16))]
    labels: BoundedList<String, { LABELS[0] }>,
    /// A receiver that hears how the job ends.
    webhook: Option<WebhookRequest>,
    /// Puts the picture and its cost report into the store of the service when the job has succeeded.
    store: Option<StoreRequest>,
}

/// A receiver that hears how a job ends.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct WebhookRequest {
    /// Where the message is posted, an address of the public network.
    #[schemars(length(max = 2048))]
    url: String,
}

/// Where the picture of a job goes in the store.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct StoreRequest {
    /// Its name below `results/TENANT/`: parts of A-Z a-z 0-9 . _ - between slashes, with {job}, {scene}, {image}, {width},
    /// {height}, {date} and {ext}, and {frame} in jobs of frames. By default {job}.{ext}, or {job}/{frame}.{ext}.
    #[schemars(length(max = 200))]
    key: Option<String>,
}

fn overrides(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "$ref": "#/components/schemas/Overrides" })
}

fn output(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "$ref": "#/components/schemas/PictureOutput" })
}

/// What a body of JSON says.
fn of_body(query: &mut Query) {
    query.settings(Format::Json);
    query.output();
    file_parameters(query);
}

async fn submit(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    let tenant = Tenant::of(&parts.extensions);
    let check = || {
        app.drain.accepts_work()?;
        body::declared_format(&parts.headers)
    };
    let declared = match check() {
        Ok(declared) => declared,
        Err(problem) => {
            body::discard(&app, &parts.headers, body).await;
            return Err(problem);
        }
    };
    let text = body::read(&app, &tenant, &parts.headers, body).await?;
    let format = body::check_content(declared, text.as_ref())?;
    let query = Query::of(&parts.uri)?;
    let of_file = match format {
        Format::Json => query.refuse_all(of_body, JSON_SAYS_ALL).map(|()| None)?,
        _ => Some(of_file(query, format)?),
    };
    let said = parts.uri.query().filter(|_| of_file.is_some()).unwrap_or_default();
    let prefer = Prefer { respond_async: false, ..Prefer::of(&parts.headers) };
    let (claimed, text) = claim(&app, &tenant, &parts.headers, said.into(), text).await?;
    let claim = match claimed {
        Claimed::Before(job) => {
            drop(text);
            return waited_for(&app, &tenant, &job, true, prefer).await;
        }
        Claimed::Now(claim) => claim,
    };
    let wanted = match of_file {
        Some(settings) => {
            let (scene, form, labels) = (text, Form::Whole(format), Vec::new());
            let wishes = wishes_of(&app, &tenant, None, None)?;
            let FileSettings { overrides, output, frames, priority } = settings;
            WantedJob { scene, form, frames, overrides, output, priority, labels, wishes }
        }
        None => {
            let (app_of, sender) = (Arc::clone(&app), Arc::clone(&tenant));
            app.service.storage_threads.run(&tenant.name, move || wanted(&app_of, &sender, text)).await??
        }
    };
    let job = submitted(&app, &tenant, wanted, claim).await?;
    waited_for(&app, &tenant, &job, false, prefer).await
}

/// The answer about a job, once it has ended or the client does not want to wait any longer.
async fn waited_for(
    app: &App,
    tenant: &Tenant,
    job: &Arc<Job>,
    is_replay: bool,
    prefer: Prefer,
) -> Result<Response, Problem> {
    if let Some(wait) = prefer.wait {
        // The job is accepted, so it is answered in any case.
        _ = until_final(app, tenant, job, wait).await;
    }
    Ok(accepted(app, job, is_replay, prefer).await)
}

/// What the query says of a job whose body is a model or NFF.
struct FileSettings {
    overrides: Overrides,
    output: FileFormat,
    frames: Option<Sequence>,
    priority: u8,
}

fn of_file(mut query: Query, format: Format) -> Result<FileSettings, Problem> {
    let mut overrides = query.settings(format);
    let (turntable, priority) = file_parameters(&mut query);
    let output = query.output();
    let output = query.picture_format(output, &HeaderMap::new())?;
    query.finish()?;
    overrides.model.around = turntable.filter(|_| format.is_model()).map(|_| true);
    let frames = turntable.map(Sequence::turntable);
    let frames = if format.is_model() { frames.map(Sequence::of_model) } else { frames };
    let priority = priority.map_or(PRIORITY, |priority| priority as u8);
    Ok(FileSettings { overrides, output, frames, priority })
}

fn file_parameters(query: &mut Query) -> (Option<u32>, Option<u32>) {
    let about = "Of a body that is no JSON: so many frames from all around.";
    let turntable = query.count("turntable", about, FRAMES.max as u32);
    (
        turntable,
        query.count_or_0(
            "priority",
            "Of a body that is no JSON: priority among the tenant's jobs, 50 by default.",
            100,
        ),
    )
}

/// The body of a job, or a file whose settings are in the query.
fn job_body() -> Body {
    let example = json!({
        "scene": example_scene(), "settings": { "width": 64 }, "output": { "format": "webp" }, "priority": 60
    });
    let about = "The job; or a model or NFF, with settings and output in the query";
    Body::json::<JobRequest<'_>>(about).example(example).or_files()
}

fn wanted(app: &AppState, tenant: &Tenant, mut text: MeteredBytes) -> Result<WantedJob, Problem> {
    let request: JobRequest<'_> =
        json_body::read(text.as_ref(), r#"the body is {"scene": {...}, "settings": {...}, ...}"#)?;
    let JobRequest { scene, frames, settings, output, priority, labels, webhook, store } = request;
    let invalid = |detail: String| Problem::new(Kind::InvalidRequest, detail);
    let priority = priority.unwrap_or(PRIORITY);
    if priority > 100 {
        return Err(invalid(format!("priority is a whole number from 0 to 100, not {priority}")));
    }
    let is_wrong = |label: &String| label.is_empty() || label.chars().count() > LABELS[1];
    if labels.count > LABELS[0] || labels.kept.iter().any(is_wrong) {
        return Err(invalid(format!("at most {} labels of 1 to {} letters each", LABELS[0], LABELS[1])));
    }
    let key = store.map(|store| store.key.as_deref().map_or(Ok(KeyTemplate::default()), str::parse)).transpose();
    let wishes = wishes_of(app, tenant, key.map_err(invalid)?, webhook.map(|webhook| webhook.url))?;
    let mut query = Query::given(settings.0, "/settings");
    let overrides = query.settings(Format::Json);
    query.finish()?;
    let mut query = Query::given(output.0, "/output");
    let output = query.output();
    let output = query.picture_format(output, &HeaderMap::new())?;
    query.finish()?;
    let (form, scene) = form_of(&app.service, tenant, scene.get().as_bytes())?;
    // Of the text only the scene is kept.
    let start = scene.as_ptr().addr() - text.as_ref().as_ptr().addr();
    let end = start + scene.len();
    text.keep(start..end);
    Ok(WantedJob { scene: text, form, frames, overrides, output, priority, labels: labels.kept, wishes })
}
