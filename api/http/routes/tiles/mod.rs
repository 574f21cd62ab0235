//! Deep zoom into known images, by three conventions over one way to a picture: IIIF Image API 3, DZI and XYZ.
//!
//! A ray tracer needs no pyramid of images: each tile is rendered at its own size, and is byte for byte that crop of the
//! whole image at that size.

mod dzi;
mod iiif;
mod iiif_info;
mod iiif_parse;
mod xyz;

pub(crate) use dzi::{__path_dzi, __path_dzi_tile, dzi, dzi_tile};
pub(crate) use iiif::{__path_iiif, __path_iiif_image, iiif, iiif_image};
pub(crate) use iiif_info::{__path_iiif_info, iiif_info};
pub(crate) use xyz::{__path_xyz, __path_xyz_tile, xyz, xyz_tile};

use crate::http::auth::client::Client;
use crate::http::auth::tenant::Tenant;
use crate::http::concurrency_limit::Permit;
use crate::http::problem::{Kind, Problem};
use crate::http::respond;
use crate::http::respond::{Freshness, ResponseContext, Source};
use crate::http::routes::images;
use crate::http::{App, Service};
use crate::service::pictures::spec::{Grid, PictureSpec, TILE, size_of};
use crate::service::scenes::cache::unknown;
use crate::service::scenes::ids::ImageId;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::task::Class;
use axum::http::request::Parts;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use strahl::camera::Window;
use strahl::film::{Adjustment, FileFormat, PictureFormat, Region};

/// A known image whose scene is built.
#[derive(Debug)]
struct Opened {
    image: ImageId,
    ready: Arc<PreparedScene>,
    /// Pixels across and down.
    size: [u32; 2],
}

/// Opens an image; its scene is built if need be.
async fn open(service: &App, tenant: &Tenant, id: &str) -> Result<Opened, Problem> {
    let image = images::image_id(id)?;
    let ready = match service.scenes.recall_known(&image.scene) {
        Some(ready) => ready,
        None => respond::build(service, tenant, Class::Tiles, Source::Known(image.clone())).await?,
    };
    let size = size_of(&ready.scene, image.zoom).ok_or_else(|| unknown(&image.scene))?;
    Ok(Opened { image, ready, size })
}

/// A place for one more tile of a client, who has it until the tile is made.
pub(crate) fn place(service: &Service, client: Client) -> Result<Permit<Client>, Problem> {
    let most = service.limits.client_tiles;
    service.tile_clients.enter(client, most).ok_or_else(|| {
        let detail = format!("you are waiting for {most} tiles already (client_tiles)");
        Problem::new(Kind::RateLimited, detail).retry_after(service.tiles.retry_after())
    })
}

/// The answer that a part of an image makes.
async fn show(
    service: &App,
    tenant: &Tenant,
    parts: &Parts,
    image: ImageId,
    spec: PictureSpec,
) -> Result<Response, Problem> {
    let context = ResponseContext {
        method: &parts.method,
        headers: &parts.headers,
        tenant,
        freshness: Freshness::Immutable,
        negotiated: false,
    };
    let mut response = images::answer(service, &context, Class::Tiles, image, spec).await?;
    everywhere(&mut response);
    Ok(response)
}

/// The id of the image that a file is about, by the file's ending.
fn id_of<'file>(file: &'file str, ending: &str) -> Result<&'file str, Problem> {
    file.strip_suffix(ending).ok_or_else(|| Problem::new(Kind::NotFound, format!("{file} has not the ending {ending}")))
}

/// A description of an image, for pages of any origin.
fn described(description: impl IntoResponse) -> Response {
    let mut response = description.into_response();
    everywhere(&mut response);
    response
}

/// Lets pages of any origin show it: who has an image's id may see it.
fn everywhere(response: &mut Response) {
    response.headers_mut().insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, HeaderValue::from_static("*"));
}

/// The level on which an image has a single pixel, or, with an edge, a single tile: the image itself is level 0.
fn last_level([width, height]: [u32; 2], edge: u32) -> u32 {
    width.max(height).div_ceil(edge).next_power_of_two().ilog2()
}

/// A tile of a level, cut off at the image's edge, if there is one there.
fn tile_of(size: [u32; 2], level: u32, column: u32, row: u32) -> Option<Region> {
    let Window { width, height, .. } = Window::level(size[0], size[1], level as i32)?;
    let (x, y) = (column.checked_mul(TILE)?, row.checked_mul(TILE)?);
    (x < width && y < height).then(|| Region { x, y, width: TILE.min(width - x), height: TILE.min(height - y) })
}

/// A tile of an image.
fn tile(grid: Grid, region: Region, format: FileFormat) -> PictureSpec {
    PictureSpec { grid, region: Some(region), adjustment: Adjustment::default(), format }
}

/// Formats of tiles, by ending.
fn tile_format(ending: &str) -> Option<FileFormat> {
    PictureFormat::by_name(ending).filter(|format| !format.is_linear())?.with(None, None).ok()
}

/// `a<between>b.ending` taken apart.
fn tile_name(file: &str, between: char) -> Option<(u32, u32, FileFormat)> {
    let (place, ending) = file.rsplit_once('.')?;
    let (a, b) = place.split_once(between)?;
    Some((a.parse().ok()?, b.parse().ok()?, tile_format(ending)?))
}

fn no_tile(what: &str) -> Problem {
    Problem::new(Kind::NotFound, format!("there is no tile {what}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_end_with_one_pixel_or_one_tile() {
        assert_eq!(last_level([1, 1], 1), 0);
        assert_eq!(last_level([1_000, 600], 1), 10);
        assert_eq!(last_level([1_024, 600], 1), 10);
        assert_eq!(last_level([1_025, 600], 1), 11);
        assert_eq!(last_level([512, 512], TILE), 0);
        assert_eq!(last_level([513, 512], TILE), 1);
        assert_eq!(last_level([1_000, 3_000], TILE), 3);
    }

    #[test]
    fn tiles_end_with_the_image() {
        assert_eq!(tile_of([1_000, 600], 0, 1, 1), Some(Region { x: 512, y: 512, width: 488, height: 88 }));
        assert_eq!(tile_of([1_000, 600], 1, 0, 0), Some(Region { x: 0, y: 0, width: 500, height: 300 }));
        assert_eq!(tile_of([1_000, 600], 0, 2, 0), None);
        assert_eq!(tile_of([1_000, 600], 0, u32::MAX, 0), None);
        assert_eq!(tile_name("3_14.png", '_'), Some((3, 14, FileFormat::Png8)));
        for wrong in ["3_14.exr", "3.png", "3_-1.png", "3_1", "_.png"] {
            assert_eq!(tile_name(wrong, '_'), None, "{wrong}");
        }
    }
}
