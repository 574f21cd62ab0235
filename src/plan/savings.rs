//! What a picture would save without one of its effects: the time of a pilot with it and of one without it.
//!
//! This is more than the effect's share of the time if its rays cause others, as with glass, whose rays need shadow rays, too. It
//! is less if other rays replace them.

use super::Plan;
use super::estimate::rounded;
use super::explain::State;
use super::pilot::{Effort, Pilot};
use crate::control::{Cancelled, Control};
use crate::film::Region;
use crate::scene::Scene;
use crate::scene::effects::Effect;
use std::time::Duration;

/// Limits of these pilots: a time slice for each.
const EFFORT: Effort = Effort { time: Duration::from_millis(40), share: 0.02 };

impl Plan {
    /// The effects that are on, to be [compared](Self::compare) one by one.
    pub fn comparable(&self) -> Vec<Effect> {
        self.explanation.effects.iter().filter(|row| row.state == State::On).map(|row| row.kind).collect()
    }

    /// Adds to the actual cost of an effect what the picture would save without it, if it can be left out alone. `trace_ms` is
    /// the time in which the picture of the region was traced.
    pub fn compare(
        &mut self,
        effect: Effect,
        scene: &Scene,
        region: Region,
        control: &Control,
        trace_ms: f64,
    ) -> Result<(), Cancelled> {
        let Some(without) = scene.without(effect) else { return Ok(()) };
        // One right after the other, since the speed of a shared machine changes.
        let [all, rest] = [scene, &without].map(|scene| Pilot::run(scene, region, control, EFFORT));
        let saved = 1.0 - rest?.nanoseconds() / all?.nanoseconds().max(1.0);
        for row in self.explanation.effects.iter_mut().filter(|row| row.kind == effect) {
            if let Some(act) = &mut row.act {
                act.saves_ms = Some(rounded(trace_ms * saved));
            }
        }
        Ok(())
    }
}
