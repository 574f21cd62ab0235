//! What the table knows of each effect.

use super::recursion::Cut;
use crate::lanes::Real;
use crate::scene::description::{self as d, Description};
use crate::scene::effects::{Effect, Entry, MAX_POINTERS, State};
use crate::scene::problem::push_token;
use crate::scene::usage::{Pointers, Used};
use crate::scene::world::World;
use crate::shading::material::Material;
use std::borrow::Cow;

/// All that is known of one effect.
pub(super) struct Rule<R> {
    pub(super) effect: Effect,
    pub(super) when: When<R>,
    /// Takes it out of a world, to see what it costs.
    pub(super) remove: Option<fn(&mut World<R>)>,
}

/// When an effect is on, and why.
pub(super) enum When<R> {
    /// If a material that bodies have shows it.
    Material(OfMaterial<R>),
    /// Whatever decides.
    Scene {
        on: fn(&World<R>) -> bool,
        /// Given whether it is on.
        why: fn(&Facts<'_, R>, bool) -> EffectReason,
    },
}

/// An effect of materials.
pub(super) struct OfMaterial<R> {
    /// The key by which a material asks for it, if it does.
    pub(super) asks: fn(&d::Material) -> Option<&'static str>,
    /// Whether it shows on bodies that have the material.
    pub(super) shows: fn(&Material<R>, Used) -> bool,
    /// Whether it is one of rays that leave surfaces, which may not be followed.
    pub(super) follows: bool,
    /// Why it is on.
    pub(super) on: &'static str,
    /// Why it is removed although bodies have a material that asks for it.
    pub(super) removed: &'static str,
    /// Why it is off.
    pub(super) off: &'static str,
}

/// What the rules look at.
pub(in crate::scene::compile) struct Facts<'a, R> {
    pub(in crate::scene::compile) description: &'a Description,
    pub(in crate::scene::compile) world: &'a World<R>,
    pub(in crate::scene::compile) pointers: &'a Pointers,
    /// JSON pointer of an object by the number that its item has.
    pub(in crate::scene::compile) source: &'a dyn Fn(u32) -> String,
    /// Samples of each pixel.
    pub(in crate::scene::compile) samples: u32,
    /// Whether each pixel gets as many as it asks for.
    pub(in crate::scene::compile) adaptive: bool,
}

/// Why an effect is on, off or removed.
pub(super) struct EffectReason {
    pub(super) reason: Cow<'static, str>,
    pub(super) because: Vec<String>,
    pub(super) asked: bool,
}

impl EffectReason {
    /// About one that is on, or removed.
    pub(super) fn asked(reason: impl Into<Cow<'static, str>>, because: Vec<String>) -> Self {
        Self { reason: reason.into(), because, asked: true }
    }

    /// About one that is on, or removed, because of one pointer.
    pub(super) fn asked_at(reason: impl Into<Cow<'static, str>>, because: &str) -> Self {
        Self::asked(reason, vec![because.to_owned()])
    }

    /// About one that is off.
    pub(super) fn off(reason: impl Into<Cow<'static, str>>) -> Self {
        Self { reason: reason.into(), because: Vec::new(), asked: false }
    }

    /// The same, by what a pointer says.
    pub(super) fn because(self, pointer: impl Into<String>) -> Self {
        Self { because: vec![pointer.into()], ..self }
    }

    /// The same, with another reason where it is off.
    pub(super) fn or_off(self, reason: &'static str) -> Self {
        if self.asked { self } else { Self::off(reason) }
    }

    /// The row of an effect.
    pub(super) fn entry(mut self, effect: Effect, on: bool) -> Entry {
        self.because.truncate(MAX_POINTERS);
        let state = match (on, self.asked) {
            (true, _) => State::On,
            (false, true) => State::Removed,
            (false, false) => State::Off,
        };
        Entry { effect, state, reason: self.reason, because: self.because }
    }
}

impl<R: Real> Rule<R> {
    /// One that looks at more than materials.
    pub(super) fn new(effect: Effect, on: fn(&World<R>) -> bool, why: fn(&Facts<'_, R>, bool) -> EffectReason) -> Self {
        Self { effect, when: When::Scene { on, why }, remove: None }
    }

    /// One of materials.
    pub(super) fn of_material(effect: Effect, of: OfMaterial<R>) -> Self {
        Self { effect, when: When::Material(of), remove: None }
    }

    /// The same, with what takes it out of a world.
    pub(super) fn without(self, remove: fn(&mut World<R>)) -> Self {
        Self { remove: Some(remove), ..self }
    }

    /// Whether a world holds it.
    pub(super) fn is_on(&self, world: &World<R>) -> bool {
        match &self.when {
            When::Material(of) => of.is_on(world),
            When::Scene { on, .. } => on(world),
        }
    }

    pub(super) fn explain(&self, facts: &Facts<'_, R>) -> Entry {
        let on = self.is_on(facts.world);
        let reason = match &self.when {
            When::Material(of) => of.why(facts, on),
            When::Scene { why, .. } => why(facts, on),
        };
        reason.entry(self.effect, on)
    }
}

impl<R: Real> OfMaterial<R> {
    /// Whether a world holds it.
    pub(super) fn is_on(&self, world: &World<R>) -> bool {
        world.has_material(self.shows) && !(self.follows && Cut::of(world).is_some())
    }

    /// Who asks for it, and what keeps it from being seen.
    pub(super) fn why(&self, facts: &Facts<'_, R>, on: bool) -> EffectReason {
        let used = &facts.world.usage.materials;
        let asking = facts.description.materials.iter().enumerate().filter_map(|(i, (name, material))| {
            let key = (self.asks)(material)?;
            Some((i, push_token(&push_token("/materials", name), key)))
        });
        let asking: Vec<(usize, String)> = asking.collect();
        let those = |test: &dyn Fn(usize) -> bool| -> Vec<String> {
            asking.iter().filter(|(i, _)| test(*i)).map(|(_, pointer)| pointer.clone()).collect()
        };
        let showing = those(&|i| used[i].anywhere && (self.shows)(&facts.world.materials[i], used[i]));
        if on {
            return EffectReason::asked(self.on, showing);
        }
        if let (true, false, Some(cut)) = (self.follows, showing.is_empty(), Cut::of(facts.world)) {
            return cut.reason(facts.description);
        }
        if asking.is_empty() {
            return EffectReason::off(self.off);
        }
        let bodies = those(&|i| used[i].anywhere);
        if bodies.is_empty() {
            return EffectReason::asked("only materials of which no object can be seen ask for it", those(&|_| true));
        }
        EffectReason::asked(self.removed, bodies)
    }
}

/// Whether a color of the description is more than black.
pub(super) fn is_some(color: d::Color) -> bool {
    color.0.max_element() > 0.0
}

/// The kernel's black.
pub(in crate::scene::compile) fn black<R: Real>() -> [R; 3] {
    [R::from_f64(0.0); 3]
}
