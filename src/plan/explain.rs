//! Which effects a scene calls for, and why.

use super::estimate::{Actual, Estimated};
use super::sampled;
use super::use_of::{Uses, uses};
use crate::scene::description::{
    Camera, Checker, Description, Diffuse, Falloff, Fresnel, Gradient, Light, Noise, Object, Precision, Shadows,
};
use crate::scene::problem::push_token;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The effects of a scene.
#[derive(Debug, Clone, Serialize)]
pub struct Explanation {
    /// Every effect the renderer knows.
    pub effects: Vec<Effect>,
    /// What no ray of this renderer shows, whatever the scene.
    pub not_simulated: &'static [&'static str],
}

/// One effect.
#[derive(Debug, Clone, Serialize)]
pub struct Effect {
    /// Its name, a token of letters and `_`.
    pub effect: &'static str,
    /// Whether it is simulated.
    pub state: State,
    /// Why, in a sentence.
    pub reason: String,
    /// JSON pointers of what calls for it, at most [`MAX_POINTERS`].
    pub because: Vec<String>,
    /// Values of those pointers, if they are short.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, Value>,
    /// What it is expected to take.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub est: Option<Estimated>,
    /// What it took.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub act: Option<Actual>,
}

/// States of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Simulated.
    On,
    /// Asked for, but it cannot show in the picture.
    Removed,
    /// Not asked for.
    Off,
}

/// Most pointers listed for one effect.
pub const MAX_POINTERS: usize = 10;

const NOT_SIMULATED: &[&str] = &["caustics", "indirect_diffuse_light", "diffraction", "polarisation"];

/// Explains what a scene makes the renderer do.
pub fn explain(description: &Description) -> Explanation {
    let uses = uses(description);
    let effects = vec![
        ambient(description),
        diffuse(description, &uses),
        highlights(description, &uses),
        shadows(description),
        transmissive_shadows(description, &uses),
        colored_shadows(description, &uses),
        reflection(description, &uses),
        transmission(description, &uses),
        absorption(description, &uses),
        emission(description, &uses),
        fog(description),
        fresnel(description, &uses),
        total_reflection(description, &uses),
        refraction(description, &uses),
        hollow(&uses),
        checker(description, &uses),
        gradient(description, &uses),
        noise(description, &uses),
        images(description, &uses),
        bumps(description, &uses),
        normal_maps(description, &uses),
        environment(description),
        smooth_normals(&uses),
        spot_lights(description),
        falloff(description),
        instancing(&uses),
        projection(description),
        sampled::soft_shadows(description),
        sampled::gloss(description, &uses),
        sampled::dispersion(description, &uses),
        sampled::depth_of_field(description),
        sampled::motion_blur(&uses),
        sampled::color_bleeding(description),
        antialiasing(description),
        double_precision(description),
    ];
    Explanation { effects, not_simulated: NOT_SIMULATED }
}

impl Explanation {
    /// Names of the effects that are on.
    pub fn names_on(&self) -> impl Iterator<Item = &'static str> {
        self.effects.iter().filter(|e| e.state == State::On).map(|e| e.effect)
    }
}

pub(super) fn effect(name: &'static str, state: State, reason: impl Into<String>, mut because: Vec<String>) -> Effect {
    because.truncate(MAX_POINTERS);
    Effect { effect: name, state, reason: reason.into(), because, values: BTreeMap::new(), est: None, act: None }
}

/// On, if something calls for it; removed, if only materials that no object uses do.
pub(super) fn by_material(
    name: &'static str,
    description: &Description,
    uses: &Uses,
    key: &str,
    calls: impl Fn(&crate::scene::description::Material) -> bool,
    on: &str,
    off: &str,
) -> Effect {
    let pointer = |material: &str| push_token(&push_token("/materials", material), key);
    let calling: Vec<&str> = description.materials.iter().filter(|(_, m)| calls(m)).map(|(name, _)| name).collect();
    let used: Vec<String> = calling.iter().filter(|m| uses.materials.contains(**m)).map(|m| pointer(m)).collect();
    if !used.is_empty() {
        return effect(name, State::On, on, used);
    }
    if !calling.is_empty() {
        let unused = calling.into_iter().map(pointer).collect();
        return effect(name, State::Removed, "only materials that no object uses ask for it", unused);
    }
    effect(name, State::Off, off, Vec::new())
}

fn ambient(description: &Description) -> Effect {
    if description.ambient.0.max_element() > 0.0 {
        effect("ambient_light", State::On, "the scene has ambient light", vec!["/ambient".into()])
    } else {
        effect("ambient_light", State::Off, "ambient is 0", Vec::new())
    }
}

fn lit(description: &Description) -> bool {
    description.lights.iter().any(|light| {
        let (color, intensity) = match light {
            Light::Point(l) => (l.color, l.intensity),
            Light::Directional(l) => (l.color, l.intensity),
            Light::Spot(l) => (l.color, l.intensity),
        };
        color.0.max_element() * intensity > 0.0
    })
}

fn shines(diffuse: &Diffuse) -> bool {
    match diffuse {
        Diffuse::Uniform(color) => color.0.max_element() > 0.0,
        Diffuse::Checker(Checker { a, b, .. })
        | Diffuse::Gradient(Gradient { a, b, .. })
        | Diffuse::Noise(Noise { a, b, .. }) => a.0.max_element().max(b.0.max_element()) > 0.0,
        Diffuse::Image(_) => true,
    }
}

fn diffuse(description: &Description, uses: &Uses) -> Effect {
    let name = "diffuse_reflection";
    if !lit(description) {
        return effect(name, State::Removed, "no light shines", vec!["/lights".into()]);
    }
    if uses.default_material {
        return effect(name, State::On, "bodies without a material are diffuse", Vec::new());
    }
    let (on, off) = ("surfaces scatter the lights", "no material has a diffuse colour");
    by_material(name, description, uses, "diffuse", |m| shines(&m.diffuse), on, off)
}

fn highlights(description: &Description, uses: &Uses) -> Effect {
    let name = "highlights";
    let effect_of = by_material(
        name,
        description,
        uses,
        "specular",
        |m| m.specular.0.max_element() > 0.0,
        "lights mirror in shiny surfaces (Phong)",
        "specular is 0 everywhere",
    );
    if effect_of.state == State::On && !lit(description) {
        return effect(name, State::Removed, "no light shines", vec!["/lights".into()]);
    }
    effect_of
}

fn shadows(description: &Description) -> Effect {
    let name = "shadows";
    match (description.render.shadows, lit(description)) {
        (Shadows::None, _) => effect(name, State::Off, "render.shadows is \"none\"", vec!["/render/shadows".into()]),
        (_, false) => effect(name, State::Removed, "no light shines", vec!["/lights".into()]),
        _ => effect(name, State::On, "bodies hide the lights from each other", vec!["/lights".into()]),
    }
}

fn transmissive_shadows(description: &Description, uses: &Uses) -> Effect {
    let name = "transmissive_shadows";
    if description.render.shadows != Shadows::Transmissive {
        return effect(name, State::Off, "render.shadows is not \"transmissive\"", Vec::new());
    }
    let clear = |m: &str| description.materials.get(m).is_some_and(|m| m.transmission.0.max_element() > 0.0);
    let because = vec!["/render/shadows".into()];
    if !uses.materials.iter().any(|m| clear(m)) {
        return effect(name, State::Removed, "no body transmits light", because);
    }
    effect(name, State::On, "transmitting bodies let some of the light through", because)
}

fn colored_shadows(description: &Description, uses: &Uses) -> Effect {
    let name = "colored_shadows";
    let absorption = absorption(description, uses);
    if absorption.state != State::On {
        return effect(name, State::Off, "no body absorbs the light that passes through it", Vec::new());
    }
    if description.render.shadows != Shadows::Transmissive {
        return effect(name, State::Off, "render.shadows is not \"transmissive\"", vec!["/render/shadows".into()]);
    }
    if !lit(description) {
        return effect(name, State::Removed, "no light shines", vec!["/lights".into()]);
    }
    effect(name, State::On, "bodies absorb some of the light on its way to surfaces", absorption.because)
}

/// Why nothing beyond the camera rays is followed, if so.
fn cut_off(description: &Description) -> Option<&'static str> {
    if description.render.max_depth <= 1 {
        Some("max_depth is 1: only camera rays are followed")
    } else if description.render.min_weight >= 1.0 {
        Some("min_weight is 1: no ray is heavy enough to be followed")
    } else {
        None
    }
}

fn reflection(description: &Description, uses: &Uses) -> Effect {
    let name = "reflection";
    let effect_of = by_material(
        name,
        description,
        uses,
        "reflection",
        |m| m.reflection.0.max_element() > 0.0 || m.fresnel == Fresnel::Conductor,
        "surfaces mirror their surroundings",
        "reflection is 0 everywhere",
    );
    match cut_off(description) {
        Some(why) if effect_of.state == State::On => {
            effect(name, State::Removed, why, vec!["/render/max_depth".into()])
        }
        _ => effect_of,
    }
}

fn transmission(description: &Description, uses: &Uses) -> Effect {
    let name = "transmission";
    let effect_of = by_material(
        name,
        description,
        uses,
        "transmission",
        |m| m.transmission.0.max_element() > 0.0,
        "light passes through bodies",
        "transmission is 0 everywhere",
    );
    match cut_off(description) {
        Some(why) if effect_of.state == State::On => {
            effect(name, State::Removed, why, vec!["/render/max_depth".into()])
        }
        _ => effect_of,
    }
}

fn refraction(description: &Description, uses: &Uses) -> Effect {
    let name = "refraction";
    let clear = |m: &crate::scene::description::Material| m.transmission.0.max_element() > 0.0;
    let (on, off) = ("light bends by Snell's law", "nothing transmits light");
    let effect_of = by_material(name, description, uses, "ior", clear, on, off);
    if effect_of.state != State::On || cut_off(description).is_some() {
        return effect(name, State::Off, off, Vec::new());
    }
    let bends = |m: &crate::scene::description::Material| clear(m) && m.ior != 1.0;
    let bending = by_material(name, description, uses, "ior", bends, on, off);
    if bending.state == State::On {
        return bending;
    }
    effect(name, State::Removed, "all indices of refraction are 1: nothing bends", effect_of.because)
}

fn fresnel(description: &Description, uses: &Uses) -> Effect {
    let name = "fresnel";
    let asks = |m: &crate::scene::description::Material| m.fresnel != Fresnel::None;
    let on = "reflection and transmission depend on the angle of incidence";
    let effect_of = by_material(name, description, uses, "fresnel", asks, on, "fresnel is \"none\" everywhere");
    if effect_of.state != State::On {
        return effect_of;
    }
    if let Some(why) = cut_off(description) {
        return effect(name, State::Removed, why, vec!["/render/max_depth".into()]);
    }
    let shows = |m: &crate::scene::description::Material| {
        m.fresnel == Fresnel::Conductor || m.reflection.0.max(m.transmission.0).max_element() > 0.0
    };
    let used = |name: &str| uses.materials.contains(name);
    if !description.materials.iter().any(|(name, m)| asks(m) && used(name) && shows(m)) {
        let why = "dielectrics with reflection 0 and transmission 0 do not mirror";
        return effect(name, State::Removed, why, effect_of.because);
    }
    effect_of
}

fn absorption(description: &Description, uses: &Uses) -> Effect {
    let name = "absorption";
    let absorbs = |m: &crate::scene::description::Material| m.absorption.0.max_element() > 0.0;
    let on = "bodies absorb light along its way through them";
    let effect_of = by_material(name, description, uses, "absorption", absorbs, on, "absorption is 0 everywhere");
    if effect_of.state != State::On {
        return effect_of;
    }
    let filled = |name: &str| uses.filled.contains(name);
    let inside = |(name, m): (&str, &crate::scene::description::Material)| {
        absorbs(m) && m.transmission.0.max_element() > 0.0 && filled(name)
    };
    if !description.materials.iter().any(inside) {
        let why = "light gets into no body that absorbs: those that ask for it are opaque, hollow or sheets";
        return effect(name, State::Removed, why, effect_of.because);
    }
    effect_of
}

fn fog(description: &Description) -> Effect {
    match &description.fog {
        Some(fog) if fog.density > 0.0 => {
            let how = if fog.height.is_some() { "fog that thins out with height" } else { "fog" };
            effect("fog", State::On, format!("{how} fades what is far away"), vec!["/fog".into()])
        }
        Some(_) => effect("fog", State::Removed, "fog.density is 0", vec!["/fog/density".into()]),
        None => effect("fog", State::Off, "the scene has no fog", Vec::new()),
    }
}

fn emission(description: &Description, uses: &Uses) -> Effect {
    let (on, off) = ("surfaces shine by themselves", "emission is 0 everywhere");
    let shines = |m: &crate::scene::description::Material| m.emission.0.max_element() > 0.0;
    by_material("emission", description, uses, "emission", shines, on, off)
}

fn total_reflection(description: &Description, uses: &Uses) -> Effect {
    let name = "total_reflection";
    let clear = |m: &&crate::scene::description::Material| m.transmission.0.max_element() > 0.0;
    let used = |(n, m)| uses.materials.contains(n).then_some(m);
    let indices: Vec<f64> = description.materials.iter().filter_map(used).filter(clear).map(|m| m.ior).collect();
    if cut_off(description).is_some() {
        return effect(name, State::Off, "no refraction", Vec::new());
    }
    match indices.as_slice() {
        [] => effect(name, State::Off, "no refraction", Vec::new()),
        all if all.iter().all(|ior| *ior == 1.0) => {
            effect(name, State::Removed, "all indices of refraction are 1: nothing bends", Vec::new())
        }
        _ => effect(name, State::On, "light can meet a less dense medium at a grazing angle", Vec::new()),
    }
}

pub(super) fn found(name: &'static str, because: &[String], on: &str, off: &str) -> Effect {
    let state = if because.is_empty() { State::Off } else { State::On };
    effect(name, state, if because.is_empty() { off } else { on }, because.to_vec())
}

fn hollow(uses: &Uses) -> Effect {
    found("hollow_bodies", &uses.hollow, "bodies enclose empty space", "no body is hollow")
}

fn checker(description: &Description, uses: &Uses) -> Effect {
    let checkered = |d: &Diffuse| matches!(d, Diffuse::Checker(c) if c.a != c.b);
    let (on, off) = ("colours depend on the place", "all colours are uniform");
    let calls =
        |m: &crate::scene::description::Material| checkered(&m.diffuse) || m.ambient.as_ref().is_some_and(checkered);
    by_material("checker_texture", description, uses, "diffuse", calls, on, off)
}

/// A pattern of diffuse or ambient colours.
fn pattern(
    name: &'static str,
    description: &Description,
    uses: &Uses,
    calls: impl Fn(&Diffuse) -> bool,
    on: &str,
    off: &str,
) -> Effect {
    let calls = |m: &crate::scene::description::Material| calls(&m.diffuse) || m.ambient.as_ref().is_some_and(&calls);
    by_material(name, description, uses, "diffuse", calls, on, off)
}

fn gradient(description: &Description, uses: &Uses) -> Effect {
    let calls = |d: &Diffuse| matches!(d, Diffuse::Gradient(g) if g.a != g.b);
    let (on, off) = ("colours change from point to point", "no colour is a gradient");
    pattern("gradient_texture", description, uses, calls, on, off)
}

fn noise(description: &Description, uses: &Uses) -> Effect {
    let calls = |d: &Diffuse| matches!(d, Diffuse::Noise(n) if n.a != n.b);
    pattern("noise_texture", description, uses, calls, "colours are clouds of noise", "no colour is noise")
}

fn images(description: &Description, uses: &Uses) -> Effect {
    let calls = |d: &Diffuse| matches!(d, Diffuse::Image(_));
    let (on, off) = ("pictures lie on surfaces, filtered by the footprint of each ray", "no colour is a picture");
    pattern("image_texture", description, uses, calls, on, off)
}

fn bumps(description: &Description, uses: &Uses) -> Effect {
    let calls = |m: &crate::scene::description::Material| m.bump.as_ref().is_some_and(|bump| bump.height > 0.0);
    let flat = |m: &crate::scene::description::Material| m.bump.as_ref().is_some_and(|bump| bump.height == 0.0);
    let effect_of = by_material(
        "bump_mapping",
        description,
        uses,
        "bump",
        calls,
        "surfaces are lit as if they were rough",
        "no material has bumps",
    );
    if effect_of.state != State::Off {
        return effect_of;
    }
    let flat = description.materials.iter().filter(|(_, m)| flat(m));
    let flat: Vec<String> = flat.map(|(name, _)| push_token(&push_token("/materials", name), "bump")).collect();
    if flat.is_empty() { effect_of } else { effect("bump_mapping", State::Removed, "all bumps have height 0", flat) }
}

fn normal_maps(description: &Description, uses: &Uses) -> Effect {
    let calls = |m: &crate::scene::description::Material| m.normal_map.is_some();
    let (on, off) = ("pictures tilt the normals of surfaces", "no material has a normal map");
    by_material("normal_mapping", description, uses, "normal_map", calls, on, off)
}

fn environment(description: &Description) -> Effect {
    let name = "environment_map";
    match &description.environment {
        None => effect(name, State::Off, "rays that hit nothing see the background", Vec::new()),
        Some(environment) if environment.intensity == 0.0 => {
            effect(name, State::Removed, "its intensity is 0: it is black", vec!["/environment/intensity".into()])
        }
        Some(_) => effect(name, State::On, "rays that hit nothing see a picture", vec!["/environment".into()]),
    }
}

fn smooth_normals(uses: &Uses) -> Effect {
    found("smooth_normals", &uses.smooth, "meshes interpolate their normals", "no mesh has normals")
}

pub(super) fn light_pointers(description: &Description, calls: impl Fn(&Light) -> bool) -> Vec<String> {
    let calling = description.lights.iter().enumerate().filter(|(_, light)| calls(light));
    calling.map(|(i, _)| format!("/lights/{i}")).collect()
}

fn spot_lights(description: &Description) -> Effect {
    let spots = light_pointers(description, |light| matches!(light, Light::Spot(_)));
    found("spot_lights", &spots, "lights shine into cones", "no light is a spot")
}

fn falloff(description: &Description) -> Effect {
    let fades = light_pointers(description, |light| match light {
        Light::Point(l) => l.falloff != Falloff::None,
        Light::Spot(l) => l.falloff != Falloff::None,
        Light::Directional(_) => false,
    });
    found("light_falloff", &fades, "lights fade with distance", "no light fades with distance")
}

fn instancing(uses: &Uses) -> Effect {
    found("instancing", &uses.placed, "objects are placed, not copied", "no object is placed by a transform")
}

fn projection(description: &Description) -> Effect {
    let kind = description.camera.kind();
    let state = if matches!(description.camera, Camera::Pinhole(_)) { State::Off } else { State::On };
    effect("special_projection", state, format!("the camera is {kind}"), vec![format!("/camera/{kind}")])
}

fn antialiasing(description: &Description) -> Effect {
    let name = "antialiasing";
    let render = &description.render;
    if render.antialias && render.samples.unwrap_or(1) >= 16 {
        return effect(
            name,
            State::Removed,
            "every pixel has 16 samples or more anyway",
            vec!["/render/samples".into()],
        );
    }
    if render.antialias {
        return effect(
            name,
            State::On,
            "pixels that differ from a neighbour get 16 samples",
            vec!["/render/antialias".into()],
        );
    }
    effect(name, State::Off, "render.antialias is false", vec!["/render/antialias".into()])
}

fn double_precision(description: &Description) -> Effect {
    match description.render.precision {
        Precision::Double => effect("double_precision", State::On, "asked for", vec!["/render/precision".into()]),
        Precision::Single => effect("double_precision", State::Off, "render.precision is \"single\"", Vec::new()),
    }
}

/// Whether an object is placed by a transform of its own.
pub(super) fn is_placed(object: &Object) -> bool {
    match object {
        Object::Instance(_) => true,
        Object::Group(group) => group.transform != crate::scene::description::Transform::default(),
        _ => false,
    }
}

/// Whether an object moves while the shutter is open.
pub(super) fn moves(object: &Object) -> bool {
    let motion = match object {
        Object::Instance(instance) => instance.motion,
        Object::Group(group) => group.motion,
        _ => None,
    };
    motion.is_some_and(|motion| motion.moves())
}
