//! `/v1/assets`: files that scenes name by their SHA-256, sent once.

use crate::http::extract::bounded::BoundedList;
use crate::http::extract::conditions::{Verdict, has_any, may_act, weigh};
use crate::http::extract::{body as request_body, json_body};
use crate::http::prelude::*;
use crate::http::respond::body;
use crate::http::respond::repr_digest;
use crate::service::assets::Sent;
use axum::Extension;
use axum::http::Method;
use data_encoding::HEXLOWER;
use std::collections::HashSet;
use strahl::scene::assets::{SCHEME, is_hash};

/// Hashes of one question.
const ASKED: usize = 10_000;

pub(super) fn routes() -> Vec<Route> {
    let sent = [Content::json::<SentAsset>()];
    let about_put = "Sends an asset: a model, or a picture, that scenes name as sha256: and these digits.\n\nThe body must have this \
                     SHA-256. Whoever has not sent the bytes does not have the asset, whatever hash it knows.";
    let about_post = "Sends an asset, and returns its SHA-256.";
    let about_get = "The bytes of an asset that you have sent. HEAD says whether it is there.";
    let about_missing = "Which of some assets you have yet to send.";
    let about_remove = "Forgets an asset. Its bytes are deleted once every tenant that sent them has deleted them.\n\nScenes that \
                        name it are refused then. While a job of yours needs it that has not ended, the answer is 409.";
    let file = Content::file("application/octet-stream");
    let digits = "64 hexadecimal digits, small letters.";
    vec![
        Route::put("/v1/assets/{sha256}", put, ["putAsset", "assets", about_put])
            .needs(Scope::Render)
            .path("sha256", digits)
            .header("If-None-Match", "`*`: only if you have not sent it.")
            .body(Body::file("The bytes, of whatever type"))
            .answer(201, "It is yours now", &sent)
            .answer(200, "You have sent it before", &sent),
        Route::post("/v1/assets", post, ["addAsset", "assets", about_post])
            .needs(Scope::Render)
            .body(Body::file("The bytes, of whatever type"))
            .answer(201, "It is yours now", &sent)
            .answer(200, "You have sent it before", &sent)
            .answer_header("Location", "The asset's path."),
        Route::get("/v1/assets/{sha256}", get, ["asset", "assets", about_get])
            .needs(Scope::Read)
            .path("sha256", digits)
            .header("If-None-Match", "The ETag of the bytes that the client has.")
            .answer(200, "The bytes", &[file])
            .answer_header("ETag", "Its hash.")
            .answer(304, "The client has them", &[]),
        Route::delete("/v1/assets/{sha256}", remove, ["removeAsset", "assets", about_remove])
            .needs(Scope::Render)
            .path("sha256", digits)
            .header("If-Match", "The asset's ETag.")
            .answer(204, "It is forgotten", &[]),
        Route::post("/v1/assets/missing", missing, ["missingAssets", "assets", about_missing])
            .needs(Scope::Render)
            .body(Body::json::<AssetHashes>("The hashes"))
            .answer(200, "Those to send", &[Content::json::<MissingAssets>()]),
    ]
}

/// An asset that was sent.
#[derive(Debug, Serialize, JsonSchema)]
struct SentAsset {
    /// Its SHA-256 in hexadecimal digits.
    sha256: String,
    /// What scenes call it: `sha256:` and these digits.
    asset: String,
    /// How many bytes it has.
    bytes: u64,
}

/// Assets that somebody needs.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct AssetHashes {
    /// Their SHA-256 in hexadecimal digits, with or without `sha256:` before them.
    #[schemars(with = "Vec<String>", length(max = 10_000))]
    sha256: BoundedList<String, ASKED>,
}

/// Assets that have to be sent.
#[derive(Debug, Serialize, JsonSchema)]
struct MissingAssets {
    /// Their SHA-256 in hexadecimal digits.
    missing: Vec<String>,
}

async fn put(state: State<App>, Path(hash): Path<String>, request: Request) -> Result<Response, Problem> {
    send(state, Some(hash), request).await
}

async fn post(state: State<App>, request: Request) -> Result<Response, Problem> {
    send(state, None, request).await
}

async fn send(State(app): State<App>, expected: Option<String>, request: Request) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    let tenant = Tenant::of(&parts.extensions);
    let check = async {
        app.drain.accepts_work()?;
        Query::of(&parts.uri)?.finish()?;
        let expected = expected.as_deref().map(known_hash).transpose()?;
        if expected.is_some() && parts.headers.contains_key(header::CONTENT_RANGE) {
            // As RFC 9110 wants it, section 14.5.
            let detail = "an asset is sent whole: Content-Range, which says that this is a part of it, is not taken";
            return Err(Problem::new(Kind::MalformedRequest, detail));
        }
        if let Some(hash) = expected.as_ref().filter(|_| has_any(&parts.headers)) {
            let found = app.service.asset_size(tenant.name.clone(), hash.clone()).await?;
            check_conditions(&parts.headers, hash, found.is_some())?;
        }
        Ok(expected)
    };
    let expected = match check.await {
        Ok(expected) => expected,
        Err(problem) => {
            request_body::discard(&app, &parts.headers, body).await;
            return Err(problem);
        }
    };
    let bytes = request_body::read(&app, &tenant, &parts.headers, body).await?;
    let length = bytes.len() as u64;
    if length == 0 {
        return Err(Problem::new(Kind::InvalidRequest, "the body is empty: send the bytes of a model or a picture"));
    }
    let Sent { hash, is_new } = app.service.keep_asset(tenant.name.clone(), expected, bytes).await?;
    let status = if is_new { StatusCode::CREATED } else { StatusCode::OK };
    let location = [(header::LOCATION, format!("/v1/assets/{hash}"))];
    let sent = SentAsset { asset: format!("{SCHEME}{hash}"), sha256: hash, bytes: length };
    Ok((status, location, Json(sent)).into_response())
}

async fn get(
    State(app): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    Path(hash): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    let hash = known_hash(&hash)?;
    let etag = etag(&hash);
    let digest = HEXLOWER.decode(hash.as_bytes()).unwrap_or_default();
    let mut headers = HeaderMap::new();
    let mut add = |name: header::HeaderName, value: String| {
        HeaderValue::from_str(&value).map(|value| headers.insert(name, value))
    };
    // It is shown by no browser: what tenants send may be a page with a script.
    let _ = add(header::CONTENT_TYPE, "application/octet-stream".into());
    let _ = add(header::X_CONTENT_TYPE_OPTIONS, "nosniff".into());
    let _ = add(header::ETAG, etag.clone());
    let _ = add(header::CACHE_CONTROL, "private, max-age=31536000, immutable".into());
    let _ = add(header::HeaderName::from_static("repr-digest"), repr_digest(&digest));
    let absent = || not_yours(&hash);
    let is_head = request.method() == Method::HEAD;
    // Who has not sent the bytes hears nothing of them, whatever the conditions are.
    if is_head || has_any(request.headers()) {
        let size = app.service.asset_size(tenant.name.clone(), hash.clone()).await?.ok_or_else(absent)?;
        match weigh(request.method(), request.headers(), Some(&etag)) {
            Verdict::NotModified => return Ok((StatusCode::NOT_MODIFIED, headers).into_response()),
            Verdict::Failed => return Err(Problem::new(Kind::PreconditionFailed, format!("the asset is {etag}"))),
            Verdict::Proceed => {}
        }
        if is_head {
            headers.insert(header::CONTENT_LENGTH, size.into());
            return Ok(headers.into_response());
        }
    }
    let bytes = app.service.asset(tenant.name.clone(), hash.clone()).await?.ok_or_else(absent)?;
    Ok((headers, body(bytes)).into_response())
}

async fn missing(
    State(app): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    request_body::declares_json(&parts.headers)?;
    let text = request_body::read(&app, &tenant, &parts.headers, body).await?;
    let invalid = |detail: String| Problem::new(Kind::InvalidRequest, detail);
    let AssetHashes { sha256 } =
        json_body::read(text.as_ref(), r#"the body is {"sha256": ["64 hexadecimal digits", ...]}"#)?;
    if sha256.count > ASKED {
        return Err(invalid(format!("at most {ASKED} hashes")));
    }
    let hashes = sha256.kept.iter().map(|hash| {
        let hash = hash.strip_prefix(SCHEME).unwrap_or(hash);
        let wrong = || invalid(format!("{hash:?} is no SHA-256: write 64 hexadecimal digits, small letters"));
        if is_hash(hash) { Ok(hash.to_owned()) } else { Err(wrong()) }
    });
    let mut hashes = hashes.collect::<Result<Vec<_>, _>>()?;
    let mut known = HashSet::new();
    hashes.retain(|hash| known.insert(hash.clone()));
    let missing = app.service.missing_assets(tenant.name.clone(), hashes).await?;
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(MissingAssets { missing })).into_response())
}

async fn remove(
    State(app): State<App>,
    Extension(tenant): Extension<Arc<Tenant>>,
    Path(hash): Path<String>,
    headers: HeaderMap,
) -> Result<StatusCode, Problem> {
    let hash = known_hash(&hash)?;
    if has_any(&headers) {
        let found = app.service.asset_size(tenant.name.clone(), hash.clone()).await?;
        found.ok_or_else(|| not_yours(&hash))?;
        check_conditions(&headers, &hash, true)?;
    }
    if app.service.remove_asset(tenant.name.clone(), hash.clone()).await? {
        Ok(StatusCode::NO_CONTENT)
    } else {
        Err(not_yours(&hash))
    }
}

/// The ETag of an asset.
fn etag(hash: &str) -> String {
    format!("\"{hash}\"")
}

/// Refuses to act on an asset if the conditions of the request do not hold.
fn check_conditions(headers: &HeaderMap, hash: &str, is_there: bool) -> Result<(), Problem> {
    let etag = is_there.then(|| etag(hash));
    if may_act(headers, etag.as_deref()) {
        return Ok(());
    }
    let detail = if is_there { "the asset is there, with its hash as ETag" } else { "you have not sent the asset" };
    Err(Problem::new(Kind::PreconditionFailed, detail))
}

fn not_yours(hash: &str) -> Problem {
    Problem::new(Kind::NotFound, format!("you have not sent the asset {hash}, or it is deleted: PUT /v1/assets/{hash}"))
}

/// The hash in a path, with or without `sha256:` before it.
fn known_hash(text: &str) -> Result<String, Problem> {
    let hash = text.strip_prefix(SCHEME).unwrap_or(text);
    if is_hash(hash) {
        return Ok(hash.to_owned());
    }
    let detail = format!("{text:?} is no SHA-256: write 64 hexadecimal digits, small letters, as sha256sum does");
    Err(Problem::new(Kind::NotFound, detail))
}
