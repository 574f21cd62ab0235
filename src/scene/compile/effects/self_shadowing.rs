//! Whether anything can come between a surface and a light: where nothing can, no shadow rays are needed.
//!
//! It is proved for scenes of a single body, of geometry as it is and with room for every rounding:
//! - What is flat never hides a light from itself. A side is only lit if the light lies in front of it, and then all of the
//!   way to the light lies in front of it.
//! - Nor does an opaque convex body that the eye is outside of. No ray gets inside, and where its outside is lit the light lies
//!   in front of the tangent plane, with the body behind.

use crate::accel::{Item, Shape};
use crate::lanes::Real;
use crate::scene::compile::camera::eye_radius;
use crate::scene::compile::occluded::ROUNDING_MARGIN;
use crate::scene::description::{Description, Shadows};
use crate::scene::world::World;
use crate::scene::world::shows;
use crate::shading::light::{Light, Source};
use crate::shape::Sides;
use glam::DVec3;

/// The only body of a world, and why it hides no light from itself, if that is so.
pub(in crate::scene::compile) fn casts_no_shadow<'w, R: Real>(
    description: &Description,
    world: &'w World<R>,
) -> Option<(&'w Item<R>, &'static str)> {
    // By the counting rules of the SPD shadow rays are traced, needed or not.
    if world.rules.spd_counts {
        return None;
    }
    let [item] = &world.geometries[world.root].items[..] else { return None };
    let material = &world.materials[item.material as usize];
    // The way to the light may lead through what absorbs it.
    if description.render.shadows == Shadows::Transmissive && item.closed && shows(material.absorption) {
        return None;
    }
    let vector = |v: [R; 3]| DVec3::from_array(v.map(Real::to_f64));
    let eye = DVec3::from_array(description.camera.view().eye);
    let lit_clearly = |off: &dyn Fn(DVec3) -> f64, size: f64| {
        world.lights.iter().filter(|light| shows(light.color)).all(|light| match middle(light) {
            // Of parallel light the same product says which side is lit and where its rays go.
            None => true,
            Some(middle) => {
                off(middle)
                    > light.area.map_or(0.0, |area| area.reach())
                        + ROUNDING_MARGIN * (size + middle.abs().max_element())
            }
        })
    };
    let outside = |off: f64, size: f64| {
        let opaque = !item.lets_light_through() && !item.has_holes && item.sides != Sides::Inside;
        opaque && off > eye_radius(description) + ROUNDING_MARGIN * (size + eye.abs().max_element())
    };
    match &item.shape {
        Shape::Plane(plane) => {
            // Far away only the heights above planes parallel to two axes are exact.
            let upright = plane.normal.iter().filter(|n| **n != R::from_f64(0.0)).count() == 1;
            let parallel = world.lights.iter().all(|light| middle(light).is_none());
            (upright || parallel).then_some((item, FLAT))
        }
        Shape::Disc(disc) => {
            let (point, normal) = (vector(disc.plane.point), vector(disc.plane.normal));
            let off = |p: DVec3| normal.dot(p - point).abs();
            lit_clearly(&off, point.abs().max_element() + disc.radius.to_f64()).then_some((item, FLAT))
        }
        Shape::Sphere(sphere) => {
            let (center, radius) = (vector(sphere.center), sphere.radius.to_f64());
            let (off, size) = (|p: DVec3| p.distance(center) - radius, center.abs().max_element() + radius);
            (outside(off(eye), size) && lit_clearly(&|p| off(p).abs(), size)).then_some((item, CONVEX))
        }
        Shape::Cuboid(cuboid) if item.closed => {
            let (min, max) = (vector(cuboid.min), vector(cuboid.max));
            let size = min.abs().max(max.abs()).max_element();
            // Of all planes of the sides, so that no light grazes any of them.
            let off = |p: DVec3| (p - min).abs().min((p - max).abs()).min_element();
            let from_outside = (min - eye).max(eye - max).max_element();
            (outside(from_outside, size) && lit_clearly(&off, size)).then_some((item, CONVEX))
        }
        _ => None,
    }
}

const FLAT: &str = "the only body is flat: it hides no light from the side that faces it";
const CONVEX: &str = "the only body is convex: it hides the lights from its back only, which they do not light";

/// Where a light stands, if it is not infinitely far away.
fn middle<R: Real>(light: &Light<R>) -> Option<DVec3> {
    match light.source {
        Source::Point { position } | Source::Spot { position, .. } => {
            Some(DVec3::from_array(position.map(Real::to_f64)))
        }
        Source::Directional { .. } => None,
    }
}
