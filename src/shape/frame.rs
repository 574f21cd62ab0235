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

    /// A point's distance from the axis, and its height along it.
    pub fn cylindrical(&self, p: DVec3) -> [f64; 2] {
        let [origin, u, v, w] = [self.origin, self.u, self.v, self.w].map(|a| DVec3::from_array(a.map(Real::to_f64)));
        let p = p - origin;
        [math::hypot(u.dot(p), v.dot(p)), w.dot(p)]
    }

    /// A point in the frame's coordinates.
    #[inline(always)]
    pub fn point_in<L: Lanes<Real = R>>(&self, s: L::Simd, p: V3<L>) -> V3<L> {
        self.vector_in(s, p - V3::splat(s, self.origin))
    }

    /// A direction in the frame's coordinates.
    #[inline(always)]
    pub fn vector_in<L: Lanes<Real = R>>(&self, s: L::Simd, d: V3<L>) -> V3<L> {
        V3 { x: d.dot(V3::splat(s, self.u)), y: d.dot(V3::splat(s, self.v)), z: d.dot(V3::splat(s, self.w)) }
    }

    /// A direction of the frame in the coordinates outside.
    #[inline(always)]
    pub fn vector_out<L: Lanes<Real = R>>(&self, s: L::Simd, d: V3<L>) -> V3<L> {
        V3::splat(s, self.u) * d.x + V3::splat(s, self.v) * d.y + V3::splat(s, self.w) * d.z
    }

    /// A point of the frame in outer coordinates, and its error bound: the roundings of rotating it there and back, and of
    /// adding the origin.
    #[inline(always)]
    pub fn point_out<L: Lanes<Real = R>>(&self, s: L::Simd, p: V3<L>) -> (V3<L>, V3<L>) {
        let origin = V3::<L>::splat(s, self.origin);
        let point = origin + self.vector_out(s, p);
        let reach = p.abs();
        let turn = (reach.x + reach.y + reach.z) * L::lit(s, gamma::<R>(16.0));
        let sum = (point.abs() + origin.abs()) * L::lit(s, gamma::<R>(4.0));
        (point, sum + V3 { x: turn, y: turn, z: turn })
    }
}
