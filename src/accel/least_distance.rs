//! Lower bounds on the distance of surfaces from a point, for lights whose strength grows without bound towards them.

use super::extent::Ball;
use super::geometry::Geometry;
use super::item::{Instance, Item, Shape};
use crate::lanes::Real;
use crate::math;
use glam::DVec3;
use rayon::prelude::*;

/// Bodies and triangles that are looked at one by one. Of instances behind them the balls are: instances of instances double them with
/// each level.
const LOOKS: u64 = 1 << 22;

/// For each material a lower bound on the distance of its surfaces from `point`; infinite if it has no surface.
pub(crate) fn least_distances<R: Real>(
    geometries: &[Geometry<R>],
    root: usize,
    point: [f64; 3],
    materials: usize,
) -> Vec<f64> {
    let mut search = Search {
        geometries,
        below: below(geometries, materials),
        nearest: vec![f64::INFINITY; materials],
        left: LOOKS,
    };
    search.visit(root, DVec3::from_array(point), 1.0);
    search.nearest
}

/// The materials of each geometry and of those that it places, each once. Geometries come after those they place.
fn below<R: Real>(geometries: &[Geometry<R>], materials: usize) -> Vec<Vec<u32>> {
    let mut below: Vec<Vec<u32>> = Vec::with_capacity(geometries.len());
    // The last geometry in which each was met.
    let (mut met, mut placed) = (vec![usize::MAX; materials], vec![usize::MAX; geometries.len()]);
    for (number, geometry) in geometries.iter().enumerate() {
        let mut own = Vec::new();
        let mut meet = |material: u32| {
            if std::mem::replace(&mut met[material as usize], number) != number {
                own.push(material);
            }
        };
        for item in &geometry.items {
            match &item.shape {
                Shape::Instance(instance) => {
                    let inside = instance.geometry as usize;
                    if std::mem::replace(&mut placed[inside], number) != number {
                        below[inside].iter().for_each(|material| meet(*material));
                    }
                }
                _ => meet(item.material),
            }
        }
        below.push(own);
    }
    below
}

struct Search<'a, R> {
    geometries: &'a [Geometry<R>],
    below: Vec<Vec<u32>>,
    nearest: Vec<f64>,
    left: u64,
}

impl<R: Real> Search<'_, R> {
    /// A length of 1 in the geometry is at least `scale` in the scene.
    fn visit(&mut self, geometry: usize, point: DVec3, scale: f64) {
        let geometries = self.geometries;
        for item in &geometries[geometry].items {
            if let Shape::Instance(instance) = &item.shape {
                self.left = self.left.saturating_sub(1);
                if instance.motion.is_some() || self.left == 0 {
                    // What moves stays in the ball around its path.
                    let from_ball = |ball: &Ball<R>| point.distance(wide(ball.center)) - ball.radius.to_f64();
                    let least = scale * instance.ball.as_ref().map_or(0.0, from_ball).max(0.0);
                    for material in &self.below[instance.geometry as usize] {
                        let known = &mut self.nearest[*material as usize];
                        *known = known.min(least);
                    }
                } else {
                    let scale = scale / instance.to_local.largest_stretch();
                    self.visit(instance.geometry as usize, into(instance, point), scale);
                }
                continue;
            }
            self.left = self.left.saturating_sub(item.expanded);
            let known = &mut self.nearest[item.material as usize];
            *known = known.min(scale * distance(item, point));
        }
    }
}

fn into<R: Real>(instance: &Instance<R>, p: DVec3) -> DVec3 {
    let map = &instance.to_local;
    let [x, y, z] = map.columns.map(wide);
    x * p.x + y * p.y + z * p.z + wide(map.translation)
}

/// A lower bound on the distance of a surface that is not placed, from a point in its coordinates.
fn distance<R: Real>(item: &Item<R>, p: DVec3) -> f64 {
    match &item.shape {
        Shape::Sphere(sphere) => (p.distance(wide(sphere.center)) - sphere.radius.to_f64()).abs(),
        Shape::Plane(plane) => wide(plane.normal).dot(p - wide(plane.point)).abs(),
        Shape::Disc(disc) => {
            let (center, normal) = (wide(disc.plane.point), wide(disc.plane.normal));
            let height = normal.dot(p - center);
            let beside = (p - center - normal * height).length() - disc.radius.to_f64();
            math::hypot(height, beside.max(0.0))
        }
        Shape::Cuboid(cuboid) => {
            let (min, max) = (wide(cuboid.min), wide(cuboid.max));
            let outside = (min - p).max(p - max);
            if outside.max_element() > 0.0 { outside.max(DVec3::ZERO).length() } else { -outside.max_element() }
        }
        Shape::Torus(torus) => {
            let [across, height] = torus.frame.cylindrical(p);
            (math::hypot(across - torus.major_radius.to_f64(), height) - torus.minor_radius.to_f64()).abs()
        }
        Shape::Frustum(frustum) => {
            // The distance from the convex hull of its two circles; 0 inside of it.
            let [across, height] = frustum.frame.cylindrical(p);
            let widest = frustum.base_radius.to_f64().max(frustum.top_radius.to_f64());
            let beyond = (-height).max(height - frustum.height.to_f64()).max(0.0);
            math::hypot((across - widest).max(0.0), beyond)
        }
        Shape::Mesh(mesh) => {
            let face = |face: usize| distance_to_triangle(p, mesh.corners(face).map(wide));
            let faces = (0..mesh.faces.len()).into_par_iter().filter(|face| !mesh.is_collapsed(*face));
            faces.map(face).reduce(|| f64::INFINITY, f64::min)
        }
        Shape::Instance(_) => 0.0,
    }
}

/// Distance from a point to the closest point of a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
pub(crate) fn distance_to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ap.length();
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return bp.length();
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (ap - ab * (d1 / (d1 - d3))).length();
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return cp.length();
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (ap - ac * (d2 / (d2 - d6))).length();
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return (bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))).length();
    }
    let denominator = 1.0 / (va + vb + vc);
    (ap - ab * (vb * denominator) - ac * (vc * denominator)).length()
}

fn wide<R: Real>(v: [R; 3]) -> DVec3 {
    DVec3::from_array(v.map(Real::to_f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closest_point_of_a_triangle_is_found_in_all_seven_regions() {
        let corners = [DVec3::ZERO, DVec3::new(2.0, 0.0, 0.5), DVec3::new(0.3, 1.5, -0.4)];
        for i in 0..400 {
            let spread =
                |k: u32| f64::from(2_654_435_761u32.wrapping_mul(k).wrapping_mul(i) >> 8) / 2f64.powi(24) * 6.0 - 3.0;
            let p = DVec3::new(spread(1), spread(7), spread(13));
            let mut least = f64::INFINITY;
            for a in 0..=200 {
                for b in 0..=(200 - a) {
                    let (u, v) = (f64::from(a) / 200.0, f64::from(b) / 200.0);
                    least = least
                        .min(p.distance(corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v));
                }
            }
            let found = distance_to_triangle(p, corners);
            assert!(found <= least + 1e-12 && found >= least - 0.02, "{p}: {found} {least}");
        }
    }
}
