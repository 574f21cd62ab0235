//! A thin lens: what lies off the plane in focus is blurred.

use super::{Basis, Primary};
use crate::lanes::{Lanes, Real, V3, circle};

/// A lens around the eye of a pinhole camera.
#[derive(Debug, Clone, Copy)]
pub struct Lens<R> {
    /// Radii of the lens.
    right: [R; 3],
    up: [R; 3],
    forward: [R; 3],
    /// Distance of the plane in focus, along the view.
    focus: R,
}

impl<R: Real> Lens<R> {
    pub(crate) fn new(basis: &Basis, radius: f64, focus: f64) -> Self {
        Self {
            right: (basis.right * radius).to_array().map(R::from_f64),
            up: (basis.up * radius).to_array().map(R::from_f64),
            forward: basis.forward.to_array().map(R::from_f64),
            focus: R::from_f64(focus),
        }
    }

    /// Rays from points of the lens, one for each (a, b) in the unit square, that meet the rays through the lens's middle in
    /// the plane in focus.
    #[inline(always)]
    pub fn bend<L: Lanes<Real = R>>(&self, s: L::Simd, primary: &Primary<L>, [a, b]: [L; 2]) -> Primary<L> {
        let [x, y] = circle(s, a);
        let reach = b.sqrt();
        let offset = V3::<L>::splat(s, self.right) * (x * reach) + V3::splat(s, self.up) * (y * reach);
        let along = primary.dir.dot(V3::splat(s, self.forward));
        let dir = primary.dir * (L::splat(s, self.focus) / along) - offset;
        Primary { origin: primary.origin + offset, dir: dir.normalized(s), ..*primary }
    }
}
