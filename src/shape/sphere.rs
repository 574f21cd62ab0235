//! Sphere: from afar the quadratic that does not cancel (Haines, Günther, Akenine-Möller, Ray Tracing Gems ch. 7), else the
//! plain one, which is more exact for origins on or inside the sphere.

use super::Sides;
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::ray::{Hit, Intersection, Rays, error_around};

/// All points at `radius` from `center`.
#[derive(Debug, Clone, Copy)]
pub struct Sphere<R> {
    /// Centre.
    pub center: [R; 3],
    /// Radius, above 0.
    pub radius: R,
}

impl<R: Real> Sphere<R> {
    /// Nearest intersection in range.
    #[inline(always)]
    pub fn intersect<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, sides: Sides) -> Intersection<L> {
        let (center, radius) = (V3::splat(s, self.center), L::splat(s, self.radius));
        sphere_surface(s, center, radius, rays, &hit_sphere(s, center, radius, rays, sides))
    }
}

/// Where each lane's ray meets its sphere first inside its range.
#[inline(always)]
pub fn hit_sphere<L: Lanes>(s: L::Simd, center: V3<L>, radius: L, rays: &Rays<L>, sides: Sides) -> Hit<L> {
    let Some(Quadratic { a, q, toward, small, real }) = quadratic(s, center, radius, rays) else {
        return Hit::none(s);
    };
    let mut t = small;
    let mut hit = real & toward & sides.outside::<L>(s, rays.in_range(small));
    if (real & !hit).any() {
        let large = q / a;
        let t0 = L::select(toward, small, large);
        let t1 = L::select(toward, large, small);
        let first = sides.outside::<L>(s, rays.in_range(t0));
        hit = real & (first | sides.inside::<L>(s, rays.in_range(t1)));
        t = L::select(first, t0, t1);
    }
    Hit::at(t, hit)
}

/// The surface of each lane's sphere where its ray meets it.
#[inline(always)]
pub fn sphere_surface<L: Lanes>(s: L::Simd, center: V3<L>, radius: L, rays: &Rays<L>, hit: &Hit<L>) -> Intersection<L> {
    let Hit { t, lanes, .. } = *hit;
    let f = rays.origin - center;

    // Not rays.at(t) - center: far from the origin that is 0 or a coarse grid. Where even this vector is 0, the normal is
    // set against the ray.
    let from_center = f + rays.dir * t;
    let length = from_center.length();
    let mut normal = from_center * (L::lit(s, 1.0) / length);
    if (lanes & length.le(L::lit(s, 0.0))).any() {
        normal = V3::select(length.gt(L::lit(s, 0.0)), normal, -rays.dir.normalized(s));
    }
    let from_center = normal * radius;
    let point = center + from_center;
    // Six roundings from the square root to here.
    let error = error_around(s, point, center, 6.0, from_center);
    Intersection { normalized: true, ..Intersection::at(t, lanes, point, error, normal) }
}

/// Lanes whose ray crosses its sphere on the way in, and on the way out: what two searches by [`hit_sphere`] find,
/// the second beginning where the first ended.
#[inline(always)]
pub fn sphere_crossings<L: Lanes>(s: L::Simd, center: V3<L>, radius: L, rays: &Rays<L>, sides: Sides) -> [L::Mask; 2] {
    let Some(Quadratic { a, q, toward, small, real }) = quadratic(s, center, radius, rays) else {
        return [L::mask(s, 0); 2];
    };
    let large = q / a;
    let t0 = L::select(toward, small, large);
    let t1 = L::select(toward, large, small);
    let first = real & sides.outside::<L>(s, rays.in_range(t0));
    let second = real & sides.inside::<L>(s, rays.in_range(t1)) & !(first & t1.le(t0));
    [first, second]
}

/// A ray and a sphere: the roots of a t^2 - 2 b' t + c, of which one is q / a.
struct Quadratic<L: Lanes> {
    a: L,
    q: L,
    /// Lanes that see the sphere ahead, whose first root is `small`; it is the second one in the others.
    toward: L::Mask,
    small: L,
    /// Active lanes with roots that may lie in range.
    real: L::Mask,
}

/// With f = o - c, a = d.d, b' = -f.d, c = (|f|-r)(|f|+r) the roots are c/q and q/a for q = b' + sign(b') s, and
/// s = sqrt(b'^2 - a c) = sqrt(a (r-l)(r+l)) with l = |f + (b'/a) d|. None if no active lane has roots.
#[inline(always)]
fn quadratic<L: Lanes>(s: L::Simd, center: V3<L>, radius: L, rays: &Rays<L>) -> Option<Quadratic<L>> {
    let zero = L::lit(s, 0.0);
    let f = rays.origin - center;
    let a = rays.dir.dot(rays.dir);
    let b = -f.dot(rays.dir);
    let bb = b * b;
    // |f|^2 a - b'^2 = a l^2, off by less than 16 u |f|^2 a. Rays that miss by more than that, or point away from
    // outside, need no roots.
    let slack = 64.0 * L::Real::ROUNDOFF;
    let ff = f.dot(f) * a * L::lit(s, 1.0 - slack);
    let rr = a * (radius * radius * L::lit(s, 1.0 + slack)) + L::lit(s, 16.0 * L::Real::SMALLEST);
    let outside = ff.gt(rr);
    let close = rays.active & !(ff - bb).gt(rr) & !(outside & b.lt(zero) & rays.t_min.ge(zero));
    if !close.any() {
        return None;
    }

    // Near the sphere b'^2 - ac is exact enough; from afar it cancels, and the distance l of the line does not. Most
    // packets are all near or all far, which saves a square root.
    let half = L::lit(s, 0.5) * bb;
    let (mut near, mut c) = (L::mask(s, 0), zero);
    if (close & !(ff - rr).gt(half)).any() {
        let distance = f.length();
        c = (distance - radius) * (distance + radius);
        near = c.le(zero) | (a * c).abs().lt(half);
    }
    let mut discriminant = bb - a * c;
    if (close & !near).any() {
        let l = (f + rays.dir * (b / a)).length();
        discriminant = L::select(near, discriminant, a * ((radius - l) * (radius + l)));
    }
    let real = discriminant.ge(zero) & close;
    let root = discriminant.max(zero).sqrt();

    let toward = b.gt(zero);
    let signed = L::select(toward, root, -root);
    let q = b + signed;
    // From afar b' - sign(b') s does not cancel, and it has two roundings less than c/q.
    let small = L::select(near, c, b - signed) / L::select(near, q, a);
    Some(Quadratic { a, q, toward, small, real })
}
