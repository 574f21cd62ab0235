//! Which effects beyond the lecture's model a scene calls for: what its kernel must hold.

/// The effects beyond the lecture's model that a world calls for, of bodies only those it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(missing_docs, reason = "the names say it")]
pub struct Called {
    pub absorption: bool,
    pub area_lights: bool,
    pub bleeding: bool,
    pub colored_shadows: bool,
    pub depth_of_field: bool,
    pub dispersion: bool,
    pub emission: bool,
    pub environment: bool,
    pub fog: bool,
    pub fresnel: bool,
    pub gloss: bool,
    pub motion: bool,
    /// Patterns beyond the checkerboard, bumps and normal maps.
    pub paint: bool,
}

impl Called {
    /// Whether any detail of surfaces, bodies or the space between them is called for.
    pub fn details(&self) -> bool {
        let Self { absorption, emission, environment, fog, fresnel, paint, .. } = *self;
        absorption | emission | environment | fog | fresnel | paint
    }

    /// Whether anything is a mean over choices.
    pub fn sampled(&self) -> bool {
        let Self { area_lights, bleeding, depth_of_field, dispersion, gloss, motion, .. } = *self;
        area_lights | bleeding | depth_of_field | dispersion | gloss | motion
    }
}
