//! Mirror, Snell's law, and the media a ray is in.

use super::world::{Container, Intersection, Path};
use crate::math::Rgb;
use glam::DVec3;

/// r = d - 2 (d.n) n.
pub(super) fn reflect(d: DVec3, n: DVec3) -> DVec3 {
    (d - n * (2.0 * d.dot(n))).normalize()
}

/// Direction of the refracted ray, with `n` on the side `d` comes from and eta = n1/n2; none under total internal
/// reflection, the critical angle included.
///
/// t = eta d + (eta c1 - c2) n with c1 = -d.n, c2 = sqrt(1 - eta^2 sin^2). The factor of n is written as
/// (eta^2 - 1) / (eta c1 + c2), which does not cancel: equal indices do not bend at all.
pub(super) fn refract(d: DVec3, n: DVec3, eta: f64) -> Option<DVec3> {
    if eta == 1.0 {
        return Some(d);
    }
    let c1 = -d.dot(n);
    let radicand = 1.0 - eta * eta * d.cross(n).length_squared();
    if radicand <= 0.0 {
        return None;
    }
    let bend = (eta * eta - 1.0) / (eta * c1 + radicand.sqrt());
    Some((d * eta + n * bend).normalize())
}

/// Fresnel's reflectance of unpolarised light from n1 to n2, at an angle of incidence given by its cosine.
pub(super) fn reflectance(cos1: f64, n1: f64, n2: f64) -> f64 {
    let sin2 = (1.0 - cos1 * cos1).max(0.0).sqrt() * n1 / n2;
    if sin2 >= 1.0 && n1 != n2 {
        return 1.0;
    }
    let cos2 = (1.0 - sin2 * sin2).max(0.0).sqrt();
    let perpendicular = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2);
    let parallel = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2);
    (perpendicular * perpendicular + parallel * parallel) / 2.0
}

/// The medium in one body.
#[derive(Debug, Clone, PartialEq)]
struct Medium {
    body: Path,
    ior: f64,
    absorption: Rgb,
    volume: f64,
}

/// The media a ray is in, in no order. Around all of them is empty space.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Media(Vec<Medium>);

impl Media {
    /// The media at the eye.
    pub(super) fn around_eye(containers: Vec<Container>) -> Self {
        let medium =
            |c: Container| Medium { body: c.path, ior: c.inner_ior, absorption: c.absorption, volume: c.volume };
        Self(containers.into_iter().map(medium).collect())
    }

    /// Where bodies overlap the smaller one decides, of equal ones the one written last.
    fn deciding(&self) -> Option<&Medium> {
        self.0.iter().min_by(|a, b| a.volume.total_cmp(&b.volume).then_with(|| b.body.cmp(&a.body)))
    }

    pub(super) fn ior(&self) -> f64 {
        self.deciding().map_or(1.0, |medium| medium.ior)
    }

    /// What a unit of length absorbs.
    pub(super) fn absorption(&self) -> Rgb {
        self.deciding().map_or(Rgb::ZERO, |medium| medium.absorption)
    }

    /// Whether the ray is outside all bodies.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A ray passes the surface of a body with `inner_ior`: n1, n2 and the media behind the surface.
    pub(super) fn pass(&self, intersection: &Intersection<'_>, inner_ior: f64) -> (f64, f64, Self) {
        let body = &intersection.path;
        let mut without = self.clone();
        without.0.retain(|medium| medium.body != *body);
        let mut with = without.clone();
        with.0.push(Medium {
            body: body.clone(),
            ior: inner_ior,
            absorption: intersection.body.inner_absorption(),
            volume: intersection.volume,
        });
        // A body left without having been entered counts as entered.
        if intersection.goes_in { (self.ior(), with.ior(), with) } else { (with.ior(), without.ior(), without) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refraction_obeys_snell() {
        let d = DVec3::new(0.8, -0.6, 0.0);
        let t = refract(d, DVec3::Y, 1.0 / 1.5).unwrap();
        assert!((t.x - 0.8 / 1.5).abs() < 1e-15 && t.y < 0.0, "{t}");
        assert_eq!(refract(d, DVec3::Y, 1.0), Some(d));
        let back = refract(-t, DVec3::NEG_Y, 1.5).unwrap();
        assert!(back.abs_diff_eq(-d, 1e-15), "{back}");
    }

    #[test]
    fn beyond_the_critical_angle_all_is_reflected() {
        let at = |degrees: f64| {
            let (sin, cos) = crate::math::sin_cos(degrees.to_radians());
            refract(DVec3::new(sin, -cos, 0.0), DVec3::Y, 1.5)
        };
        // asin(1 / 1.5) = 41.81 degrees.
        assert!(at(41.8).is_some());
        assert!(at(41.9).is_none());
    }

    #[test]
    fn reflection_keeps_the_angle() {
        assert_eq!(reflect(DVec3::new(0.8, -0.6, 0.0), DVec3::Y), DVec3::new(0.8, 0.6, 0.0));
    }

    #[test]
    fn the_smaller_body_decides() {
        let container = |i, inner_ior, volume| Container { path: vec![i], inner_ior, absorption: Rgb::ZERO, volume };
        let media = Media::around_eye(vec![container(0, 1.3, 2.0), container(1, 1.5, f64::INFINITY)]);
        assert_eq!(media.ior(), 1.3);
    }
}
