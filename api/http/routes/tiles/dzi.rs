//! Deep Zoom Images, as OpenSeadragon opens them: `/dzi/{id}.dzi`, `/dzi/{id}_files/{level}/{column}_{row}.png`.

use super::{described, id_of, last_level, no_tile, open, place, show, tile, tile_name, tile_of};
use crate::http::App;
use crate::http::auth::client::Client;
use crate::http::auth::tenant::Tenant;
use crate::http::contract::bodies::{Picture, Xml};
use crate::http::contract::queries;
use crate::http::extract::query::Parameters;
use crate::http::problem::Problem;
use crate::service::pictures::spec::{Grid, TILE};
use axum::extract::{Path, State};
use axum::http::header;
use axum::http::request::Parts;
use axum::response::Response;

/// The size of an image and of its tiles, as XML.
#[utoipa::path(
    get, path = "/dzi/{image}", operation_id = "dzi", tag = "tiles",
    params(("image" = String, Path, description = "The image's id and `.dzi`."), queries::Tiles),
    responses((status = 200, description = "The description", body = Xml, content_type = "application/xml")),
)]
pub(crate) async fn dzi(
    State(service): State<App>,
    Path(file): Path<String>,
    parts: Parts,
) -> Result<Response, Problem> {
    let id = id_of(&file, ".dzi")?;
    let mut parameters = Parameters::of(&parts.uri)?;
    let format = parameters.choice("format", &[("png", "png"), ("jpg", "jpg"), ("webp", "webp")], "png");
    parameters.finish()?;
    let [width, height] = open(&service, &Tenant::of(&parts.extensions), id).await?.size;
    let xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <Image xmlns=\"http://schemas.microsoft.com/deepzoom/2008\" Format=\"{format}\" Overlap=\"0\" \
         TileSize=\"{TILE}\"><Size Width=\"{width}\" Height=\"{height}\"/></Image>\n"
    );
    Ok(described(([(header::CONTENT_TYPE, "application/xml")], xml)))
}

/// A tile. Level 0 is a single pixel; each further level is twice as wide and high, up to the image itself.
#[utoipa::path(
    get, path = "/dzi/{folder}/{level}/{tile}", operation_id = "dziTile", tag = "tiles",
    params(
        ("folder" = String, Path, description = "The image's id and `_files`."),
        ("level" = u32, Path, description = "From 0 to the logarithm of the longer side."),
        ("tile" = String, Path, description = "Column, `_`, row and `.png`, `.jpg` or `.webp`."),
    ),
    responses((status = 200, response = Picture)),
)]
pub(crate) async fn dzi_tile(
    State(service): State<App>,
    Path((folder, level, file)): Path<(String, String, String)>,
    parts: Parts,
) -> Result<Response, Problem> {
    let missing = || no_tile(&format!("{folder}/{level}/{file}"));
    let id = folder.strip_suffix("_files").ok_or_else(missing)?;
    let level: u32 = level.parse().map_err(|_| missing())?;
    let (column, row, format) = tile_name(&file, '_').ok_or_else(missing)?;
    let tenant = Tenant::of(&parts.extensions);
    let _place = place(&service, Client::of(&parts.extensions))?;
    let opened = open(&service, &tenant, id).await?;
    let down = last_level(opened.size, 1).checked_sub(level).ok_or_else(missing)?;
    let region = tile_of(opened.size, down, column, row).ok_or_else(missing)?;
    show(&service, &tenant, &parts, opened.image, tile(Grid::Level(down as i32), region, format)).await
}
