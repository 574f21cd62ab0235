//! Circular cone, its frustum, and the cylinder, which is the frustum of equal radii.

use super::{Frame, Sides};
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::ray::{Hit, Intersection, Rays, Wanted};

/// x^2 + y^2 = (r0 + k z)^2 for 0 <= z <= height, with discs at both ends if `capped`.
#[derive(Debug, Clone, Copy)]
pub struct Frustum<R> {
    /// Its base is the origin, its axis points to the top.
    pub frame: Frame<R>,
    /// Length of the axis, above 0.
    pub height: R,
    /// Radius at z = 0.
    pub base_radius: R,
    /// Radius at z = height.
    pub top_radius: R,
    /// k = (top_radius - base_radius) / height.
    pub slope: R,
    /// Whether discs close the ends.
    pub capped: bool,
}

impl<R: Real> Frustum<R> {
    /// Nearest intersection in range.
    ///
    /// First the origin moves along the ray to where its line is closest to the axis, so that a large distance does not
    /// cancel digits. With o, d the parts across the axis, m = k dz and r = r0 + k oz:
    /// a = d.d - m^2, b' = -(o.d - m r), c = (|o|-r)(|o|+r), and the discriminant b'^2 - a c is
    /// (A - B)(A + B) with A = |r d - m o|, B = |o x d|. q = b' + sign(b') s covers a = 0, a ray parallel to a generator.
    #[inline(always)]
    pub fn intersect<L: Lanes<Real = R>>(
        &self,
        s: L::Simd,
        rays: &Rays<L>,
        sides: Sides,
        wanted: Wanted,
    ) -> Intersection<L> {
        let zero = L::lit(s, 0.0);
        let height = L::splat(s, self.height);
        let (r0, k) = (L::splat(s, self.base_radius), L::splat(s, self.slope));

        let far = self.frame.point_in(s, rays.origin);
        let d = self.frame.vector_in(s, rays.dir);
        // Clamped to the ends: a ray along the axis is close to all of it.
        let closest = far.z - d.z * ((far.x * d.x + far.y * d.y) / (d.x * d.x + d.y * d.y));
        let closest = L::select(closest.eq(closest), closest, far.z).max(zero).min(height);
        let shift = (V3 { x: zero, y: zero, z: closest } - far).dot(d) / d.dot(d);
        let o = far + d * shift;

        let m = k * d.z;
        let r = r0 + k * o.z;
        let a = d.x * d.x + d.y * d.y - m * m;
        let b = m * r - (o.x * d.x + o.y * d.y);
        let across = (o.x * o.x + o.y * o.y).sqrt();
        let c = (across - r) * (across + r);
        let (ax, ay) = (r * d.x - m * o.x, r * d.y - m * o.y);
        let big = (ax * ax + ay * ay).sqrt();
        let small = (o.x * d.y - o.y * d.x).abs();
        let discriminant = (big - small) * (big + small);
        let real = discriminant.ge(zero);
        let root = discriminant.max(zero).sqrt();
        // |q| is at least sqrt(|a c|). Where the discriminant of a grazing ray has rounded to less, c/q would be noise.
        let q = (b.abs() + root).max((a * c).abs().sqrt());
        let q = L::select(b.gt(zero), q, -q);
        let line = Line { o, d, shift, a, m, c, q, u: c / q, v: q / a, real };
        if self.capped {
            self.intersect_solid(s, rays, sides, wanted, &line)
        } else {
            self.intersect_open(s, rays, sides, &line)
        }
    }

    /// The body is the intersection of the inside of the side with the space between the ends, so a ray is in it from the
    /// later entry to the earlier exit. No decision depends on the rim, so no ray slips through there.
    #[inline(always)]
    fn intersect_solid<L: Lanes<Real = R>>(
        &self,
        s: L::Simd,
        rays: &Rays<L>,
        sides: Sides,
        wanted: Wanted,
        line: &Line<L>,
    ) -> Intersection<L> {
        let zero = L::lit(s, 0.0);
        let infinity = L::lit(s, f64::INFINITY);
        let height = L::splat(s, self.height);
        let (r0, r1, k) = (L::splat(s, self.base_radius), L::splat(s, self.top_radius), L::splat(s, self.slope));
        let Line { o, d, shift, a, m, c, q, u, v, real } = *line;

        let level = d.z.eq(zero);
        let between = zero.le(o.z) & o.z.le(height);
        let (base, top) = ((zero - o.z) / d.z, (height - o.z) / d.z);
        let cap_in = L::select(level, -infinity, base.min(top));
        let cap_out = L::select(level, infinity, base.max(top));

        // A ray steeper than the side (a < 0) is inside one nappe before or after both roots, or always.
        let (low, high) = (u.min(v), u.max(v));
        let steep = a.lt(zero);
        let along = a.eq(zero) & q.eq(zero);
        let rising = m.gt(zero);
        let all = along | (steep & !real);
        let side_in = L::select(all | (steep & !rising), -infinity, L::select(steep, high, low));
        let side_out = L::select(all | (steep & rising), infinity, L::select(steep, low, high));
        let inside = (real | steep) & (!along | c.le(zero)) & (!level | between);

        let (t_in, t_out) = (cap_in.max(side_in), cap_out.min(side_out));
        let first = sides.outside::<L>(s, rays.in_range(t_in + shift));
        let last = sides.inside::<L>(s, rays.in_range(t_out + shift));
        let hit = rays.active & inside & t_in.le(t_out) & (first | last);
        let t = L::select(first, t_in, t_out);
        if wanted == Wanted::Distance || !hit.any() {
            return Intersection { hit: Hit::at(t + shift, hit), ..Intersection::none(s, rays) };
        }
        let on_cap = (first & side_in.le(cap_in)) | (!first & cap_out.le(side_out));

        // The point stays away from the rim by more than its error: a ray that leaves from there must not start beyond
        // the neighbouring surface.
        let p = o + d * t;
        let (_, error) = self.frame.point_out(s, V3 { x: p.x, y: p.y, z: height });
        let away = error.x.max(error.y).max(error.z) * (L::lit(s, 1.0) + L::lit(s, 2.0) * k.abs());
        let half = L::lit(s, 0.5);
        // A ray that goes down enters at the top, one that goes up leaves there.
        let upper = (first & d.z.lt(zero)) | (!first & d.z.gt(zero));
        let end_radius = L::select(upper, r1, r0);
        let rho = (p.x * p.x + p.y * p.y).sqrt();
        let margin = away.min(height * half);
        let z = L::select(on_cap, L::select(upper, height, zero), p.z.max(margin).min(height - margin));
        let radius = r0 + k * z;
        let within = rho.min(end_radius - away.min(end_radius * half));
        let axial = rho.eq(zero);
        let fit = L::select(axial, zero, L::select(on_cap, within, radius) / rho);
        let point = V3 { x: p.x * fit, y: p.y * fit, z };
        let side = V3 { x: point.x, y: point.y, z: L::select(axial, -k, -(k * radius)) };
        let cap = V3 { x: zero, y: zero, z: L::select(upper, L::lit(s, 1.0), L::lit(s, -1.0)) };
        let (point, error) = self.frame.point_out(s, point);
        let normal = self.frame.vector_out(s, V3::select(on_cap, cap, side));
        Intersection::at(t + shift, hit, point, error, normal)
    }

    /// The side alone, from both sides.
    #[inline(always)]
    fn intersect_open<L: Lanes<Real = R>>(
        &self,
        s: L::Simd,
        rays: &Rays<L>,
        sides: Sides,
        line: &Line<L>,
    ) -> Intersection<L> {
        let zero = L::lit(s, 0.0);
        let height = L::splat(s, self.height);
        let (r0, r1, k) = (L::splat(s, self.base_radius), L::splat(s, self.top_radius), L::splat(s, self.slope));
        let Line { o, d, shift, u, v, real, .. } = *line;
        let mut best = Candidate { t: L::lit(s, f64::INFINITY), found: L::mask(s, 0), point: o, normal: o };
        // The rounding at an end depends on where the ray is, not on the size of the body: a long tube ends as sharply as
        // a short one.
        let slack = L::lit(s, 16.0 * R::ROUNDOFF);
        let width = r0.max(r1) + o.z.abs();
        for t in [u, v] {
            let p = o + d * t;
            let z = p.z.max(zero).min(height);
            let radius = r0 + k * z;
            let rho = (p.x * p.x + p.y * p.y).sqrt();
            let fit = radius / rho;
            let (x, y) = (p.x * fit, p.y * fit);
            let slack = slack * (width + p.z.abs());
            let on = real & (p.z - z).abs().le(slack) & zero.le(r0 + k * p.z + slack);
            // The only surface on the axis is the tip, whose normal is the axis.
            let tip = rho.eq(zero);
            let on = on & (!tip | radius.le(slack));
            let (x, y) = (L::select(tip, zero, x), L::select(tip, zero, y));
            let normal = V3 { x, y, z: L::select(tip, -k, -(k * radius)) };
            best.offer(s, rays, t + shift, on, V3 { x, y, z }, normal, d, sides);
        }

        let (point, error) = self.frame.point_out(s, best.point);
        let normal = self.frame.vector_out(s, best.normal);
        Intersection::at(best.t, best.found & rays.active, point, error, normal)
    }
}

/// A ray in the frame's coordinates, moved by `shift`, and where it meets the whole double cone: a t^2 - 2 b' t + c = 0.
#[derive(Clone, Copy)]
struct Line<L: Lanes> {
    o: V3<L>,
    d: V3<L>,
    shift: L,
    a: L,
    m: L,
    c: L,
    q: L,
    u: L,
    v: L,
    real: L::Mask,
}

/// The nearest of the two intersections with the side, in the frame's coordinates.
struct Candidate<L: Lanes> {
    t: L,
    found: L::Mask,
    point: V3<L>,
    normal: V3<L>,
}

impl<L: Lanes> Candidate<L> {
    #[inline(always)]
    fn offer(
        &mut self,
        s: L::Simd,
        rays: &Rays<L>,
        t: L,
        on: L::Mask,
        point: V3<L>,
        normal: V3<L>,
        dir: V3<L>,
        sides: Sides,
    ) {
        let zero = L::lit(s, 0.0);
        let cosine = normal.dot(dir);
        let seen = sides.outside::<L>(s, cosine.le(zero)) | sides.inside::<L>(s, cosine.ge(zero));
        let better = on & seen & rays.in_range(t) & t.lt(self.t);
        self.t = L::select(better, t, self.t);
        self.found = self.found | better;
        self.point = V3::select(better, point, self.point);
        self.normal = V3::select(better, normal, self.normal);
    }
}
