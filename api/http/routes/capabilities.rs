//! `POST /v1/capabilities`.

use crate::http::App;
use crate::http::auth::capability::PREFIX;
use crate::http::auth::now;
use crate::http::auth::tenant::Tenant;
use crate::http::extract::body;
use crate::http::problem::{Kind, Problem};
use axum::Json;
use axum::extract::{Request, State};
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Seconds a capability lasts where nobody says how many.
const TTL: u64 = 3_600;
/// Seconds a capability lasts at most.
const MAX_TTL: u64 = 7 * 86_400;

/// What shall be opened: a job or a picture.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wanted {
    /// Id of a picture.
    #[schema(min_length = 1, max_length = 64, pattern = "^[A-Za-z0-9_-]+$")]
    image_id: Option<String>,
    /// Id of a job.
    #[schema(min_length = 1, max_length = 64, pattern = "^[A-Za-z0-9_-]+$")]
    job_id: Option<String>,
    /// Seconds it lasts; 3600 if nobody says.
    #[schema(minimum = 1, maximum = 604_800)]
    ttl: Option<u64>,
}

/// A capability.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Minted {
    /// What to put before paths, such as `/v1/jobs/{id}/events` or `/iiif/3/{id}/info.json`.
    prefix: String,
    /// When it ends, in seconds since 1970.
    expires: u64,
}

/// A URL prefix that lets pages without a key look at one job or picture.
#[utoipa::path(
    post, path = "/v1/capabilities", operation_id = "mintCapability", tag = "service",
    request_body = Wanted,
    responses((status = 201, description = "The capability", body = Minted)),
)]
pub(crate) async fn mint(State(service): State<App>, request: Request) -> Result<(StatusCode, Json<Minted>), Problem> {
    let (parts, body) = request.into_parts();
    let tenant = Tenant::of(&parts.extensions);
    body::json_only(&parts.headers)?;
    let body = body::read(&service, &parts.headers, body).await?;
    let wanted: Wanted = serde_json::from_slice(body.as_ref())
        .map_err(|error| Problem::new(Kind::InvalidRequest, format!("this is not what is expected: {error}")))?;
    let id = match (wanted.image_id, wanted.job_id) {
        (Some(id), None) | (None, Some(id)) => id,
        _ => return Err(invalid("give either image_id or job_id")),
    };
    if !(1..=64).contains(&id.len()) || !id.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_".contains(&b)) {
        return Err(invalid("an id has 1 to 64 letters, digits, - and _"));
    }
    let ttl = wanted.ttl.unwrap_or(TTL);
    if !(1..=MAX_TTL).contains(&ttl) {
        return Err(invalid(&format!("ttl must be 1 to {MAX_TTL} seconds")));
    }
    let expires = now() + ttl;
    let text = service.access.sign(&id, &tenant.name, expires);
    Ok((StatusCode::CREATED, Json(Minted { prefix: format!("{PREFIX}{text}"), expires })))
}

fn invalid(detail: &str) -> Problem {
    Problem::new(Kind::InvalidRequest, detail)
}
