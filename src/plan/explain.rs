//! Which effects a scene calls for, and why.

use super::catalogue::{choices, light, passing, picture, surfaces};
use super::estimate::{Actual, Estimated};
use super::use_of::{Uses, uses};
use crate::scene::description::{Description, Light, Material, Object};
use crate::scene::problem::push_token;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The effects of a scene.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Explanation {
    /// Every effect the renderer knows.
    pub effects: Vec<Effect>,
    /// What no ray of this renderer shows, whatever the scene.
    pub not_simulated: &'static [&'static str],
}

/// One effect.
#[derive(Debug, Clone, Serialize, JsonSchema)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "EffectState")]
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

const NOT_SIMULATED: &[&str] = &["caustics", "repeated_diffuse_interreflection", "diffraction", "polarisation"];

/// Explains what a scene makes the renderer do.
pub fn explain(description: &Description) -> Explanation {
    let uses = uses(description);
    let mut effects = vec![
        light::ambient(description),
        light::diffuse(description, &uses),
        light::highlights(description, &uses),
        light::shadows(description),
        light::transmissive_shadows(description, &uses),
        light::colored_shadows(description, &uses),
        passing::reflection(description, &uses),
        passing::transmission(description, &uses),
        passing::absorption(description, &uses),
        light::emission(description, &uses),
        light::fog(description),
        passing::fresnel(description, &uses),
        passing::total_reflection(description, &uses),
        passing::refraction(description, &uses),
        passing::hollow(&uses),
        surfaces::checker(description, &uses),
        surfaces::gradient(description, &uses),
        surfaces::noise(description, &uses),
        surfaces::images(description, &uses),
        surfaces::bumps(description, &uses),
        surfaces::normal_maps(description, &uses),
        light::environment(description),
        surfaces::smooth_normals(&uses),
        light::spot_lights(description),
        light::falloff(description),
        picture::instancing(&uses),
        picture::projection(description),
    ];
    let choices = [
        choices::soft_shadows(description),
        choices::gloss(description, &uses),
        choices::dispersion(description, &uses),
        choices::depth_of_field(description),
        choices::motion_blur(&uses),
        choices::color_bleeding(description),
    ];
    let chooses = choices.iter().any(|effect| effect.state == State::On);
    effects.extend(choices);
    effects.extend([picture::antialiasing(description, chooses), picture::double_precision(description)]);
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
    calls: impl Fn(&Material) -> bool,
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

pub(super) fn found(name: &'static str, because: &[String], on: &str, off: &str) -> Effect {
    let state = if because.is_empty() { State::Off } else { State::On };
    effect(name, state, if because.is_empty() { off } else { on }, because.to_vec())
}

pub(super) fn light_pointers(description: &Description, calls: impl Fn(&Light) -> bool) -> Vec<String> {
    let calling = description.lights.iter().enumerate().filter(|(_, light)| calls(light));
    calling.map(|(i, _)| format!("/lights/{i}")).collect()
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
