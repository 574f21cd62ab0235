//! Affine maps between coordinate systems: points, directions, normals and errors.

use crate::lanes::{Lanes, Real, V3};
use glam::{DAffine3, DMat3, DVec3};

/// An affine map: columns of the linear part, and the image of the origin.
#[derive(Debug, Clone, Copy)]
pub struct Placement<R> {
    /// Columns of the 3 x 3 part.
    pub columns: [[R; 3]; 3],
    /// Translation.
    pub translation: [R; 3],
}

impl<R: Real> Placement<R> {
    /// Factor on volumes.
    pub(super) fn volume_scale(&self) -> f64 {
        let [x, y, z] = self.columns.map(|column| DVec3::from_array(column.map(Real::to_f64)));
        x.cross(y).dot(z).abs()
    }

    /// The map in this format.
    pub fn new(map: DAffine3) -> Self {
        let narrow = |v: DVec3| v.to_array().map(R::from_f64);
        let DMat3 { x_axis, y_axis, z_axis } = map.matrix3;
        Self { columns: [narrow(x_axis), narrow(y_axis), narrow(z_axis)], translation: narrow(map.translation) }
    }

    #[inline(always)]
    fn columns<L: Lanes<Real = R>>(&self, s: L::Simd) -> [V3<L>; 3] {
        let [x, y, z] = self.columns;
        [V3::splat(s, x), V3::splat(s, y), V3::splat(s, z)]
    }

    /// The image of a point.
    #[inline(always)]
    pub(super) fn point<L: Lanes<Real = R>>(&self, s: L::Simd, p: V3<L>) -> V3<L> {
        V3::splat(s, self.translation) + self.vector(s, p)
    }

    /// The image of a direction.
    #[inline(always)]
    pub(super) fn vector<L: Lanes<Real = R>>(&self, s: L::Simd, d: V3<L>) -> V3<L> {
        let [x, y, z] = self.columns(s);
        x * d.x + y * d.y + z * d.z
    }

    /// The transposed linear part, applied to a normal.
    #[inline(always)]
    pub(super) fn transposed<L: Lanes<Real = R>>(&self, s: L::Simd, n: V3<L>) -> V3<L> {
        let [x, y, z] = self.columns::<L>(s);
        V3 { x: x.dot(n), y: y.dot(n), z: z.dot(n) }
    }

    /// The linear part in 64 bits.
    pub(super) fn matrix(&self) -> DMat3 {
        let [x, y, z] = self.columns.map(|column| DVec3::from_array(column.map(Real::to_f64)));
        DMat3::from_cols(x, y, z)
    }

    /// Bound on how much the map lengthens any vector: the square root of the largest row sum of |M^T M|, which is exact
    /// for rotations with scale.
    pub fn largest_stretch(&self) -> f64 {
        let m = self.matrix();
        let gram = m.transpose() * m;
        let row = |i: usize| gram.row(i).abs().element_sum();
        row(0).max(row(1)).max(row(2)).sqrt()
    }

    /// The error bounds of a mapped point: the map's absolute values times the point's error bounds.
    #[inline(always)]
    pub(super) fn spread<L: Lanes<Real = R>>(&self, s: L::Simd, e: V3<L>) -> V3<L> {
        let [x, y, z] = self.columns::<L>(s);
        x.abs() * e.x + y.abs() * e.y + z.abs() * e.z
    }
}
