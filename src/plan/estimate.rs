//! Estimated and actual rays and times of effects.
//!
//! Rays are counted by kind. Time is not measured by kind, but divided by the time that a ray of each kind takes in the pilot.
//! Effects without rays of their own, such as highlights or textures, are part of those that have some.

use super::Plan;
use super::explain::{Row, State};
use super::pilot::{Effort, Expected, Pilot};
use super::ray_times::by_kind;
use crate::control::{Cancelled, Control, milliseconds};
use crate::film::Region;
use crate::render::{CHUNK, COARSEST_SHARE, Refined};
use crate::scene::Scene;
use crate::scene::description::{Accuracy, Rays, Time};
use crate::scene::effects::Effect;
use crate::trace::counts::RayCounts;
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// Estimate of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct EffectEstimate {
    /// Its own rays.
    pub rays: u64,
    /// Their 95 % interval.
    pub rays_ci: [u64; 2],
    /// Milliseconds of wall time on all threads. Null if its time is part of other effects' rays.
    pub ms: Option<f64>,
}

/// Actual cost of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct EffectCost {
    /// Its own rays, counted.
    pub rays: u64,
    /// The same as `share_ms`, under its former name.
    pub ms_estimated: Option<f64>,
    /// Milliseconds that its own rays took: their number times what rays of their kind took in the pilot. Null if its time is
    /// part of other effects' rays.
    pub share_ms: Option<f64>,
    /// Milliseconds that the picture would save without this one effect, measured by a pilot without it. Below 0 if it would
    /// take longer. Null if the effect is off, or cannot be left out alone.
    pub saves_ms: Option<f64>,
}

/// Estimate of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Estimate {
    /// Pixels of the picture or its region.
    pub pixels: u64,
    /// Pixels traced by the pilot.
    pub pilot_pixels: u64,
    /// All rays, including shadow rays.
    pub rays: u64,
    /// Their 95 % interval.
    pub rays_ci: [u64; 2],
    /// Camera rays.
    pub camera_rays: u64,
    /// Pixels that antialiasing refines.
    pub refined_pixels: u64,
    /// Pixels whose proof is given up, since it would take too many rays: their bound is larger than what was asked for.
    #[serde(skip_serializing_if = "is_zero")]
    pub unproved_pixels: u64,
    /// Milliseconds of wall time for tracing on `threads`, if nothing else runs on them.
    pub ms: f64,
    /// Their 95 % interval.
    pub ms_ci: [f64; 2],
    /// Whether even the pilot's first pixels took too long: then the picture takes at least what is said here.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub at_least: bool,
    /// Milliseconds of the pilot.
    pub pilot_ms: f64,
    /// Threads of the pool.
    pub threads: usize,
}

/// The rays that an effect follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Own {
    /// Rays of a kind.
    Kind(usize),
    /// Reflected rays of total internal reflection.
    Total,
    /// Rays of additional samples.
    Added,
    /// None.
    Nothing,
}

const SHADOW: usize = 1;
const REFLECTED: usize = 2;
const TRANSMITTED: usize = 3;
const GATHERED: usize = 4;

fn own(row: &Row) -> Own {
    match row.kind {
        _ if row.state != State::On => Own::Nothing,
        Effect::Shadows => Own::Kind(SHADOW),
        Effect::Reflection => Own::Kind(REFLECTED),
        Effect::Transmission => Own::Kind(TRANSMITTED),
        Effect::TotalReflection => Own::Total,
        Effect::ColorBleeding | Effect::GlobalIllumination => Own::Kind(GATHERED),
        Effect::Antialiasing => Own::Added,
        _ => Own::Nothing,
    }
}

impl Plan {
    /// Adds the estimate of a region, which must fit the picture, and returns the pilot that it comes from.
    pub fn estimate(
        &mut self,
        scene: &Scene,
        region: Region,
        control: &Control,
        effort: Effort,
    ) -> Result<Pilot, Cancelled> {
        let started = Instant::now();
        let pilot = Pilot::run(scene, region, control, effort)?;
        let threads = rayon::current_num_threads();
        let whole = pilot.nanoseconds() / threads as f64 * 1e-6;
        let coarsest = COARSEST_SHARE / f64::from(scene.samples);
        let share = share(self.accuracy, whole, pilot.rays.value).clamp(coarsest, 1.0);
        let pilot_ms = milliseconds(started);
        // A picture of which not even the first pixels were done in that time takes longer, unless it ends by itself.
        let least = if pilot.is_cut_off && share == 1.0 { pilot_ms } else { 0.0 };
        let ms = |nanoseconds: f64| rounded(share * nanoseconds / threads as f64 * 1e-6);
        let all_ms = |nanoseconds: f64| ms(nanoseconds).max(rounded(least));
        let count = |expected: f64| (share * expected).round() as u64;
        for effect in &mut self.explanation.effects {
            let (rays, nanoseconds) = match own(effect) {
                Own::Kind(kind) => (pilot.kinds[kind], Some(pilot.times.nanoseconds[kind])),
                Own::Total => (pilot.total_reflections, Some(pilot.times.nanoseconds[REFLECTED])),
                Own::Added => (pilot.added, Some(pilot.added_nanoseconds)),
                Own::Nothing => (Expected::default(), (effect.state != State::On).then_some(0.0)),
            };
            let [low, high] = rays.interval.map(|end| share * end);
            effect.est = Some(EffectEstimate {
                rays: count(rays.value),
                rays_ci: [low.floor() as u64, high.ceil() as u64],
                ms: nanoseconds.map(|each| ms(rays.value * each)),
            });
        }
        let [low, high] = self.rays_within(&pilot, share);
        let whole = pilot.nanoseconds();
        let off = whole * pilot.time_off;
        self.estimate = Some(Estimate {
            pixels: pilot.pixels,
            pilot_pixels: pilot.traced,
            rays: count(pilot.rays.value),
            rays_ci: [low.floor() as u64, high.ceil() as u64],
            camera_rays: count(pilot.kinds[0].value),
            refined_pixels: count(pilot.refined.value),
            unproved_pixels: count(pilot.given_up.value),
            ms: all_ms(whole),
            ms_ci: [all_ms((whole - off).max(0.0)), all_ms(whole + off)],
            at_least: pilot.is_cut_off,
            pilot_ms: rounded(pilot_ms),
            threads,
        });
        self.explain_ms += pilot_ms;
        Ok(pilot)
    }

    /// The interval of the rays of a share of the picture.
    fn rays_within(&self, pilot: &Pilot, share: f64) -> [f64; 2] {
        let [low, high] = pilot.rays.interval.map(|end| share * end);
        match self.accuracy {
            // How many there are in a time is as uncertain as their time.
            Accuracy::Time(_) if share < 1.0 => [low / (1.0 + pilot.time_off), high * (1.0 + pilot.time_off)],
            // The chunk that reaches the number is finished, unless it alone takes more.
            Accuracy::Rays(Rays { count }) if share < 1.0 => {
                let chunk = CHUNK as f64 * pilot.rays.value / pilot.pixels as f64;
                [low.min(count as f64), high.max(count as f64) + chunk.min(count as f64)]
            }
            _ => [low, high],
        }
    }

    /// Adds the actual cost of effects, and how deep rays went, given the rays and milliseconds of a picture.
    pub fn measure(&mut self, pilot: &Pilot, rays: &RayCounts, refined: &Refined, trace_ms: f64) {
        let each = pilot.times.nanoseconds;
        let weigh = |rays: &RayCounts| -> f64 { by_kind(rays).iter().zip(each).map(|(n, t)| n * t).sum() };
        let whole = weigh(rays).max(f64::MIN_POSITIVE);
        self.depth.reached = Some(rays.deepest);
        for effect in &mut self.explanation.effects {
            let (count, nanoseconds) = match own(effect) {
                Own::Kind(kind) => {
                    let count = by_kind(rays)[kind];
                    (count as u64, Some(count * each[kind]))
                }
                Own::Total => {
                    let count = rays.total_internal_reflections;
                    (count, Some(count as f64 * each[REFLECTED]))
                }
                Own::Added => {
                    let count = refined.rays.total();
                    (count, Some((count as f64 * pilot.added_nanoseconds).min(whole)))
                }
                Own::Nothing => (0, (effect.state != State::On).then_some(0.0)),
            };
            let share_ms = nanoseconds.map(|ns| rounded(trace_ms * (ns / whole)));
            effect.act = Some(EffectCost { rays: count, ms_estimated: share_ms, share_ms, saves_ms: None });
        }
    }
}

/// The share of a picture that there is where a time or a number of rays ends it, given the milliseconds and the rays of all of it.
fn share(accuracy: Accuracy, ms: f64, rays: f64) -> f64 {
    match accuracy {
        Accuracy::Time(Time { ms: most }) => most / ms,
        Accuracy::Rays(Rays { count }) => count as f64 / rays,
        _ => 1.0,
    }
}

fn is_zero(n: &u64) -> bool {
    *n == 0
}

/// Milliseconds to the microsecond.
pub(super) fn rounded(ms: f64) -> f64 {
    (ms * 1e3).round() / 1e3
}
