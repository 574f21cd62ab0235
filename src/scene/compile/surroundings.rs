//! What is around a scene: a color, or a picture that may light surfaces.

use crate::math::Rgb;
use crate::scene::description::{self as d, Description};
use crate::scene::picture_decoding::Meaning;
use crate::scene::pictures::Pictures;
use crate::shading::material::Material;
use crate::shading::pbr::Channel;
use crate::shading::surroundings::Surroundings;
use crate::shading::texture::environment::{Environment, clear_sky};
use crate::shading::texture::studio::studio;
use parking_lot::Mutex;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// What rays see that hit nothing: a color, or a picture if it has more than one.
pub(super) fn seen_around(description: &Description, pictures: &Pictures) -> (Rgb, Option<Environment>) {
    let Some(d::Environment { image, sky, studio: _, rotate_deg, intensity, light: _ }) = &description.environment
    else {
        return (description.background.0, None);
    };
    let mipmap = match (image, sky) {
        (Some(image), _) => pictures.get(image, Meaning::Radiance),
        (None, Some(sky)) => Arc::new(clear_sky(sky.zenith.0, sky.horizon.0, sky.ground.0)),
        (None, None) => studio(),
    };
    let uniform = if *intensity == 0.0 { Some([0.0; 3]) } else { mipmap.uniform() };
    match uniform {
        Some(color) => (Rgb::from_array(color) * *intensity, None),
        None => {
            let environment = Environment { mipmap, turn: rotate_deg / 360.0, intensity: *intensity };
            (description.background.0, Some(environment))
        }
    }
}

/// The roughnesses of surfaces that see surroundings. Texels are up to 1.
fn roughnesses<R>(materials: &[Material<R>]) -> Vec<RangeInclusive<f64>> {
    let of = |channel: &Channel<f64>| match channel.texel {
        Some(_) => 0.0..=channel.factor,
        None => channel.factor..=channel.factor,
    };
    let lit =
        materials.iter().filter_map(|material| material.pbr.as_ref()).filter(|pbr| !pbr.unlit && !pbr.catches_shadows);
    lit.flat_map(|pbr| {
        let clearcoat = (pbr.clearcoat.factor > 0.0).then(|| of(&pbr.clearcoat_roughness));
        [of(&pbr.roughness)].into_iter().chain(clearcoat)
    })
    .collect()
}

/// The light of surroundings: that of the scene that this one is a variation of, or of a studio that stood like this before, if it is
/// the same.
pub(super) fn surroundings<R>(
    map: &Environment,
    materials: &[Material<R>],
    before: Option<(&Environment, &Arc<Surroundings>)>,
) -> Arc<Surroundings> {
    /// Studios that are kept, at 1.5 MB each: views of models have names, so they stand in few ways.
    const STUDIOS: usize = 16;
    static KEPT: Mutex<Vec<(Environment, Arc<Surroundings>)>> = Mutex::new(Vec::new());
    let same = |other: &Environment| {
        Arc::ptr_eq(&other.mipmap, &map.mipmap) && other.turn == map.turn && other.intensity == map.intensity
    };
    let seen = roughnesses(materials);
    let before = before.filter(|(other, _)| same(other)).map(|(_, known)| Arc::clone(known));
    let is_studio = Arc::ptr_eq(&map.mipmap, &studio());
    let kept = || KEPT.lock().iter().find(|(other, _)| same(other)).map(|(_, known)| Arc::clone(known));
    if let Some(known) = before.or_else(|| kept().filter(|_| is_studio)) {
        known.prepare(&seen);
        return known;
    }
    let made = Arc::new(Surroundings::new(map, &seen));
    if is_studio {
        let mut kept = KEPT.lock();
        if kept.len() == STUDIOS {
            kept.remove(0);
        }
        kept.push((map.clone(), Arc::clone(&made)));
    }
    made
}
