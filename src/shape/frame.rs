//! An orthonormal frame: where a body of revolution stands and where its axis points.

use crate::lanes::{Lanes, Real, V3};
use crate::math;
use crate::ray::gamma;
use glam::DVec3;

/// Origin and three perpendicular unit vectors; `w` is the axis.
#[derive(Debug, Clone, Copy)]
pub struct Frame<R> {
    origin: [R; 3],
    u: [R; 3],
    v: [R; 3],
    w: [R; 3],
}

impl<R: Real> Frame<R> {
    /// A frame at `origin` whose third vector is the unit vector `axis` (Duff et al., Building an Orthonormal Basis,
    /// Revisited, JCGT 6(1) 2017).
    pub fn new(origin: DVec3, axis: DVec3) -> Self {
        let sign = 1.0f64.copysign(axis.z);
        let a = -1.0 / (sign + axis.z);
        let b = axis.x * axis.y * a;
        let u = DVec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
        let v = DVec3::new(b, sign + axis.y * axis.y * a, -axis.y);
        let narrow = |p: DVec3| p.to_array().map(R::from_f64);
        Self { origin: narrow(origin), u: narrow(u), v: narrow(v), w: narrow(axis) }
    }

    /// A ray in the frame's coordinates, in 64 bits.
    pub fn ray_in(&self, origin: DVec3, dir: DVec3) -> (DVec3, DVec3) {
        let [from, u, v, w] = [self.origin, self.u, self.v, self.w].map(|a| DVec3::from_array(a.map(Real::to_f64)));
        let inside = |p: DVec3| DVec3::new(u.dot(p), v.dot(p), w.dot(p));
        (inside(origin - from), inside(dir))
    }

    /// A point's distance from the axis, and its height along it.
    pub fn cylindrical(&self, p: DVec3) -> [f64; 2] {
        let [origin, u, v, w] = [self.origin, self.u, self.v, self.w].map(|a| DVec3::from_array(a.map(Real::to_f64)));
        let p = p - origin;
        [math::hypot(u.dot(p), v.dot(p)), w.dot(p)]
    }

    /// The frame in all lanes.
    #[inline(always)]
    pub fn splat<L: Lanes<Real = R>>(&self, s: L::Simd) -> Frames<L> {
        Frames {
            origin: V3::splat(s, self.origin),
            u: V3::splat(s, self.u),
            v: V3::splat(s, self.v),
            w: V3::splat(s, self.w),
        }
    }

    /// Its twelve numbers.
    pub(super) fn numbers(&self) -> [R; 12] {
        let [[a, b, c], [d, e, f], [g, h, i], [j, k, l]] = [self.origin, self.u, self.v, self.w];
        [a, b, c, d, e, f, g, h, i, j, k, l]
    }
}

/// A frame in each lane.
#[derive(Debug, Clone, Copy)]
pub struct Frames<L> {
    origin: V3<L>,
    u: V3<L>,
    v: V3<L>,
    w: V3<L>,
}

impl<L: Lanes> Frames<L> {
    /// From twelve bundles in the order of [`Frame::numbers`].
    #[inline(always)]
    pub(super) fn of([a, b, c, d, e, f, g, h, i, j, k, l]: [L; 12]) -> Self {
        let (origin, u) = (V3 { x: a, y: b, z: c }, V3 { x: d, y: e, z: f });
        Self { origin, u, v: V3 { x: g, y: h, z: i }, w: V3 { x: j, y: k, z: l } }
    }

    /// A point in the frame's coordinates.
    #[inline(always)]
    pub fn point_in(&self, p: V3<L>) -> V3<L> {
        self.vector_in(p - self.origin)
    }

    /// A direction in the frame's coordinates.
    #[inline(always)]
    pub fn vector_in(&self, d: V3<L>) -> V3<L> {
        V3 { x: d.dot(self.u), y: d.dot(self.v), z: d.dot(self.w) }
    }

    /// A direction of the frame in the coordinates outside.
    #[inline(always)]
    pub fn vector_out(&self, d: V3<L>) -> V3<L> {
        self.u * d.x + self.v * d.y + self.w * d.z
    }

    /// A point of the frame in outer coordinates, and its error bound: the roundings of rotating it there and back, and of
    /// adding the origin.
    #[inline(always)]
    pub fn point_out(&self, s: L::Simd, p: V3<L>) -> (V3<L>, V3<L>) {
        let point = self.origin + self.vector_out(p);
        let reach = p.abs();
        let turn = (reach.x + reach.y + reach.z) * L::lit(s, gamma::<L::Real>(16.0));
        let sum = (point.abs() + self.origin.abs()) * L::lit(s, gamma::<L::Real>(4.0));
        (point, sum + V3 { x: turn, y: turn, z: turn })
    }
}
