//! Shafts: all ways from the points of a box to those of another, or in a range of directions (Haines and Wallace, Shaft Culling
//! for Efficient Ray-Traced Radiosity, 1991).
//!
//! The points that lie at a share t of these ways fill a box whose sides are linear in t. So what a shaft meets follows from
//! intervals of t, as for a ray.

use super::bounds::Bounds;
use super::extent::Extent;
use super::item::{Item, Mesh, Shape};
use crate::lanes::Real;
use crate::shape::Sides;
use glam::DVec3;

/// Faces of the largest mesh that is looked at for being flat.
const MOST_FACES: usize = 64;
/// Room for roundings, as a share of the numbers involved.
const SLACK: f64 = 256.0;

/// Ways from a box.
#[derive(Debug, Clone, Copy)]
pub struct Shaft {
    start: Bounds,
    /// How far each side has moved at t = 1.
    step: Bounds,
    most: f64,
}

impl Shaft {
    /// All ways from one box to another.
    pub fn between(start: Bounds, end: Bounds) -> Self {
        Self { start, step: Bounds { min: end.min - start.min, max: end.max - start.max }, most: 1.0 }
    }

    /// All ways from a box without end, in directions that lie in another box.
    pub fn towards(start: Bounds, directions: Bounds) -> Self {
        Self { start, step: directions, most: f64::INFINITY }
    }

    fn at(&self, t: f64) -> Bounds {
        Bounds { min: self.start.min + self.step.min * t, max: self.start.max + self.step.max * t }
    }

    /// The shares of the way at which its box fulfils a + b t <= 0 for some numbers, from the first to the last; none if the
    /// first is beyond the last.
    fn shares(&self, conditions: impl IntoIterator<Item = (f64, f64)>) -> [f64; 2] {
        conditions.into_iter().fold([0.0, self.most], |[first, last], (a, b)| match b {
            b if b > 0.0 => [first, last.min(-a / b)],
            b if b < 0.0 => [first.max(-a / b), last],
            _ if a > 0.0 => [f64::INFINITY, last],
            _ => [first, last],
        })
    }

    /// Whether some way may pass a box.
    fn meets_box(&self, other: Bounds) -> bool {
        let Self { start, step, .. } = self;
        let [first, last] = self.shares((0..3).flat_map(|axis| {
            let below = (start.min[axis] - other.max[axis], step.min[axis]);
            [below, (other.min[axis] - start.max[axis], -step.max[axis])]
        }));
        first <= last
    }

    /// Whether all ways pass through points inside of a box, and end outside of it.
    fn crosses_box(&self, other: Bounds) -> bool {
        let Self { start, step, .. } = self;
        let [first, last] = self.shares((0..3).flat_map(|axis| {
            let above = (other.min[axis] - start.min[axis], -step.min[axis]);
            [above, (start.max[axis] - other.max[axis], step.max[axis])]
        }));
        let end = self.at(1.0);
        let ends_outside = end.min.cmpgt(other.max).any() || end.max.cmplt(other.min).any();
        first <= last && (self.most.is_infinite() || ends_outside)
    }

    /// The share of the way at which its middle is nearest to a point.
    fn nearest(&self, point: DVec3) -> f64 {
        let way = self.step.center();
        ((point - self.start.center()).dot(way) / way.length_squared()).clamp(0.0, self.most)
    }

    /// Whether a plane is found between a ball and all ways: a sufficient condition.
    fn misses_ball(&self, center: DVec3, radius: f64) -> bool {
        let near = self.at(self.nearest(center));
        let away = center.clamp(near.min, near.max) - center;
        // The least n.p of a box.
        let least = |bounds: Bounds| {
            (0..3).map(|axis| (away[axis] * bounds.min[axis]).min(away[axis] * bounds.max[axis])).sum::<f64>()
        };
        let beyond = least(self.start) > away.dot(center) + radius * away.length();
        beyond
            && if self.most.is_infinite() {
                least(self.step) >= 0.0
            } else {
                least(self.at(1.0)) > away.dot(center) + radius * away.length()
            }
    }

    /// Whether all ways pass through points inside of a ball, and end outside of it.
    fn crosses_ball(&self, center: DVec3, radius: f64) -> bool {
        let furthest = |bounds: Bounds| (bounds.min - center).abs().max((bounds.max - center).abs()).length();
        let end = self.at(1.0);
        let ends_outside = end.min.max(center).min(end.max).distance(center) > radius;
        (self.most.is_infinite() || ends_outside) && furthest(self.at(self.nearest(center))) < radius
    }

    /// Whether all ways stay on one side of a plane.
    fn misses_plane(&self, point: DVec3, normal: DVec3, slack: f64) -> bool {
        let heights = |bounds: Bounds, from: DVec3| {
            let (middle, reach) = (normal.dot(bounds.center() - from), normal.abs().dot(bounds.max - bounds.min) * 0.5);
            [middle - reach, middle + reach]
        };
        let [low, high] = heights(self.start, point);
        let [low_end, high_end] = if self.most.is_infinite() {
            let [low_end, high_end] = heights(self.step, DVec3::ZERO);
            [if low_end >= 0.0 { low } else { -slack }, if high_end <= 0.0 { high } else { slack }]
        } else {
            heights(self.at(1.0), point)
        };
        low.min(low_end) > slack || high.max(high_end) < -slack
    }
}

/// What a shaft may meet: an item of a geometry.
#[derive(Debug, Clone)]
pub struct Obstacle {
    place: Place,
    /// Whether it may hide light from itself where its surface faces that.
    folds: bool,
    /// Whether no light passes it.
    blocks: bool,
    slack: f64,
}

#[derive(Debug, Clone)]
enum Place {
    Ball {
        bounds: Bounds,
        center: DVec3,
        radius: f64,
    },
    Block(Bounds),
    /// Something in a box.
    In(Bounds),
    Plane {
        point: DVec3,
        normal: DVec3,
    },
}

/// What a shaft meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Met {
    /// At most one item, which hides nothing from its own outside.
    Open,
    /// A body that blocks all ways.
    Blocked,
    /// Something.
    Mixed,
}

impl Obstacle {
    /// An item, none if it is of several ones without bounds. `is_opaque` if its material lets no light through.
    pub fn new<R: Real>(item: &Item<R>, extent: &Option<Extent>, is_opaque: bool) -> Option<Self> {
        let vector = |v: [R; 3]| DVec3::from_array(v.map(Real::to_f64));
        let bounds = match &item.shape {
            Shape::Mesh(mesh) => Bounds::around(mesh.vertices.iter().map(|vertex| vector(*vertex))),
            Shape::Plane(plane) => Bounds::around([vector(plane.point)]),
            _ => (*extent)?.bounds,
        };
        let size = bounds.min.abs().max(bounds.max.abs()).max_element();
        let place = match &item.shape {
            Shape::Sphere(sphere) => {
                Place::Ball { bounds, center: vector(sphere.center), radius: sphere.radius.to_f64() }
            }
            Shape::Cuboid(_) if item.closed => Place::Block(bounds),
            Shape::Plane(plane) => Place::Plane { point: vector(plane.point), normal: vector(plane.normal) },
            _ => Place::In(bounds),
        };
        let folds = match &item.shape {
            Shape::Plane(_) | Shape::Disc(_) => false,
            // Of sheets the inside is seen, too.
            Shape::Sphere(_) | Shape::Cuboid(_) | Shape::Frustum(_) => !item.closed,
            Shape::Mesh(mesh) => !is_flat(mesh),
            Shape::Torus(_) | Shape::Instance(_) => true,
        };
        let blocks = is_opaque && item.sides == Sides::Both;
        Some(Self { place, folds, blocks, slack: SLACK * R::ROUNDOFF * size })
    }

    /// The box around it, if it has bounds.
    pub fn bounds(&self) -> Option<Bounds> {
        match self.place {
            Place::Ball { bounds, .. } | Place::Block(bounds) | Place::In(bounds) => Some(bounds),
            Place::Plane { .. } => None,
        }
    }

    fn is_met(&self, shaft: &Shaft) -> bool {
        match self.place {
            Place::Plane { point, normal } => !shaft.misses_plane(point, normal, self.slack),
            Place::Ball { bounds, center, radius } => {
                shaft.meets_box(bounds.grown(self.slack)) && !shaft.misses_ball(center, radius + self.slack)
            }
            Place::Block(bounds) | Place::In(bounds) => shaft.meets_box(bounds.grown(self.slack)),
        }
    }

    fn blocks(&self, shaft: &Shaft) -> bool {
        self.blocks
            && match self.place {
                Place::Ball { center, radius, .. } => shaft.crosses_ball(center, radius - self.slack),
                Place::Block(bounds) => shaft.crosses_box(bounds.grown(-self.slack)),
                Place::In(_) | Place::Plane { .. } => false,
            }
    }

    /// What a shaft meets of some items.
    pub fn met(all: &[Self], shaft: &Shaft) -> Met {
        let mut met = all.iter().filter(|obstacle| obstacle.is_met(shaft));
        let (first, second) = (met.next(), met.next());
        match (first, second) {
            (first, None) if first.is_none_or(|first| !first.folds) => Met::Open,
            _ if first.into_iter().chain(second).chain(met).any(|obstacle| obstacle.blocks(shaft)) => Met::Blocked,
            _ => Met::Mixed,
        }
    }
}

/// Whether a mesh is small and lies in one plane, to the last bit.
fn is_flat<R: Real>(mesh: &Mesh<R>) -> bool {
    if mesh.faces.len() > MOST_FACES || !mesh.normals.is_empty() {
        return false;
    }
    // A triangle that is but a line, also one with three corners, lies in many planes.
    let plane = |face: usize| {
        let [a, b, c] = mesh.points(face);
        (a, (b - a).cross(c - a))
    };
    let Some((a, normal)) = (0..mesh.faces.len()).map(plane).find(|(_, normal)| *normal != DVec3::ZERO) else {
        return false;
    };
    mesh.vertices.iter().all(|p| normal.dot(DVec3::from_array(p.map(Real::to_f64)) - a) == 0.0)
}
