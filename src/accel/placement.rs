//! Rays, points, normals and errors from one coordinate system to another.

use super::geometry::{Ball, Instance, Placement, Shape};
use super::resolve::Owner;
use crate::lanes::{Lanes, Mask, Real, V3};
use crate::ray::Rays;
use glam::{DMat3, DVec3};

impl<R: Real> Placement<R> {
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
    fn matrix(&self) -> DMat3 {
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

    /// The image of a box of errors: absolute values throughout.
    #[inline(always)]
    pub(super) fn spread<L: Lanes<Real = R>>(&self, s: L::Simd, e: V3<L>) -> V3<L> {
        let [x, y, z] = self.columns::<L>(s);
        x.abs() * e.x + y.abs() * e.y + z.abs() * e.z
    }
}

impl<R: Real> Instance<R> {
    /// Rays in the coordinates of the instance's geometry, without those that pass by; t is multiplied by the unit.
    #[inline(always)]
    pub(super) fn rays_in<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, time: Option<&L>) -> Rays<L> {
        let active = match &self.ball {
            Some(ball) => rays.active & ball.near(s, rays),
            None => rays.active,
        };
        if !active.any() {
            return Rays { active, ..*rays };
        }
        let mut moved = *rays;
        if let (Some(motion), Some(time)) = (&self.motion, time) {
            moved = motion.back(s, rays, *time);
        }
        let rays = &moved;
        let unit = L::splat(s, self.unit);
        Rays {
            origin: self.to_local.point(s, rays.origin),
            dir: self.to_local.vector(s, rays.dir) * (L::lit(s, 1.0) / unit),
            t_min: rays.t_min * unit,
            t_max: rays.t_max * unit,
            active,
        }
    }
}

impl<R: Real> Ball<R> {
    /// The lanes whose line passes the ball: |(o - c) x d| <= r |d|, where each side may be off by roundings of |o - c|.
    #[inline(always)]
    fn near<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>) -> L::Mask {
        let f = rays.origin - V3::splat(s, self.center);
        let across = f.cross(rays.dir);
        let reach = L::splat(s, self.radius) + f.length() * L::lit(s, 16.0 * R::ROUNDOFF);
        across.dot(across).le(reach * reach * rays.dir.dot(rays.dir))
    }
}

impl<R: Real> Owner<'_, R> {
    /// The placements around the body, outermost first.
    fn placements(&self) -> impl DoubleEndedIterator<Item = &Instance<R>> {
        self.instances.iter().filter_map(|item| match &item.shape {
            Shape::Instance(instance) => Some(&**instance),
            _ => None,
        })
    }

    /// A direction of the scene in the body's own coordinates.
    pub fn into_object(&self, d: DVec3) -> DVec3 {
        self.placements().fold(d, |d, placed| placed.to_local.matrix() * d)
    }

    /// A normal of the scene in the body's own coordinates, unit again.
    pub fn normal_into_object(&self, n: DVec3) -> DVec3 {
        self.placements().fold(n, |n, placed| (placed.to_world.matrix().transpose() * n).normalize())
    }

    /// A unit normal of the body's own coordinates in those of the scene, unit again.
    pub fn normal_out_of_object(&self, n: DVec3) -> DVec3 {
        self.placements().rev().fold(n, |n, placed| (placed.to_local.matrix().transpose() * n).normalize())
    }
}
