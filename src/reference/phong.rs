//! Local illumination: Phong's model (CACM 18(6), 1975), lights and their falloff, checkerboards.

use crate::math::{self, Rgb};
use crate::scene::description::{Checker, Diffuse, Falloff, Light, Material, SpotLight};
use glam::DVec3;

/// Light that arrives at a point if nothing is in the way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Incident {
    /// Unit direction to the light.
    pub(super) to_light: DVec3,
    /// Distance of the light, maybe infinite.
    pub(super) distance: f64,
    pub(super) radiance: Rgb,
}

/// The light that a light source sends to `point`; none if it sends none.
pub(super) fn incident(light: &Light, point: DVec3) -> Option<Incident> {
    let incident = match light {
        Light::Directional(sun) => Incident {
            to_light: -DVec3::from(sun.direction).normalize(),
            distance: f64::INFINITY,
            radiance: sun.color.0 * sun.intensity,
        },
        Light::Point(lamp) => from_position(lamp.position.into(), lamp.color.0 * lamp.intensity, lamp.falloff, point)?,
        Light::Spot(spot) => {
            let lamp = from_position(spot.position.into(), spot.color.0 * spot.intensity, spot.falloff, point)?;
            Incident { radiance: lamp.radiance * cone_factor(spot, -lamp.to_light), ..lamp }
        }
    };
    (incident.radiance.max_element() > 0.0).then_some(incident)
}

fn from_position(position: DVec3, radiance: Rgb, falloff: Falloff, point: DVec3) -> Option<Incident> {
    let distance = position.distance(point);
    if distance == 0.0 {
        return None;
    }
    let factor = match falloff {
        Falloff::None => 1.0,
        Falloff::Linear(linear) => (1.0 - distance / linear.reach).max(0.0),
        Falloff::InverseSquare => 1.0 / (distance * distance),
        Falloff::Windowed(windowed) => (1.0 - (distance / windowed.range).powi(4)).max(0.0) / (distance * distance),
    };
    Some(Incident { to_light: (position - point) / distance, distance, radiance: radiance * factor })
}

/// 1 in the inner cone, 0 outside the outer one, between them 3 s^2 - 2 s^3 in the cosine.
fn cone_factor(spot: &SpotLight, from_light: DVec3) -> f64 {
    let cos = DVec3::from(spot.direction).normalize().dot(from_light);
    let (_, cos_inner) = math::sin_cos(spot.inner_deg.to_radians());
    let (_, cos_outer) = math::sin_cos(spot.outer_deg.to_radians());
    if cos < cos_outer {
        return 0.0;
    }
    if cos >= cos_inner {
        return 1.0;
    }
    let s = (cos - cos_outer) / (cos_inner - cos_outer);
    s * s * (3.0 - 2.0 * s)
}

/// (k_d (N.L) + k_s (R.V)^m) I for one light. `ns` is on the viewer's side, `to_viewer` is unit. A facet without
/// interpolated normals, `ng`, is dark where it faces away.
pub(super) fn phong(
    material: &Material,
    object_point: DVec3,
    ng: Option<DVec3>,
    ns: DVec3,
    to_viewer: DVec3,
    light: &Incident,
) -> Rgb {
    let n_dot_l = ns.dot(light.to_light);
    if n_dot_l <= 0.0 || ng.is_some_and(|ng| ng.dot(light.to_light) <= 0.0) {
        return Rgb::ZERO;
    }
    let mirrored = ns * (2.0 * n_dot_l) - light.to_light;
    let highlight = math::pow(mirrored.dot(to_viewer).max(0.0), material.shininess);
    (color(&material.diffuse, object_point) * n_dot_l + material.specular.0 * highlight) * light.radiance
}

/// k_a I_a.
pub(super) fn ambient(material: &Material, object_point: DVec3, ambient_light: Rgb) -> Rgb {
    color(material.ambient.as_ref().unwrap_or(&material.diffuse), object_point) * ambient_light
}

fn color(diffuse: &Diffuse, object_point: DVec3) -> Rgb {
    match diffuse {
        Diffuse::Uniform(color) => color.0,
        Diffuse::Checker(checker) => checker_color(checker, object_point),
        Diffuse::Gradient(gradient) => {
            let (from, to) = (DVec3::from_array(gradient.from), DVec3::from_array(gradient.to));
            let part = (object_point - from).dot(to - from) / (to - from).length_squared();
            gradient.a.0.lerp(gradient.b.0, part.clamp(0.0, 1.0))
        }
        Diffuse::Image(_) | Diffuse::Noise(_) => unreachable!("`Reference::knows` says so"),
    }
}

fn checker_color(checker: &Checker, object_point: DVec3) -> Rgb {
    let tiles = (object_point / checker.size).floor().to_array();
    let sum: f64 = tiles.iter().zip(checker.axes.flags()).filter(|(_, counts)| *counts).map(|(tile, _)| tile).sum();
    if sum.rem_euclid(2.0) == 0.0 { checker.a.0 } else { checker.b.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(json: &str) -> Light {
        serde_json::from_str(json).unwrap()
    }

    fn red(light: &Light, point: [f64; 3]) -> f64 {
        incident(light, point.into()).map_or(0.0, |incident| incident.radiance.x)
    }

    #[test]
    fn falloffs() {
        let none = light(r#"{ "point": { "position": [0, 0, 0], "intensity": 3 } }"#);
        let linear = light(r#"{ "point": { "position": [0, 0, 0], "falloff": { "linear": { "reach": 4 } } } }"#);
        let square = light(r#"{ "point": { "position": [0, 0, 0], "falloff": "inverse_square" } }"#);
        assert_eq!(red(&none, [9.0, 0.0, 0.0]), 3.0);
        assert_eq!(red(&linear, [0.0, 1.0, 0.0]), 0.75);
        assert_eq!(red(&linear, [0.0, 5.0, 0.0]), 0.0);
        assert_eq!(red(&square, [0.0, 0.0, 2.0]), 0.25);
        assert_eq!(red(&square, [0.0, 0.0, 0.0]), 0.0);
    }

    #[test]
    fn directional_light_travels_along_its_direction() {
        let sun = light(r#"{ "directional": { "direction": [0, -2, 0] } }"#);
        let incident = incident(&sun, DVec3::ZERO).unwrap();
        assert_eq!(incident.to_light, DVec3::Y);
        assert_eq!(incident.distance, f64::INFINITY);
    }

    #[test]
    fn spot_fades_between_its_cones() {
        let soft =
            light(r#"{ "spot": { "position": [0, 0, 0], "direction": [0, 0, -1], "inner_deg": 0, "outer_deg": 60 } }"#);
        assert_eq!(red(&soft, [0.0, 0.0, -1.0]), 1.0);
        assert_eq!(red(&soft, [2.0, 0.0, -1.0]), 0.0);
        // cos = 3/4 is half-way between cos 0 = 1 and cos 60 = 1/2.
        let half = red(&soft, [7f64.sqrt(), 0.0, -3.0]);
        assert!((half - 0.5).abs() < 1e-14, "{half}");

        let hard = light(
            r#"{ "spot": { "position": [0, 0, 0], "direction": [0, 0, -1], "inner_deg": 30, "outer_deg": 30 } }"#,
        );
        assert_eq!(red(&hard, [0.57, 0.0, -1.0]), 1.0);
        assert_eq!(red(&hard, [0.58, 0.0, -1.0]), 0.0);
    }

    #[test]
    fn phong_adds_diffuse_and_highlight() {
        let material: Material =
            serde_json::from_str(r#"{ "diffuse": 0.5, "specular": 0.25, "shininess": 2 }"#).unwrap();
        let diagonal = DVec3::new(1.0, 1.0, 0.0).normalize();
        let lamp = Incident { to_light: diagonal, distance: 1.0, radiance: Rgb::ONE };
        let lit = |viewer| phong(&material, DVec3::ZERO, Some(DVec3::Y), DVec3::Y, viewer, &lamp).x;
        let diffuse = 0.5 * 0.5f64.sqrt();
        assert!((lit(DVec3::Y) - (diffuse + 0.25 * 0.5)).abs() < 1e-15);
        assert!((lit(DVec3::new(-1.0, 1.0, 0.0).normalize()) - (diffuse + 0.25)).abs() < 1e-15);
        let behind = phong(&material, DVec3::ZERO, Some(DVec3::NEG_Y), DVec3::Y, DVec3::Y, &lamp);
        assert_eq!(behind, Rgb::ZERO);
    }

    #[test]
    fn checker_counts_the_named_axes() {
        let checker: Checker = serde_json::from_str(r#"{ "a": 1, "b": 0, "size": 2, "axes": "xz" }"#).unwrap();
        let tile = |x, y, z| checker_color(&checker, DVec3::new(x, y, z)).x;
        assert_eq!(tile(1.0, 5.0, 1.0), 1.0);
        assert_eq!(tile(-1.0, 5.0, 1.0), 0.0);
        assert_eq!(tile(-1.0, 7.0, -1.0), 1.0);
        assert_eq!(tile(3.0, 0.0, 0.5), 0.0);
    }
}
