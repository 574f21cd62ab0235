//! How deep the recursion goes.

use super::explain::{Explanation, State};
use crate::lanes::Real;
use crate::scene::effects::{Effect, MAX_POINTERS};
use crate::scene::world::World;
use schemars::JsonSchema;
use serde::Serialize;

/// How long chains of rays get.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Depth {
    /// `render.max_depth`, if the scene names one.
    pub requested: Option<u32>,
    /// A depth at which no chain is cut off: 1 where no surface sends rays on. Null elsewhere.
    pub proved_sufficient: Option<u32>,
    /// Why, in a sentence.
    pub why: &'static str,
    /// JSON pointers of what sends rays on.
    pub because: Vec<String>,
    /// Rays in the longest chain of the rendered picture. Null where only a plan was asked for.
    pub reached: Option<u32>,
}

impl Depth {
    /// What is known before anything is rendered.
    pub(super) fn of<R: Real>(requested: Option<u32>, world: &World<R>, explanation: &Explanation) -> Self {
        if !(world.reflects || world.transmits || world.rules.color_bleeding || world.rules.has_global_illumination()) {
            let why = "no surface reflects, transmits or gathers light";
            return Self { requested, proved_sufficient: Some(1), why, because: Vec::new(), reached: None };
        }
        let senders = [Effect::Reflection, Effect::Transmission, Effect::ColorBleeding, Effect::GlobalIllumination];
        let senders = explanation.effects.iter().filter(|row| row.state != State::Off && senders.contains(&row.kind));
        let mut because: Vec<String> = senders.flat_map(|row| row.because.iter().cloned()).collect();
        because.dedup();
        because.truncate(MAX_POINTERS);
        let why = "surfaces send rays on, and only a rendered picture tells how far they go";
        Self { requested, proved_sufficient: None, why, because, reached: None }
    }
}
