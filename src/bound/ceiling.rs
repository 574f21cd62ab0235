//! The radiance ceiling: an upper bound on the radiance of any ray in a scene, so on what an omitted ray could have added.
//!
//! A surface adds at most A and sends on at most g of what comes. So with the background B (fog and surroundings included)
//!
//! U = max(B, max over materials of A / (1 - g)),
//!
//! where materials with A = 0 and g <= 1 do not count: if U bounds what arrives, A + g U <= U bounds what leaves. Where some
//! g is too large for that, U_n = max(B, max A + g U_(n-1)) bounds chains of at most n rays, with U_0 = 0.

use crate::math::Rgb;
use schemars::JsonSchema;
use serde::Serialize;

/// An upper bound on the radiance of any ray, for each channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Ceiling {
    /// U by the number of rays that a chain may still have, the ray itself included; the last entry is for that number and
    /// all larger ones. [`NO_BOUND`] where there is no bound.
    levels: Vec<[f64; 3]>,
    /// The largest factor on the light of a transparent background, seen through bodies.
    clear: f64,
    /// What it is about.
    pub reach: Reach,
}

/// What pictures are held against, and why.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Reach {
    /// Longest chain of rays of that picture; none for recursion without end.
    pub max_depth: Option<u32>,
    /// The largest radiance of a ray that may go on for all of it. None where nothing bounds it.
    pub ceiling: Option<[f64; 3]>,
    /// What decides that, in a sentence.
    pub why: String,
    /// JSON pointers of what the sentence is about.
    pub because: Vec<String>,
}

/// Factor on ceilings for the roundings of the kernel, mainly those of a highlight's power.
const SLACK: f64 = 1.002;

/// What stands for infinity: a weight of 0 times it is 0, not NaN.
const NO_BOUND: f64 = 1e28;

/// Longest chains whose ceilings are kept one by one.
const LEVELS: u32 = 4_096;

/// Steps, one for each material and ray of a chain, that a ceiling may take: some 10 ms.
const MOST_STEPS: u64 = 10_000_000;

/// The largest g with which a scene counts as bounded without a limit of depth: chains of 4,096 rays come as near to that
/// as any format can tell.
const MOST_SENT: f64 = 0.99;

/// What one material adds and sends on at most, for each channel.
#[derive(Debug, Clone)]
pub struct MaterialBound {
    /// JSON pointer of the material, if it has one.
    pub pointer: Option<String>,
    /// A: what its surfaces add.
    pub adds: Rgb,
    /// g: the share of what comes that they send on.
    pub sends: Rgb,
}

impl Ceiling {
    /// A ceiling that bounds nothing, for chains of at most `max_depth` rays.
    pub fn unbounded(max_depth: u32, why: String, because: Vec<String>) -> Self {
        Self::of_levels(vec![[f64::INFINITY; 3]], max_depth, why, because)
    }

    /// For recursion without end. Where a material makes that impossible, for chains of at most `max_depth` rays.
    /// `split` is the largest factor that splitting light into wavelengths puts on it.
    pub fn endless(beyond: Rgb, materials: &[MaterialBound], split: Rgb, max_depth: u32) -> Self {
        match steady(beyond, materials) {
            Ok((most, by)) => {
                let radiance = (most * split).to_array().map(|c| c * SLACK);
                let why = match by {
                    Some(_) => "of what a material adds, and of what it sends on again and again: A/(1 - g)",
                    None => "nothing is brighter than the background",
                };
                let because = by.and_then(|material| material.pointer.clone()).into_iter().collect();
                let reach = Reach { max_depth: None, ceiling: Some(radiance), why: why.to_owned(), because };
                Self { levels: vec![radiance], clear: 1.0, reach }
            }
            Err(material) => {
                let why = "a material sends on nearly all light that it gets, or more, and adds some: recursion \
                           without end has no bound, or none that would be of use";
                let because = material.pointer.clone().into_iter().collect();
                Self::by_depth(beyond, materials, split, max_depth, why.to_owned(), because)
            }
        }
    }

    /// For chains of at most `max_depth` rays.
    pub fn by_depth(
        beyond: Rgb,
        materials: &[MaterialBound],
        split: Rgb,
        max_depth: u32,
        why: String,
        because: Vec<String>,
    ) -> Self {
        let mut levels = vec![[0.0; 3]];
        let mut below = Rgb::ZERO;
        for _ in 0..max_depth.min(LEVELS) {
            below = longer(beyond, materials, below);
            levels.push((below * split).to_array());
        }
        if max_depth > LEVELS {
            levels.push((longest(beyond, materials, below, max_depth - LEVELS) * split).to_array());
        }
        Self::of_levels(levels, max_depth, why, because)
    }

    /// By the number of rays in a chain, entry 0 being that of no ray.
    fn of_levels(levels: Vec<[f64; 3]>, max_depth: u32, why: String, because: Vec<String>) -> Self {
        let levels: Vec<[f64; 3]> = levels.into_iter().map(|level| level.map(|c| c * SLACK)).collect();
        let ceiling = levels.last().copied().filter(|level| level.iter().all(|c| c.is_finite()));
        let levels = levels.into_iter().map(|level| level.map(|c| c.min(NO_BOUND))).collect();
        Self { levels, clear: 1.0, reach: Reach { max_depth: Some(max_depth), ceiling, why, because } }
    }

    /// The most that a ray sees of a transparent background which begins a chain of at most `rays`: nothing where it is of none.
    pub fn clear(&self, rays: u32) -> f64 {
        if rays == 0 && self.reach.max_depth.is_some() { 0.0 } else { self.clear }
    }

    /// Multiplies it. Tests use it to see that a ceiling which is too low is noticed.
    pub fn scale(&mut self, factor: f64) {
        self.levels.iter_mut().flatten().for_each(|level| *level *= factor);
        self.clear *= factor;
    }

    /// The same with the largest factor on the light of a transparent background.
    #[must_use]
    pub fn with_clear(self, clear: f64) -> Self {
        Self { clear: (clear * SLACK).min(NO_BOUND), ..self }
    }

    /// The ceiling of a ray that begins a chain of at most `rays`.
    pub fn of(&self, rays: u32) -> [f64; 3] {
        self.levels[(rays as usize).min(self.levels.len() - 1)]
    }
}

/// U without slack: for recursion without end, or where that has no bound for chains of at most `max_depth` rays.
pub fn brightest(beyond: Rgb, materials: &[MaterialBound], max_depth: u32) -> Rgb {
    let by_depth = |_| longest(beyond, materials, Rgb::ZERO, max_depth).min(Rgb::splat(NO_BOUND));
    steady(beyond, materials).map(|(most, _)| most).unwrap_or_else(by_depth)
}

/// U_n by U_(n-1).
fn longer(beyond: Rgb, materials: &[MaterialBound], below: Rgb) -> Rgb {
    materials.iter().fold(beyond, |most, m| most.max(m.adds + m.sends * below))
}

/// U_(n + rays) by U_n; without bound where that would take too long to say.
fn longest(beyond: Rgb, materials: &[MaterialBound], mut below: Rgb, rays: u32) -> Rgb {
    if u64::from(rays) * materials.len() as u64 > MOST_STEPS {
        return Rgb::splat(f64::INFINITY);
    }
    for _ in 0..rays {
        let next = longer(beyond, materials, below);
        if next == below {
            break;
        }
        below = next;
    }
    below
}

/// U = max(B, max A / (1 - g)) and the material that decides it; or the material whose g is too large.
fn steady(beyond: Rgb, materials: &[MaterialBound]) -> Result<(Rgb, Option<&MaterialBound>), &MaterialBound> {
    let (mut most, mut by) = (beyond, None);
    // Of materials that say the same the one with the first pointer is named, in whatever order the scene has them.
    let mut in_order: Vec<&MaterialBound> = materials.iter().collect();
    in_order.sort_by(|a, b| a.pointer.cmp(&b.pointer));
    for material in in_order {
        for c in 0..3 {
            let (adds, sends) = (material.adds[c], material.sends[c]);
            let least = match () {
                () if adds == 0.0 && sends <= 1.0 => 0.0,
                () if sends <= MOST_SENT => adds / (1.0 - sends),
                () => return Err(material),
            };
            if least > most[c] {
                most[c] = least;
                by = Some(material);
            }
        }
    }
    Ok((most, by))
}
