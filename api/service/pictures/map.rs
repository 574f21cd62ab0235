//! Maps of a picture as files.

use crate::service::scheduler::pool::Workers;
use schemars::JsonSchema;
use serde::Deserialize;
use strahl::film::encode::png_of;
use strahl::film::{FileFormat, Region, encode};
use strahl::inspect::maps::{Map, MapKind};
use strahl::render::{Cancelled, Control, render, render_measured};
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

/// Most pixels across and down that one pixel of a coarse map stands for.
pub(crate) const COARSEST: u32 = 64;

/// Renders what a map of the whole picture needs to know, and writes the map. In a coarse one each pixel traced stands for
/// `step` x `step` of them.
pub(crate) fn draw(
    scene: &Scene,
    step: u32,
    kind: MapKind,
    format: MapFormat,
    workers: &Workers,
    control: &Control,
) -> Result<Vec<u8>, Cancelled> {
    workers.work(|| {
        let picture = match kind {
            // With its alpha.
            MapKind::Proved if step == 1 => render(scene, Region::whole(scene.width, scene.height), control),
            _ => render_measured(scene, step, kind == MapKind::Time, control),
        }?;
        let map = Map::of(kind, &picture).enlarged(step, Region::whole(scene.width, scene.height));
        Ok(match format {
            MapFormat::Png => {
                let drawn = map.draw();
                png_of(drawn.width as u32, drawn.height() as u32, drawn.pixels.as_flattened())
            }
            MapFormat::Pfm => map.pfm(),
            MapFormat::Exr => encode(&map.film(), FileFormat::Exr),
        })
    })?
}
