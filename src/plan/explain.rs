//! The effects of a scene as plans list them: its own table, and what each effect takes.

use super::estimate::{Actual, Estimated};
use crate::scene::Scene;
pub use crate::scene::effects::State;
use crate::scene::effects::{Effect, Entry};

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The effects of a scene.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Explanation {
    /// Every effect the renderer knows.
    pub effects: Vec<Row>,
    /// What no ray of this renderer shows, whatever the scene.
    pub not_simulated: &'static [&'static str],
}

/// One effect.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "Effect")]
pub struct Row {
    /// What it is.
    #[serde(skip)]
    pub kind: Effect,
    /// Its name, a token of letters and `_`.
    pub effect: &'static str,
    /// Whether it is simulated.
    pub state: State,
    /// Why, in a sentence.
    pub reason: String,
    /// JSON pointers of what calls for it, at most 10.
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

const NOT_SIMULATED: &[&str] = &["caustics", "repeated_diffuse_interreflection", "diffraction", "polarisation"];

/// Explains what a scene makes the renderer do.
pub fn explain(scene: &Scene) -> Explanation {
    Explanation { effects: scene.effects.iter().map(Row::new).collect(), not_simulated: NOT_SIMULATED }
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

    /// Fills in the values of its pointers from the settings of a description, its objects left out.
    pub(super) fn look_up(&mut self, settings: &Value) {
        let short = |pointer: &String| {
            let value = settings.pointer(pointer).filter(|value| is_short(value))?;
            Some((pointer.clone(), value.clone()))
        };
        self.values = self.because.iter().filter_map(short).collect();
    }
}

/// A number, a word or a colour.
fn is_short(value: &Value) -> bool {
    match value {
        Value::Array(values) => values.len() <= 4 && values.iter().all(Value::is_number),
        Value::Object(_) => false,
        _ => true,
    }
}
