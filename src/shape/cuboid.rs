//! Axis-aligned box: three pairs of parallel planes (Kay and Kajiya, SIGGRAPH 1986).

use super::Sides;
use crate::lanes::{Lanes, Real, V3};
use crate::ray::{Intersection, Rays, gamma};

/// All points between two corners. It may be flat.
#[derive(Debug, Clone, Copy)]
pub struct Cuboid<R> {
    /// Lower corner.
    pub min: [R; 3],
    /// Upper corner.
    pub max: [R; 3],
}

impl<R: Real> Cuboid<R> {
    /// Nearest intersection in range.
    #[inline(always)]
    pub fn intersect<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, sides: Sides) -> Intersection<L> {
        let zero = L::lit(s, 0.0);
        let one = L::lit(s, 1.0);
        let infinity = L::lit(s, f64::INFINITY);
        let origin = [rays.origin.x, rays.origin.y, rays.origin.z];
        let dir = [rays.dir.x, rays.dir.y, rays.dir.z];

        let mut inside = rays.active;
        let (mut t_in, mut t_out) = (-infinity, infinity);
        let (mut axis_in, mut axis_out) = (zero, zero);
        for axis in 0..3 {
            let (o, d) = (origin[axis], dir[axis]);
            let (low, high) = (L::splat(s, self.min[axis]), L::splat(s, self.max[axis]));
            // A ray parallel to a pair of planes is always or never between them; an origin on a plane would give 0/0.
            let parallel = d.eq(zero);
            inside = inside & (!parallel | (low.le(o) & o.le(high)));
            let (a, b) = ((low - o) / d, (high - o) / d);
            let enter = L::select(parallel, -infinity, a.min(b));
            let exit = L::select(parallel, infinity, a.max(b));
            let later = enter.gt(t_in);
            t_in = L::select(later, enter, t_in);
            axis_in = L::select(later, L::lit(s, axis as f64), axis_in);
            let sooner = exit.lt(t_out);
            t_out = L::select(sooner, exit, t_out);
            axis_out = L::select(sooner, L::lit(s, axis as f64), axis_out);
        }

        let real = inside & t_in.le(t_out);
        let first = sides.outside::<L>(s, rays.in_range(t_in));
        let hit = real & (first | sides.inside::<L>(s, rays.in_range(t_out)));
        let t = L::select(first, t_in, t_out);
        let axis = L::select(first, axis_in, axis_out);

        // The coordinate across the face is that of the face. The others stay inside the box, a few roundings away from its
        // edges: a ray that leaves from there must not start beyond the neighbouring face.
        let at = rays.at(t);
        let at = [at.x, at.y, at.z];
        let mut point = [zero; 3];
        let mut normal = [zero; 3];
        for i in 0..3 {
            let (low, high) = (L::splat(s, self.min[i]), L::splat(s, self.max[i]));
            let across = axis.eq(L::lit(s, i as f64));
            // Entering through the face that the ray meets from outside, leaving through the opposite one.
            let lower = (dir[i].gt(zero) & first) | (dir[i].lt(zero) & !first);
            let face = L::select(lower, low, high);
            let away = low.abs().max(high.abs()) * L::lit(s, gamma::<R>(8.0));
            let away = away.min((high - low) * L::lit(s, 0.5));
            point[i] = L::select(across, face, at[i].max(low + away).min(high - away));
            normal[i] = L::select(across, L::select(lower, -one, one), zero);
        }
        let point = V3 { x: point[0], y: point[1], z: point[2] };
        let normal = V3 { x: normal[0], y: normal[1], z: normal[2] };
        let error = point.abs() * L::lit(s, gamma::<R>(2.0));
        Intersection::at(t, hit, point, error, normal)
    }
}
