//! Circular cone, its frustum, and the cylinder, which is the frustum of equal radii.

use super::frame::Frames;
use super::{Frame, Sides};
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::ray::{Hit, Intersection, Rays};

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

/// Numbers of a frustum: its frame's, then height, radii and slope.
pub const FRUSTUM_NUMBERS: usize = 16;

impl<R: Real> Frustum<R> {
    /// Nearest intersection in range.
    #[inline(always)]
    pub fn intersect<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, sides: Sides) -> Intersection<L> {
        let frusta = Frusta::splat(s, self);
        let Some(line) = frusta.line(s, rays) else { return Intersection::none(s, rays) };
        let met = frusta.met(s, self.capped, rays, sides, &line);
        if self.capped { frusta.solid_surface(s, &line, &met) } else { frusta.side_surface(s, &line, &met) }
    }

    /// Its numbers, in the order of [`Frusta::of`].
    pub fn numbers(&self) -> [R; FRUSTUM_NUMBERS] {
        let [a, b, c, d, e, f, g, h, i, j, k, l] = self.frame.numbers();
        [a, b, c, d, e, f, g, h, i, j, k, l, self.height, self.base_radius, self.top_radius, self.slope]
    }
}

/// A frustum in each lane.
#[derive(Debug, Clone, Copy)]
pub struct Frusta<L> {
    frame: Frames<L>,
    height: L,
    base_radius: L,
    top_radius: L,
    slope: L,
}

/// Where each lane's ray meets its frustum first inside its range. All frusta are `capped`, or none is.
#[inline(always)]
pub fn hit_frusta<L: Lanes>(s: L::Simd, frusta: &Frusta<L>, capped: bool, rays: &Rays<L>, sides: Sides) -> Hit<L> {
    match frusta.line(s, rays) {
        Some(line) => frusta.met(s, capped, rays, sides, &line).hit(&line),
        None => Hit::none(s),
    }
}

/// Lanes whose ray crosses its frustum once, and twice: what two searches by [`hit_frusta`] find, the second beginning where
/// the first ended.
#[inline(always)]
pub fn frusta_crossings<L: Lanes>(
    s: L::Simd,
    frusta: &Frusta<L>,
    capped: bool,
    rays: &Rays<L>,
    sides: Sides,
) -> [L::Mask; 2] {
    let Some(mut line) = frusta.line(s, rays) else { return [L::mask(s, 0); 2] };
    let first = frusta.met(s, capped, rays, sides, &line).hit(&line);
    if !first.lanes.any() {
        return [first.lanes; 2];
    }
    line.close = first.lanes;
    let behind = Rays { t_min: first.t, active: first.lanes, ..*rays };
    [first.lanes, frusta.met(s, capped, &behind, sides, &line).found]
}

impl<L: Lanes> Frusta<L> {
    /// One frustum in all lanes.
    #[inline(always)]
    pub fn splat(s: L::Simd, frustum: &Frustum<L::Real>) -> Self {
        Self {
            frame: frustum.frame.splat(s),
            height: L::splat(s, frustum.height),
            base_radius: L::splat(s, frustum.base_radius),
            top_radius: L::splat(s, frustum.top_radius),
            slope: L::splat(s, frustum.slope),
        }
    }

    /// From one bundle for each of [`Frustum::numbers`].
    #[inline(always)]
    pub fn of(numbers: [L; FRUSTUM_NUMBERS]) -> Self {
        let [a, b, c, d, e, f, g, h, i, j, k, l, height, base_radius, top_radius, slope] = numbers;
        Self { frame: Frames::of([a, b, c, d, e, f, g, h, i, j, k, l]), height, base_radius, top_radius, slope }
    }

    /// Where lines meet the double cones, unless no active ray comes near.
    #[inline(always)]
    fn line(&self, s: L::Simd, rays: &Rays<L>) -> Option<Line<L>> {
        let far = self.frame.point_in(rays.origin);
        let d = self.frame.vector_in(rays.dir);
        let close = rays.active & self.near(s, far, d);
        if close.any() { self.line_through(s, far, d, close) } else { None }
    }

    /// The same of the lanes `close`, for lines through `far` along `d`.
    ///
    /// First the origin moves along the ray to where its line is closest to the axis, so that a large distance does not
    /// cancel digits. With o, d the parts across the axis, m = k dz and r = r0 + k oz:
    /// a = d.d - m^2, b' = -(o.d - m r), c = (|o|-r)(|o|+r), and the discriminant b'^2 - a c is
    /// (A - B)(A + B) with A = |r d - m o|, B = |o x d|. q = b' + sign(b') s covers a = 0, a ray parallel to a generator.
    #[inline(always)]
    fn line_through(&self, s: L::Simd, far: V3<L>, d: V3<L>, close: L::Mask) -> Option<Line<L>> {
        let zero = L::lit(s, 0.0);
        let (height, r0, k) = (self.height, self.base_radius, self.slope);
        // Clamped to the ends: a ray along the axis is close to all of it.
        let closest = far.z - d.z * ((far.x * d.x + far.y * d.y) / (d.x * d.x + d.y * d.y));
        let closest = L::select(closest.eq(closest), closest, far.z).max(zero).min(height);
        let shift = (V3 { x: zero, y: zero, z: closest } - far).dot(d) / d.dot(d);
        let o = far + d * shift;

        let m = k * d.z;
        let r = r0 + k * o.z;
        let a = d.x * d.x + d.y * d.y - m * m;
        let (ax, ay) = (r * d.x - m * o.x, r * d.y - m * o.y);
        let big = (ax * ax + ay * ay).sqrt();
        let small = (o.x * d.y - o.y * d.x).abs();
        let discriminant = (big - small) * (big + small);
        let real = discriminant.ge(zero);
        let close = close & (real | a.lt(zero));
        if !close.any() {
            return None;
        }
        let b = m * r - (o.x * d.x + o.y * d.y);
        let across = (o.x * o.x + o.y * o.y).sqrt();
        let c = (across - r) * (across + r);
        let root = discriminant.max(zero).sqrt();
        // |q| is at least sqrt(|a c|). Where the discriminant of a grazing ray has rounded to less, c/q would be noise.
        let q = (b.abs() + root).max((a * c).abs().sqrt());
        let q = L::select(b.gt(zero), q, -q);
        Some(Line { close, o, d, shift, a, m, c, q, u: c / q, v: q / a, real })
    }

    /// The lanes whose line passes the axis within the larger radius, or almost: |o x d| <= r |d| across the axis, without a
    /// root. Each side may be off by roundings of |o| |d|, and a flat cone may be met beyond its rim by roundings of its
    /// height times its slope; (x + y)^2 <= (1 + e) x^2 + (1 + 1/e) y^2 with e = 1/64 has room for 32 of them.
    #[inline(always)]
    fn near(&self, s: L::Simd, far: V3<L>, d: V3<L>) -> L::Mask {
        let u = L::Real::ROUNDOFF;
        let aside = far.x * d.y - far.y * d.x;
        let beyond = L::lit(s, 1.0) + self.slope.abs() * L::lit(s, 32.0 * u);
        let reach = self.base_radius.max(self.top_radius) * beyond;
        let radii = reach * reach * (d.x * d.x + d.y * d.y) * L::lit(s, 1.0 + 1.0 / 64.0);
        let slack = far.dot(far) * d.dot(d) * L::lit(s, 65.0 * 32.0 * 32.0 * u * u);
        !(aside * aside).gt(radii + slack + L::lit(s, 16.0 * L::Real::SMALLEST))
    }

    /// The first place in range where each ray meets its frustum.
    #[inline(always)]
    fn met(&self, s: L::Simd, capped: bool, rays: &Rays<L>, sides: Sides, line: &Line<L>) -> Met<L> {
        if capped { self.met_solid(s, rays, sides, line) } else { self.met_side(s, rays, sides, line) }
    }

    /// The body is the intersection of the inside of the side with the space between the ends, so a ray is in it from the
    /// later entry to the earlier exit. No decision depends on the rim, so no ray slips through there.
    #[inline(always)]
    fn met_solid(&self, s: L::Simd, rays: &Rays<L>, sides: Sides, line: &Line<L>) -> Met<L> {
        let zero = L::lit(s, 0.0);
        let infinity = L::lit(s, f64::INFINITY);
        let height = self.height;
        let Line { close, o, d, shift, a, m, c, q, u, v, real } = *line;

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
        let found = close & inside & t_in.le(t_out) & (first | last);
        let on_cap = (first & side_in.le(cap_in)) | (!first & cap_out.le(side_out));
        Met { t: L::select(first, t_in, t_out), found, first, on_cap }
    }

    /// The surface of a frustum with caps.
    #[inline(always)]
    fn solid_surface(&self, s: L::Simd, line: &Line<L>, met: &Met<L>) -> Intersection<L> {
        let zero = L::lit(s, 0.0);
        let (height, r0, r1, k) = (self.height, self.base_radius, self.top_radius, self.slope);
        let Line { o, d, .. } = *line;
        let Met { t, first, on_cap, .. } = *met;

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
        let normal = self.frame.vector_out(V3::select(on_cap, cap, side));
        let Hit { t, lanes, .. } = met.hit(line);
        Intersection::at(t, lanes, point, error, normal)
    }

    /// The side alone, from both sides.
    #[inline(always)]
    fn met_side(&self, s: L::Simd, rays: &Rays<L>, sides: Sides, line: &Line<L>) -> Met<L> {
        let zero = L::lit(s, 0.0);
        let (height, r0, r1, k) = (self.height, self.base_radius, self.top_radius, self.slope);
        let Line { close, o, d, shift, u, v, real, .. } = *line;
        let none = L::mask(s, 0);
        let (mut t, mut found, mut nearest) = (u, none, L::lit(s, f64::INFINITY));
        // The rounding at an end depends on where the ray is, not on the size of the body: a long tube ends as sharply as
        // a short one.
        let slack = L::lit(s, 16.0 * L::Real::ROUNDOFF);
        let width = r0.max(r1) + o.z.abs();
        for root in [u, v] {
            let at = root + shift;
            let p = o + d * root;
            let z = p.z.max(zero).min(height);
            let slack = slack * (width + p.z.abs());
            let on = real & (p.z - z).abs().le(slack) & zero.le(r0 + k * p.z + slack);
            // The only surface on the axis is the tip, whose normal is the axis.
            let on = on & (!(p.x * p.x + p.y * p.y).eq(zero) | (r0 + k * z).le(slack));
            let mut on = on & close & rays.in_range(at) & at.lt(nearest);
            if sides != Sides::Both && on.any() {
                let cosine = self.on_side(s, p).1.dot(d);
                on = on & (sides.outside::<L>(s, cosine.le(zero)) | sides.inside::<L>(s, cosine.ge(zero)));
            }
            t = L::select(on, root, t);
            nearest = L::select(on, at, nearest);
            found = found | on;
        }
        Met { t, found, first: none, on_cap: none }
    }

    /// The point of the side that a point almost on it belongs to, and the normal there.
    #[inline(always)]
    fn on_side(&self, s: L::Simd, p: V3<L>) -> (V3<L>, V3<L>) {
        let zero = L::lit(s, 0.0);
        let z = p.z.max(zero).min(self.height);
        let radius = self.base_radius + self.slope * z;
        let rho = (p.x * p.x + p.y * p.y).sqrt();
        let fit = radius / rho;
        let tip = rho.eq(zero);
        let (x, y) = (L::select(tip, zero, p.x * fit), L::select(tip, zero, p.y * fit));
        (V3 { x, y, z }, V3 { x, y, z: L::select(tip, -self.slope, -(self.slope * radius)) })
    }

    /// The surface of a frustum without caps.
    #[inline(always)]
    fn side_surface(&self, s: L::Simd, line: &Line<L>, met: &Met<L>) -> Intersection<L> {
        let (point, normal) = self.on_side(s, line.o + line.d * met.t);
        let (point, error) = self.frame.point_out(s, point);
        let Hit { t, lanes, .. } = met.hit(line);
        Intersection::at(t, lanes, point, error, self.frame.vector_out(normal))
    }
}

/// A ray in the frame's coordinates, moved by `shift`, and where it meets the whole double cone: a t^2 - 2 b' t + c = 0.
#[derive(Clone, Copy)]
struct Line<L: Lanes> {
    /// Active lanes that may meet it.
    close: L::Mask,
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

/// Where lines meet frusta.
struct Met<L: Lanes> {
    /// Counted from the moved origin.
    t: L,
    found: L::Mask,
    /// Whether the ray enters there; of bodies with caps.
    first: L::Mask,
    on_cap: L::Mask,
}

impl<L: Lanes> Met<L> {
    #[inline(always)]
    fn hit(&self, line: &Line<L>) -> Hit<L> {
        Hit::at(self.t + line.shift, self.found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sin_cos;
    use glam::DVec3;

    /// Numbers from -1 to 1 without a pattern.
    fn noise(i: u32) -> f64 {
        sin_cos(f64::from(i) * 12.9898).0 * 43_758.547 % 1.0
    }

    fn frustum<R: Real>(i: u32, capped: bool) -> Frustum<R> {
        let [x, y, z] = [0, 1, 2].map(|axis| noise(7 * i + axis));
        let height = if i.is_multiple_of(5) { 1e-5 } else { 1.0 + noise(7 * i + 3) };
        let [base, top] = [4, 5].map(|end| 0.3 + 0.3 * noise(7 * i + end));
        let top = if i.is_multiple_of(3) { base } else { top };
        Frustum {
            frame: Frame::new(DVec3::new(x, y, z), DVec3::new(y, z, x + 0.1).normalize()),
            height: R::from_f64(height),
            base_radius: R::from_f64(base),
            top_radius: R::from_f64(top),
            slope: R::from_f64((top - base) / height),
            capped,
        }
    }

    /// The slow twin takes roots of every line, as far away as it passes.
    fn agree<R: Real + Lanes<Real = R, Simd = ()>>() {
        let (s, mut hits) = ((), 0);
        for (i, capped) in (0..40).flat_map(|i| [(i, false), (i, true)]) {
            let frusta = Frusta::<R>::splat(s, &frustum(i, capped));
            let base = DVec3::from_array([0, 1, 2].map(|axis| noise(7 * i + axis)));
            for j in 0..2000 {
                let at = |k: u32| noise(1000 * i + 11 * j + k);
                let distance = [3.0, 100.0, 1e5][j as usize % 3];
                let far = DVec3::new(at(0), at(1), at(2)) * distance;
                let aim = base + DVec3::new(at(3), at(4), at(5)) - far;
                let narrow = |v: DVec3| V3::splat(s, v.to_array().map(R::from_f64));
                let rays = Rays {
                    origin: narrow(far),
                    dir: narrow(aim.normalize()),
                    t_min: R::from_f64(0.0),
                    t_max: R::from_f64(f64::INFINITY),
                    active: R::mask(s, 1),
                };
                let (o, d) = (frusta.frame.point_in(rays.origin), frusta.frame.vector_in(rays.dir));
                let hit = |line: Option<Line<R>>| {
                    let line = line?;
                    let hit = frusta.met(s, capped, &rays, Sides::Both, &line).hit(&line);
                    hit.lanes.any().then_some(hit.t)
                };
                let slow = hit(frusta.line_through(s, o, d, rays.active));
                assert_eq!(hit(frusta.line(s, &rays)), slow, "{i} {capped} {j}");
                hits += u32::from(slow.is_some());
            }
        }
        assert!(hits > 2_000, "{hits}");
    }

    #[test]
    fn lines_that_end_early_meet_nothing() {
        agree::<f32>();
        agree::<f64>();
    }
}
