//! The memory that a scene may take for copies of its models' data.

use crate::models::{Budget, Kind, Model, Picture, Placement};
use crate::scene::Files;
use crate::scene::limits::{Limit, TRIANGLES};
use crate::scene::problem::{Code, Problem, Problems};

/// Bytes that an instance takes at most while it is read: its matrix, copies of that, and the object that has it.
const INSTANCE: u64 = 1_000;
/// Bytes that a point of glass takes at most while seams are looked for.
const WELDED: u64 = 200;

/// What the models of a scene have taken so far.
#[derive(Debug, Default)]
pub(super) struct CopyBudget {
    triangles: u64,
    /// The most points of a body of glass.
    welded: u64,
    bytes: Budget,
}

impl CopyBudget {
    /// Takes room for what a scene copies of a model, before it does: a mesh for each of its materials, and a picture wherever a
    /// material names it. Fails if there is no memory for its instances, or if the scene would have more triangles than it may, or more bytes than a model may be decoded to.
    pub(super) fn take_model(&mut self, model: &Model, files: &dyn Files, pointer: &str) -> Result<(), Problems> {
        let of = |placement: &Placement| model.geometries[placement.geometry].triangles.len() as u64;
        self.triangles += model.placements.iter().map(of).sum::<u64>();
        let Limit { name, max } = TRIANGLES;
        if self.triangles > max {
            let detail = format!("{} triangles are over the limit of {max} ({name})", self.triangles);
            return Err(Problems::one(Problem::new(pointer, Code::Limit, detail)));
        }
        let instances = model.placements.iter().map(|placement| placement.transforms.len() as u64).sum::<u64>();
        if !files.has_room(INSTANCE * instances) {
            let detail = format!("there is no memory for its {instances} instances");
            return Err(Problems::one(Problem::new(pointer, Code::Limit, detail)));
        }
        let is_glass =
            |placement: &&Placement| placement.material.is_some_and(|index| model.materials[index].bends_light());
        let points_of = |placement: &Placement| model.geometries[placement.geometry].positions.len() as u64;
        let points = model.placements.iter().filter(is_glass).map(points_of).max().unwrap_or(0);
        let more = points.saturating_sub(self.welded);
        self.welded += more;
        if !files.has_room(WELDED * more) {
            let detail = format!("there is no memory to look for seams of glass with {points} points");
            return Err(Problems::one(Problem::new(pointer, Code::Limit, detail)));
        }
        let meshes = model.placements.iter().map(|placement| model.geometries[placement.geometry].bytes());
        let textures =
            model.materials.iter().flat_map(|material| material.textures().chain(material.opacity_texture()));
        // In base64.
        let written = |picture: &Picture| picture.bytes.len() / 3 * 4;
        let named = textures.map(|texture| written(&model.pictures[texture.picture]));
        for bytes in meshes.chain(named).chain(model.pictures.iter().map(written)) {
            self.take(bytes, pointer)?;
        }
        Ok(())
    }

    /// Takes room for so many bytes.
    pub(super) fn take(&self, bytes: usize, pointer: &str) -> Result<(), Problems> {
        self.bytes.take(1, bytes).map_err(|fault| {
            let code = if fault.kind == Kind::Cancelled { Code::Cancelled } else { Code::Limit };
            Problems::one(Problem::new(pointer, code, fault.detail))
        })
    }
}
