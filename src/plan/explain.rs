//! The table of effects in plans, with the cost of each.

use super::estimate::{EffectCost, EffectEstimate};
use crate::scene::Scene;
pub use crate::scene::effects::State;
use crate::scene::effects::{Effect, Entry};

use crate::scene::description::{Description, Material};
use crate::scene::named::Named;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The effects of a scene.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Explanation {
    /// Every effect the renderer knows.
    pub effects: Vec<Row>,
    /// Effects of light that no ray of the picture simulates.
    pub not_simulated: Vec<&'static str>,
}

/// One effect.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "Effect")]
pub struct Row {
    /// The effect.
    #[serde(skip)]
    pub kind: Effect,
    /// Its name, a token of letters and `_`.
    pub effect: &'static str,
    /// Whether it is simulated.
    pub state: State,
    /// Why, in a sentence.
    pub reason: Cow<'static, str>,
    /// JSON pointers of the keys that ask for it, at most 10.
    pub because: Vec<String>,
    /// Values of those keys, if they are short.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, Value>,
    /// Estimated cost.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub est: Option<EffectEstimate>,
    /// Actual cost.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub act: Option<EffectCost>,
}

/// The effects of a scene.
pub fn explain(scene: &Scene) -> Explanation {
    let is_global =
        scene.effects.iter().any(|entry| entry.effect == Effect::GlobalIllumination && entry.state == State::On);
    let mut not_simulated = vec!["caustics", "repeated_diffuse_interreflection", "diffraction", "polarisation"];
    not_simulated.retain(|name| !(is_global && *name == "repeated_diffuse_interreflection"));
    Explanation { effects: scene.effects.iter().map(Row::new).collect(), not_simulated }
}

impl Explanation {
    /// Names of the effects that are on.
    pub fn names_on(&self) -> impl Iterator<Item = &'static str> {
        self.effects.iter().filter(|row| row.state == State::On).map(|row| row.effect)
    }
}

impl Row {
    fn new(entry: &Entry) -> Self {
        Self {
            kind: entry.effect,
            effect: entry.effect.name(),
            state: entry.state,
            reason: entry.reason.clone(),
            because: entry.because.clone(),
            values: BTreeMap::new(),
            est: None,
            act: None,
        }
    }
}

/// The settings of a description as JSON, to look up values by pointer. Each material is written when it is asked for, and
/// objects have no settings.
pub(super) struct Lookup<'a> {
    materials: &'a Named<Material>,
    settings: Value,
}

impl<'a> Lookup<'a> {
    pub(super) fn new(description: &'a mut Description) -> Self {
        let settings = description.settings();
        Self { materials: &description.materials, settings }
    }

    /// The values of pointers that are short.
    pub(super) fn values(&self, pointers: &[String]) -> BTreeMap<String, Value> {
        let short = |pointer: &String| Some((pointer.clone(), self.value(pointer).filter(is_short)?));
        pointers.iter().filter_map(short).collect()
    }

    fn value(&self, pointer: &str) -> Option<Value> {
        let Some((name, key)) = pointer.strip_prefix("/materials/").and_then(|rest| rest.split_once('/')) else {
            return self.settings.pointer(pointer).cloned();
        };
        let material = self.materials.get(&name.replace("~1", "/").replace("~0", "~"))?;
        serde_json::to_value(material).ok()?.pointer(&format!("/{key}")).cloned()
    }
}

/// Bytes of a short text.
const SHORT: usize = 64;

/// A number, a word or a color.
fn is_short(value: &Value) -> bool {
    match value {
        Value::Array(values) => values.len() <= 4 && values.iter().all(Value::is_number),
        Value::Object(_) => false,
        Value::String(text) => text.len() <= SHORT,
        _ => true,
    }
}
