//! The bodies that send rays on, as the graph of [`depth`](super::depth) sees them: flat, convex or anything.

use crate::accel::Bounds;
use crate::scene::description::{Description, Material, Mesh, Object, Vec3};
use crate::scene::problem::push_token;
use crate::scene::transform::affine;
use glam::{DAffine3, DVec3};
use std::collections::HashMap;

/// Most bodies that are looked at.
pub(super) const MAX_BODIES: usize = 64;
/// Most corners of a mesh that is looked at for being flat.
const MAX_CORNERS: usize = 1_000;
/// Roundings that numbers may be off after their transforms.
const ROUNDINGS: f64 = 64.0;

/// A placed body that reflects or transmits.
#[derive(Debug, Clone)]
pub(super) struct Body {
    /// JSON pointer of its object.
    pub(super) pointer: String,
    pub(super) form: Form,
    /// Where it is.
    pub(super) place: Place,
    pub(super) reflects: bool,
    pub(super) transmits: bool,
    /// Whether rays meet its front or outside, and its back or inside.
    pub(super) sides: [bool; 2],
}

/// What a body's form says about rays that leave it.
#[derive(Debug, Clone, Copy)]
pub(super) enum Form {
    /// All of it lies in one plane.
    Flat(Flat),
    /// It is opaque and bounds a convex region: what leaves its outside never comes back by itself.
    Convex,
    /// Nothing is known.
    Any,
}

/// A plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flat {
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
    /// Largest rounding of a coordinate, relative to it.
    roundoff: f64,
}

/// Where a body is.
#[derive(Debug, Clone)]
pub(super) enum Place {
    /// In the convex hull of these points.
    Hull(Vec<DVec3>),
    /// All over a plane.
    Plane(Flat),
    /// Somewhere.
    Anywhere,
}

impl Flat {
    fn new(point: Vec3, normal: DVec3, map: &DAffine3, roundoff: f64) -> Self {
        // Normals go by the inverse transpose.
        let normal = map.matrix3.inverse().transpose() * normal.normalize();
        Self { point: map.transform_point3(DVec3::from_array(point)), normal, roundoff }
    }

    /// Whether some point may lie strictly in front (`back` false) or behind. Where the plane is parallel to two axes the
    /// sign of a height is exact; elsewhere heights that rounding may have made 0 count.
    fn may_hold(&self, p: DVec3, back: bool) -> bool {
        let height = self.normal.dot(p - self.point) * if back { -1.0 } else { 1.0 };
        let exact = self.normal.to_array().iter().filter(|n| **n != 0.0).count() == 1;
        let size = self.normal.abs().dot(p.abs() + self.point.abs());
        height > if exact { 0.0 } else { -ROUNDINGS * self.roundoff * size }
    }

    /// Whether some of what is at a place may lie on a side.
    pub(super) fn sees(&self, place: &Place, back: bool) -> bool {
        match place {
            Place::Hull(points) => points.iter().any(|p| self.may_hold(*p, back)),
            Place::Plane(other) if other.normal.cross(self.normal) == DVec3::ZERO => self.may_hold(other.point, back),
            Place::Plane(_) | Place::Anywhere => true,
        }
    }
}

impl Place {
    fn bounds(&self) -> Option<Bounds> {
        match self {
            Self::Hull(points) => {
                let bounds = Bounds::around(points.iter().copied());
                let size = bounds.min.abs().max(bounds.max.abs()).max_element();
                Some(bounds.grown(ROUNDINGS * f64::from(f32::EPSILON) * size))
            }
            Self::Plane(_) | Self::Anywhere => None,
        }
    }

    /// Whether two places may have points in common.
    pub(super) fn meets(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Plane(plane), Self::Hull(_)) => [false, true].iter().all(|back| plane.sees(other, *back)),
            (Self::Hull(_), Self::Plane(_)) => other.meets(self),
            _ => match (self.bounds(), other.bounds()) {
                (Some(a), Some(b)) => a.min.cmple(b.max).all() && b.min.cmple(a.max).all(),
                _ => true,
            },
        }
    }
}

/// The bodies that reflect or transmit, each as often as it is placed; `None` if there are more than [`MAX_BODIES`].
pub(super) fn specular_bodies(description: &Description, roundoff: f64) -> Option<Vec<Body>> {
    if !description.materials.iter().any(|(_, m)| reflects(m) || transmits(m)) {
        return Some(Vec::new());
    }
    let mut search = Search { description, roundoff, holding: HashMap::new(), found: Vec::new() };
    search.walk("/objects", &description.objects, DAffine3::IDENTITY)?;
    Some(search.found)
}

struct Search<'a> {
    description: &'a Description,
    roundoff: f64,
    /// Whether definitions hold any such body, so that their placements need not be followed if not.
    holding: HashMap<&'a str, bool>,
    found: Vec<Body>,
}

impl<'a> Search<'a> {
    fn walk(&mut self, list: &str, objects: &'a [Object], map: DAffine3) -> Option<()> {
        for (i, object) in objects.iter().enumerate() {
            if !self.holds(object) {
                continue;
            }
            let pointer = format!("{list}/{i}/{}", object.kind());
            match object {
                Object::Group(group) => {
                    let inner = map * affine(&group.transform).ok()?;
                    self.walk(&format!("{pointer}/objects"), &group.objects, inner)?;
                }
                Object::Instance(instance) => {
                    let inner = map * affine(&instance.transform).ok()?;
                    let objects = self.description.definitions.get(&instance.of)?;
                    self.walk(&push_token("/definitions", &instance.of), objects, inner)?;
                }
                _ if self.found.len() == MAX_BODIES => return None,
                _ => {
                    let material = self.material(object)?;
                    self.found.push(body(pointer, object, material, &map, self.roundoff));
                }
            }
        }
        Some(())
    }

    fn material(&self, object: &Object) -> Option<&'a Material> {
        self.description.materials.get(object.look()?.material?)
    }

    fn holds(&mut self, object: &'a Object) -> bool {
        match object {
            Object::Group(group) => group.objects.iter().any(|object| self.holds(object)),
            Object::Instance(instance) => {
                if let Some(known) = self.holding.get(instance.of.as_str()) {
                    return *known;
                }
                let objects = self.description.definitions.get(&instance.of);
                let holds = objects.is_some_and(|objects| objects.iter().any(|object| self.holds(object)));
                self.holding.insert(&instance.of, holds);
                holds
            }
            _ => self.material(object).is_some_and(|m| reflects(m) || transmits(m)),
        }
    }
}

fn reflects(material: &Material) -> bool {
    material.reflection.0.max_element() > 0.0
}

fn transmits(material: &Material) -> bool {
    material.transmission.0.max_element() > 0.0
}

fn body(pointer: String, object: &Object, material: &Material, map: &DAffine3, roundoff: f64) -> Body {
    let hollow = object.look().is_some_and(|look| look.hollow);
    let sides = if material.one_sided { [!hollow, hollow] } else { [true, true] };
    let (form, place) = form(object, map, roundoff);
    let form = match form {
        // Light inside a closed body may be reflected there again and again, and one-sided ones let it in or out.
        Form::Convex if transmits(material) || material.one_sided => Form::Any,
        Form::Flat(_) if transmits(material) && matches!(object, Object::Plane(_) | Object::Mesh(_)) => Form::Any,
        _ => form,
    };
    Body { pointer, form, place, reflects: reflects(material), transmits: transmits(material), sides }
}

fn form(object: &Object, map: &DAffine3, roundoff: f64) -> (Form, Place) {
    let vector = DVec3::from_array;
    let corners = |bounds: Bounds| Place::Hull(bounds.corners().map(|p| map.transform_point3(p)).to_vec());
    let hull = |points: &[Vec3]| Place::Hull(points.iter().map(|p| map.transform_point3(vector(*p))).collect());
    let ball = |center: Vec3, radius: f64| Bounds::around([vector(center)]).grown(radius);
    match object {
        Object::Sphere(o) => (Form::Convex, corners(ball(o.center, o.radius))),
        Object::Box(o) if (0..3).all(|i| o.min[i] < o.max[i]) => {
            (Form::Convex, corners(Bounds { min: vector(o.min), max: vector(o.max) }))
        }
        Object::Cylinder(o) if o.capped => (Form::Convex, corners(ball(o.base, o.radius).union(ball(o.top, o.radius)))),
        Object::Cone(o) if o.capped => {
            (Form::Convex, corners(ball(o.base, o.base_radius).union(ball(o.top, o.top_radius))))
        }
        Object::Plane(o) => {
            let flat = Flat::new(o.point, vector(o.normal), map, roundoff);
            (Form::Flat(flat), Place::Plane(flat))
        }
        Object::Disc(o) => {
            let normal = vector(o.normal).normalize();
            let reach = (DVec3::ONE - normal * normal).max(DVec3::ZERO).map(f64::sqrt) * o.radius;
            let bounds = Bounds { min: vector(o.center) - reach, max: vector(o.center) + reach };
            (Form::Flat(Flat::new(o.center, normal, map, roundoff)), corners(bounds))
        }
        Object::Triangle(o) => (flat(&o.vertices, map, roundoff), hull(&o.vertices)),
        Object::Quad(o) => (flat(&o.vertices, map, roundoff), hull(&o.vertices)),
        Object::Polygon(o) => (flat(&o.vertices, map, roundoff), hull(&o.vertices)),
        Object::Mesh(Mesh { vertices, normals: None, .. }) if vertices.len() <= MAX_CORNERS => {
            (flat(vertices, map, roundoff), hull(vertices))
        }
        _ => (Form::Any, Place::Anywhere),
    }
}

/// Flat if all points lie in one plane, as far as the format's numbers tell.
fn flat(points: &[Vec3], map: &DAffine3, roundoff: f64) -> Form {
    let vector = DVec3::from_array;
    let (Some(first), Some(second)) = (points.first(), points.get(1)) else { return Form::Any };
    let edge = vector(*second) - vector(*first);
    let normals = points[1..].iter().map(|p| edge.cross(vector(*p) - vector(*first)));
    let Some(normal) = normals.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())) else {
        return Form::Any;
    };
    if normal.try_normalize().is_none() {
        return Form::Any;
    }
    let plane = Flat::new(*first, normal, map, roundoff);
    let size = |p: DVec3| plane.normal.abs().dot(p.abs() + plane.point.abs());
    let near = |p: DVec3| plane.normal.dot(p - plane.point).abs() <= ROUNDINGS * roundoff * size(p);
    if points.iter().all(|p| near(map.transform_point3(vector(*p)))) { Form::Flat(plane) } else { Form::Any }
}
