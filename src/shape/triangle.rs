//! Watertight triangles: Woop, Benthin, Wald, JCGT 2(1) 2013, with the products compared instead of subtracted.
//!
//! Rounding is monotone: exact a >= b implies fl(a) >= fl(b). So the accepted set of each triangle contains the exact
//! one over the rounded vertices, and since neighbours share these bit for bit, no ray slips between them, at any
//! scale. This needs products that are not fused with the comparison; Rust never fuses on its own.

use super::Sides;
use crate::lanes::{Lanes, MAX_LANES, Mask, Real, V3, is_single, lanes_of};
use crate::ray::{Hit, Intersection, Rays, gamma};
use glam::DVec3;

/// Whether two corners are in one place: such a triangle is but a line, and no ray hits it. Slivers are none, since without them there
/// would be gaps.
#[inline(always)]
pub fn is_collapsed<R: PartialEq>([a, b, c]: &[[R; 3]; 3]) -> bool {
    a == b || b == c || c == a
}

/// A ray's shear: the transformation that makes it point along +z from the origin.
#[derive(Debug, Clone, Copy)]
pub struct Shear<L: Lanes> {
    /// The axis along which the ray is longest, if all active lanes agree.
    common: Option<Axis>,
    y_major: L::Mask,
    z_major: L::Mask,
    flip: L::Mask,
    origin: V3<L>,
    sx: L,
    sy: L,
    sz: L,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Axis {
    index: u8,
    flip: bool,
}

impl<L: Lanes> Shear<L> {
    /// The shear of each ray, chosen once per ray so that all triangles see the same one.
    #[inline(always)]
    pub fn new(s: L::Simd, rays: &Rays<L>) -> Self {
        let a = rays.dir.abs();
        let z_major = a.z.ge(a.x) & a.z.ge(a.y);
        let y_major = !z_major & a.y.ge(a.x);
        let major = L::select(z_major, rays.dir.z, L::select(y_major, rays.dir.y, rays.dir.x));
        let flip = major.lt(L::lit(s, 0.0));

        let on = rays.active.bits();
        let same = |mask: L::Mask| match mask.bits() & on {
            0 => Some(false),
            bits if bits == on => Some(true),
            _ => None,
        };
        let common = match (same(z_major), same(y_major), same(flip)) {
            (Some(true), _, Some(flip)) => Some(Axis { index: 2, flip }),
            (Some(false), Some(true), Some(flip)) => Some(Axis { index: 1, flip }),
            (Some(false), Some(false), Some(flip)) => Some(Axis { index: 0, flip }),
            _ => None,
        };
        let mut shear = Self {
            common,
            y_major,
            z_major,
            flip,
            origin: rays.origin,
            sx: major,
            sy: major,
            sz: L::lit(s, 1.0) / major,
        };
        let d = shear.permute(rays.dir);
        shear.sx = d.x * shear.sz;
        shear.sy = d.y * shear.sz;
        shear
    }

    /// The shear of one lane's ray, in all lanes.
    #[inline(always)]
    pub fn alone(&self, s: L::Simd, lane: usize) -> Self {
        let has = |mask: L::Mask| mask.bits() & (1 << lane) != 0;
        let index = if has(self.z_major) { 2 } else { u8::from(has(self.y_major)) };
        let splat = |x: L| L::splat(s, x.lane(lane));
        Self {
            common: Some(Axis { index, flip: has(self.flip) }),
            origin: V3::splat(s, self.origin.lane(lane)),
            sx: splat(self.sx),
            sy: splat(self.sy),
            sz: splat(self.sz),
            ..*self
        }
    }

    /// Coordinates in the order kx, ky, kz, where kz is the major axis and handedness is kept.
    #[inline(always)]
    fn permute(&self, v: V3<L>) -> V3<L> {
        if let Some(axis) = self.common {
            let (x, y, z) = match axis.index {
                2 => (v.x, v.y, v.z),
                1 => (v.z, v.x, v.y),
                _ => (v.y, v.z, v.x),
            };
            return if axis.flip { V3 { x: y, y: x, z } } else { V3 { x, y, z } };
        }
        let x = L::select(self.z_major, v.x, L::select(self.y_major, v.z, v.y));
        let y = L::select(self.z_major, v.y, L::select(self.y_major, v.x, v.z));
        let z = L::select(self.z_major, v.z, L::select(self.y_major, v.y, v.x));
        V3 { x: L::select(self.flip, y, x), y: L::select(self.flip, x, y), z }
    }

    /// A vertex in the ray's sheared space; z is left unscaled.
    #[inline(always)]
    fn apply(&self, vertex: V3<L>) -> V3<L> {
        let v = self.permute(vertex - self.origin);
        V3 { x: v.x - self.sx * v.z, y: v.y - self.sy * v.z, z: v.z }
    }
}

/// Where each ray meets its triangle, whose front sees v0, v1, v2 counter-clockwise.
#[inline(always)]
pub fn hit_triangle<L: Lanes>(
    s: L::Simd,
    [v0, v1, v2]: [V3<L>; 3],
    rays: &Rays<L>,
    shear: &Shear<L>,
    sides: Sides,
) -> Hit<L> {
    let zero = L::lit(s, 0.0);
    // Whether the ray passes between the edges, and where.
    let (a, b, c) = (shear.apply(v0), shear.apply(v1), shear.apply(v2));
    let (u0, u1) = (c.x * b.y, c.y * b.x);
    let (w0, w1) = (b.x * a.y, b.y * a.x);
    let (h0, h1) = (a.x * c.y, a.y * c.x);
    let inside = (u0.ge(u1) & h0.ge(h1) & w0.ge(w1)) | (u0.le(u1) & h0.le(h1) & w0.le(w1));
    let inside = rays.active & inside;
    if !inside.any() {
        return Hit::none(s);
    }
    let (mut u, mut v, mut w) = (u0 - u1, h0 - h1, w0 - w1);
    let mut det = u + v + w;
    let flat = inside & det.eq(zero);
    if flat.any() {
        // All rounded areas vanish: decide in f64, where products of f32 are exact. In f64 such a triangle is missed.
        let exact = |lane: usize| {
            let [ax, ay, _] = a.lane(lane).map(Real::to_f64);
            let [bx, by, _] = b.lane(lane).map(Real::to_f64);
            let [cx, cy, _] = c.lane(lane).map(Real::to_f64);
            let areas = [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax];
            // Rounded corners may lie a little beside the ray, so that a weight has the wrong sign: it becomes 0.
            let front = (areas[0] + areas[1] + areas[2]).signum();
            let weights = areas.map(|area| (area * front).max(0.0));
            let sum = weights[0] + weights[1] + weights[2];
            weights.map(|weight| weight / sum * front)
        };
        let mut areas = [[0.0; 3]; MAX_LANES];
        for lane in lanes_of(flat.bits()) {
            areas[lane] = exact(lane);
        }
        let area = |k: usize| L::from_fn(s, |lane| L::Real::from_f64(areas[lane][k]));
        u = L::select(flat, area(0), u);
        v = L::select(flat, area(1), v);
        w = L::select(flat, area(2), w);
        det = u + v + w;
    }
    // A division, not a product with the reciprocal: at a vertex the weight is exactly 1, so all triangles there agree on t.
    let (b0, b1, b2) = (u / det, v / det, w / det);
    let t = (b0 * a.z + b1 * b.z + b2 * c.z) * shear.sz;

    // det has the sign of the area as the ray sees it: it is positive where the ray meets the front.
    let seen = sides.outside::<L>(s, det.gt(zero)) | sides.inside::<L>(s, det.lt(zero));
    let lanes = inside & seen & rays.in_range(t);
    Hit { t, lanes, weights: [b0, b1, b2] }
}

/// The surface of each lane's triangle where its ray meets it.
#[inline(always)]
pub fn triangle_surface<L: Lanes>(s: L::Simd, corners: [V3<L>; 3], hit: &Hit<L>, rays: &Rays<L>) -> Intersection<L> {
    let [v0, v1, v2] = corners;
    let Hit { lanes, weights: [b0, b1, b2], .. } = *hit;
    let (e1, e2) = (v1 - v0, v2 - v0);

    // t is a weighted mean of the corners' depths, so a point on the triangle is off by a few roundings of the
    // triangle's own size.
    let reach = (v0.abs() * b0.abs() + v1.abs() * b1.abs() + v2.abs() * b2.abs()) + v0.abs();
    let size = e1.abs() + e2.abs();
    let size = size.x.max(size.y).max(size.z);
    let extent = size * L::lit(s, gamma::<L::Real>(6.0));
    let error = reach * L::lit(s, gamma::<L::Real>(8.0)) + V3 { x: extent, y: extent, z: extent };

    // Edges of length 1, so that the product of tiny ones is not lost.
    let scale = L::lit(s, 1.0) / size;
    let (f1, f2) = (e1 * scale, e2 * scale);
    let normal = f1.cross(f2);
    // The normal of a sliver that has no finite reciprocal length is set against the ray.
    let length = normal.abs();
    let measurable = (length.x + length.y + length.z).gt(L::lit(s, L::Real::SMALLEST / 4.0));
    let normal = V3::select(measurable, normal, -rays.dir);

    let border = Border { f1, f2, normal, off: (error.x + error.y + error.z) * scale };
    let (_, [_, p1, p2]) = border.keep_away(s, lanes, hit.weights);
    let point = v0 + (e1 * p1 + e2 * p2);
    let mut intersection = Intersection { hit: *hit, point, met: point, error, normal, normalized: false };

    let distance = (point - rays.origin).abs();
    let distance = distance.x.max(distance.y).max(distance.z);
    let large = lanes & (size * L::lit(s, LARGE)).gt(distance);
    if is_single::<L>() && large.any() {
        refine(s, &corners, rays, large, &border, &mut intersection);
    }
    intersection
}

/// Points on triangles larger than the ray's length over this are found in double precision. The weights are off by
/// roundings of the triangle's size over the cosine: on a floor of size 10^5 points in single were 0.4 off along it.
const LARGE: f64 = 16.0;

/// Replaces the points in `large` by more exact ones, where those are proved. A function of its own: most meshes have small
/// triangles only.
#[inline(never)]
fn refine<L: Lanes>(
    s: L::Simd,
    corners: &[V3<L>; 3],
    rays: &Rays<L>,
    large: L::Mask,
    border: &Border<L>,
    intersection: &mut Intersection<L>,
) {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let exact = ExactPoint::new(s, corners, rays);
            let lanes = large & exact.proved;
            // Rounding lets rays hit that pass the edge by.
            let zero = L::lit(s, 0.0);
            let [b0, b1, b2] = exact.weights;
            let (amid, [_, p1, p2]) = border.keep_away(s, lanes, [b0.max(zero), b1.max(zero), b2.max(zero)]);
            let inwards = (corners[1] - corners[0]) * (p1 - b1) + (corners[2] - corners[0]) * (p2 - b2);
            let point = V3::select(amid, exact.point, exact.point + inwards);
            intersection.met = V3::select(lanes, exact.point, intersection.met);
            intersection.point = V3::select(lanes, point, intersection.point);
        },
    );
}

/// What keeps points away from a triangle's edges.
struct Border<L: Lanes> {
    /// Two edges, in units of the triangle's size.
    f1: V3<L>,
    f2: V3<L>,
    /// Their product.
    normal: V3<L>,
    /// How far away, in these units.
    off: L,
}

impl<L: Lanes> Border<L> {
    /// Weights of a point that stays away from the edges by more than its error: a ray that leaves from there must not start
    /// beyond a neighbour. And the lanes in which it was far enough from them.
    #[inline(always)]
    fn keep_away(&self, s: L::Simd, lanes: L::Mask, [b0, b1, b2]: [L; 3]) -> (L::Mask, [L; 3]) {
        let Self { f1, f2, normal, off } = *self;
        let (mut p0, mut p1, mut p2) = (b0, b1, b2);
        // No edge of f1, f2 is longer than 2, and few points are near an edge.
        let least = b0.min(b1).min(b2);
        let amid = (least * least * normal.dot(normal)).gt(L::lit(s, 4.0) * off * off);
        if (lanes & !amid).any() {
            let away = off / normal.length();
            let most = L::lit(s, 0.25);
            p0 = p0.max((away * (f2 - f1).length()).min(most));
            p1 = p1.max((away * f2.length()).min(most));
            p2 = p2.max((away * f1.length()).min(most));
        }
        let inverse = L::lit(s, 1.0) / (p0 + p1 + p2);
        (amid, [p0 * inverse, p1 * inverse, p2 * inverse])
    }
}

/// Where rays meet triangles, by Möller and Trumbore's formulas (JGT 2(1), 1997) in double precision.
///
/// With u = 2^-53 and E, T and D the largest coordinates of the edges, of the way from v0 to the origin and of the direction:
/// differences of the input have one rounding. So t's numerator and denominator are off by at most 42 u E1 E2 T and
/// 42 u E1 E2 D, and the point by 64 u E1 E2 D (T + |t| D) / |det| with all roundings that follow. It is proved where that
/// is below a rounding of the triangle's size in the kernel's format, which the bound of other points contains several times.
struct ExactPoint<L: Lanes> {
    proved: L::Mask,
    point: V3<L>,
    weights: [L; 3],
}

impl<L: Lanes> ExactPoint<L> {
    #[inline(always)]
    fn new(s: L::Simd, corners: &[V3<L>; 3], rays: &Rays<L>) -> Self {
        let mut read = [[L::Real::default(); MAX_LANES]; 15];
        let vectors = [corners[0], corners[1], corners[2], rays.origin, rays.dir];
        for (vector, columns) in vectors.into_iter().zip(read.chunks_exact_mut(3)) {
            vector.x.store(&mut columns[0]);
            vector.y.store(&mut columns[1]);
            vector.z.store(&mut columns[2]);
        }
        let mut written = [[L::Real::default(); MAX_LANES]; 7];
        for lane in 0..L::COUNT {
            let vector = |k: usize| {
                let number = |axis: usize| read[3 * k + axis][lane].to_f64();
                DVec3::new(number(0), number(1), number(2))
            };
            let (v0, origin, dir) = (vector(0), vector(3), vector(4));
            let (e1, e2, way) = (vector(1) - v0, vector(2) - v0, origin - v0);
            let (p, q) = (dir.cross(e2), way.cross(e1));
            let det = e1.dot(p);
            let (t, b1, b2) = (e2.dot(q) / det, way.dot(p) / det, dir.dot(q) / det);
            let point = origin + dir * t;

            let most = |v: DVec3| v.abs().max_element();
            let (size, step) = (most(e1) * most(e2), most(dir));
            let off = 64.0 * f64::ROUNDOFF * size * step * (most(way) + t.abs() * step);
            let room = L::Real::ROUNDOFF * (most(e1) + most(e2)) * det.abs();
            let proved = if off < room { 1.0 } else { 0.0 };
            let answers = [point.x, point.y, point.z, 1.0 - b1 - b2, b1, b2, proved];
            for (column, answer) in written.iter_mut().zip(answers) {
                column[lane] = L::Real::from_f64(answer);
            }
        }
        let column = |k: usize| L::load(s, &written[k]);
        Self {
            proved: column(6).gt(L::lit(s, 0.0)),
            point: V3 { x: column(0), y: column(1), z: column(2) },
            weights: [column(3), column(4), column(5)],
        }
    }
}
