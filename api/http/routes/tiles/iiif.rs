//! IIIF Image API 3.0, level 2: images and their description (`info.json`).

use super::grid::{base_of, last_level};
use super::iiif_parse::{ImageRequest, understand};
use crate::http::auth::client::Client;
use crate::http::extract::accept;
use crate::http::prelude::*;
use crate::http::respond::image::{self, everywhere, image_id, open, tile_permit};
use crate::http::respond::put;
use crate::http::state::AppState;
use crate::service::requests::scenes::OpenedImage;
use axum::http::request::Parts;
use strahl::camera::Window;

const CONTEXT: &str = "http://iiif.io/api/image/3/context.json";

pub(super) fn routes() -> Vec<Route> {
    let image_id = "The image's id.";
    let size = "`max`, `w,h`, `w,`, `,h`, `pct:n` or `!w,h`; with `^` before it more detail than the image has.";
    let about_image = "Any rectangle of an image in any size, mirrored and turned, in color or without.";
    vec![
        Route::get("/iiif/3/{image}", to_info, ["iiif", "tiles", "Leads to the image's description."])
            .needs(Scope::Read)
            .path("image", image_id)
            .answer(303, "The description is at info.json", &[]),
        Route::get("/iiif/3/{image}/info.json", info, ["iiifInfo", "tiles", "The description of an image."])
            .needs(Scope::Read)
            .path("image", image_id)
            .answer(
                200,
                "The description",
                &[Content::json::<ImageInfo>(), Content::json_as::<ImageInfo>("application/ld+json")],
            ),
        Route::get("/iiif/3/{image}/{region}/{size}/{rotation}/{file}", part, ["iiifImage", "tiles", about_image])
            .needs(Scope::Read)
            .path("image", image_id)
            .path("region", "`full`, `square`, `x,y,w,h` or `pct:x,y,w,h`.")
            .path("size", size)
            .path("rotation", "`0`, `90`, `180`, `270` or `360`; with `!` before it mirrored.")
            .path("file", "`default`, `color`, `gray` or `bitonal`, and `.jpg`, `.png` or `.webp`.")
            .picture(),
    ]
}

async fn to_info(State(app): State<App>, Path(id): Path<String>, parts: Parts) -> Result<Response, Problem> {
    image_id(&id)?;
    let to = format!("{}/info.json", address(&app, &parts, &id));
    Ok(everywhere(&app, (StatusCode::SEE_OTHER, [(header::LOCATION, to)])))
}

async fn part(
    State(app): State<App>,
    Path((id, region, size, rotation, file)): Path<(String, String, String, String, String)>,
    parts: Parts,
) -> Result<Response, Problem> {
    let tenant = Tenant::of(&parts.extensions);
    let _permit = tile_permit(&app, Client::of(&parts.extensions))?;
    let opened = open(&app, &tenant, &id).await?;
    let max_area = app.service.settings.answers.max_area(&opened.ready.scene);
    let asked = ImageRequest { region: &region, size: &size, rotation: &rotation, file: &file };
    let understood = understand(asked, opened.size, max_area)?;
    let canonical = format!("{}/{}", address(&app, &parts, &id), understood.canonical);
    let mut response = image::tile(&app, &tenant, &parts, opened.image, understood.spec).await?;
    let links = format!("<{canonical}>;rel=\"canonical\", <http://iiif.io/api/image/3/level2.json>;rel=\"profile\"");
    put(response.headers_mut(), header::LINK, &links);
    Ok(response)
}

/// The URL of an image as its client sees it.
fn address(app: &AppState, parts: &Parts, id: &str) -> String {
    format!("{}/iiif/3/{id}", base_of(app, parts))
}

/// The description of an image by the IIIF Image API 3.0, section 5.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
struct ImageInfo {
    /// URL of the JSON-LD context.
    #[serde(rename = "@context")]
    context: &'static str,
    /// URL of the image.
    id: String,
    /// `ImageService3`.
    r#type: &'static str,
    /// URL of the protocol.
    protocol: &'static str,
    /// `level2`.
    profile: &'static str,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// Most pixels of an answer.
    max_area: u64,
    /// Sizes of the whole image.
    sizes: Vec<InfoSize>,
    /// Tiles and their scale factors.
    tiles: Vec<InfoTile>,
    /// Formats, the preferred first.
    preferred_formats: &'static [&'static str],
    /// Formats beyond those of level 2.
    extra_formats: &'static [&'static str],
    /// Qualities beyond `default`.
    extra_qualities: &'static [&'static str],
    /// Features beyond those of level 2.
    extra_features: &'static [&'static str],
}

/// A size of an image.
#[derive(Debug, Serialize, JsonSchema)]
struct InfoSize {
    /// `Size`.
    r#type: &'static str,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
}

/// Tiles of an image.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
struct InfoTile {
    /// `Tile`.
    r#type: &'static str,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// Pixels of the image for one pixel of a tile, across and down.
    scale_factors: Vec<u64>,
}

async fn info(State(app): State<App>, Path(id): Path<String>, parts: Parts) -> Result<Response, Problem> {
    let opened = open(&app, &Tenant::of(&parts.extensions), &id).await?;
    let (answers, scene) = (&app.service.settings.answers, &opened.ready.scene);
    let info = ImageInfo::of(address(&app, &parts, &id), &opened, answers.max_area(scene), answers.tile_edge(scene));
    let mut response = everywhere(&app, Json(info));
    if wants_linked_data(&parts.headers) {
        put(response.headers_mut(), header::CONTENT_TYPE, &format!("application/ld+json;profile=\"{CONTEXT}\""));
    }
    put(response.headers_mut(), header::VARY, "Accept");
    Ok(response)
}

/// Whether to send JSON-LD, as the API prefers. Clients that accept anything, such as browsers, get plain JSON.
fn wants_linked_data(headers: &HeaderMap) -> bool {
    !headers.contains_key(header::ACCEPT) || accept::names(headers, "application/ld+json")
}

impl ImageInfo {
    fn of(id: String, opened: &OpenedImage, max_area: u64, edge: u32) -> Self {
        let [width, height] = opened.size;
        let levels = 0..=last_level(opened.size, edge);
        let sizes = levels.clone().rev().filter_map(|level| {
            let Window { width, height, .. } = Window::level(width, height, level as i32)?;
            let fits = u64::from(width) * u64::from(height) <= max_area;
            fits.then_some(InfoSize { r#type: "Size", width, height })
        });
        let scale_factors = levels.map(|level| 1 << level).collect();
        Self {
            context: CONTEXT,
            id,
            r#type: "ImageService3",
            protocol: "http://iiif.io/api/image",
            profile: "level2",
            width,
            height,
            max_area,
            sizes: sizes.collect(),
            tiles: vec![InfoTile { r#type: "Tile", width: edge, height: edge, scale_factors }],
            preferred_formats: &["webp", "png", "jpg"],
            extra_formats: &["webp"],
            extra_qualities: &["color", "gray", "bitonal"],
            extra_features: &["canonicalLinkHeader", "mirroring", "profileLinkHeader", "sizeUpscaling"],
        }
    }
}
