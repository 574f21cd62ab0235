//! `POST /v1/capabilities`.

use crate::http::auth::capability::PREFIX;
use crate::http::extract::{body, json_body};
use crate::http::prelude::*;
use crate::service::clock::unix_time;

pub(super) fn routes() -> Vec<Route> {
    let about = "Makes a URL prefix with which pages can read one job, picture or scene without a key.";
    vec![
        Route::post("/v1/capabilities", mint, ["mintCapability", "service", about])
            .needs(Scope::Read)
            .body(Body::json::<CapabilityRequest>("What it is for"))
            .answer(201, "The capability", &[Content::json::<Capability>()]),
    ]
}

/// Default lifetime of a capability in seconds.
const TTL: u64 = 3_600;
/// Longest lifetime of a capability in seconds.
const MAX_TTL: u64 = 7 * 86_400;

/// What a capability is for: a job, a picture or a scene.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CapabilityRequest {
    /// Id of a picture.
    #[schemars(length(min = 1, max = 64), regex(pattern = "^[A-Za-z0-9_-]+$"))]
    image_id: Option<String>,
    /// Id of a job.
    #[schemars(length(min = 1, max = 64), regex(pattern = "^[A-Za-z0-9_-]+$"))]
    job_id: Option<String>,
    /// Id of a scene, whose text is to be read.
    #[schemars(length(min = 1, max = 64), regex(pattern = "^[A-Za-z0-9_-]+$"))]
    scene_id: Option<String>,
    /// Lifetime in seconds, 3600 by default.
    #[schemars(range(min = 1, max = 604_800))]
    ttl: Option<u64>,
}

/// A capability.
#[derive(Debug, Serialize, JsonSchema)]
struct Capability {
    /// Prefix of paths, such as `/v1/jobs/{id}/events` or `/iiif/3/{id}/info.json`.
    prefix: String,
    /// When it expires, in seconds since 1970.
    expires: u64,
}

async fn mint(State(app): State<App>, request: Request) -> Result<(StatusCode, Json<Capability>), Problem> {
    let (parts, body) = request.into_parts();
    let tenant = Tenant::of(&parts.extensions);
    let declared = body::declares_json(&parts.headers)?;
    let body = body::read(&app, &tenant, &parts.headers, body).await?;
    body::check_content(declared, body.as_ref())?;
    let wanted: CapabilityRequest =
        json_body::read(body.as_ref(), r#"the body is {"image_id": "<id>"}, or with job_id or scene_id"#)?;
    let mut ids = [wanted.image_id, wanted.job_id, wanted.scene_id].into_iter().flatten();
    let (Some(id), None) = (ids.next(), ids.next()) else {
        return Err(invalid("give one of image_id, job_id and scene_id"));
    };
    if !(1..=64).contains(&id.len()) || !id.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_".contains(&b)) {
        return Err(invalid("an id has 1 to 64 letters, digits, - and _"));
    }
    let ttl = wanted.ttl.unwrap_or(TTL);
    if !(1..=MAX_TTL).contains(&ttl) {
        return Err(invalid(&format!("ttl must be 1 to {MAX_TTL} seconds")));
    }
    let expires = unix_time().as_secs() + ttl;
    let text = app.access.sign(&id, &tenant.name, expires);
    Ok((StatusCode::CREATED, Json(Capability { prefix: format!("{PREFIX}{text}"), expires })))
}

fn invalid(detail: &str) -> Problem {
    Problem::new(Kind::InvalidRequest, detail)
}
