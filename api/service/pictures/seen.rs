//! Maps of what the camera sees: whose surface, how far away, how much of each pixel comes from one object.
//!
//! They take one ray a pixel, or those of a share, and are made of any part at any coarseness.

use crate::service::scheduler::pool::Workers;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::HashMap;
use strahl::camera::Window;
use strahl::film::{Layer, Region};
use strahl::render::{Cancelled, Control, Layers, render_layers, render_sources};
use strahl::scene::Scene;

/// Whose surface is seen in each pixel.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ObjectMap {
    /// The part of the picture: left edge.
    pub(crate) x: u32,
    /// Upper edge.
    pub(crate) y: u32,
    /// Pixels across.
    pub(crate) w: u32,
    /// Pixels down.
    pub(crate) h: u32,
    /// Each number stands for so many pixels across and down.
    pub(crate) step: u32,
    /// Numbers in a row.
    pub(crate) columns: u32,
    /// Rows.
    pub(crate) rows: u32,
    /// What is seen, in the order in which it is met, row by row.
    pub(crate) objects: Vec<SeenObject>,
    /// Row by row, pairs of a number and how often it comes next: 0 where nothing is seen, n for the n-th of `objects`.
    #[schemars(with = "Vec<[u32; 2]>")]
    pub(crate) runs: Vec<(u32, u32)>,
}

/// An object that is seen.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SeenObject {
    /// Its JSON pointer. Objects inside of what is placed, as instances are, have that of what places them.
    pub(crate) pointer: String,
    /// Its name.
    pub(crate) name: Option<String>,
}

/// A part of the picture of a scene, and how coarse it is looked at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Looked {
    /// The part.
    pub(crate) region: Region,
    /// Pixels across and down that each ray stands for.
    pub(crate) step: u32,
}

impl Looked {
    /// Columns and rows.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.region.width, self.region.height].map(|length| length.div_ceil(self.step))
    }

    /// The pixels that are traced. Without steps they are those of the picture, to the last bit.
    fn pixels(&self, scene: &Scene) -> (Window, Region) {
        if self.step == 1 {
            return (Window::whole(scene.width, scene.height), self.region);
        }
        let [width, height] = self.size();
        let (origin, step) = ([self.region.x, self.region.y].map(f64::from), f64::from(self.step));
        (Window { origin, step: [step; 2], width, height }, Region::whole(width, height))
    }

    /// Whose surface is seen.
    pub(crate) fn objects(
        &self,
        scene: &Scene,
        workers: &Workers,
        control: &Control,
    ) -> Result<(Vec<SeenObject>, Vec<u32>), Cancelled> {
        let (window, region) = self.pixels(scene);
        let sources = workers.work(|| render_sources(scene, &window, region, control))??;
        let (mut objects, mut known) = (Vec::new(), HashMap::new());
        let mut number = |source: u32| {
            *known.entry(source).or_insert_with(|| {
                let name = scene.sources.name(source).map(str::to_owned);
                objects.push(SeenObject { pointer: scene.sources.pointer(source), name });
                objects.len() as u32
            })
        };
        let numbers = sources.into_iter().map(|source| source.map_or(0, &mut number)).collect();
        Ok((objects, numbers))
    }

    /// The numbers of a layer that has one for each pixel; none for others.
    pub(crate) fn numbers(
        &self,
        scene: &Scene,
        layer: Layers,
        workers: &Workers,
        control: &Control,
    ) -> Result<Vec<f32>, Cancelled> {
        let (window, region) = self.pixels(scene);
        let (layers, _) = workers.work(|| render_layers(scene, &window, region, control, layer))??;
        Ok(match layers.into_iter().next() {
            Some((_, Layer::Distance(numbers) | Layer::Share(_, numbers))) => numbers,
            _ => Vec::new(),
        })
    }
}

/// Numbers as pairs of a number and how often it comes next.
pub(crate) fn runs(numbers: &[u32]) -> Vec<(u32, u32)> {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for number in numbers {
        match runs.last_mut() {
            Some((last, count)) if last == number => *count += 1,
            _ => runs.push((*number, 1)),
        }
    }
    runs
}
