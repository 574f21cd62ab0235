//! Bodies, surroundings and lights that no ray of a picture can reach: an opaque ball, box or half-space is between them and the
//! eye.
//!
//! It is proved for bodies as they are written, with room for every rounding. Rays asked for by themselves may start anywhere, so
//! hidden bodies stay in the scene; only effects do not count them.

use super::camera::eye_radius;
use super::contact;
use super::enclosure::Enclosures;
use crate::accel::{Bounds, Extent, Geometry, Item, Shape};
use crate::lanes::Real;
use crate::scene::description::Description;
use crate::scene::usage::Used;
use crate::shading::light::{Light, Source};
use crate::shading::material::Material;
use crate::shape::Sides;
use glam::DVec3;

/// Distances above this share of all lengths involved are beyond all roundings.
pub(super) const ROUNDING_MARGIN: f64 = 1.0 / 1024.0;
/// Most bodies that are asked what is inside of them or behind.
const MOST_WALLS: usize = 16;

/// What cannot be seen.
#[derive(Debug, Default)]
pub(super) struct Occluded {
    /// Indices of items of the scene itself, in order.
    items: Vec<usize>,
    /// Indices of those that the eye may be inside of, in order.
    around_eye: Vec<usize>,
    /// Bodies that no ray passes, and whether the eye is inside of them or behind.
    walls: Vec<(Wall, bool)>,
    /// Whether the eye is in a closed room.
    pub(super) eye_is_enclosed: bool,
}

/// What is hidden in a scene of these items.
pub(super) fn occluded<R: Real>(
    description: &Description,
    materials: &[Material<R>],
    geometries: &[Geometry<R>],
    items: &[Item<R>],
    extents: &[Option<Extent>],
) -> Occluded {
    let around = eye_radius(description);
    let eye = DVec3::from_array(description.camera.view().eye);
    let around_eye = Bounds { min: eye - around, max: eye + around };
    let walls = || items.iter().filter(|item| is_opaque(materials, item)).filter_map(Wall::of);
    let around = walls().filter(|wall| wall.contains(around_eye)).map(|wall| (wall, true));
    let beside = walls().filter(|wall| wall.excludes(around_eye)).map(|wall| (wall, false));
    let walls: Vec<(Wall, bool)> = around.take(MOST_WALLS).chain(beside.take(MOST_WALLS)).collect();
    let hides = |bounds| walls.iter().any(|(wall, has_eye)| wall.divides(bounds, *has_eye));
    let boxes: Vec<Option<Bounds>> =
        items.iter().zip(extents).map(|(item, extent)| contact::bounds(item, extent)).collect();
    let beside_eye = |(item, bounds): (&Item<R>, Option<Bounds>)| match Wall::of(item) {
        Some(wall) => wall.excludes(around_eye),
        None => bounds.is_some_and(|bounds| Wall::Block(bounds).excludes(around_eye)),
    };
    let numbered = || items.iter().zip(boxes.iter().copied()).enumerate();
    Occluded {
        items: numbered().filter(|(_, (_, bounds))| bounds.is_some_and(hides)).map(|(index, _)| index).collect(),
        around_eye: numbered().filter(|(_, each)| !beside_eye(*each)).map(|(index, _)| index).collect(),
        walls,
        eye_is_enclosed: Enclosures::new(geometries, materials).around(items, around_eye),
    }
}

impl Occluded {
    /// Whether no shadow ray from what is seen gets to a light: it would have to pass one of the walls.
    pub(super) fn hides_light<R: Real>(&self, light: &Light<R>) -> bool {
        let vector = |v: [R; 3]| DVec3::from_array(v.map(Real::to_f64));
        let reach = light.area.map_or(0.0, |area| area.reach());
        match light.source {
            Source::Point { position } | Source::Spot { position, .. } => {
                let around = Bounds::around([vector(position)]).grown(reach);
                self.walls.iter().any(|(wall, has_eye)| wall.divides(around, *has_eye))
            }
            Source::Directional { to_light } => {
                self.walls.iter().any(|(wall, has_eye)| wall.hides_sky(vector(to_light), reach, *has_eye))
            }
        }
    }

    /// How materials are used, and whether anything moves, but for what is hidden; `None` if nothing is, nor around the eye.
    pub(super) fn usage<R: Real>(&self, geometries: &[Geometry<R>], materials: usize) -> Option<(Vec<Used>, bool)> {
        if self.items.is_empty() && self.around_eye.is_empty() {
            return None;
        }
        let (mut used, mut moves) = (vec![Used::default(); materials], false);
        let mut seen = vec![0; geometries.len()];
        let mut left = vec![(geometries.len() - 1, false)];
        while let Some((geometry, around_eye)) = left.pop() {
            let is_scene = geometry == geometries.len() - 1;
            for (index, item) in geometries[geometry].items.iter().enumerate() {
                if is_scene && self.items.binary_search(&index).is_ok() {
                    continue;
                }
                let around_eye = around_eye || is_scene && self.around_eye.binary_search(&index).is_ok();
                match &item.shape {
                    Shape::Instance(instance) => {
                        moves |= instance.motion.is_some();
                        // Once more where the eye may be inside, which no placement before has said.
                        let seen = &mut seen[instance.geometry as usize];
                        if *seen < 1 + u8::from(around_eye) {
                            *seen = 1 + u8::from(around_eye);
                            left.push((instance.geometry as usize, around_eye));
                        }
                    }
                    _ => {
                        let of = &mut used[item.material as usize];
                        of.anywhere = true;
                        of.filled |= item.closed && !item.hollow;
                        of.around_eye |= around_eye && item.closed && !item.hollow;
                    }
                }
            }
        }
        Some((used, moves))
    }
}

/// Whether no ray passes an item.
pub(super) fn is_opaque<R: Real>(materials: &[Material<R>], item: &Item<R>) -> bool {
    !materials[item.material as usize].transmits() && !item.has_holes && item.sides == Sides::Both
}

/// A body that no ray passes.
#[derive(Debug)]
pub(super) enum Wall {
    Ball { center: DVec3, radius: f64 },
    Block(Bounds),
    HalfSpace { point: DVec3, normal: DVec3 },
}

impl Wall {
    pub(super) fn of<R: Real>(item: &Item<R>) -> Option<Self> {
        let vector = |v: [R; 3]| DVec3::from_array(v.map(Real::to_f64));
        match &item.shape {
            Shape::Sphere(sphere) => Some(Self::Ball { center: vector(sphere.center), radius: sphere.radius.to_f64() }),
            Shape::Cuboid(cuboid) if item.closed => {
                Some(Self::Block(Bounds { min: vector(cuboid.min), max: vector(cuboid.max) }))
            }
            Shape::Plane(plane) => {
                Some(Self::HalfSpace { point: vector(plane.point), normal: vector(plane.normal).normalize() })
            }
            _ => None,
        }
    }

    /// Whether nothing beyond it can be seen from inside.
    pub(super) fn closes(&self) -> bool {
        !matches!(self, Self::HalfSpace { .. })
    }

    /// Whether it is between an eye and all of a box, given on which side the eye is.
    fn divides(&self, bounds: Bounds, has_eye: bool) -> bool {
        if has_eye { self.excludes(bounds) } else { self.contains(bounds) }
    }

    /// Whether it is between an eye and a light in the sky, which is as wide as a disc of the radius `reach` at the distance 1.
    fn hides_sky(&self, to_light: DVec3, reach: f64, has_eye: bool) -> bool {
        match self {
            Self::HalfSpace { normal, .. } => {
                let outward = if has_eye { normal.dot(to_light) } else { -normal.dot(to_light) };
                outward > reach + ROUNDING_MARGIN
            }
            Self::Ball { .. } | Self::Block(_) => has_eye,
        }
    }

    /// Whether all of a box is clearly inside, or behind.
    pub(super) fn contains(&self, inner: Bounds) -> bool {
        match self {
            Self::Ball { center, radius } => {
                // Most bodies are beside it already along x.
                (inner.min.x - center.x).abs() < *radius && {
                    let furthest = (inner.min - *center).abs().max((inner.max - *center).abs());
                    furthest.length() + slack(center.abs().max_element() + radius, inner) < *radius
                }
            }
            Self::Block(block) => {
                let slack = slack(block.min.abs().max(block.max.abs()).max_element(), inner);
                (inner.min - slack).cmpgt(block.min).all() && (inner.max + slack).cmplt(block.max).all()
            }
            Self::HalfSpace { .. } => self.height(inner) < 0.0,
        }
    }

    /// Whether all of a box is clearly outside, or in front.
    fn excludes(&self, outer: Bounds) -> bool {
        match self {
            Self::Ball { center, radius } => {
                let nearest = (outer.min - *center).max(*center - outer.max).max(DVec3::ZERO);
                nearest.length() > *radius + slack(center.abs().max_element() + radius, outer)
            }
            Self::Block(block) => {
                let slack = slack(block.min.abs().max(block.max.abs()).max_element(), outer);
                (outer.min - slack).cmpgt(block.max).any() || (outer.max + slack).cmplt(block.min).any()
            }
            Self::HalfSpace { .. } => self.height(outer) > 0.0,
        }
    }

    /// Distance of a box in front of a plane, negative behind it, and 0 where that is not clear.
    fn height(&self, bounds: Bounds) -> f64 {
        let Self::HalfSpace { point, normal } = *self else { return 0.0 };
        let (middle, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
        let (height, reach) =
            (normal.dot(middle - point), normal.abs().dot(half) + slack(point.abs().max_element(), bounds));
        if height.abs() > reach { height } else { 0.0 }
    }
}

/// Room for roundings.
pub(super) fn slack(size: f64, bounds: Bounds) -> f64 {
    ROUNDING_MARGIN * (size + bounds.min.abs().max(bounds.max.abs()).max_element())
}
