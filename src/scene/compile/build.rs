//! A checked description in the kernel's format.

use super::camera::{camera_of, edges_of};
use super::ceiling::ceiling;
use super::effects::{casts_no_shadow, derive_flags, disperses};
use super::geometries::Builder;
use super::known::Known;
use super::light_from_around::LightFromAround;
use super::lights::light;
use super::materials::narrow_rgb;
use super::pbr;
use super::{CompileOptions, Sources, contact, prune};
use crate::accel::{Blockers, Bounds};
use crate::bound::ceiling::Ceiling;
use crate::camera::Basis;
use crate::film::Display;
use crate::lanes::Real;
use crate::scene::description::{self as d, Description, Shadows};
use crate::scene::effects::{Effect, SceneEffects};
use crate::scene::light_cells::LightCells;
use crate::scene::pictures::Pictures;
use crate::scene::usage::{FAR_AWAY, Pointers, TINY};
use crate::scene::world::{Pruning, Rules, World};
use crate::shading::fog::{Fog, Height};
use crate::shading::light::Light;
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
    let mut builder = Builder::<R>::new(description, options, pictures, camera, known.map(Known::new));
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
    builder.usage.enclosed = builder.occluded.eye_is_enclosed;
    let around =
        LightFromAround::new(description, pictures, &builder.materials, builder.usage.enclosed, fog.as_ref(), known);
    let fades = builder.materials.iter().any(|m| m.pbr.as_ref().is_some_and(|pbr| pbr.edge_fade > 0.0));
    if let Some((materials, moves)) = builder.occluded.usage(&builder.geometries, builder.materials.len()) {
        (builder.usage.materials, builder.usage.moves) = (materials, moves);
    }
    // Where shadows are asked for, lights behind a wall reach nothing that is seen.
    let shines_through = render.shadows == Shadows::None;
    let is_seen = |light: &Light<R>| shines_through || !builder.occluded.hides_light(light);
    let lights: Vec<Light<R>> = description.lights.iter().enumerate().map(light).filter(is_seen).collect();
    let hides_lights = lights.len() < description.lights.len();
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
        hides_lights,
        ambient: narrow_rgb(around.ambient),
        ambient_of_catchers: narrow_rgb(around.ambient_of_catchers),
        background: narrow_rgb(around.background),
        transparent: description.film.background != d::FilmBackground::Scene,
        behind: display(&description.film).radiance_behind().map(|color| color.map(R::from_f64)),
        display: display(&description.film),
        environment: around.environment,
        surroundings: around.surroundings,
        bright_directions: around.bright_directions,
        emitters: around.emitters,
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
            color_bleeding: render.color_bleeding && !pbr::wants_global_illumination(render),
            global_illumination: pbr::wants_global_illumination(render),
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
    let is_unshadowed = || !world.is_lit() || casts_no_shadow(description, &world).is_some();
    // What hides lights is a shadow, too.
    if !options.spd_counts && !world.hides_lights && is_unshadowed() {
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
