//! Lights on a model: those of its file, or the studio's key light.

use super::studio::surroundings;
use super::{LightChoice, ModelOptions};
use crate::math::{self, Rgb};
use crate::models::{Lamp, LampKind, Model, Subject, Warning};
use crate::scene::description::{
    AngularArea, Camera, Color, DirectionalLight, Environment, Falloff, Fidelity, Light, PointLight, SpotLight,
    WindowedFalloff,
};
use crate::scene::limits::{MAGNITUDE, SMALLEST_LENGTH};
use glam::DVec3;
use std::f64::consts::PI;

/// Intensity of the studio beside its key light: together white that faces the camera shows about 0.8 (code 231).
const BESIDE_KEY: f64 = 0.8;
/// Intensity of the key light.
const KEY: f64 = 0.5;
/// Intensity of the studio beside the lamps of a file, as a part of theirs if they are bright: more washes out their colors.
const BESIDE_LAMPS: f64 = 0.2;

/// Angle of the soft key light in degrees: a window, two of its widths away.
const SOFT: f64 = 15.0;

/// Most stops of the film. What is brighter is dimmed: nobody can tell.
const MOST_STOPS: f64 = 32.0;
/// What that many stops make white.
const BRIGHTEST: f64 = 4_294_967_296.0;

/// Drops lamps that are farther than scenes reach.
pub(super) fn drop_far(model: &mut Model) {
    let is_far = |lamp: &mut Lamp| {
        lamp.kind != LampKind::Directional && lamp.placed.w_axis.truncate().abs().max_element() > MAGNITUDE
    };
    if model.lamps.extract_if(.., is_far).count() > 0 {
        let detail = format!("lamps that are more than {MAGNITUDE:e} from the model are left out");
        warn(&mut model.warnings, Subject::Skipped, "far-lamps", detail);
    }
}

/// What lights a model.
pub(super) struct LitBy {
    pub(super) lights: Vec<Light>,
    pub(super) surroundings: Option<Environment>,
    /// Whether the key light is the studio's, which casts a shadow on the floor.
    pub(super) is_studio: bool,
    /// Stops of the film.
    pub(super) exposure: f64,
}

/// The lights of the scene. The radiance of a white surface is a light's illuminance divided by pi.
pub(super) fn lights(
    lamps: &[Lamp],
    options: &ModelOptions,
    camera: &Camera,
    fidelity: Fidelity,
    warnings: &mut Vec<Warning>,
) -> LitBy {
    let middle = DVec3::from_array(camera.view().look_at);
    let choice = options.light.unwrap_or_default();
    // Programs write lamps that are switched off, too.
    let has_lamps = lamps.iter().any(|lamp| strength(lamp) > 0.0);
    let own = choice != LightChoice::Studio && (has_lamps || choice == LightChoice::File);
    if !own {
        return LitBy {
            lights: vec![key(camera, fidelity)],
            surroundings: Some(surroundings(camera, BESIDE_KEY)),
            is_studio: true,
            exposure: 0.0,
        };
    }
    if !has_lamps {
        let detail = "light=file shines with the lamps of the file, which has none that shines: only what glows is seen; light=studio lights it";
        warn(warnings, Subject::Assumed, "no-lamps", detail.to_owned());
    }
    if lamps.iter().any(|lamp| matches!(lamp.kind, LampKind::Spot { .. })) {
        let detail = "the light of a spot falls to its edge along another curve than the file's";
        warn(warnings, Subject::Approximated, "spot-edge", detail.to_owned());
    }
    // Lamps are as bright as in the world: hundreds of candela, or a sun.
    let bright = brightness(lamps, middle);
    let strongest = lamps.iter().map(strength).fold(0.0, f64::max);
    let dimmed = (BRIGHTEST / bright).min(MAGNITUDE / strongest).min(1.0);
    let bright = bright * dimmed;
    let exposure = if bright > 1.0 { -math::log2(bright).min(MOST_STOPS) } else { 0.0 };
    let surroundings = (choice == LightChoice::Auto).then(|| surroundings(camera, BESIDE_LAMPS * bright.max(1.0)));
    LitBy { lights: lamps.iter().map(|lamp| light(lamp, dimmed)).collect(), surroundings, is_studio: false, exposure }
}

impl LitBy {
    /// Notes an exposure that nobody has asked for.
    pub(super) fn warn_of_exposure(&self, warnings: &mut Vec<Warning>) {
        if self.exposure < 0.0 {
            let stops = self.exposure;
            let detail =
                format!("the film is exposed by {stops:.1} stops, so that white in the middle of the model is white");
            warn(warnings, Subject::Assumed, "exposure", detail);
        }
    }
}

/// The radiance of white in the middle of the model, if it faces all lamps.
fn brightness(lamps: &[Lamp], middle: DVec3) -> f64 {
    let of = |lamp: &Lamp| {
        let squared = lamp.placed.w_axis.truncate().distance_squared(middle);
        let fades = if lamp.kind == LampKind::Directional { 1.0 } else { squared.max(1e-12) };
        strength(lamp) / fades
    };
    lamps.iter().map(of).sum::<f64>().min(f64::MAX)
}

/// The radiance of white that faces a lamp at a distance of 1.
fn strength(lamp: &Lamp) -> f64 {
    lamp.intensity * lamp.color.iter().copied().fold(0.0, f64::max) / PI
}

fn light(lamp: &Lamp, dimmed: f64) -> Light {
    let color = Color(Rgb::from_array(lamp.color));
    let intensity = lamp.intensity / PI * dimmed;
    // Programs write the largest number where there is no end.
    let range = lamp.range.filter(|range| *range < MAGNITUDE).map(|range| range.max(SMALLEST_LENGTH));
    let falloff = range.map_or(Falloff::InverseSquare, |range| Falloff::Windowed(WindowedFalloff { range }));
    let position = lamp.placed.w_axis.truncate().to_array();
    let along = lamp.placed.transform_vector3(DVec3::NEG_Z).try_normalize().unwrap_or(DVec3::NEG_Z);
    let direction = along.to_array();
    match lamp.kind {
        LampKind::Directional => Light::Directional(DirectionalLight { direction, color, intensity, area: None }),
        LampKind::Point => Light::Point(PointLight { position, color, intensity, falloff, area: None }),
        LampKind::Spot { inner, outer } => {
            let degrees = |angle: f64| (angle * 180.0 / PI).min(90.0);
            Light::Spot(SpotLight {
                position,
                direction,
                inner_deg: degrees(inner),
                outer_deg: degrees(outer),
                color,
                intensity,
                falloff,
                area: None,
            })
        }
    }
}

/// A light from the upper left of the camera, as much from its side as from above: tops are lit by the studio. It is soft where each
/// sample chooses a point of it anyway.
fn key(camera: &Camera, fidelity: Fidelity) -> Light {
    let view = camera.view();
    let [eye, look_at, up] = [view.eye, view.look_at, view.up].map(DVec3::from_array);
    let back = (eye - look_at).try_normalize().unwrap_or(DVec3::Z);
    let right = up.cross(back).try_normalize().unwrap_or(DVec3::X);
    let over = back.cross(right);
    let to_light = -0.5 * right + 0.7 * over + 0.7 * back;
    let direction = (-to_light).to_array();
    let area = (fidelity == Fidelity::Faithful).then_some(AngularArea { angle_deg: SOFT });
    Light::Directional(DirectionalLight { direction, color: Color::WHITE, intensity: KEY, area })
}

fn warn(warnings: &mut Vec<Warning>, subject: Subject, what: &'static str, detail: String) {
    warnings.push(Warning { subject, what, detail, pointer: String::new() });
}
