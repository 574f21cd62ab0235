//! Motion of placed geometries while the shutter is open, at a time of its own for each lane.
//!
//! A motion is an angle and a shift, which are interpolated, so turning bodies keep their shape. Rays are moved back to
//! where the body stood when the shutter opened, and surfaces are moved forth.

use super::extent::Extent;
use super::surface::Surface;
use crate::lanes::{Lanes, Real, V3, circle};
use crate::math;
use crate::ray::{Rays, gamma};
use glam::{DAffine3, DMat3, DVec3};

/// A steady motion, complete at time 1.
#[derive(Debug, Clone, Copy)]
pub struct Motion<R> {
    shift: [R; 3],
    turn: Option<Turn<R>>,
}

/// A rotation.
#[derive(Debug, Clone, Copy)]
struct Turn<R> {
    /// Unit vector.
    axis: [R; 3],
    /// A point of the axis.
    center: [R; 3],
    /// Its angle as a number of turns.
    turns: R,
}

/// Roundings of moving a point: 6 of its product with a rotation, 4 of the rotation's numbers, 4 of two sums.
const ROUNDINGS: f64 = 16.0;

/// Steps in which a motion is followed to bound where a body may be.
const STEPS: u32 = 32;

impl<R: Real> Motion<R> {
    /// A rotation by `degrees` around the unit vector `axis` through `center`, followed by a shift.
    pub fn new(shift: DVec3, axis: DVec3, degrees: f64, center: DVec3) -> Self {
        let narrow = |v: DVec3| v.to_array().map(R::from_f64);
        let turn = Turn { axis: narrow(axis), center: narrow(center), turns: R::from_f64(degrees / 360.0) };
        Self { shift: narrow(shift), turn: (degrees != 0.0).then_some(turn) }
    }

    /// The pose at each lane's time.
    #[inline(always)]
    fn pose<L: Lanes<Real = R>>(&self, s: L::Simd, time: L) -> Pose<L> {
        let shift = V3::<L>::splat(s, self.shift) * time;
        let Some(turn) = &self.turn else { return Pose { shift, turned: None } };
        let turns = time * L::splat(s, turn.turns);
        let [cos, sin] = circle(s, turns - turns.floor());
        let (axis, center) = (V3::splat(s, turn.axis), V3::splat(s, turn.center));
        Pose { shift, turned: Some(Turned { axis, center, cos, sin }) }
    }

    /// Directions of the body at time 0 as they are at each lane's time.
    pub(super) fn directions_forth<L: Lanes>(&self, s: L::Simd, d: V3<L>, time: L) -> V3<L> {
        self.directions(s, d, time, 1.0)
    }

    /// Directions at each lane's time as those of the body at time 0.
    pub(super) fn directions_back<L: Lanes>(&self, s: L::Simd, d: V3<L>, time: L) -> V3<L> {
        self.directions(s, d, time, -1.0)
    }

    /// In lanes of any precision, which need not be that of the motion.
    fn directions<L: Lanes>(&self, s: L::Simd, d: V3<L>, time: L, sign: f64) -> V3<L> {
        let Some(turn) = &self.turn else { return d };
        L::vectorize(
            s,
            #[inline(always)]
            || {
                let turns = time * L::lit(s, turn.turns.to_f64());
                let [cos, sin] = circle(s, turns - turns.floor());
                let [x, y, z] = turn.axis.map(Real::to_f64);
                let axis = V3 { x: L::lit(s, x), y: L::lit(s, y), z: L::lit(s, z) };
                let turned = Turned { axis, center: axis, cos, sin };
                turned.vector(s, d, sin * L::lit(s, sign))
            },
        )
    }

    /// The map at a time.
    fn map(&self, time: f64) -> DAffine3 {
        let wide = |v: [R; 3]| DVec3::from_array(v.map(Real::to_f64));
        let shift = DAffine3::from_translation(wide(self.shift) * time);
        let Some(turn) = &self.turn else { return shift };
        let (sin, cos) = math::sin_cos(time * turn.turns.to_f64() * std::f64::consts::TAU);
        let axis = wide(turn.axis);
        let rotated = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
        let matrix3 = DMat3::from_cols(rotated(DVec3::X), rotated(DVec3::Y), rotated(DVec3::Z));
        let center = wide(turn.center);
        shift * DAffine3 { matrix3, translation: center - matrix3 * center }
    }

    /// The extent of a moving body over all times.
    pub fn swept(&self, extent: &Extent) -> Extent {
        let wide = |v: [R; 3]| DVec3::from_array(v.map(Real::to_f64));
        // A point moves by at most half a step's arc and shift from where it is in the middle of the step.
        let arm = self.turn.as_ref().map_or(0.0, |turn| {
            let reach = extent.center.distance(wide(turn.center)) + extent.radius;
            turn.turns.to_f64().abs() * std::f64::consts::TAU * reach
        });
        let slack = 0.5 / f64::from(STEPS) * (arm + wide(self.shift).length()) * (1.0 + 1e-9)
            + 64.0 * R::ROUNDOFF * (extent.center.length() + extent.radius + arm + wide(self.shift).length());
        let middles = (0..STEPS).map(|step| self.map((f64::from(step) + 0.5) / f64::from(STEPS)));
        let mut swept = Extent::EMPTY;
        for map in middles.clone() {
            let corners = extent.bounds.corners().map(|corner| map.transform_point3(corner));
            swept.bounds = swept.bounds.union(super::bounds::Bounds::around(corners).grown(slack));
        }
        let centers: Vec<DVec3> = middles.map(|map| map.transform_point3(extent.center)).collect();
        swept.center = centers.iter().sum::<DVec3>() / f64::from(STEPS);
        let farthest = centers.iter().map(|center| center.distance(swept.center)).fold(0.0, f64::max);
        swept.radius = farthest + extent.radius + slack;
        swept
    }

    /// Rays in the coordinates of the body at time 0.
    pub(super) fn back<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, time: L) -> Rays<L> {
        L::vectorize(
            s,
            #[inline(always)]
            || self.back_in(s, rays, time),
        )
    }

    #[inline(always)]
    fn back_in<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, time: L) -> Rays<L> {
        let pose = self.pose(s, time);
        let origin = rays.origin - pose.shift;
        match &pose.turned {
            None => Rays { origin, ..*rays },
            Some(turned) => Rays {
                origin: turned.center + turned.vector(s, origin - turned.center, -turned.sin),
                dir: turned.vector(s, rays.dir, -turned.sin),
                ..*rays
            },
        }
    }

    /// A surface at each lane's time. Its error grows by the roundings of this move, and by those of moving the origin of the
    /// next ray back.
    pub(super) fn forth<L: Lanes<Real = R>>(&self, s: L::Simd, surface: Surface<L>, time: L) -> Surface<L> {
        L::vectorize(
            s,
            #[inline(always)]
            || self.forth_in(s, surface, time),
        )
    }

    #[inline(always)]
    fn forth_in<L: Lanes<Real = R>>(&self, s: L::Simd, surface: Surface<L>, time: L) -> Surface<L> {
        let pose = self.pose(s, time);
        let step = L::lit(s, 2.0 * gamma::<R>(ROUNDINGS));
        let Some(turned) = &pose.turned else {
            let point = surface.point + pose.shift;
            let size = surface.point.abs() + pose.shift.abs();
            return Surface { point, error: surface.error + size * step, ..surface };
        };
        let arm = surface.point - turned.center;
        let size = surface.point.abs() + turned.center.abs();
        let size = size.x.max(size.y).max(size.z);
        let even = |x: L| V3 { x, y: x, z: x };
        let error = surface.error;
        // A rotated box fits into the ball around it.
        let error = even(error.length() + size * step * L::lit(s, 3.0)) + pose.shift.abs() * step;
        Surface {
            point: turned.center + turned.vector(s, arm, turned.sin) + pose.shift,
            error,
            ng: turned.vector(s, surface.ng, turned.sin),
            ns: turned.vector(s, surface.ns, turned.sin),
            inwards: turned.vector(s, surface.inwards, turned.sin),
            lift: turned.vector(s, surface.lift, turned.sin),
            ..surface
        }
    }
}

/// A motion at each lane's time.
struct Pose<L: Lanes> {
    shift: V3<L>,
    turned: Option<Turned<L>>,
}

struct Turned<L: Lanes> {
    axis: V3<L>,
    center: V3<L>,
    cos: L,
    sin: L,
}

impl<L: Lanes> Turned<L> {
    /// Rodrigues' formula; the sine is negative for the rotation back.
    #[inline(always)]
    fn vector(&self, s: L::Simd, v: V3<L>, sin: L) -> V3<L> {
        let along = self.axis.dot(v) * (L::lit(s, 1.0) - self.cos);
        v * self.cos + self.axis.cross(v) * sin + self.axis * along
    }
}

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::*;

    #[test]
    fn the_way_stays_inside_what_it_sweeps() {
        let axis = DVec3::new(1.0, 2.0, -0.5).normalize();
        let bounds = Bounds::around([DVec3::new(1.0, 0.0, 2.0), DVec3::new(1.5, 0.7, 3.0)]);
        let extent = Extent::of_box(bounds);
        for (degrees, shift) in [(0.0, DVec3::X), (30.0, DVec3::ZERO), (-400.0, DVec3::new(3.0, -1.0, 0.0))] {
            let motion = Motion::<f64>::new(shift, axis, degrees, DVec3::new(0.3, 0.0, 0.0));
            let swept = motion.swept(&extent);
            for i in 0..=1000 {
                let map = motion.map(f64::from(i) / 1000.0);
                for corner in bounds.corners().map(|corner| map.transform_point3(corner)) {
                    assert!(corner.cmpge(swept.bounds.min).all() && corner.cmple(swept.bounds.max).all());
                    assert!(corner.distance(swept.center) <= swept.radius);
                }
            }
        }
    }

    #[test]
    fn rays_go_back_where_surfaces_go_forth() {
        let motion = Motion::<f64>::new(DVec3::new(0.1, 2.0, 0.0), DVec3::Y, 70.0, DVec3::new(1.0, 0.0, 0.0));
        let point = DVec3::new(0.4, -0.3, 0.9);
        for i in 0..=10 {
            let time = f64::from(i) / 10.0;
            let moved = motion.map(time).transform_point3(point).to_array();
            let origin = V3 { x: moved[0], y: moved[1], z: moved[2] };
            let rays = Rays { origin, dir: origin, t_min: 0.0, t_max: 1.0, active: true };
            let back = motion.back((), &rays, time).origin;
            assert!(DVec3::new(back.x, back.y, back.z).distance(point) < 1e-14);
        }
    }
}
