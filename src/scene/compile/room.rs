//! Whether the eye is in a closed room: an opaque ball, box or closed mesh is all around it, as it is written or placed by transforms.
//! Then no ray of the picture leaves the scene.

use super::hidden::{Wall, is_opaque, slack};
use crate::accel::{Bounds, Geometry, Instance, Item, Mesh, Shape};
use crate::lanes::Real;
use crate::math;
use crate::scene::closed_mesh::is_closed;
use crate::shading::material::Material;
use glam::DVec3;
use std::f64::consts::PI;

/// Most items that are looked at.
const MOST_ITEMS: usize = 4_096;
/// Most triangles of all meshes that are looked at.
const MOST_TRIANGLES: usize = 200_000;

/// Looks for rooms in a scene.
#[derive(Debug)]
pub(super) struct Rooms<'a, R> {
    geometries: &'a [Geometry<R>],
    materials: &'a [Material<R>],
    items: usize,
    triangles: usize,
}

impl<'a, R: Real> Rooms<'a, R> {
    /// In a scene of these geometries.
    pub(super) fn new(geometries: &'a [Geometry<R>], materials: &'a [Material<R>]) -> Self {
        Self { geometries, materials, items: MOST_ITEMS, triangles: MOST_TRIANGLES }
    }

    /// Whether one of some items is a room around a box.
    pub(super) fn around(&mut self, items: &[Item<R>], eye: Bounds) -> bool {
        items.iter().any(|item| {
            let Some(left) = self.items.checked_sub(1) else { return false };
            self.items = left;
            self.is_room(item, eye)
        })
    }

    fn is_room(&mut self, item: &Item<R>, eye: Bounds) -> bool {
        match &item.shape {
            Shape::Instance(instance) if instance.motion.is_none() => {
                let geometry = &self.geometries[instance.geometry as usize];
                let inside = placed(instance, eye);
                is_within(inside, geometry.extent.bounds) && self.around(&geometry.items, inside)
            }
            _ if !is_opaque(self.materials, item) => false,
            Shape::Mesh(mesh) if item.closed => self.encloses(mesh, eye),
            _ => Wall::of(item).is_some_and(|wall| wall.closes() && wall.contains(eye)),
        }
    }

    /// Whether a mesh without a hole goes round a box: the solid angles of its triangles sum up to 4 pi or more (van Oosterom and Strackee, The
    /// Solid Angle of a Plane Triangle, 1983), and none of them is near the box.
    fn encloses(&mut self, mesh: &Mesh<R>, eye: Bounds) -> bool {
        let Some(left) = self.triangles.checked_sub(mesh.faces.len()) else { return false };
        let point = |i: u32| DVec3::from_array(mesh.vertices[i as usize].map(Real::to_f64));
        if !is_within(eye, Bounds::around(mesh.faces.iter().flatten().map(|i| point(*i)))) {
            return false;
        }
        self.triangles = left;
        let (middle, reach) = ((eye.min + eye.max) * 0.5, (eye.max - eye.min).length() * 0.5);
        let mut angle = 0.0;
        for face in mesh.faces.iter() {
            let corners = face.map(|i| point(i) - middle);
            let [a, b, c] = corners;
            let furthest = corners.iter().map(|corner| corner.length()).fold(0.0, f64::max);
            let room = reach + slack(furthest, eye);
            let normal = (b - a).cross(c - a);
            let by_plane = normal.dot(a).abs() > room * normal.length();
            let by_box =
                a.min(b).min(c).cmpgt(DVec3::splat(room)).any() || a.max(b).max(c).cmplt(DVec3::splat(-room)).any();
            if !by_plane && !by_box {
                return false;
            }
            let [x, y, z] = corners.map(|corner| corner.length());
            let cosine = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
            angle += 2.0 * math::atan2(a.dot(b.cross(c)), cosine);
        }
        let vertices: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| v.map(Real::to_f64)).collect();
        angle.abs() > 2.0 * PI && is_closed(&vertices, &mesh.faces)
    }
}

/// Whether a box is within another one.
fn is_within(inner: Bounds, outer: Bounds) -> bool {
    inner.min.cmpge(outer.min).all() && inner.max.cmple(outer.max).all()
}

/// The box around a box in the coordinates of a placed geometry.
fn placed<R: Real>(instance: &Instance<R>, outer: Bounds) -> Bounds {
    let vector = |v: [R; 3]| DVec3::from_array(v.map(Real::to_f64));
    let [x, y, z] = instance.to_local.columns.map(vector);
    let corners = (0..8).map(|corner| {
        let side = |bit: u32| corner >> bit & 1 == 0;
        let p = DVec3::select(glam::BVec3::new(side(0), side(1), side(2)), outer.min, outer.max);
        x * p.x + y * p.y + z * p.z + vector(instance.to_local.translation)
    });
    Bounds::around(corners)
}
