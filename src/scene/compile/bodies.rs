//! The shapes of bodies in the kernel's format.

use crate::accel::{Attributes, Mesh, Shape};
use crate::lanes::Real;
use crate::scene::description::{self as d, Appearance, Object, Vec3};
use crate::shape::ear_clipping::triangulate;
use crate::shape::{Cuboid, Disc, Frame, Frustum, Plane, Sphere, Torus};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::{Arc, LazyLock};

/// The faces of all triangles and of all quads: one list for each, however many there are.
static TRIANGLE: LazyLock<Arc<Vec<[u32; 3]>>> = LazyLock::new(|| vec![[0, 1, 2]].into());
static QUAD: LazyLock<Arc<Vec<[u32; 3]>>> = LazyLock::new(|| vec![[0, 1, 2], [0, 2, 3]].into());

/// The volume of a closed body.
pub(super) fn volume(object: &Object) -> f64 {
    let distance = |a: Vec3, b: Vec3| DVec3::from_array(a).distance(DVec3::from_array(b));
    match object {
        Object::Sphere(o) => 4.0 / 3.0 * PI * o.radius.powi(3),
        Object::Box(o) => (DVec3::from_array(o.max) - DVec3::from_array(o.min)).element_product(),
        Object::Cylinder(o) => PI * o.radius * o.radius * distance(o.base, o.top),
        Object::Cone(o) => {
            let (r, q) = (o.base_radius, o.top_radius);
            PI / 3.0 * distance(o.base, o.top) * (r * r + r * q + q * q)
        }
        Object::Torus(o) => 2.0 * PI * PI * o.major_radius * o.minor_radius * o.minor_radius,
        Object::Mesh(o) => {
            // Sum of the signed volumes of the tetrahedra below the faces, seen from a point near the mesh.
            let corner = |i: u32| DVec3::from_array(o.vertices[i as usize]);
            let apex = corner(o.faces[0][0]);
            let six = |f: &[u32; 3]| (corner(f[0]) - apex).dot((corner(f[1]) - apex).cross(corner(f[2]) - apex));
            o.faces.iter().map(six).sum::<f64>().abs() / 6.0
        }
        _ => f64::INFINITY,
    }
}

/// What a mesh keeps of its vertices beside places and normals, since its material looks at it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Kept {
    uvs: bool,
    uvs1: bool,
    colors: bool,
    tangents: bool,
}

impl Kept {
    /// What an object's material needs.
    pub(super) fn of(object: &Object, material: Option<&d::Material>) -> Self {
        let (Object::Mesh(mesh), Some(material)) = (object, material) else { return Self::default() };
        let [uvs, uvs1] = material.uv_sets();
        let takes_tangents =
            |pbr: &d::Pbr| pbr.normals().into_iter().any(|(_, map)| map.is_some_and(|map| pbr.takes_tangents(map)));
        let tangents = mesh.tangents.is_some() && material.pbr.as_deref().is_some_and(takes_tangents);
        Self { uvs, uvs1, colors: mesh.colors.is_some() && material.pbr.is_some(), tangents }
    }

    /// What a mesh has kept.
    pub(super) fn by<R>(mesh: &Mesh<R>) -> Self {
        let more = mesh.attributes.as_ref();
        Self {
            uvs: !mesh.uvs.is_empty(),
            uvs1: more.is_some_and(|more| !more.uvs.is_empty()),
            colors: more.is_some_and(|more| !more.colors.is_empty()),
            tangents: more.is_some_and(|more| !more.tangents.is_empty()),
        }
    }
}

pub(super) fn shape<R: Real>(object: &Object, kept: Kept) -> (Shape<R>, Appearance<'_>) {
    let number = R::from_f64;
    let point = |p: Vec3| p.map(R::from_f64);
    let vector = DVec3::from_array;
    let plane =
        |at: Vec3, normal: Vec3| Plane { point: point(at), normal: point(vector(normal).normalize().to_array()) };
    match object {
        Object::Sphere(o) => {
            (Shape::Sphere(Sphere { center: point(o.center), radius: number(o.radius) }), o.appearance())
        }
        Object::Plane(o) => (Shape::Plane(plane(o.point, o.normal)), o.appearance()),
        Object::Disc(o) => {
            (Shape::Disc(Disc { plane: plane(o.center, o.normal), radius: number(o.radius) }), o.appearance())
        }
        Object::Triangle(o) => {
            (Shape::Mesh(mesh(&o.vertices, Arc::clone(&TRIANGLE), None, None).into()), o.appearance())
        }
        Object::Quad(o) => (Shape::Mesh(mesh(&o.vertices, Arc::clone(&QUAD), None, None).into()), o.appearance()),
        Object::Box(o) => (Shape::Cuboid(Cuboid { min: point(o.min), max: point(o.max) }), o.appearance()),
        Object::Cylinder(o) => {
            (Shape::Frustum(frustum(vector(o.base), vector(o.top), o.radius, o.radius, o.capped)), o.appearance())
        }
        Object::Cone(o) => (
            Shape::Frustum(frustum(vector(o.base), vector(o.top), o.base_radius, o.top_radius, o.capped)),
            o.appearance(),
        ),
        Object::Torus(o) => {
            let torus = Torus {
                frame: Frame::new(vector(o.center), vector(o.axis).normalize()),
                major_radius: number(o.major_radius),
                minor_radius: number(o.minor_radius),
            };
            (Shape::Torus(Box::new(torus)), o.appearance())
        }
        Object::Mesh(o) => {
            let mut mesh =
                mesh(&o.vertices, Arc::clone(&o.faces), o.normals.as_deref(), o.uvs.as_deref().filter(|_| kept.uvs));
            if kept.uvs1 || kept.colors || kept.tangents {
                let uvs = o.uvs1.iter().filter(|_| kept.uvs1).flatten().map(|uv| uv.map(R::from_f64)).collect();
                let colors = o.colors.iter().filter(|_| kept.colors).flatten().map(|c| c.map(R::from_f64)).collect();
                let tangents = o.tangents.iter().filter(|_| kept.tangents).flatten();
                let tangents = tangents.map(|tangent| tangent.map(R::from_f64)).collect();
                mesh.attributes = Some(Box::new(Attributes { uvs, colors, tangents }));
            }
            (Shape::Mesh(mesh.into()), o.appearance())
        }
        Object::Polygon(o) => {
            let faces = triangulate(&o.vertices).unwrap_or_default();
            (Shape::Mesh(mesh(&o.vertices, faces.into(), None, None).into()), o.appearance())
        }
        Object::Group(_) | Object::Instance(_) | Object::Model(_) => {
            unreachable!("groups, instances and models are no shapes")
        }
    }
}

fn frustum<R: Real>(base: DVec3, top: DVec3, base_radius: f64, top_radius: f64, capped: bool) -> Box<Frustum<R>> {
    let height = base.distance(top);
    Box::new(Frustum {
        frame: Frame::new(base, (top - base) / height),
        height: R::from_f64(height),
        base_radius: R::from_f64(base_radius),
        top_radius: R::from_f64(top_radius),
        slope: R::from_f64((top_radius - base_radius) / height),
        capped,
    })
}

/// A mesh, which shares the list of faces of the description. Hierarchies leave out what rounding has collapsed to lines.
fn mesh<R: Real>(
    vertices: &[Vec3],
    faces: Arc<Vec<[u32; 3]>>,
    normals: Option<&[Vec3]>,
    uvs: Option<&[[f64; 2]]>,
) -> Mesh<R> {
    let vertices = vertices.iter().map(|v| v.map(R::from_f64)).collect();
    let unit = |n: &Vec3| DVec3::from_array(*n).normalize_or_zero().to_array().map(R::from_f64);
    let uvs = uvs.unwrap_or_default().iter().map(|uv| uv.map(R::from_f64)).collect();
    let normals = normals.unwrap_or_default().iter().map(unit).collect();
    Mesh { faces, normals, vertices, uvs, attributes: None }
}
