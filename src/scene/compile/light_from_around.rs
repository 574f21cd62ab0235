//! The light that comes from around a scene, and from what glows in it: which of it surfaces have without rays, and which rays
//! look for.

use super::emitters::emitters;
use super::pbr;
use super::surroundings::{seen_around, surroundings};
use crate::lanes::Real;
use crate::math::Rgb;
use crate::scene::description::{self as d, Description};
use crate::scene::pictures::Pictures;
use crate::scene::world::{World, shows};
use crate::shading::bright_directions::BrightDirections;
use crate::shading::emitters::Emitters;
use crate::shading::fog::Fog;
use crate::shading::material::Material;
use crate::shading::surroundings::Surroundings;
use crate::shading::texture::environment::Environment;
use std::sync::Arc;

/// What a world holds of it.
pub(super) struct LightFromAround {
    /// What rays see that hit nothing, where there is no environment.
    pub(super) background: Rgb,
    /// What they see instead.
    pub(super) environment: Option<Environment>,
    /// The environment, blurred: what surfaces have of it without rays.
    pub(super) surroundings: Option<Arc<Surroundings>>,
    /// Where rays look for the bright parts of the environment.
    pub(super) bright_directions: Option<Arc<BrightDirections>>,
    /// What rays look for of that which glows.
    pub(super) emitters: Option<Arc<Emitters>>,
    /// Light from all sides, without rays.
    pub(super) ambient: Rgb,
    /// The same of what catches shadows, which has no rays of its own.
    pub(super) ambient_of_catchers: Rgb,
}

impl LightFromAround {
    /// That of a checked description. `enclosed`: the eye is in a closed room. `known` is a world of the same objects.
    pub(super) fn new<R: Real>(
        description: &Description,
        pictures: &Pictures,
        materials: &[Material<R>],
        enclosed: bool,
        fog: Option<&Fog<R>>,
        known: Option<&World<R>>,
    ) -> Self {
        let (background, seen) = seen_around(description, pictures);
        // An environment of one color is ambient light, which rays bring with global illumination.
        let around = if seen.is_none() && !enclosed { background } else { Rgb::ZERO };
        let environment = seen.filter(|_| !enclosed);
        let global_illumination = pbr::wants_global_illumination(&description.render);
        let lights_surfaces = description.environment.as_ref().is_some_and(|e| e.light == d::EnvironmentLight::Fast);
        let catches = materials.iter().any(Material::catches_shadows);
        // Inside of bodies is no fog.
        let in_the_open = materials.iter().all(|m| !m.transmits() && !shows(m.absorption));
        let is_hidden = in_the_open && fog.is_some_and(|fog| fog.height.is_none());
        let without_rays = if global_illumination { catches && !is_hidden } else { lights_surfaces };
        let lit_before = known.and_then(|world| Some((world.environment.as_ref()?, world.surroundings.as_ref()?)));
        let surroundings =
            environment.as_ref().filter(|_| without_rays).map(|map| surroundings(map, materials, lit_before));
        // Fog hides the surroundings from rays, not the light that surfaces have without rays.
        let environment = environment.filter(|_| !is_hidden);
        // Fog would fade the light on its way.
        let looked_for = global_illumination && fog.is_none();
        let bright_directions =
            environment.as_ref().filter(|_| looked_for).map(|map| Arc::new(BrightDirections::new(map)));
        let emitters = looked_for.then(|| emitters(description, materials)).flatten().map(Arc::new);
        let ambient = match (global_illumination, lights_surfaces) {
            (true, _) => Rgb::ZERO,
            (false, true) => description.ambient.0 + around,
            (false, false) => description.ambient.0,
        };
        let ambient_of_catchers = if global_illumination { around } else { ambient };
        Self { background, environment, surroundings, bright_directions, emitters, ambient, ambient_of_catchers }
    }
}
