//! Answers with a picture: conditions, headers, caching.

use super::put;
use super::repr_digest;
use crate::http::auth::tenant::Tenant;
use crate::http::extract::conditions::{Verdict, weigh};
use crate::http::metrics::render_cost::Cost;
use crate::http::problem::{Kind, Problem};
use crate::http::state::AppState;
use crate::service::pictures::cache::{MadePicture, Took};
use crate::service::pictures::file::PictureFile;
use crate::service::pictures::spec::PictureSpec;
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::fmt::Display;
use std::sync::Arc;
use strahl::film::{DEFAULT_QUALITY, FileFormat};

/// A file that other answers may have, too.
pub(super) struct Shared(pub(super) Arc<PictureFile>);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        &self.0.bytes
    }
}

/// How long caches may keep an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Freshness {
    /// For ever, since its URL always means this picture.
    Immutable,
    /// Only if they ask again before each use.
    Once,
}

/// What an answer depends on besides its picture.
#[derive(Debug)]
pub(crate) struct ResponseContext<'a> {
    /// The request's method.
    pub(crate) method: &'a Method,
    /// The request's headers.
    pub(crate) headers: &'a HeaderMap,
    /// The tenant. Shared caches must not keep what only one tenant may see.
    pub(crate) tenant: &'a Tenant,
    /// How long caches may keep it.
    pub(crate) freshness: Freshness,
    /// Whether `Accept` decided on the format.
    pub(crate) negotiated: bool,
}

/// The entity tag of a picture: its name.
pub(crate) fn tag(name: &str) -> String {
    format!("\"{name}\"")
}

/// The answer of a request whose conditions decide it before anything is rendered. `place` is where the picture stays, if an answer
/// with it says so.
pub(crate) fn precondition_response(
    context: &ResponseContext<'_>,
    etag: Option<&str>,
    place: Option<&str>,
) -> Option<Result<Response, Problem>> {
    match weigh(context.method, context.headers, etag) {
        Verdict::Proceed => None,
        Verdict::Failed => {
            let detail = "the picture is not the one that If-Match or If-None-Match asks for";
            Some(Err(Problem::new(Kind::PreconditionFailed, detail)))
        }
        Verdict::NotModified => {
            let mut response = StatusCode::NOT_MODIFIED.into_response();
            put(response.headers_mut(), header::ETAG, etag.unwrap_or_default());
            if let Some(place) = place {
                put(response.headers_mut(), header::CONTENT_LOCATION, place);
            }
            caching(response.headers_mut(), context);
            Some(Ok(response))
        }
    }
}

/// A picture that was in a cache.
pub(crate) fn stored(file: Arc<PictureFile>) -> MadePicture {
    MadePicture { file, took: Took::CACHED }
}

/// The answer with a picture, if the request's conditions allow it.
pub(crate) fn deliver(
    app: &AppState,
    context: &ResponseContext<'_>,
    MadePicture { file, took }: &MadePicture,
    spec: &PictureSpec,
) -> Result<Response, Problem> {
    let image = file.meta.image.as_ref();
    let etag = image.map(|image| tag(&spec.name(image)));
    let place = image.and_then(|image| place_of(context, image, spec));
    if let Some(answer) = precondition_response(context, etag.as_deref(), place.as_deref()) {
        return answer;
    }
    let is_new = |image: &String| !app.service.pictures.seen.note(&context.tenant.name, &spec.name(image));
    let took = match image {
        Some(image) if is_new(image) && took.render.is_none() => Took::by_others(&file.meta),
        _ => *took,
    };
    let (ending, media_type) = spec.format.names();
    let mut response = Response::new(Body::from(Bytes::from_owner(Shared(Arc::clone(file)))));
    if let Some(cost) = Cost::of(&took, spec.format) {
        response.extensions_mut().insert(cost);
    }
    let headers = response.headers_mut();
    for (name, value) in &file.meta.lines {
        // Pictures of an older version may have other lines.
        if let Ok(name) = name.parse() {
            put(headers, name, value);
        }
    }
    // RFC 9530.
    put(headers, HeaderName::from_static("repr-digest"), &repr_digest(&file.digest));
    headers.insert(header::CONTENT_LENGTH, file.bytes.len().into());
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    let name = image.map_or("picture", String::as_str);
    put(headers, header::CONTENT_DISPOSITION, &format!("inline; filename=\"{name}.{ending}\""));
    put(headers, HeaderName::from_static("server-timing"), &timing(&took));
    for (name, value) in [(header::ETAG, &etag), (header::CONTENT_LOCATION, &place)] {
        if let Some(value) = value {
            put(headers, name, value);
        }
    }
    caching(headers, context);
    if etag.is_none() {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    Ok(response)
}

/// Where the picture of an answer stays, if that is elsewhere.
pub(crate) fn place_of(context: &ResponseContext<'_>, image: impl Display, spec: &PictureSpec) -> Option<String> {
    (context.freshness == Freshness::Once && spec.is_whole()).then(|| address_of(image, spec.format))
}

/// The permanent path of an image in a format.
pub(crate) fn address_of(image: impl Display, format: FileFormat) -> String {
    let parameters = match format {
        FileFormat::Png16 => "?bits=16".into(),
        FileFormat::Jpeg(quality) if quality != DEFAULT_QUALITY => format!("?quality={quality}"),
        _ => String::new(),
    };
    format!("/v1/images/{image}.{}{parameters}", format.names().0)
}

/// `Server-Timing`: milliseconds of the phases, if the picture was rendered.
fn timing(took: &Took) -> String {
    let scene = format!("scene;desc={}", if took.scene_cached && !took.is_shared { "hit" } else { "miss" });
    let Some((phases, _)) = took.render else { return scene + ", picture;desc=hit" };
    let durations = [("queue", took.queue_ms)].into_iter().chain(phases.list());
    let durations = durations.map(|(phase, ms)| format!("{phase};dur={ms:.3}"));
    let refine = format!("refine;dur={:.3};desc=\"part of trace\"", phases.refine);
    let timing: Vec<String> = [scene].into_iter().chain(durations).chain([refine]).collect();
    timing.join(", ")
}

fn caching(headers: &mut HeaderMap, context: &ResponseContext<'_>) {
    let everybody = context.tenant.is_anonymous();
    let value = match context.freshness {
        Freshness::Immutable if everybody => "public, max-age=31536000, immutable",
        Freshness::Immutable => "private, max-age=31536000, immutable",
        Freshness::Once => "no-cache",
    };
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static(value));
    if context.negotiated {
        headers.insert(header::VARY, HeaderValue::from_static("Accept"));
    }
}
