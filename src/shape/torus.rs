//! Torus: a quartic, solved in f64 lane by lane, since few rays reach it.
//!
//! Lengths are divided by the major radius and the origin is moved to where the ray enters the bounding sphere, so the
//! quartic's coefficients are of order 1 from any distance. The quartic only says where the ray's distance to the tube
//! turns; roots are sign changes of the factored form g = (sqrt(x^2+y^2) - 1)^2 + z^2 - r^2, which does not cancel.
//! A tangent ray therefore meets the torus twice or not at all.

use super::quartic::{sign_changes, turns};
use super::{Frame, Sides};
use crate::lanes::{Lanes, Mask, Real, V3, lanes_of};
use crate::ray::{Intersection, Rays, gamma};

/// All points at `minor_radius` from a circle of `major_radius` around the frame's axis.
#[derive(Debug, Clone, Copy)]
pub struct Torus<R> {
    /// Its origin is the centre, `w` the axis.
    pub frame: Frame<R>,
    /// Radius of the circle, above the minor radius.
    pub major_radius: R,
    /// Radius of the tube, above 0.
    pub minor_radius: R,
}

impl<R: Real> Torus<R> {
    /// Nearest intersection in range.
    #[inline(always)]
    pub fn intersect<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, sides: Sides) -> Intersection<L> {
        let o = self.frame.point_in(s, rays.origin);
        let d = self.frame.vector_in(s, rays.dir);
        let mut found = [None; crate::lanes::MAX_LANES];
        let mut hit = 0;
        for lane in lanes_of(rays.active.bits()) {
            let wide = |v: V3<L>| v.lane(lane).map(Real::to_f64);
            let range = (rays.t_min.lane(lane).to_f64(), rays.t_max.lane(lane).to_f64());
            found[lane] = self.first_root(wide(o), wide(d), range, sides);
            hit |= u32::from(found[lane].is_some()) << lane;
        }
        let t = L::from_fn(s, |lane| found[lane].unwrap_or(R::from_f64(f64::INFINITY)));

        // Back onto the tube: towards the nearest point of the circle, at the minor radius.
        let p = o + d * t;
        let (major, minor) = (L::splat(s, self.major_radius), L::splat(s, self.minor_radius));
        let rho = (p.x * p.x + p.y * p.y).sqrt();
        let ring = V3 { x: p.x / rho * major, y: p.y / rho * major, z: L::lit(s, 0.0) };
        let tube = p - ring;
        let normal = tube * (minor / tube.length());
        let (point, mut error) = self.frame.point_out(s, ring + normal);
        let own = (major + minor) * L::lit(s, gamma::<R>(8.0));
        error = error + V3 { x: own, y: own, z: own };
        Intersection::at(t, rays.active & L::mask(s, hit), point, error, self.frame.vector_out(s, normal))
    }

    fn first_root(&self, o: [f64; 3], d: [f64; 3], (t_min, t_max): (f64, f64), sides: Sides) -> Option<R> {
        let major = self.major_radius.to_f64();
        let r = self.minor_radius.to_f64() / major;
        let (o, d) = (glam::DVec3::from_array(o) / major, glam::DVec3::from_array(d));
        // x is the length along the unit direction, in major radii; t = x / speed.
        let speed = d.length() / major;
        let dir = d / d.length();

        let middle = -o.dot(dir);
        let closest = o + dir * middle;
        let half_chord = (1.0 + r) * (1.0 + r) * (1.0 + 1e-9) - closest.length_squared();
        if half_chord.is_nan() || half_chord < 0.0 {
            return None;
        }
        let half_chord = half_chord.sqrt();
        let (low, high) = ((t_min * speed - middle).max(-half_chord), half_chord);
        if low >= high {
            return None;
        }

        let g = |x: f64| {
            let p = closest + dir * x;
            let rho = p.x.hypot(p.y);
            (rho - 1.0 - r) * (rho - 1.0 + r) + p.z * p.z
        };
        let slope = |x: f64| {
            let p = closest + dir * x;
            let rho = p.x.hypot(p.y);
            2.0 * ((rho - 1.0) * (p.x * dir.x + p.y * dir.y) / rho + p.z * dir.z)
        };
        // (p.p + 1 - r^2)^2 - 4 (x^2 + y^2) along p = closest + x dir, where closest.dir = 0.
        let k = closest.length_squared() + 1.0 - r * r;
        let across = closest.x * closest.x + closest.y * closest.y;
        let along = closest.x * dir.x + closest.y * dir.y;
        let lean = dir.x * dir.x + dir.y * dir.y;
        let quartic = [k * k - 4.0 * across, -8.0 * along, 2.0 * k - 4.0 * lean, 0.0, 1.0];
        let bends = turns(quartic, low, high);

        // A ray that starts within a few roundings of the tube does not meet it there. Rays that leave it start further
        // off, so this does not affect them.
        let noise = 8.0 * f64::EPSILON * r;
        let roots = sign_changes(g, slope, bends.as_slice(), low, high, noise);
        roots.as_slice().iter().find_map(|&x| {
            let t = R::from_f64((x + middle) / speed);
            let seen = match sides {
                Sides::Both => true,
                Sides::Outside => slope(x) <= 0.0,
                Sides::Inside => slope(x) >= 0.0,
            };
            (seen && t.to_f64() > t_min && t.to_f64() < t_max).then_some(t)
        })
    }
}
