//! XYZ tiles, for Leaflet and others: `/xyz/{id}/{z}/{x}/{y}.png`, described by `/xyz/{id}.json`.
//!
//! Zoom 0 is a single tile, and zooms beyond the image's own size show more detail. Viewers of maps expect whole tiles, so those
//! along the edges extend beyond the image.

use super::grid::{base_of, id_of, last_level, no_tile, tile, tile_format, tile_of};
use crate::http::auth::client::Client;
use crate::http::prelude::*;
use crate::http::respond::image::{self, everywhere, open, tile_permit};
use crate::service::pictures::spec::{Grid, size_of};
use crate::service::scenes::ids::MAX_ZOOM;
use axum::http::request::Parts;
use strahl::film::Region;

pub(super) fn routes() -> Vec<Route> {
    let about = "The size of an image and where its tiles are: TileJSON, with pixels for coordinates.";
    let about_tile = "A tile, of 512 x 512 pixels unless its description says less. At zoom 0 all of the image is in one tile; each further zoom doubles it.";
    vec![
        Route::get("/xyz/{image}", description, ["xyz", "tiles", about])
            .needs(Scope::Read)
            .path("image", "The image's id and `.json`.")
            .answer(200, "The description", &[Content::json::<TileJson>()]),
        Route::get("/xyz/{image}/{z}/{x}/{y}", xyz_tile, ["xyzTile", "tiles", about_tile])
            .needs(Scope::Read)
            .path("image", "The image's id.")
            .number("z", "Zoom, from 0 to `maxzoom`.")
            .number("x", "Column, from 0 at the left.")
            .path("y", "Row, from 0 at the top, and `.png`, `.jpg` or `.webp`.")
            .picture(),
    ]
}

/// The description of an image's tiles: TileJSON, with pixels for coordinates.
#[derive(Debug, Serialize, JsonSchema)]
struct TileJson {
    /// `3.0.0`.
    tilejson: &'static str,
    /// `simple`.
    crs: &'static str,
    /// Addresses with `{z}`, `{x}` and `{y}`.
    tiles: Vec<String>,
    /// Edge of a tile in pixels.
    #[serde(rename = "tileSize")]
    tile_size: u32,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// 0: the whole image in one tile.
    minzoom: u32,
    /// The largest zoom.
    maxzoom: u32,
    /// The zoom at which the image has its own size.
    nativezoom: u32,
}

async fn description(State(app): State<App>, Path(file): Path<String>, parts: Parts) -> Result<Response, Problem> {
    let id = id_of(&file, ".json")?;
    let opened = open(&app, &Tenant::of(&parts.extensions), id).await?;
    let [width, height] = opened.size;
    let edge = app.service.settings.answers.tile_edge(&opened.ready.scene);
    let native = last_level(opened.size, edge);
    // Up to the precision of the scene's numbers.
    let deeper = (0..=MAX_ZOOM - opened.image.zoom)
        .rev()
        .find(|more| size_of(&opened.ready.scene, opened.image.zoom + more).is_some())
        .unwrap_or(0);
    Ok(everywhere(
        &app,
        Json(TileJson {
            tilejson: "3.0.0",
            crs: "simple",
            tiles: vec![format!("{}/xyz/{id}/{{z}}/{{x}}/{{y}}.png", base_of(&app, &parts))],
            tile_size: edge,
            width,
            height,
            minzoom: 0,
            maxzoom: native + deeper,
            nativezoom: native,
        }),
    ))
}

async fn xyz_tile(
    State(app): State<App>,
    Path((id, z, x, file)): Path<(String, String, String, String)>,
    parts: Parts,
) -> Result<Response, Problem> {
    let missing = || no_tile(&format!("{z}/{x}/{file}"));
    let (y, ending) = file.rsplit_once('.').ok_or_else(missing)?;
    let format = tile_format(ending).ok_or_else(missing)?;
    let number = |text: &str| text.parse::<u32>().map_err(|_| missing());
    let (zoom, column, row) = (number(&z)?, number(&x)?, number(y)?);
    let tenant = Tenant::of(&parts.extensions);
    let _permit = tile_permit(&app, Client::of(&parts.extensions))?;
    let opened = open(&app, &tenant, &id).await?;
    // Levels count down from the image itself, zooms up to it and beyond.
    let edge = app.service.settings.answers.tile_edge(&opened.ready.scene);
    let level = i64::from(last_level(opened.size, edge)) - i64::from(zoom);
    let more = u32::try_from(-level).unwrap_or(0);
    let deepest = opened.image.zoom.checked_add(more).filter(|zoom| *zoom <= MAX_ZOOM).ok_or_else(missing)?;
    size_of(&opened.ready.scene, deepest).ok_or_else(missing)?;
    let level = i32::try_from(level).map_err(|_| missing())?;
    let Region { x, y, .. } = tile_of(opened.size, level, edge, column, row).ok_or_else(missing)?;
    let spec = tile(Grid::Tiles(level), Region { x, y, width: edge, height: edge }, format);
    spec.render_spec(&opened.ready.scene, opened.image.zoom).map_err(|_| missing())?;
    image::tile(&app, &tenant, &parts, opened.image, spec).await
}
