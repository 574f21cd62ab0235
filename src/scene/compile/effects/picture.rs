//! How the picture is taken.

use super::rule::{EffectReason, Facts, Rule};
use crate::film::{Display, ToneMapping};
use crate::lanes::Real;
use crate::scene::description::{Accuracy, Camera, Precision};
use crate::scene::effects::{Effect, Entry, REFINED_SAMPLES};

pub(super) fn rules<R: Real>() -> Vec<Rule<R>> {
    vec![
        Rule::new(Effect::Instancing, |world| world.usage.placed, instancing),
        Rule::new(Effect::SpecialProjection, |world| !world.camera.is_pinhole(), projection),
        Rule::new(Effect::AlphaChannel, |world| world.transparent, alpha_channel)
            .without(|world| (world.transparent, world.behind) = (false, None)),
        Rule::new(Effect::ToneMapping, |world| !world.display.is_plain(), tone_mapping)
            .without(|world| world.display = Display::default()),
        Rule::new(Effect::DoublePrecision, |_| R::ROUNDOFF < f64::from(f32::EPSILON) / 4.0, double_precision),
    ]
}

/// Whether pixels that differ from a neighbour get more samples.
pub(in crate::scene::compile) fn refines(antialias: bool, samples: u32, statistical: bool) -> bool {
    antialias && samples < REFINED_SAMPLES && !statistical
}

pub(super) fn antialiasing<R>(facts: &Facts<'_, R>) -> Entry {
    let (render, samples) = (&facts.description.render, facts.samples);
    let statistical = matches!(render.accuracy(), Accuracy::Statistical(_));
    let reason = match render.antialias {
        true if statistical => {
            EffectReason::asked_at("each pixel gets as many samples as its own spread asks for", "/render/accuracy")
        }
        true if facts.adaptive => {
            EffectReason::asked_at("each pixel gets as many samples as its error asks for", "/render/samples")
        }
        true if samples >= REFINED_SAMPLES => {
            EffectReason::asked_at(format!("every pixel has {samples} samples anyway"), "/render/samples")
        }
        true => EffectReason::asked_at("pixels that differ from a neighbour get 4 to 16 samples", "/render/antialias"),
        false => EffectReason::off("render.antialias is false").because("/render/antialias"),
    };
    reason.entry(Effect::Antialiasing, refines(render.antialias, samples, statistical))
}

fn instancing<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    if on {
        EffectReason::asked("objects are placed, not copied", facts.pointers.placed.clone())
    } else {
        EffectReason::off("no object is placed by a transform")
    }
}

fn projection<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let camera = &facts.description.camera;
    debug_assert_eq!(on, !matches!(camera, Camera::Pinhole(_)));
    EffectReason::off(format!("the camera is {}", camera.kind())).because(format!("/camera/{}", camera.kind()))
}

fn alpha_channel<R>(_: &Facts<'_, R>, on: bool) -> EffectReason {
    if on {
        EffectReason::asked_at(
            "the picture has an alpha channel: rays that reach the background tell how much of it is seen",
            "/film/background",
        )
    } else {
        EffectReason::off("film.background is \"scene\"")
    }
}

fn tone_mapping<R>(facts: &Facts<'_, R>, on: bool) -> EffectReason {
    let film = &facts.description.film;
    if !on {
        return EffectReason::off("light is shown as it is: film names neither exposure nor tone");
    }
    let asked = [("/film/exposure", film.exposure != 0.0), ("/film/tone", film.tone != ToneMapping::None)];
    let because = asked.into_iter().filter(|(_, asked)| *asked).map(|(key, _)| key.to_owned());
    EffectReason::asked("codes are those of the light as the film shows it", because.collect())
}

fn double_precision<R>(facts: &Facts<'_, R>, _: bool) -> EffectReason {
    match facts.description.render.precision {
        Precision::Double => EffectReason::asked_at("asked for", "/render/precision"),
        Precision::Single => EffectReason::off("render.precision is \"single\""),
    }
}
