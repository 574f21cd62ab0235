//! Light between surfaces: absorption inside bodies, fog outside of them, colored shadows.

use super::optics::Media;
use super::ray::Ray;
use super::world::World;
use crate::math::{self, Rgb};
use crate::scene::description::Fog;
use std::f64::consts::E;

/// e^-depth in each channel; a channel that nothing absorbs passes whatever the distance.
fn remaining(sigma: Rgb, distance: f64) -> Rgb {
    sigma.map(|sigma| if sigma > 0.0 { math::pow(E, -sigma * distance) } else { 1.0 })
}

/// The share of light that passes along a ray, and the light that fog adds.
pub(super) fn along(fog: Option<&Fog>, media: &Media, ray: &Ray, distance: f64) -> (Rgb, Rgb) {
    let passed = remaining(media.absorption(), distance);
    match fog.filter(|fog| fog.density > 0.0 && media.is_empty()) {
        Some(fog) => {
            let share = math::pow(E, -optical_depth(fog, ray, distance));
            (passed * share, fog.color.0 * (1.0 - share))
        }
        None => (passed, Rgb::ZERO),
    }
}

/// Density, integrated from the antiderivative of e^(-u) on either side of the base.
fn optical_depth(fog: &Fog, ray: &Ray, distance: f64) -> f64 {
    let Some(height) = fog.height else { return fog.density * distance };
    let slope = ray.dir.y / height.falloff;
    let start = (ray.origin.y - height.base) / height.falloff;
    if slope.abs() < 1e-12 {
        return fog.density * distance * math::pow(E, -start.max(0.0));
    }
    // Antiderivative over u, continuous at the base.
    let total = |u: f64| if u < 0.0 { u } else { 1.0 - math::pow(E, -u) };
    fog.density * (total(start + slope * distance) - total(start)) / slope
}

/// The share of light that the bodies along a straight line from within `media` let pass.
pub(super) fn colored_shadow(world: &World, media: &Media, ray: &Ray, near: f64, far: f64) -> Rgb {
    let mut crossings = Vec::new();
    world.each_intersection(ray, near, far, |crossing| {
        crossings.push(crossing);
        far
    });
    crossings.sort_by(|a, b| a.t.total_cmp(&b.t));
    let mut media = media.clone();
    let (mut passed, mut from) = (Rgb::ONE, 0.0);
    for crossing in crossings {
        passed *= remaining(media.absorption(), crossing.t - from);
        from = crossing.t;
        if let Some(inner_ior) = crossing.body.inner_ior() {
            media = media.pass(&crossing, inner_ior).2;
        }
    }
    passed * remaining(media.absorption(), far - from)
}
