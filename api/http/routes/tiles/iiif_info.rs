//! `info.json`: what an image is and what may be asked of it (section 5 of the IIIF Image API 3.0).

use super::iiif::address;
use super::{Opened, described, last_level, open};
use crate::http::App;
use crate::http::auth::tenant::Tenant;
use crate::http::contract::pictures::ImageInfo;
use crate::http::problem::Problem;
use crate::http::respond::put;
use crate::service::pictures::spec::TILE;
use axum::Json;
use axum::extract::{Path, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, header};
use axum::response::Response;
use serde_json::{Value, json};
use strahl::camera::Window;

const CONTEXT: &str = "http://iiif.io/api/image/3/context.json";

/// The description of an image.
#[utoipa::path(
    get, path = "/iiif/3/{image}/info.json", operation_id = "iiifInfo", tag = "tiles",
    params(("image" = String, Path, description = "The image's id.")),
    responses((status = 200, description = "The description", body = ImageInfo)),
)]
pub(crate) async fn iiif_info(
    State(service): State<App>,
    Path(id): Path<String>,
    parts: Parts,
) -> Result<Response, Problem> {
    let opened = open(&service, &Tenant::of(&parts.extensions), &id).await?;
    let max_area = service.limits.max_area(&opened.ready.scene);
    let mut response = described(Json(info(&address(&service, &parts, &id), &opened, max_area)));
    if wants_linked_data(&parts.headers) {
        put(response.headers_mut(), header::CONTENT_TYPE, &format!("application/ld+json;profile=\"{CONTEXT}\""));
    }
    put(response.headers_mut(), header::VARY, "Accept");
    Ok(response)
}

/// Who says nothing gets what the API prefers; browsers and others that take anything get what they can show.
fn wants_linked_data(headers: &HeaderMap) -> bool {
    let accepts: Vec<_> = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok()).collect();
    accepts.is_empty() || accepts.iter().any(|accept| accept.contains("application/ld+json"))
}

fn info(address: &str, opened: &Opened, max_area: u64) -> Value {
    let [width, height] = opened.size;
    let levels = 0..=last_level(opened.size, TILE);
    let sizes = levels.clone().rev().filter_map(|level| {
        let Window { width, height, .. } = Window::level(width, height, level as i32)?;
        let fits = u64::from(width) * u64::from(height) <= max_area;
        fits.then(|| json!({ "type": "Size", "width": width, "height": height }))
    });
    let factors: Vec<u64> = levels.map(|level| 1 << level).collect();
    json!({
        "@context": CONTEXT,
        "id": address,
        "type": "ImageService3",
        "protocol": "http://iiif.io/api/image",
        "profile": "level2",
        "width": width,
        "height": height,
        "maxArea": max_area,
        "sizes": sizes.collect::<Vec<_>>(),
        "tiles": [{ "type": "Tile", "width": TILE, "height": TILE, "scaleFactors": factors }],
        "preferredFormats": ["webp", "png", "jpg"],
        "extraFormats": ["webp"],
        "extraQualities": ["color", "gray", "bitonal"],
        "extraFeatures": ["canonicalLinkHeader", "mirroring", "profileLinkHeader", "sizeUpscaling"],
    })
}
