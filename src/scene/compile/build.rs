//! A checked description in the kernel's format.

use super::camera::{camera_of, edges_of};
use super::ceiling::ceiling;
use super::effects::{casts_no_shadow, derive_flags, disperses};
use super::emitters::emitters;
use super::geometries::Builder;
use super::known::Known;
use super::lights::light;
use super::materials::narrow_rgb;
use super::pbr;
use super::surroundings::{seen_around, surroundings};
use super::{CompileOptions, Sources, contact, prune};
use crate::accel::{Blockers, Bounds};
use crate::bound::ceiling::Ceiling;
use crate::camera::Basis;
use crate::film::Display;
use crate::lanes::Real;
use crate::math::Rgb;
use crate::scene::description::{self as d, Description, Shadows};
use crate::scene::effects::{Effect, SceneEffects};
use crate::scene::light_cells::LightCells;
use crate::scene::pictures::Pictures;
use crate::scene::usage::{FAR_AWAY, Pointers, TINY};
use crate::scene::world::{Pruning, Rules, World, shows};
use crate::shading::bright_directions::BrightDirections;
use crate::shading::fog::{Fog, Height};
use crate::shading::light::Light;
use crate::shading::material::Material;
use crate::shading::spectrum::Spectrum;
use std::sync::Arc;

/// What building finds out besides the world.
pub(super) struct Built {
    pub(super) sources: Sources,
    pub(super) pointers: Pointers,
    pub(super) expanded: u128,
}

/// Builds the world of a checked description. `known` is a world of the same objects.
pub(super) fn build<R: Real>(
    description: &Description,
    options: CompileOptions,
    pictures: &Pictures,
    known: Option<&World<R>>,
) -> (World<R>, Built) {
    let basis = Basis::new(&description.camera.view()).unwrap_or_else(|| unreachable!("the camera has been checked"));
    let camera = camera_of(&description.camera, &basis, description.image.width, description.image.height);
    let lit_before = known.and_then(|world| Some((world.environment.as_ref()?, world.surroundings.as_ref()?)));
    let known = known.map(Known::new);
    let mut builder = Builder::<R>::new(description, options, pictures, camera, known);
    let list = builder.list("/objects".to_owned());
    let root = builder.geometry(&description.objects, list);
    contact::mark_placed(&mut builder.geometries);
    let expanded = builder.expanded[root];
    let bounds = builder.geometries[root].extent.bounds;
    let size = if bounds == Bounds::EMPTY { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
    let extent = (bounds.max - bounds.min).max_element();
    builder.usage.tiny = extent > 0.0 && extent < TINY;
    builder.usage.far_away = size > 0.0 && extent > 0.0 && size > FAR_AWAY * extent;
    let render = &description.render;
    let fog = description.fog.as_ref().map(fog).filter(|fog| fog.density > R::from_f64(0.0));
    let (background, mut environment) = seen_around(description, pictures);
    let is_uniform = environment.is_none();
    builder.usage.enclosed = builder.occluded.eye_is_enclosed;
    if builder.usage.enclosed {
        environment = None;
    }
    let lights_surfaces = description.environment.as_ref().is_some_and(|e| e.light == d::EnvironmentLight::Fast);
    let global_illumination = pbr::wants_global_illumination(render);
    let catches = builder.materials.iter().any(Material::catches_shadows);
    let fades = builder.materials.iter().any(|m| m.pbr.as_ref().is_some_and(|pbr| pbr.edge_fade > 0.0));
    // What catches shadows has no rays of its own for the light from around.
    // Inside of bodies is no fog.
    let in_the_open = builder.materials.iter().all(|m| !m.transmits() && !shows(m.absorption));
    let is_hidden = in_the_open && fog.as_ref().is_some_and(|fog| fog.height.is_none());
    let without_rays = if global_illumination { catches && !is_hidden } else { lights_surfaces };
    let surroundings =
        environment.as_ref().filter(|_| without_rays).map(|map| surroundings(map, &builder.materials, lit_before));
    // Fog hides the surroundings from rays, not the light that surfaces have without rays.
    if is_hidden {
        environment = None;
    }
    // Fog would fade the light on its way.
    let looked_for = global_illumination && fog.is_none();
    let bright = environment.as_ref().filter(|_| looked_for).map(|map| Arc::new(BrightDirections::new(map)));
    let emitters = looked_for.then(|| emitters(description, &builder.materials)).flatten().map(Arc::new);
    // One of one color is ambient light, which rays bring with global illumination.
    let around = if is_uniform && !builder.usage.enclosed { background } else { Rgb::ZERO };
    let ambient = match (global_illumination, lights_surfaces) {
        (true, _) => Rgb::ZERO,
        (false, true) => description.ambient.0 + around,
        (false, false) => description.ambient.0,
    };
    if let Some((materials, moves)) = builder.occluded.usage(&builder.geometries, builder.materials.len()) {
        (builder.usage.materials, builder.usage.moves) = (materials, moves);
    }
    let lights: Vec<Light<R>> = description.lights.iter().enumerate().map(light).collect();
    let mut world = World {
        geometries: match &builder.known {
            Some(known) => known.share(builder.geometries),
            None => builder.geometries.into(),
        },
        root,
        size: R::from_f64(size),
        usage: builder.usage,
        shared_eye: builder.shared_eye,
        spectrum: None,
        materials: builder.materials,
        lights,
        ambient: narrow_rgb(ambient),
        ambient_of_catchers: narrow_rgb(if global_illumination { around } else { ambient }),
        background: narrow_rgb(background),
        transparent: description.film.background != d::FilmBackground::Scene,
        behind: display(&description.film).radiance_behind().map(|color| color.map(R::from_f64)),
        display: display(&description.film),
        environment,
        surroundings,
        bright_directions: bright,
        emitters,
        fog,
        edges: if fades {
            edges_of(&description.camera, description.image.width, description.image.height)
        } else {
            None
        },
        camera,
        rules: Rules {
            max_depth: render.fixed_depth(),
            pruning: Pruning::of(render.accuracy(), render.fixed_weight()),
            shadows: match render.shadows {
                Shadows::Transmissive => Some(Blockers::Transmissive),
                Shadows::Opaque => Some(Blockers::Opaque),
                Shadows::None => None,
            },
            colors_shadows: render.shadows == Shadows::Transmissive,
            color_bleeding: render.color_bleeding && !global_illumination,
            global_illumination,
            filter_checkers: render.filter_checkers,
            spd_counts: options.spd_counts,
        },
        ceiling: Ceiling::unbounded(0, String::new(), Vec::new()),
        transmits: false,
        reflects: false,
        angular: false,
        branches: false,
        effects: SceneEffects::default(),
        light_cells: None,
    };
    if render.max_depth != Some(1) && world.has_material(disperses) {
        world.spectrum = Some(Box::new(Spectrum::visible()));
    }
    prune::remove_ambient_light(&mut world);
    world.ceiling = ceiling(description, &world);
    world.rules.finish(render, &world.ceiling.reach);
    prune::remove_unlit(&mut world);
    // By the counting rules of the SPD shadow rays are traced, needed or not.
    if !options.spd_counts && (!world.is_lit() || casts_no_shadow(description, &world).is_some()) {
        world.rules.shadows = None;
    }
    derive_flags(&mut world);
    if world.rules.shadows.is_some() && !options.spd_counts && !world.effects.has(Effect::ColoredShadows) {
        let cells = builder.obstacles.and_then(|obstacles| LightCells::new(obstacles, &world.lights));
        world.light_cells = cells.map(Arc::new);
    }
    (world, Built { sources: builder.sources, pointers: builder.pointers, expanded })
}

/// How light becomes colors.
fn display(film: &d::Film) -> Display {
    let display = Display::new(film.exposure, film.tone);
    match film.background {
        d::FilmBackground::Color(color) => display.over(color.0.to_array()),
        d::FilmBackground::Scene | d::FilmBackground::Transparent => display,
    }
}

fn fog<R: Real>(fog: &d::Fog) -> Fog<R> {
    let height = |height: d::FogHeight| Height { base: R::from_f64(height.base), falloff: R::from_f64(height.falloff) };
    Fog { color: narrow_rgb(fog.color.0), density: R::from_f64(fog.density), height: fog.height.map(height) }
}
