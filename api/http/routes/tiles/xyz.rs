//! XYZ tiles, as Leaflet and others take them: `/xyz/{id}/{z}/{x}/{y}.png`, described by `/xyz/{id}.json`.
//!
//! Zoom 0 is a single tile; deeper zooms than the image's own size show more detail. Viewers of maps expect whole tiles, so
//! those along the edges go on where the image ends: its rays do.

use super::{described, id_of, last_level, no_tile, open, place, show, tile, tile_format};
use crate::http::App;
use crate::http::auth::client::Client;
use crate::http::auth::tenant::Tenant;
use crate::http::contract::bodies::Picture;
use crate::http::contract::pictures::TileJson;
use crate::http::problem::Problem;
use crate::service::pictures::spec::{Grid, TILE, size_of};
use crate::service::scenes::ids::MAX_ZOOM;
use axum::Json;
use axum::extract::{Path, State};
use axum::http::request::Parts;
use axum::response::Response;
use serde_json::json;
use strahl::film::Region;

/// The size of an image and where its tiles are: TileJSON, with pixels for coordinates.
#[utoipa::path(
    get, path = "/xyz/{image}", operation_id = "xyz", tag = "tiles",
    params(("image" = String, Path, description = "The image's id and `.json`.")),
    responses((status = 200, description = "The description", body = TileJson)),
)]
pub(crate) async fn xyz(
    State(service): State<App>,
    Path(file): Path<String>,
    parts: Parts,
) -> Result<Response, Problem> {
    let id = id_of(&file, ".json")?;
    let opened = open(&service, &Tenant::of(&parts.extensions), id).await?;
    let [width, height] = opened.size;
    let native = last_level(opened.size, TILE);
    // As deep as the numbers reach.
    let deeper = (0..=MAX_ZOOM - opened.image.zoom)
        .rev()
        .find(|more| size_of(&opened.ready.scene, opened.image.zoom + more).is_some())
        .unwrap_or(0);
    Ok(described(Json(json!({
        "tilejson": "3.0.0",
        "crs": "simple",
        "tiles": [format!("/xyz/{id}/{{z}}/{{x}}/{{y}}.png")],
        "tileSize": TILE,
        "width": width,
        "height": height,
        "minzoom": 0,
        "maxzoom": native + deeper,
        "nativezoom": native,
    }))))
}

/// A tile of 512 x 512 pixels. At zoom z the image is 2^z tiles wide or high, whichever is longer.
#[utoipa::path(
    get, path = "/xyz/{image}/{z}/{x}/{y}", operation_id = "xyzTile", tag = "tiles",
    params(
        ("image" = String, Path, description = "The image's id."),
        ("z" = u32, Path, description = "Zoom, from 0 to `maxzoom`."),
        ("x" = u32, Path, description = "Column, from 0 at the left."),
        ("y" = String, Path, description = "Row, from 0 at the top, and `.png`, `.jpg` or `.webp`."),
    ),
    responses((status = 200, response = Picture)),
)]
pub(crate) async fn xyz_tile(
    State(service): State<App>,
    Path((id, z, x, file)): Path<(String, String, String, String)>,
    parts: Parts,
) -> Result<Response, Problem> {
    let missing = || no_tile(&format!("{z}/{x}/{file}"));
    let (y, ending) = file.rsplit_once('.').ok_or_else(missing)?;
    let format = tile_format(ending).ok_or_else(missing)?;
    let number = |text: &str| text.parse::<u32>().map_err(|_| missing());
    let (zoom, column, row) = (number(&z)?, number(&x)?, number(y)?);
    let tenant = Tenant::of(&parts.extensions);
    let _place = place(&service, Client::of(&parts.extensions))?;
    let opened = open(&service, &tenant, &id).await?;
    // Levels count down from the image itself, zooms up to it and beyond.
    let level = i64::from(last_level(opened.size, TILE)) - i64::from(zoom);
    let more = u32::try_from(-level).unwrap_or(0);
    let deepest = opened.image.zoom.checked_add(more).filter(|zoom| *zoom <= MAX_ZOOM).ok_or_else(missing)?;
    size_of(&opened.ready.scene, deepest).ok_or_else(missing)?;
    let grid = Grid::Tiles(i32::try_from(level).map_err(|_| missing())?);
    let (left, top) = (column.checked_mul(TILE).ok_or_else(missing)?, row.checked_mul(TILE).ok_or_else(missing)?);
    let region = Region { x: left, y: top, width: TILE, height: TILE };
    let spec = tile(grid, region, format);
    spec.shot(&opened.ready.scene, opened.image.zoom).map_err(|_| missing())?;
    show(&service, &tenant, &parts, opened.image, spec).await
}
