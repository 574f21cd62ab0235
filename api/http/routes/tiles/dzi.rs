//! Deep Zoom Images, for OpenSeadragon: `/dzi/{id}.dzi`, `/dzi/{id}_files/{level}/{column}_{row}.png`.

use super::grid::{id_of, last_level, no_tile, tile, tile_name, tile_of};
use crate::http::auth::client::Client;
use crate::http::prelude::*;
use crate::http::respond::image::{self, everywhere, open, tile_permit};
use crate::service::pictures::spec::Grid;
use axum::http::request::Parts;

pub(super) fn routes() -> Vec<Route> {
    let about =
        "A tile. Level 0 is a single pixel; each further level is twice as wide and high, up to the image itself.";
    vec![
        Route::get("/dzi/{image}", description, ["dzi", "tiles", "The size of an image and of its tiles, as XML."])
            .needs(Scope::Read)
            .path("image", "The image's id and `.dzi`.")
            .query(format)
            .answer(200, "The description", &[Content::text("application/xml")]),
        Route::get("/dzi/{folder}/{level}/{tile}", dzi_tile, ["dziTile", "tiles", about])
            .needs(Scope::Read)
            .path("folder", "The image's id and `_files`.")
            .number("level", "From 0 to the logarithm of the longer side.")
            .path("tile", "Column, `_`, row and `.png`, `.jpg` or `.webp`.")
            .picture(),
    ]
}

/// The formats of tiles.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum TileFormat {
    Png,
    Jpg,
    Webp,
}

fn format(query: &mut Query) -> &'static str {
    match query.word("format", "Format of the tiles that the description names.") {
        Some(TileFormat::Jpg) => "jpg",
        Some(TileFormat::Webp) => "webp",
        Some(TileFormat::Png) | None => "png",
    }
}

async fn description(State(app): State<App>, Path(file): Path<String>, parts: Parts) -> Result<Response, Problem> {
    let id = id_of(&file, ".dzi")?;
    let format = Query::read(&parts.uri, format)?;
    let opened = open(&app, &Tenant::of(&parts.extensions), id).await?;
    let ([width, height], edge) = (opened.size, app.service.settings.answers.tile_edge(&opened.ready.scene));
    let xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <Image xmlns=\"http://schemas.microsoft.com/deepzoom/2008\" Format=\"{format}\" Overlap=\"0\" \
         TileSize=\"{edge}\"><Size Width=\"{width}\" Height=\"{height}\"/></Image>\n"
    );
    Ok(everywhere(&app, ([(header::CONTENT_TYPE, "application/xml")], xml)))
}

async fn dzi_tile(
    State(app): State<App>,
    Path((folder, level, file)): Path<(String, String, String)>,
    parts: Parts,
) -> Result<Response, Problem> {
    let missing = || no_tile(&format!("{folder}/{level}/{file}"));
    let id = folder.strip_suffix("_files").ok_or_else(missing)?;
    let level: u32 = level.parse().map_err(|_| missing())?;
    let (column, row, format) = tile_name(&file, '_').ok_or_else(missing)?;
    let tenant = Tenant::of(&parts.extensions);
    let _permit = tile_permit(&app, Client::of(&parts.extensions))?;
    let opened = open(&app, &tenant, id).await?;
    let down = last_level(opened.size, 1).checked_sub(level).ok_or_else(missing)?;
    let edge = app.service.settings.answers.tile_edge(&opened.ready.scene);
    let region = tile_of(opened.size, down as i32, edge, column, row).ok_or_else(missing)?;
    image::tile(&app, &tenant, &parts, opened.image, tile(Grid::Level(down as i32), region, format)).await
}
