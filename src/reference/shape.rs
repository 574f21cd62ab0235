//! All shapes behind one enum, made from the description.

use super::flat::{AxisBox, Disc, Plane, Polygon};
use super::mesh::Mesh;
use super::ray::{Ball, Crossing, Ray};
use super::round::{Frustum, Sphere};
use super::torus::Torus;
use crate::scene::description::{Look, Object, Vec3};
use glam::DVec3;
use std::f64::consts::PI;

/// A shape in its own coordinates.
#[derive(Debug)]
pub(super) enum Shape {
    Sphere(Sphere),
    Plane(Plane),
    Disc(Disc),
    AxisBox(AxisBox),
    Frustum(Frustum),
    Torus(Torus),
    Polygon(Polygon),
    /// Also a triangle and a quad.
    Mesh {
        mesh: Mesh,
        encloses: bool,
    },
}

impl Shape {
    /// The shape and look of an object; none if it is a group or an instance.
    pub(super) fn new(object: &Object) -> Option<(Self, Look<'_>)> {
        let plane = |point: Vec3, normal: Vec3| Plane { point: point.into(), normal: DVec3::from(normal).normalize() };
        Some(match object {
            Object::Sphere(s) => (Self::Sphere(Sphere { center: s.center.into(), radius: s.radius }), s.look()),
            Object::Plane(p) => (Self::Plane(plane(p.point, p.normal)), p.look()),
            Object::Disc(d) => (Self::Disc(Disc { plane: plane(d.center, d.normal), radius: d.radius }), d.look()),
            Object::Triangle(t) => (Self::open_mesh(&t.vertices, vec![[0, 1, 2]]), t.look()),
            Object::Quad(q) => (Self::open_mesh(&q.vertices, vec![[0, 1, 2], [0, 2, 3]]), q.look()),
            Object::Box(b) => (Self::AxisBox(AxisBox { min: b.min.into(), max: b.max.into() }), b.look()),
            Object::Cylinder(c) => {
                let frustum = Frustum::new(c.base.into(), c.radius, c.top.into(), c.radius, c.capped);
                (Self::Frustum(frustum), c.look())
            }
            Object::Cone(c) => {
                let frustum = Frustum::new(c.base.into(), c.base_radius, c.top.into(), c.top_radius, c.capped);
                (Self::Frustum(frustum), c.look())
            }
            Object::Torus(t) => {
                let axis = DVec3::from(t.axis).normalize();
                let torus = Torus { center: t.center.into(), axis, major: t.major_radius, minor: t.minor_radius };
                (Self::Torus(torus), t.look())
            }
            Object::Mesh(m) => {
                let faces = m.faces.iter().map(|face| face.map(|i| i as usize)).collect();
                let mesh = Mesh::new(points(&m.vertices), faces, m.normals.as_deref().map(points));
                (Self::Mesh { mesh, encloses: true }, m.look())
            }
            Object::Polygon(p) => (Self::Polygon(Polygon::new(points(&p.vertices))), p.look()),
            Object::Group(_) | Object::Instance(_) => return None,
        })
    }

    fn open_mesh(vertices: &[Vec3], faces: Vec<[usize; 3]>) -> Self {
        Self::Mesh { mesh: Mesh::new(points(vertices), faces, None), encloses: false }
    }

    /// Every crossing of the whole line, in no order.
    pub(super) fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        match self {
            Self::Sphere(sphere) => sphere.crossings(ray),
            Self::Plane(plane) => plane.crossings(ray),
            Self::Disc(disc) => disc.crossings(ray),
            Self::AxisBox(axis_box) => axis_box.crossings(ray),
            Self::Frustum(frustum) => frustum.crossings(ray),
            Self::Torus(torus) => torus.crossings(ray),
            Self::Polygon(polygon) => polygon.crossings(ray),
            Self::Mesh { mesh, .. } => mesh.crossings(ray),
        }
    }

    /// Whether it encloses something, so that light passing its surface changes medium.
    pub(super) fn is_body(&self) -> bool {
        match self {
            Self::Sphere(_) | Self::Plane(_) | Self::Torus(_) => true,
            Self::AxisBox(axis_box) => !axis_box.is_flat(),
            Self::Frustum(frustum) => frustum.is_capped(),
            Self::Mesh { encloses, .. } => *encloses,
            Self::Disc(_) | Self::Polygon(_) => false,
        }
    }

    /// What a body encloses; infinite for a half-space.
    pub(super) fn volume(&self) -> f64 {
        match self {
            Self::Sphere(sphere) => 4.0 / 3.0 * PI * sphere.radius.powi(3),
            Self::AxisBox(axis_box) => (axis_box.max - axis_box.min).element_product(),
            Self::Frustum(frustum) => frustum.volume(),
            Self::Torus(torus) => 2.0 * PI * PI * torus.major * torus.minor.powi(2),
            Self::Mesh { mesh, .. } => mesh.volume(),
            Self::Plane(_) | Self::Disc(_) | Self::Polygon(_) => f64::INFINITY,
        }
    }

    /// Whether a point lies inside a body; false for what is none.
    pub(super) fn contains(&self, point: DVec3) -> bool {
        self.is_body()
            && match self {
                Self::Sphere(sphere) => sphere.contains(point),
                Self::Plane(plane) => plane.contains(point),
                Self::AxisBox(axis_box) => axis_box.contains(point),
                Self::Frustum(frustum) => frustum.contains(point),
                Self::Torus(torus) => torus.contains(point),
                Self::Mesh { mesh, .. } => mesh.contains(point),
                Self::Disc(_) | Self::Polygon(_) => false,
            }
    }

    /// A ball around the shape; none around a plane.
    pub(super) fn ball(&self) -> Option<Ball> {
        Some(match self {
            Self::Sphere(sphere) => sphere.ball(),
            Self::Plane(_) => return None,
            Self::Disc(disc) => disc.ball(),
            Self::AxisBox(axis_box) => axis_box.ball(),
            Self::Frustum(frustum) => frustum.ball(),
            Self::Torus(torus) => torus.ball(),
            Self::Polygon(polygon) => polygon.ball(),
            Self::Mesh { mesh, .. } => mesh.ball(),
        })
    }
}

fn points(list: &[Vec3]) -> Vec<DVec3> {
    list.iter().copied().map(DVec3::from).collect()
}
