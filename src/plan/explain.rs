//! `strahl explain`: which effects, and why.

use crate::scene::{Description, Scene};
use serde::Serialize;

/// The effects of a scene.
#[derive(Debug, Clone, Serialize)]
pub struct Explanation {
    /// Every effect the renderer knows.
    pub effects: Vec<Effect>,
}

/// One effect.
#[derive(Debug, Clone, Serialize)]
pub struct Effect {
    /// Its name.
    pub effect: &'static str,
    /// `on`, `removed` (asked for, but it cannot show) or `off` (not asked for).
    pub state: &'static str,
    /// Why, in a sentence.
    pub reason: String,
    /// JSON pointers of what calls for it.
    pub because: Vec<String>,
}

impl Explanation {
    /// A readable table.
    pub fn to_table(&self) -> String {
        String::new()
    }
}

/// Explains what a scene makes the renderer do.
pub fn explain(_description: &Description, _scene: &Scene) -> Explanation {
    Explanation { effects: Vec::new() }
}
