//! Mirror direction, Snell's law and Fresnel's reflectance, in forms that do not cancel.

use crate::lanes::{Lanes, Mask, V3};

/// Mirror direction r = d - 2 (d.n) n of a unit direction at a unit normal of either sign.
#[inline(always)]
pub fn reflect<L: Lanes>(s: L::Simd, d: V3<L>, n: V3<L>) -> V3<L> {
    d - n * (L::lit(s, 2.0) * d.dot(n))
}

/// A refracted ray by Snell's law.
#[derive(Debug, Clone, Copy)]
pub struct Refraction<L: Lanes> {
    /// Unit transmitted direction; meaningless under total internal reflection.
    pub dir: V3<L>,
    /// sin(theta1).
    pub sin_incident: L,
    /// cos(theta1), the angle of incidence.
    pub cos_incident: L,
    /// cos(theta2), the angle of refraction; 0 under total internal reflection.
    pub cos_transmitted: L,
    /// Total internal reflection: sin(theta1) >= n2/n1.
    pub total: L::Mask,
}

impl<L: Lanes> Refraction<L> {
    /// `a` where the mask is true, `b` elsewhere.
    #[inline(always)]
    pub fn select(s: L::Simd, mask: L::Mask, a: &Self, b: &Self) -> Self {
        let total = (mask.bits() & a.total.bits()) | (!mask.bits() & b.total.bits());
        Self {
            dir: V3::select(mask, a.dir, b.dir),
            sin_incident: L::select(mask, a.sin_incident, b.sin_incident),
            cos_incident: L::select(mask, a.cos_incident, b.cos_incident),
            cos_transmitted: L::select(mask, a.cos_transmitted, b.cos_transmitted),
            total: L::mask(s, total),
        }
    }
}

/// Snell's law, n1 sin(theta1) = n2 sin(theta2), for unit d and unit n with d.n < 0, and eta = n1/n2.
///
/// t = eta d + (eta c1 - c2) n, where the difference is written (eta^2 - 1)/(eta c1 + c2): a ray through a surface
/// between equal media keeps its direction exactly. sin^2(theta1) = |d x n|^2 keeps its digits near normal incidence.
#[inline(always)]
pub fn refract<L: Lanes>(s: L::Simd, d: V3<L>, n: V3<L>, eta: L) -> Refraction<L> {
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let c1 = -d.dot(n);
    let across = d.cross(n);
    let sin_squared = across.dot(across);
    let radicand = one - eta * eta * sin_squared;
    // At the critical angle all light is reflected; equal media have no critical angle.
    let total = radicand.le(zero) & !eta.eq(one);
    let c2 = radicand.max(zero).sqrt();
    let bend = (eta - one) * (eta + one) / (eta * c1 + c2);
    // Equal media at grazing incidence: 0/0, where the ray keeps its direction.
    let bend = L::select(eta.eq(one), zero, bend);
    Refraction {
        dir: d * eta + n * bend,
        sin_incident: sin_squared.sqrt(),
        cos_incident: c1,
        cos_transmitted: c2,
        total,
    }
}

/// Unpolarised Fresnel reflectance between dielectrics, eta = n1/n2; 1 under total internal reflection.
///
/// r_s = (n1 c1 - n2 c2)/(n1 c1 + n2 c2) is written (eta^2 - 1)/(eta c1 + c2)^2 and
/// r_p = r_s (s1 s2 - c1 c2)/(s1 s2 + c1 c2), which is 0 at Brewster's angle.
#[inline(always)]
pub fn fresnel_dielectric<L: Lanes>(s: L::Simd, eta: L, refraction: &Refraction<L>) -> L {
    let one = L::lit(s, 1.0);
    let (c1, c2) = (refraction.cos_incident, refraction.cos_transmitted);
    let sum = eta * c1 + c2;
    let rs = (eta - one) * (eta + one) / (sum * sum);
    let sin_squared = (one - c1) * (one + c1);
    let (sines, cosines) = (eta * sin_squared, c1 * c2);
    let rp = rs * ((sines - cosines) / (sines + cosines));
    let reflectance = (rs * rs + rp * rp) * L::lit(s, 0.5);
    L::select(refraction.total, one, reflectance.min(one))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(degrees: f64) -> V3<f64> {
        let (sin, cos) = crate::math::sin_cos(degrees.to_radians());
        V3 { x: sin, y: -cos, z: 0.0 }
    }

    const UP: V3<f64> = V3 { x: 0.0, y: 1.0, z: 0.0 };

    #[test]
    fn mirror_keeps_the_angle() {
        let r = reflect((), at(30.0), UP);
        assert!((r.x - 0.5).abs() < 1e-15 && (r.y - 0.75f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn snell_holds_in_both_directions() {
        for (n1, n2) in [(1.0, 1.5), (1.33, 1.0), (1.0, 2.4), (1.5, 1.33)] {
            for degrees in [0.0, 1e-6, 10.0, 40.0] {
                let d = at(degrees);
                let t = refract((), d, UP, n1 / n2);
                assert!(!t.total);
                assert!((n1 * d.x - n2 * t.dir.x).abs() < 1e-15);
                assert!((t.dir.dot(t.dir) - 1.0).abs() < 1e-15);
                let back = refract((), -t.dir, -UP, n2 / n1);
                assert!((back.dir.x + d.x).abs() < 1e-14 && (back.dir.y + d.y).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn total_reflection_begins_beyond_the_critical_angle() {
        let critical = crate::math::asin(1.0 / 1.5).to_degrees();
        assert!(!refract((), at(critical - 1e-6), UP, 1.5).total);
        assert!(refract((), at(critical + 1e-6), UP, 1.5).total);
        assert!(!refract((), at(89.999), UP, 1.0 / 1.5).total, "never into the denser medium");
    }

    #[test]
    fn equal_media_do_not_bend_at_any_angle() {
        for degrees in [0.0, 45.0, 89.999_999, 90.0] {
            let d = at(degrees);
            let t = refract((), d, UP, 1.0);
            assert!(t.dir.x == d.x && t.dir.y == d.y);
            assert!(!t.total);
        }
    }

    #[test]
    fn fresnel_at_normal_incidence_and_brewster() {
        let r = |degrees: f64, eta: f64| fresnel_dielectric((), eta, &refract((), at(degrees), UP, eta));
        assert!((r(0.0, 1.0 / 1.5) - 0.04).abs() < 1e-15);
        assert!((r(0.0, 1.5) - 0.04).abs() < 1e-15);
        // At Brewster's angle only r_s is left: R = r_s^2 / 2 = ((n^2-1)/(n^2+1))^2 / 2.
        let brewster = crate::math::atan(1.5).to_degrees();
        let expected = (1.25f64 / 3.25).powi(2) / 2.0;
        assert!((r(brewster, 1.0 / 1.5) - expected).abs() < 1e-14);
        assert_eq!(r(60.0, 1.5), 1.0);
    }
}
