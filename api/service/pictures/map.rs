//! Maps of a picture as files.

use crate::service::scheduler::pool::Workers;
use schemars::JsonSchema;
use serde::Deserialize;
use strahl::film::encode::png_of;
use strahl::film::{FileFormat, Region, encode};
use strahl::inspect::maps::{Map, MapKind};
use strahl::render::{Cancelled, Control, render, render_one_by_one};
use strahl::scene::Scene;

/// How a map is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum MapFormat {
    /// In colors, with a scale below.
    #[default]
    Png,
    /// The numbers themselves.
    Pfm,
    /// The numbers themselves.
    Exr,
}

/// Renders what a map needs to know, and writes the map.
pub(crate) fn draw(
    scene: &Scene,
    region: Region,
    kind: MapKind,
    format: MapFormat,
    workers: &Workers,
    control: &Control,
) -> Result<Vec<u8>, Cancelled> {
    workers.work(|| {
        let picture = match kind {
            MapKind::Proved => render(scene, region, control),
            MapKind::Rays | MapKind::Time | MapKind::Depth => render_one_by_one(scene, region, control),
        }?;
        let map = Map::of(kind, &picture);
        Ok(match format {
            MapFormat::Png => {
                let drawn = map.draw();
                png_of(drawn.width as u32, drawn.height() as u32, drawn.pixels.as_flattened())
            }
            MapFormat::Pfm => encode(&map.film(), FileFormat::Pfm),
            MapFormat::Exr => encode(&map.film(), FileFormat::Exr),
        })
    })?
}
