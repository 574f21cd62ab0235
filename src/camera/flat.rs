//! Pinhole and orthographic projection: the image plane is a plane.

use super::{Basis, Cone, Primary, Window};
use crate::lanes::{Lanes, Real, V3};
use glam::DVec3;

/// With (u, v) = (2x - width, height - 2y) the point of the image plane is `middle + u right + v up`.
#[derive(Debug, Clone, Copy)]
pub struct Flat<R> {
    width: R,
    height: R,
    eye: [R; 3],
    forward: [R; 3],
    right: [R; 3],
    up: [R; 3],
    /// Rays are parallel and start on the image plane, instead of passing through it from the eye.
    pub(super) parallel: bool,
}

impl<R: Real> Flat<R> {
    /// All rays start at the eye; the image plane lies at distance 1, h = 2 tan(theta/2).
    pub(crate) fn pinhole(basis: &Basis, half_tan: f64, size: (f64, f64)) -> Self {
        Self::new(basis, half_tan / size.1, size, false)
    }

    /// Rays run along the view through a rectangle of the given height.
    pub(crate) fn orthographic(basis: &Basis, height: f64, size: (f64, f64)) -> Self {
        Self::new(basis, 0.5 * height / size.1, size, true)
    }

    fn new(basis: &Basis, half_pixel: f64, (width, height): (f64, f64), parallel: bool) -> Self {
        let narrow = |v: DVec3| v.to_array().map(R::from_f64);
        Self {
            width: R::from_f64(width),
            height: R::from_f64(height),
            eye: narrow(basis.eye),
            forward: narrow(basis.forward),
            right: narrow(basis.right * half_pixel),
            up: narrow(basis.up * half_pixel),
            parallel,
        }
    }

    /// With x = origin + step X, (u, v) are those of X in a picture of (width - 2 origin) / step pixels, times the step.
    pub(super) fn through(self, &Window { origin, step, .. }: &Window) -> Self {
        let length = |length: R, axis: usize| R::from_f64((length.to_f64() - 2.0 * origin[axis]) / step[axis]);
        let pixel = |side: [R; 3], axis: usize| side.map(|x| R::from_f64(x.to_f64() * step[axis]));
        Self {
            width: length(self.width, 0),
            height: length(self.height, 1),
            right: pixel(self.right, 0),
            up: pixel(self.up, 1),
            ..self
        }
    }

    /// Distance along the view.
    fn depth(&self, point: DVec3) -> f64 {
        (point - wide(self.eye)).dot(wide(self.forward))
    }

    pub(super) fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let depth = self.depth(point);
        let is_seen = if self.parallel { depth >= 0.0 } else { depth > 0.0 };
        let offset = (point - wide(self.eye)) / if self.parallel { 1.0 } else { depth };
        let along = |side: [R; 3]| offset.dot(wide(side)) / wide(side).length_squared();
        let (u, v) = (along(self.right), along(self.up));
        is_seen.then(|| [0.5 * (u + self.width.to_f64()), 0.5 * (self.height.to_f64() - v)])
    }

    /// In front of a pinhole a millionth of the segment's larger depth is left out, where the picture would have no end.
    pub(super) fn clip(&self, [a, b]: [DVec3; 2]) -> Option<[DVec3; 2]> {
        let depths = [self.depth(a), self.depth(b)];
        let most = depths[0].max(depths[1]);
        let least = if self.parallel { 0.0 } else { 1e-6 * most };
        if most < 0.0 || (most <= 0.0 && !self.parallel) {
            return None;
        }
        let cut = |from: DVec3, to: DVec3, [near, far]: [f64; 2]| {
            if near >= least { from } else { from.lerp(to, (least - near) / (far - near)) }
        };
        Some([cut(a, b, depths), cut(b, a, [depths[1], depths[0]])])
    }

    /// Pixels are squares of twice the length of `up`, at the eye or at distance 1.
    pub(super) fn cone(&self) -> Cone {
        let pixel = 2.0 * DVec3::from_array(self.up.map(Real::to_f64)).length();
        if self.parallel { Cone { width: pixel, spread: 0.0 } } else { Cone { width: 0.0, spread: pixel } }
    }

    #[inline(always)]
    pub(super) fn primary<L: Lanes<Real = R>>(&self, s: L::Simd, x: L, y: L) -> Primary<L> {
        let u = x + x - L::splat(s, self.width);
        let v = L::splat(s, self.height) - (y + y);
        let offset = V3::splat(s, self.right) * u + V3::splat(s, self.up) * v;
        let (eye, forward) = (V3::splat(s, self.eye), V3::<L>::splat(s, self.forward));
        let seen = L::mask(s, u32::MAX);
        if self.parallel {
            Primary { origin: eye + offset, dir: forward, seen }
        } else {
            Primary { origin: eye, dir: (forward + offset).normalized(s), seen }
        }
    }
}

fn wide<R: Real>(v: [R; 3]) -> DVec3 {
    DVec3::from_array(v.map(Real::to_f64))
}
