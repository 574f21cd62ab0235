//! Torus: a quartic, solved in f64.
//!
//! Lengths are divided by the major radius and the origin is moved to where the ray enters the bounding sphere, so the
//! quartic's coefficients are of order 1 from any distance. The quartic only says where the ray's distance to the tube
//! turns; roots are sign changes of the factored form g = (sqrt(x^2+y^2) - 1)^2 + z^2 - r^2, which does not cancel.
//! A tangent ray therefore meets the torus twice or not at all.

use super::quartic::{Curve, SignChanges, turns};
use super::{Frame, Sides};
use crate::lanes::{Column, Columns, Double, Lanes, MAX_LANES, Mask, Real, V3, parts};
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
        let frame = self.frame.splat(s);
        let (o, d) = (frame.point_in(rays.origin), frame.vector_in(rays.dir));
        let (origins, dirs) = (Columns::of(o), Columns::of(d));
        let (starts, ends) = (Column::of(rays.t_min), Column::of(rays.t_max));
        let (mut hit, mut roots) = (0, Column::of(L::lit(s, f64::INFINITY)));
        for (first, lanes) in parts::<L>(rays.active.bits()) {
            let (o, d) = (origins.part::<L::Double>(s, first), dirs.part(s, first));
            let range = [starts.part(s, first), ends.part(s, first)];
            let (t, found) = self.first_roots(s, o, d, range, sides, L::Double::mask(s, lanes));
            roots.put(s, first, found, t);
            hit |= found.bits() << first;
        }
        let t: L = roots.lanes(s);

        // Back onto the tube: towards the nearest point of the circle, at the minor radius.
        let p = o + d * t;
        let (major, minor) = (L::splat(s, self.major_radius), L::splat(s, self.minor_radius));
        let rho = (p.x * p.x + p.y * p.y).sqrt();
        let ring = V3 { x: p.x / rho * major, y: p.y / rho * major, z: L::lit(s, 0.0) };
        let tube = p - ring;
        let normal = tube * (minor / tube.length());
        let (point, mut error) = frame.point_out(s, ring + normal);
        let own = (major + minor) * L::lit(s, gamma::<R>(8.0));
        error = error + V3 { x: own, y: own, z: own };
        Intersection::at(t, rays.active & L::mask(s, hit), point, error, frame.vector_out(normal))
    }

    /// The nearest roots in range, as numbers of this format, in the lanes that have one.
    fn first_roots<W: Double>(
        &self,
        s: W::Simd,
        o: V3<W>,
        d: V3<W>,
        range: [W; 2],
        sides: Sides,
        active: W::Mask,
    ) -> (W, W::Mask) {
        W::vectorize(
            s,
            #[inline(always)]
            || self.first_roots_in(s, o, d, range, sides, active),
        )
    }

    #[inline(always)]
    fn first_roots_in<W: Double>(
        &self,
        s: W::Simd,
        o: V3<W>,
        d: V3<W>,
        [t_min, t_max]: [W; 2],
        sides: Sides,
        active: W::Mask,
    ) -> (W, W::Mask) {
        let (zero, one, infinity) = (W::lit(s, 0.0), W::lit(s, 1.0), W::lit(s, f64::INFINITY));
        let radius = self.minor_radius.to_f64() / self.major_radius.to_f64();
        let (major, r) = (W::lit(s, self.major_radius.to_f64()), W::lit(s, radius));
        let o = over(o, major);
        // x is the length along the unit direction, in major radii; t = x / speed.
        let length = d.length();
        let (speed, dir) = (length / major, over(d, length));

        let middle = -o.dot(dir);
        let closest = o + dir * middle;
        let half_chord = W::lit(s, (1.0 + radius) * (1.0 + radius) * (1.0 + 1e-9)) - closest.dot(closest);
        let active = active & half_chord.ge(zero);
        let half_chord = half_chord.sqrt();
        let (low, high) = ((t_min * speed - middle).max(-half_chord), half_chord);
        let active = active & low.lt(high);
        if !active.any() {
            return (infinity, active);
        }

        // (p.p + 1 - r^2)^2 - 4 (x^2 + y^2) along p = closest + x dir, where closest.dir = 0: x^4 + a x^2 + b x + c.
        let k = closest.dot(closest) + one - r * r;
        let along = closest.x * dir.x + closest.y * dir.y;
        let lean = dir.x * dir.x + dir.y * dir.y;
        let a = W::lit(s, 2.0) * k - W::lit(s, 4.0) * lean;
        let turns = turns(s, a, W::lit(s, -8.0) * along, low, high, active);

        // A ray that starts within a few roundings of the tube does not meet it there. Rays that leave it start further
        // off, so this does not affect them.
        let noise = W::lit(s, 8.0 * f64::EPSILON * radius);
        let tube = Tube { closest, dir, r, one };
        let mut changes = SignChanges::new(&tube, low, high, noise);
        let (mut nearest, mut left) = (infinity, active);
        for section in 0..4 {
            let x = changes.next(s, &tube, if section < 3 { turns[section] } else { high }, left);
            let t = rounded::<W, R>(s, (x + middle) / speed);
            let seen = match sides {
                Sides::Both => left,
                Sides::Outside => left & tube.slope(x).le(zero),
                Sides::Inside => left & tube.slope(x).ge(zero),
            };
            let found = seen & t.gt(t_min) & t.lt(t_max);
            nearest = W::select(found, t, nearest);
            left = left & !found;
            if !left.any() {
                break;
            }
        }
        (nearest, active & !left)
    }
}

#[inline(always)]
fn over<W: Double>(v: V3<W>, k: W) -> V3<W> {
    V3 { x: v.x / k, y: v.y / k, z: v.z / k }
}

/// The nearest numbers of another format.
#[inline(always)]
fn rounded<W: Double, R: Real>(s: W::Simd, x: W) -> W {
    let mut numbers = [0.0; MAX_LANES];
    x.store(&mut numbers);
    for x in numbers.iter_mut().take(W::COUNT) {
        *x = R::from_f64(*x).to_f64();
    }
    W::load(s, &numbers)
}

/// g along rays, in major radii.
struct Tube<W> {
    closest: V3<W>,
    dir: V3<W>,
    r: W,
    one: W,
}

impl<W: Double> Curve<W> for Tube<W> {
    #[inline(always)]
    fn at(&self, x: W) -> W {
        let p = self.closest + self.dir * x;
        let beyond = (p.x * p.x + p.y * p.y).sqrt() - self.one;
        (beyond - self.r) * (beyond + self.r) + p.z * p.z
    }

    #[inline(always)]
    fn slope(&self, x: W) -> W {
        let p = self.closest + self.dir * x;
        let rho = (p.x * p.x + p.y * p.y).sqrt();
        let half = (rho - self.one) * (p.x * self.dir.x + p.y * self.dir.y) / rho + p.z * self.dir.z;
        half + half
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, Simd, f64x8};
    use glam::DVec3;

    #[inline(always)]
    fn compare<S: Simd>(s: S) {
        let number = |i: usize, k: f64| crate::math::sin_cos((i as f64 + 1.0) * k).0;
        let mut hits = 0;
        for i in 0..6_000 {
            let minor_radius = [0.01, 0.3, 0.99][i % 3] as f32;
            let torus = Torus { frame: Frame::new(DVec3::ZERO, DVec3::Z), major_radius: 1.0f32, minor_radius };
            let sides = [Sides::Both, Sides::Outside, Sides::Inside][i / 3 % 3];
            let reach = [0.7, 2.0, 1e4][i / 9 % 3];
            let ray = |lane: usize| {
                let at = |k: f64| number(8 * i + lane, k);
                let origin = DVec3::new(at(1.7), at(2.3), at(3.1)) * reach;
                let towards = DVec3::new(at(5.3), at(7.9), 0.3 * at(4.7));
                // Some lie in the plane of the circle, where two turns meet.
                let flat = if lane == 7 { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
                [(origin * flat).to_array(), ((towards - origin) * flat).to_array()]
            };
            let (o, d) = (V3::<f64x8<S>>::from_fn(s, |lane| ray(lane)[0]), V3::from_fn(s, |lane| ray(lane)[1]));
            let range = [0.0, 1.1].map(|t| <f64x8<S> as Lanes>::splat(s, t));
            let (t, found) = torus.first_roots(s, o, d, range, sides, <f64x8<S> as Lanes>::mask(s, 0xff));
            for lane in 0..8 {
                let [o, d] = ray(lane);
                let expected = torus.slow_root(o, d, (0.0, 1.1), sides);
                let got = (found.bits() >> lane & 1 != 0).then(|| t.lane(lane) as f32);
                assert_eq!(got, expected, "{minor_radius} {sides:?} {o:?} {d:?}");
                hits += usize::from(got.is_some());
            }
        }
        assert!(hits > 12_000, "{hits}");
    }

    #[test]
    fn lanes_agree_with_the_slow_one_to_the_bit() {
        let best = Level::new();
        fearless_simd::dispatch!(best, s => compare(s));
        #[cfg(target_arch = "x86_64")]
        if let Some(lower) = best.as_avx2() {
            fearless_simd::dispatch!(Level::Avx2(lower), s => compare(s));
        }
    }
}
