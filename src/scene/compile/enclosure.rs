//! Whether the eye is in a closed room: an opaque ball, box or closed mesh is all around it, as it is written or placed by transforms.
//! Then no ray of the picture leaves the scene.

use super::occluded::{Wall, is_opaque, slack};
use crate::accel::{Bounds, Geometry, Instance, Item, Mesh, Shape, distance_to_triangle};
use crate::control;
use crate::lanes::Real;
use crate::math;
use crate::scene::closed_mesh::is_closed;
use crate::shading::material::Material;
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// Most items of placed geometries that are looked at, a geometry each time that it is placed around the eye.
const MOST_ITEMS: usize = 1 << 20;
/// Most triangles around the eye whose solid angles are summed up.
const MOST_TRIANGLES: usize = 1 << 20;

/// Looks for rooms in a scene.
#[derive(Debug)]
pub(super) struct Enclosures<'a, R> {
    geometries: &'a [Geometry<R>],
    materials: &'a [Material<R>],
    /// Boxes of the meshes that were looked at: one that is placed often is measured once.
    boxes: HashMap<*const Mesh<R>, Bounds>,
    items: usize,
    triangles: usize,
}

impl<'a, R: Real> Enclosures<'a, R> {
    /// In a scene of these geometries.
    pub(super) fn new(geometries: &'a [Geometry<R>], materials: &'a [Material<R>]) -> Self {
        Self { geometries, materials, boxes: HashMap::new(), items: MOST_ITEMS, triangles: MOST_TRIANGLES }
    }

    /// Whether one of some items is a room around a box. Balls and boxes are looked at before meshes, which take longer.
    pub(super) fn around(&mut self, items: &[Item<R>], eye: Bounds) -> bool {
        [false, true].into_iter().any(|meshes| items.iter().any(|item| self.encloses_eye(item, eye, meshes)))
    }

    fn encloses_eye(&mut self, item: &Item<R>, eye: Bounds, meshes: bool) -> bool {
        match &item.shape {
            Shape::Instance(instance) if instance.motion.is_none() => {
                let geometry = &self.geometries[instance.geometry as usize];
                let inside = placed(instance, eye);
                is_within(inside, geometry.extent.bounds)
                    && take(&mut self.items, geometry.items.len())
                    && geometry.items.iter().any(|item| self.encloses_eye(item, inside, meshes))
            }
            _ if !is_opaque(self.materials, item) => false,
            Shape::Mesh(mesh) => meshes && item.closed && self.encloses(mesh, eye),
            _ => !meshes && Wall::of(item).is_some_and(|wall| wall.closes() && wall.contains(eye)),
        }
    }

    /// Whether a mesh without a hole goes round a box: the solid angles of its triangles sum up to 4 pi or more (van Oosterom and
    /// Strackee, The Solid Angle of a Plane Triangle, 1983), and none of them is near the box.
    fn encloses(&mut self, mesh: &Arc<Mesh<R>>, eye: Bounds) -> bool {
        let point = |i: u32| DVec3::from_array(mesh.vertices[i as usize].map(Real::to_f64));
        let bounds = || Bounds::around((0..mesh.vertices.len() as u32).map(point));
        let bounds = *self.boxes.entry(Arc::as_ptr(mesh)).or_insert_with(bounds);
        if !is_within(eye, bounds) || !take(&mut self.triangles, mesh.faces.len()) {
            return false;
        }
        let (middle, reach) = ((eye.min + eye.max) * 0.5, (eye.max - eye.min).length() * 0.5);
        let mut angle = 0.0;
        let solid =
            mesh.faces.iter().enumerate().filter(|(index, _)| !mesh.is_collapsed(*index)).map(|(_, face)| *face);
        let faces: Vec<[u32; 3]> = solid.collect();
        for face in &faces {
            if control::step(1) {
                return false;
            }
            let corners = face.map(|i| point(i) - middle);
            let [a, b, c] = corners;
            let [x, y, z] = corners.map(|corner| corner.length());
            if distance_to_triangle(DVec3::ZERO, corners) <= reach + slack(x.max(y).max(z), eye) {
                return false;
            }
            let cosine = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
            angle += 2.0 * math::atan2(a.dot(b.cross(c)), cosine);
        }
        let vertices: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| v.map(Real::to_f64)).collect();
        angle.abs() > 2.0 * PI && is_closed(&vertices, &faces)
    }
}

/// Takes some of what is left; false if there is too little.
fn take(left: &mut usize, some: usize) -> bool {
    let enough = some <= *left;
    *left -= if enough { some } else { 0 };
    enough
}

/// Whether a box is within another one.
fn is_within(inner: Bounds, outer: Bounds) -> bool {
    inner.min.cmpge(outer.min).all() && inner.max.cmple(outer.max).all()
}

/// The box around a box, with room for roundings, in the coordinates of a placed geometry.
fn placed<R: Real>(instance: &Instance<R>, outer: Bounds) -> Bounds {
    let room = slack(0.0, outer);
    let outer = Bounds { min: outer.min - room, max: outer.max + room };
    let vector = |v: [R; 3]| DVec3::from_array(v.map(Real::to_f64));
    let [x, y, z] = instance.to_local.columns.map(vector);
    let corners = (0..8).map(|corner| {
        let side = |bit: u32| corner >> bit & 1 == 0;
        let p = DVec3::select(glam::BVec3::new(side(0), side(1), side(2)), outer.min, outer.max);
        x * p.x + y * p.y + z * p.z + vector(instance.to_local.translation)
    });
    Bounds::around(corners)
}
