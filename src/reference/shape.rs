//! All shapes behind one trait, made from the description.

use super::flat::{AxisBox, Disc, Plane, Polygon};
use super::mesh::Mesh;
use super::ray::{Ball, Crossing, Ray};
use super::round::{Frustum, Sphere};
use super::torus::Torus;
use crate::scene::description::{Appearance, Object, Vec3};
use glam::DVec3;
use std::fmt::Debug;

/// A shape in its own coordinates.
pub(super) trait Shape: Debug + Send + Sync {
    /// Every crossing of the whole line, in no order.
    fn crossings(&self, ray: &Ray) -> Vec<Crossing>;

    /// A ball around the shape; none around a plane.
    fn ball(&self) -> Option<Ball>;

    /// What it encloses, infinite for a half-space; none if light that passes its surface does not change medium.
    fn volume(&self) -> Option<f64> {
        None
    }

    /// Whether a point lies inside.
    fn contains(&self, _: DVec3) -> bool {
        false
    }
}

/// The shape and appearance of an object; none if it is a group or an instance.
pub(super) fn shape_of(object: &Object) -> Option<(Box<dyn Shape>, Appearance<'_>)> {
    let plane = |point: Vec3, normal: Vec3| Plane { point: point.into(), normal: DVec3::from(normal).normalize() };
    let shape: (Box<dyn Shape>, Appearance<'_>) = match object {
        Object::Sphere(s) => (Box::new(Sphere { center: s.center.into(), radius: s.radius }), s.appearance()),
        Object::Plane(p) => (Box::new(plane(p.point, p.normal)), p.appearance()),
        Object::Disc(d) => (Box::new(Disc { plane: plane(d.center, d.normal), radius: d.radius }), d.appearance()),
        Object::Triangle(t) => (open_mesh(&t.vertices, vec![[0, 1, 2]]), t.appearance()),
        Object::Quad(q) => (open_mesh(&q.vertices, vec![[0, 1, 2], [0, 2, 3]]), q.appearance()),
        Object::Box(b) => (Box::new(AxisBox { min: b.min.into(), max: b.max.into() }), b.appearance()),
        Object::Cylinder(c) => {
            let frustum = Frustum::new(c.base.into(), c.radius, c.top.into(), c.radius, c.capped);
            (Box::new(frustum), c.appearance())
        }
        Object::Cone(c) => {
            let frustum = Frustum::new(c.base.into(), c.base_radius, c.top.into(), c.top_radius, c.capped);
            (Box::new(frustum), c.appearance())
        }
        Object::Torus(t) => {
            let axis = DVec3::from(t.axis).normalize();
            let torus = Torus { center: t.center.into(), axis, major: t.major_radius, minor: t.minor_radius };
            (Box::new(torus), t.appearance())
        }
        Object::Mesh(m) => {
            let faces = m.faces.iter().map(|face| face.map(|i| i as usize)).collect();
            let mesh = Mesh::closed(points(&m.vertices), faces, m.normals.as_deref().map(points));
            (Box::new(mesh), m.appearance())
        }
        Object::Polygon(p) => (Box::new(Polygon::new(points(&p.vertices))), p.appearance()),
        Object::Group(_) | Object::Instance(_) | Object::Model(_) => return None,
    };
    Some(shape)
}

fn open_mesh(vertices: &[Vec3], faces: Vec<[usize; 3]>) -> Box<dyn Shape> {
    Box::new(Mesh::open(points(vertices), faces))
}

fn points(list: &[Vec3]) -> Vec<DVec3> {
    list.iter().copied().map(DVec3::from).collect()
}
