//! A model as all readers give it: triangles, where they are placed, and what they look like.

use super::fault::{Fault, Kind, Subject, Warning, warn};
use super::geometry::Geometry;
use super::material::{Alpha, ModelMaterial};
use glam::{DMat3, DMat4, DVec3};
use hashbrown::HashSet;

/// A model.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// A title, if the file has one.
    pub name: Option<String>,
    /// Which axis is up.
    pub up: Up,
    /// Triangles; those of equal data are listed once.
    pub geometries: Vec<Geometry>,
    /// Where they stand.
    pub placements: Vec<Placement>,
    /// Materials, which placements name by index.
    pub materials: Vec<ModelMaterial>,
    /// Pictures, which textures name by index. Only those that textures use have bytes.
    pub pictures: Vec<Picture>,
    /// Cameras that stand in the model.
    pub cameras: Vec<ModelCamera>,
    /// Lamps that stand in the model.
    pub lamps: Vec<Lamp>,
    /// What is not as the file says.
    pub warnings: Vec<Warning>,
    /// Whether any part was read, whose content may change.
    pub has_parts: bool,
}

/// Which axis of a model is up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Up {
    #[default]
    Y,
    Z,
}

/// Triangles that stand at one or more places.
#[derive(Debug, Clone)]
pub struct Placement {
    /// Index of the geometry.
    pub geometry: usize,
    /// Index of the material; none is the default material of the format.
    pub material: Option<usize>,
    /// The name of its node or group.
    pub name: Option<String>,
    /// From the geometry to the model, at least one.
    pub transforms: Vec<DMat4>,
}

/// A picture file.
#[derive(Debug, Clone, Default)]
pub struct Picture {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// JSON pointer of it, or its name.
    pub pointer: String,
}

/// A camera.
#[derive(Debug, Clone)]
pub struct ModelCamera {
    /// Its number in the file.
    pub number: usize,
    /// Its name.
    pub name: Option<String>,
    /// From the camera, which looks along -z with +y up, to the model.
    pub placed: DMat4,
    /// Its projection.
    pub projection: Projection,
    /// Width of its picture by the height, if the file says so.
    pub aspect: Option<f64>,
}

/// How a camera projects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Perspective.
    Perspective {
        /// Full vertical angle of view in radians.
        vertical: f64,
    },
    /// Parallel.
    Orthographic {
        /// Height of the picture.
        height: f64,
    },
}

/// A lamp.
#[derive(Debug, Clone)]
pub struct Lamp {
    /// From the lamp, which shines along -z, to the model. Its scale turns lamps, too: what mirrors z lets them shine along +z
    /// (KHR_lights_punctual: scale counts for its effect on orientation).
    pub placed: DMat4,
    /// Linear color.
    pub color: [f64; 3],
    /// In candela, or in lux where it shines from far away.
    pub intensity: f64,
    /// Distance at which it ends, if it does.
    pub range: Option<f64>,
    /// Its kind.
    pub kind: LampKind,
}

/// Kinds of lamps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LampKind {
    /// Shines from infinitely far away.
    Directional,
    /// Shines from a point in all directions.
    Point,
    /// Shines from a point into a cone; angles from its axis in radians.
    Spot {
        /// Of full light.
        inner: f64,
        /// Of any light.
        outer: f64,
    },
}

/// Triangles that are looked at where a scale of 0 flattens them; beyond them some are taken to have an area.
const FLATTENED: usize = 1 << 22;

/// Whether a map makes a line or a point of everything.
fn has_no_area(map: &DMat3) -> bool {
    let longest = map.to_cols_array().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    // Scaled first, since squares of tiny and huge numbers are none.
    let [x, y, z] = [map.x_axis, map.y_axis, map.z_axis].map(|column| column / longest);
    longest == 0.0 || [x.cross(y), y.cross(z), z.cross(x)].iter().all(|area| area.length() <= 1e-12)
}

impl Model {
    /// Triangles as they are placed.
    pub fn triangles(&self) -> u64 {
        let of = |placed: &Placement| {
            self.geometries[placed.geometry].triangles.len() as u64 * placed.transforms.len() as u64
        };
        self.placements.iter().map(of).sum()
    }

    /// Drops what has no area: what scales of 0 hide, as animations do, or make a line of, and triangles of which none has three corners.
    pub(super) fn drop_unseen(&mut self) {
        let has_area: Vec<bool> = self.geometries.iter().map(Geometry::has_area).collect();
        self.placements.retain(|placement| has_area[placement.geometry]);
        let mut left = FLATTENED;
        for placement in &mut self.placements {
            let Geometry { triangles, .. } = &self.geometries[placement.geometry];
            placement.transforms.retain(|matrix| {
                let map = DMat3::from_mat4(*matrix);
                if has_no_area(&map) || map.determinant() != 0.0 || left == 0 {
                    return !has_no_area(&map);
                }
                let moved = |point| matrix.transform_point3(DVec3::from_array(point));
                let found = self.geometries[placement.geometry].first_with_area(left, moved);
                left -= found.map_or(triangles.len(), |at| at + 1).min(left);
                found.is_some() || left == 0
            });
        }
        self.placements.retain(|placement| !placement.transforms.is_empty());
    }

    /// Drops what stands in the place of another one like it, where nothing is seen of it: instances may be very many, and each
    /// ray would meet all of them.
    pub(super) fn drop_repeated(&mut self) {
        let mut is_any = false;
        for placement in self.placements.iter_mut().filter(|placement| placement.transforms.len() > 1) {
            let material = placement.material.map(|index| &self.materials[index]);
            if material.is_some_and(|it| it.alpha == Alpha::Blend || it.transmission.factor > 0.0) {
                continue;
            }
            let count = placement.transforms.len();
            let mut met = HashSet::with_capacity(count);
            // Adding 0 turns -0 into 0.
            placement.transforms.retain(|matrix| met.insert(matrix.to_cols_array().map(|x| (x + 0.0).to_bits())));
            is_any |= placement.transforms.len() < count;
        }
        if is_any {
            let detail = "of copies in one place one is kept: nothing is seen of the others";
            warn(&mut self.warnings, Subject::Skipped, "copies", String::new(), detail);
        }
    }

    /// Why there is no picture of it.
    pub(super) fn nothing_to_see(&self) -> Fault {
        let skipped = self.warnings.iter().find(|warning| matches!(warning.what, "points" | "lines"));
        let detail = match skipped {
            Some(warning) => {
                format!("the model has only {}, of which no picture is made: it needs triangles", warning.what)
            }
            None => "there is nothing to see: the model has no triangles that have an area".to_owned(),
        };
        Fault::new("", Kind::Degenerate, detail)
    }
}
