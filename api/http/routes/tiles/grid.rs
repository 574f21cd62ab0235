//! Levels and tiles of an image, and their names in paths.

use crate::http::auth::capability::Capability;
use crate::http::problem::{Kind, Problem};
use crate::http::state::AppState;
use crate::service::pictures::spec::{Grid, PictureSpec};
use axum::http::request::Parts;
use strahl::camera::Window;
use strahl::film::{FileFormat, PictureFormat, Region};

/// The level on which an image has a single tile of `edge` pixels. The image itself is level 0.
pub(super) fn last_level([width, height]: [u32; 2], edge: u32) -> u32 {
    width.max(height).div_ceil(edge).next_power_of_two().ilog2()
}

/// The region of a tile of `edge` pixels of a level, clipped to the image. None if there is no such tile.
pub(super) fn tile_of(size: [u32; 2], level: i32, edge: u32, column: u32, row: u32) -> Option<Region> {
    let Window { width, height, .. } = Window::level(size[0], size[1], level)?;
    let (x, y) = (column.checked_mul(edge)?, row.checked_mul(edge)?);
    (x < width && y < height).then(|| Region { x, y, width: edge.min(width - x), height: edge.min(height - y) })
}

/// What to render for a tile.
pub(super) fn tile(grid: Grid, region: Region, format: FileFormat) -> PictureSpec {
    PictureSpec { grid, ..PictureSpec::plain(Some(region), format) }
}

/// Formats of tiles, by ending.
pub(super) fn tile_format(ending: &str) -> Option<FileFormat> {
    PictureFormat::by_name(ending).filter(|format| !format.is_linear())?.with(None, None).ok()
}

/// Parses `a<between>b.ending`.
pub(super) fn tile_name(file: &str, between: char) -> Option<(u32, u32, FileFormat)> {
    let (place, ending) = file.rsplit_once('.')?;
    let (a, b) = place.split_once(between)?;
    Some((a.parse().ok()?, b.parse().ok()?, tile_format(ending)?))
}

/// The id of the image in a file's name.
pub(super) fn id_of<'file>(file: &'file str, ending: &str) -> Result<&'file str, Problem> {
    file.strip_suffix(ending).ok_or_else(|| Problem::new(Kind::NotFound, format!("{file} has not the ending {ending}")))
}

/// The problem of a tile that does not exist.
pub(super) fn no_tile(what: &str) -> Problem {
    Problem::new(Kind::NotFound, format!("there is no tile {what}"))
}

/// What the addresses of tiles begin with, as their client sees them.
pub(super) fn base_of(app: &AppState, parts: &Parts) -> String {
    // A capability in the path of a request is needed in further paths, too.
    let before = parts.extensions.get::<Capability>().map_or_else(String::new, Capability::prefix);
    app.base_url(&parts.extensions) + &before
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
        assert_eq!(last_level([512, 512], 512), 0);
        assert_eq!(last_level([513, 512], 512), 1);
        assert_eq!(last_level([1_000, 3_000], 512), 3);
    }

    #[test]
    fn tiles_end_with_the_image() {
        assert_eq!(tile_of([1_000, 600], 0, 512, 1, 1), Some(Region { x: 512, y: 512, width: 488, height: 88 }));
        assert_eq!(tile_of([1_000, 600], 1, 512, 0, 0), Some(Region { x: 0, y: 0, width: 500, height: 300 }));
        assert_eq!(tile_of([1_000, 600], 0, 512, 2, 0), None);
        assert_eq!(tile_of([1_000, 600], 0, 512, u32::MAX, 0), None);
        assert_eq!(tile_name("3_14.png", '_'), Some((3, 14, FileFormat::Png8)));
        for wrong in ["3_14.exr", "3.png", "3_-1.png", "3_1", "_.png"] {
            assert_eq!(tile_name(wrong, '_'), None, "{wrong}");
        }
    }
}
