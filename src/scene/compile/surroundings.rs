//! What is around a scene: a colour, or a picture that may light surfaces.

use crate::math::Rgb;
use crate::scene::description::{self as d, Description};
use crate::scene::pictures::{Meaning, Pictures};
use crate::shading::surroundings::Surroundings;
use crate::shading::texture::environment::{Environment, clear_sky};
use crate::shading::texture::studio::studio;
use parking_lot::Mutex;
use std::sync::Arc;

/// What rays see that hit nothing: a colour, or a picture if it has more than one.
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

/// The light of surroundings: that of the scene that this one is a variation of, or of a studio that stood like this before, if it is
/// the same.
pub(super) fn surroundings(map: &Environment, before: Option<(&Environment, &Arc<Surroundings>)>) -> Arc<Surroundings> {
    /// Studios that are kept, at 0.4 MB each: views of models have names, so they stand in few ways.
    const STUDIOS: usize = 16;
    static KEPT: Mutex<Vec<(Environment, Arc<Surroundings>)>> = Mutex::new(Vec::new());
    let same = |other: &Environment| {
        Arc::ptr_eq(&other.mipmap, &map.mipmap) && other.turn == map.turn && other.intensity == map.intensity
    };
    if let Some((_, known)) = before.filter(|(other, _)| same(other)) {
        return Arc::clone(known);
    }
    if !Arc::ptr_eq(&map.mipmap, &studio()) {
        return Arc::new(Surroundings::new(map));
    }
    let known = KEPT.lock().iter().find(|(other, _)| same(other)).map(|(_, known)| Arc::clone(known));
    known.unwrap_or_else(|| {
        let made = Arc::new(Surroundings::new(map));
        let mut kept = KEPT.lock();
        if kept.len() == STUDIOS {
            kept.remove(0);
        }
        kept.push((map.clone(), Arc::clone(&made)));
        made
    })
}
