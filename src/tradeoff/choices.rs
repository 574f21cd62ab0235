//! Ten settings that somebody would choose from, compared as requests for the scene's own picture.

use super::answer::{self, Seen};
use super::findings::Reference;
use super::left_out::LeftOut;
use super::remarks::remarks;
use super::sweep::{Settings, brief};
use crate::metrics::{Difference, Image8};
use crate::scene::description::Precision;
use crate::trace::counts::RayCounts;
use schemars::JsonSchema;
use serde::Serialize;

/// Which setting to take: an answer in a sentence, and what it rests on.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "TradeoffChoices")]
pub struct Choices {
    /// Which setting to take, what it costs and what is lost, and what less and more would cost.
    pub answer: String,
    /// What the answer and the numbers leave open, in a sentence each: which mode of the scene and which choice of samples is not
    /// compared, against what is proved, and why nothing is or less than was measured.
    pub remarks: Vec<String>,
    /// The picture that differences are from; none if there was no time for one.
    pub reference: Option<Reference>,
    /// Width and height of the pictures that were compared. Times are those of the picture asked for; where that is larger,
    /// they are scaled up.
    pub size: [u32; 2],
    /// Milliseconds that a request spends on loading the scene.
    pub load_ms: f64,
    /// Milliseconds that a request spends on encoding the picture as PNG.
    pub encode_ms: f64,
    /// The settings, those that take least first; at the end those that the time did not suffice for.
    pub all: Vec<Choice>,
    /// The one to take: the quickest of those that look as good as the best, and of those that take as long the best.
    pub recommended: Option<usize>,
    /// The best one that takes clearly less time.
    pub quicker: Option<usize>,
    /// The quickest that is the reference's picture in every pixel.
    pub exact: Option<usize>,
    /// Whether requests that name no number of samples leave it to the pixels.
    #[serde(skip)]
    pub(super) is_adaptive: bool,
}

/// One setting, with the samples that the scene asks for.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "TradeoffChoice")]
pub struct Choice {
    /// Its name; `proved:1` is what requests get that ask for nothing, of scenes that ask for nothing.
    pub name: String,
    /// The settings.
    pub settings: Settings,
    /// Milliseconds of a whole request: loading the scene, tracing (the shortest of repeats) and encoding the picture. None if
    /// it was not measured in the time there was.
    pub request_ms: Option<f64>,
    /// Rays by kind, of the picture compared.
    pub rays: Option<RayCounts>,
    /// From the reference. None if there was no time for one.
    pub difference: Option<Difference>,
    /// The bound proved for the end of the recursion, in 8-bit codes, if there is one: where the settings have `max_codes`,
    /// compared with recursion to their `max_depth`, elsewhere with recursion without end.
    pub proved_codes: Option<u8>,
    /// The picture.
    #[serde(skip)]
    pub picture: Option<Image8>,
}

/// Depths of the choices.
const DEPTHS: [u32; 3] = [3, 5, 10];
/// Contribution cut-offs of the choices.
const WEIGHTS: [f64; 3] = [0.1, 0.03, 1.0 / 255.0];
/// Settings take clearly less time if it is at most this share.
pub(super) const CLEARLY_LESS: f64 = 0.75;

/// Times that differ by no more than this factor are equal: a machine does other work, too.
pub(super) const NOISE: f64 = 1.15;

/// The settings to choose from for a scene that asks for some, with their names. Proofs are held against recursion to
/// `proved_depth`, none being without end.
pub fn settings(asked: Settings, proved_depth: Option<u32>) -> Vec<(String, Settings)> {
    let fixed = asked.fixed();
    let proved = |codes| fixed.proved(codes, proved_depth);
    let mut all = Vec::new();
    all.extend(DEPTHS.map(|depth| (format!("depth {depth}"), Settings { max_depth: Some(depth), ..fixed })));
    all.extend(
        WEIGHTS.map(|min_weight| (format!("weight {}", brief(min_weight)), Settings { min_weight, ..fixed.deep() })),
    );
    let (_, has_edges) = asked.positions();
    if has_edges {
        // Where edges are smoothed, most of the time goes there.
        all.push((NO_ANTIALIASING.to_owned(), Settings { antialias: false, ..proved(1) }));
    }
    all.push(("proved:2".to_owned(), proved(2)));
    all.push((DEFAULT.to_owned(), proved(1)));
    let finest = Settings { precision: Precision::Double, ..proved(0) };
    let double = if asked.precision == Precision::Double { "" } else { ", double" };
    all.push((format!("proved:0{double}"), finest));
    // The proved mode does not look at weights.
    let alike = |s: &Settings| match asked.max_codes {
        Some(_) => Settings { min_weight: asked.min_weight, ..*s } == asked,
        None => *s == asked,
    };
    if !all.iter().any(|(_, settings)| alike(settings)) {
        all.push((ASKED.to_owned(), asked));
    }
    all
}

/// What requests get that ask for nothing, of scenes that ask for nothing.
pub(super) const DEFAULT: &str = "proved:1";
/// The default with one sample in the middle of each pixel, where edges have more.
pub(super) const NO_ANTIALIASING: &str = "no antialiasing";
/// What the scene itself asks for.
pub(super) const ASKED: &str = "as the scene says";

/// How choices were measured.
#[derive(Debug, Clone, Default)]
pub struct Measurement {
    /// Width and height of the pictures that were compared.
    pub size: [u32; 2],
    /// Width and height of the picture asked for.
    pub asked_size: [u32; 2],
    /// Milliseconds that a request spends on loading the scene.
    pub load_ms: f64,
    /// Milliseconds that a request spends on encoding the picture.
    pub encode_ms: f64,
    /// The picture that differences are from.
    pub reference: Option<Reference>,
    /// The depth of the pictures that proofs are held against; none is without end.
    pub proved_depth: Option<u32>,
    /// What is proved, or why nothing is.
    pub why_proved: String,
    /// What the scene asks for and is not compared.
    pub left_out: LeftOut,
}

impl Choices {
    /// The choices among what was measured.
    pub fn among(mut all: Vec<Choice>, measured: Measurement) -> Self {
        let Measurement { size, asked_size, load_ms, encode_ms, reference, .. } = measured;
        all.sort_by(|a, b| {
            let ms = |choice: &Choice| choice.request_ms.unwrap_or(f64::INFINITY);
            ms(a).total_cmp(&ms(b))
        });
        let recommended = recommended(&all);
        let quicker = recommended.and_then(|index| quicker(&all, index));
        let exact = all.iter().position(|choice| choice.request_ms.is_some() && choice.is_exact());
        let (answer, remarks) = (String::new(), remarks(&all, &measured));
        let is_adaptive = measured.left_out.is_adaptive();
        let mut choices = Self {
            answer,
            remarks,
            reference,
            size,
            load_ms,
            encode_ms,
            all,
            recommended,
            quicker,
            exact,
            is_adaptive,
        };
        choices.answer = answer::sentences(&choices, size != asked_size);
        choices
    }

    /// Whether requests that ask for nothing get what is called the default.
    pub(super) fn has_default(&self) -> bool {
        !self.is_adaptive && !self.all.iter().any(|choice| choice.name == ASKED)
    }

    /// Whether the reference is known to be exact.
    pub(super) fn knows_exact(&self) -> bool {
        self.reference.as_ref().is_some_and(Reference::is_exact)
    }

    /// Up to three choices to look at, by growing time: those that the answer speaks of, or else the ends.
    pub fn shown(&self) -> Vec<usize> {
        let pictured = |index: &usize| self.all[*index].picture.is_some() && self.all[*index].request_ms.is_some();
        let ends = (0..self.all.len()).find(pictured).into_iter().chain((0..self.all.len()).rfind(pictured));
        let mut shown: Vec<usize> = Vec::new();
        for index in [self.recommended, self.quicker, self.exact].into_iter().flatten().chain(ends) {
            if shown.len() < 3 && pictured(&index) && !shown.contains(&index) {
                shown.push(index);
            }
        }
        shown.sort_unstable();
        shown
    }
}

/// The quickest of those that look as good as the best; of those that take as long the best, and of those that look the same the
/// default.
fn recommended(all: &[Choice]) -> Option<usize> {
    let measured = || (0..all.len()).filter(|index| all[*index].request_ms.is_some());
    let codes = |index: usize| all[index].codes().unwrap_or(f64::INFINITY);
    let best = measured().map(codes).fold(f64::INFINITY, f64::min);
    if best == f64::INFINITY {
        // Without a picture to compare with, only what is proved or what the scene asks for.
        return [DEFAULT, ASKED].into_iter().find_map(|name| measured().find(|&index| all[index].name == name));
    }
    let ms = |index: usize| all[index].request_ms.unwrap_or(f64::INFINITY);
    let good = |tolerance: f64| measured().filter(move |&index| Seen::of(codes(index) - tolerance) <= Seen::of(best));
    let least = |tolerance: f64| good(tolerance).map(ms).fold(f64::INFINITY, f64::min);
    // Where it saves much time, a code more than its class makes no difference.
    let tolerance = if least(1.0) <= CLEARLY_LESS * least(0.0) { 1.0 } else { 0.0 };
    let least_ms = least(tolerance);
    let most = |index: usize| all[index].most_codes().unwrap_or(f64::INFINITY);
    let is_default = |index: usize| all[index].name == DEFAULT;
    let order = |a: &usize, b: &usize| {
        let (a, b) = (*a, *b);
        (Seen::of(codes(a)).cmp(&Seen::of(codes(b))))
            .then(Seen::of(most(a)).cmp(&Seen::of(most(b))))
            .then(is_default(b).cmp(&is_default(a)))
            .then(codes(a).total_cmp(&codes(b)))
            .then(most(a).total_cmp(&most(b)))
            .then(ms(a).total_cmp(&ms(b)))
    };
    let chosen = good(tolerance).filter(|&index| ms(index) <= NOISE * least_ms).min_by(order)?;
    // The default in place of what takes as long and looks the same, unless something beats it.
    let alike = |index: usize| {
        let seen = |index: usize| (Seen::of(codes(index)), Seen::of(most(index)));
        ms(index) <= NOISE * ms(chosen) && seen(index) == seen(chosen)
    };
    let is_beaten = |index: usize| {
        measured().any(|by| NOISE * ms(by) < ms(index) && codes(by) <= codes(index) && most(by) <= most(index))
    };
    let default = measured().find(|&index| is_default(index) && alike(index) && !is_beaten(index));
    default.or(Some(chosen))
}

/// The one with the least difference of those that take clearly less time.
fn quicker(all: &[Choice], recommended: usize) -> Option<usize> {
    let most = CLEARLY_LESS * all[recommended].request_ms?;
    let candidates = (0..all.len()).filter(|&i| all[i].request_ms.is_some_and(|ms| ms <= most));
    let codes = |index: &usize| all[*index].codes().unwrap_or(f64::INFINITY);
    candidates.filter(|index| codes(index).is_finite()).min_by(|a, b| codes(a).total_cmp(&codes(b)))
}

impl Choice {
    /// Codes that all pixels but one of 1000 are at most off.
    pub fn codes(&self) -> Option<f64> {
        self.difference.map(|difference| difference.codes.error.p999)
    }

    /// Codes that the worst pixel is off.
    pub fn most_codes(&self) -> Option<f64> {
        self.difference.map(|difference| difference.codes.error.max)
    }

    /// Whether no pixel differs.
    pub fn is_exact(&self) -> bool {
        self.most_codes() == Some(0.0)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::metrics::Spread;

    /// A setting as asked by a scene that names none.
    fn asked() -> Settings {
        Settings {
            max_depth: None,
            min_weight: 1e-3,
            max_codes: Some(1),
            samples: 1,
            antialias: true,
            precision: Precision::Single,
        }
    }

    /// Pictures of the size asked for, against an exact one.
    pub(crate) fn measured() -> Measurement {
        let reference = Reference { max_depth: Some(1000), min_weight: 0.0, max_codes: None, dropped: 0, finer: None };
        Measurement { size: [1, 1], asked_size: [1, 1], reference: Some(reference), ..Measurement::default() }
    }

    /// A difference of some codes in all pixels but single ones.
    pub(crate) fn difference(codes: f64, most: f64) -> Difference {
        let picture = Image8::opaque(1, vec![[0; 3]]);
        let mut difference = Difference::of(&picture, &picture);
        difference.codes.error = Spread { p999: codes, max: most, ..difference.codes.error };
        difference
    }

    /// Choices of a time and a difference each. The first are depths and weights, the last the exact one.
    pub(crate) fn choices(measured: &[(f64, f64)]) -> Choices {
        let named = measured.iter().zip(settings(asked(), None)).map(|(&measured, (name, _))| (name, measured));
        choices_of(&named.map(|(name, (ms, codes))| (name, Some(ms), Some(codes), None)).collect::<Vec<_>>())
    }

    /// Name, time, difference and proof of a choice.
    pub(crate) type Measured = (String, Option<f64>, Option<f64>, Option<u8>);

    /// Choices that were measured.
    pub(crate) fn choices_of(all: &[Measured]) -> Choices {
        let known = settings(asked(), None);
        let choice = |(name, request_ms, codes, proved_codes): &Measured| Choice {
            name: name.clone(),
            settings: known.iter().find(|(known, _)| known == name).map_or_else(asked, |(_, settings)| *settings),
            request_ms: *request_ms,
            rays: None,
            difference: codes.map(|codes| difference(codes, codes)),
            proved_codes: *proved_codes,
            picture: Some(Image8::opaque(1, vec![[0; 3]])),
        };
        Choices::among(all.iter().map(choice).collect(), measured())
    }

    #[test]
    fn about_ten_settings_are_compared_and_what_the_scene_asks_for_is_among_them() {
        for max_codes in [None, Some(0), Some(1), Some(2)] {
            for (antialias, precision) in [(true, Precision::Single), (false, Precision::Double)] {
                let max_depth = if max_codes.is_none() { Some(10) } else { None };
                let asked = Settings { max_depth, max_codes, antialias, precision, ..asked() };
                let all = settings(asked, None);
                assert!((9..=11).contains(&all.len()), "{asked}: {}", all.len());
                let is_asked =
                    |s: &Settings| s.max_codes == max_codes && (s.antialias, s.precision) == (antialias, precision);
                assert!(all.iter().any(|(_, settings)| is_asked(settings)), "{asked}: {all:?}");
                for (i, (name, settings)) in all.iter().enumerate() {
                    assert!(all[..i].iter().all(|(other, same)| other != name && same != settings), "{asked}: {name}");
                }
            }
        }
    }

    #[test]
    fn the_quickest_that_looks_as_good_as_the_best_is_recommended() {
        // Name, time, codes of nearly all pixels, and of the worst.
        type Row = (&'static str, f64, f64, f64);
        let cases: [(&[Row], &str); 9] = [
            // What the scene says is as quick as the default, and nearer.
            (
                &[
                    ("weight 0.1", 1200.0, 40.0, 90.0),
                    ("as the scene says", 1400.0, 1.0, 4.0),
                    ("proved:1", 1600.0, 1.0, 14.0),
                ],
                "as the scene says",
            ),
            // Of those that look the same the quickest.
            (
                &[("depth 5", 72.0, 1.0, 1.0), ("proved:1", 100.0, 1.0, 1.0), ("proved:0, double", 150.0, 0.0, 0.0)],
                "depth 5",
            ),
            // Times are noise, and the default is as good.
            (&[("depth 5", 95.0, 1.0, 1.0), ("proved:1", 100.0, 1.0, 1.0)], "proved:1"),
            // 2 codes are 1 more than nobody sees.
            (
                &[
                    ("weight 0.03", 3600.0, 2.0, 9.0),
                    ("proved:1", 4000.0, 2.0, 2.0),
                    ("proved:0, double", 5600.0, 0.0, 0.0),
                ],
                "proved:1",
            ),
            (
                &[("depth 3", 5.0, 90.0, 200.0), ("depth 10", 10.0, 12.0, 40.0), ("proved:1", 20.0, 3.0, 3.0)],
                "proved:1",
            ),
            (
                &[("weight 0.1", 100.0, 9.0, 20.0), ("depth 10", 110.0, 8.0, 12.0), ("weight 1/255", 120.0, 3.0, 3.0)],
                "depth 10",
            ),
            (&[("depth 3", 5.0, 90.0, 200.0)], "depth 3"),
            (
                &[("depth 3", 2466.0, 1.0, 3.0), ("depth 10", 2771.0, 0.0, 1.0), ("proved:1", 2883.0, 1.0, 1.0)],
                "proved:1",
            ),
            // A code more is too much for a little time.
            (&[("proved:2", 12.0, 2.0, 2.0), ("proved:1", 14.0, 1.0, 2.0)], "proved:1"),
        ];
        for (measured, name) in cases {
            let named = measured.iter().map(|&(name, ms, codes, _)| (name.to_owned(), Some(ms), Some(codes), None));
            let mut all = choices_of(&named.collect::<Vec<_>>()).all;
            for (choice, &(.., codes, most)) in all.iter_mut().zip(measured) {
                choice.difference = Some(difference(codes, most));
            }
            let recommended = &all[recommended(&all).unwrap()];
            assert_eq!(recommended.name, name, "{measured:?}");
            let beats = |other: &Choice| {
                NOISE * other.request_ms.unwrap() < recommended.request_ms.unwrap()
                    && other.codes() <= recommended.codes()
                    && other.most_codes() <= recommended.most_codes()
            };
            assert!(!all.iter().any(beats), "{measured:?}");
        }
    }

    #[test]
    fn antialiasing_is_left_out_only_where_there_is_some() {
        for (samples, antialias) in [(1, true), (1, false), (64, true)] {
            let asked = Settings { samples, antialias, ..asked() };
            let is_there = settings(asked, None).iter().any(|(name, _)| name == "no antialiasing");
            assert_eq!(is_there, (samples, antialias) == (1, true));
        }
    }

    #[test]
    fn proofs_are_held_against_the_depth_that_requests_have() {
        for depth in [None, Some(10)] {
            let all = settings(Settings { max_depth: depth, ..asked() }, depth);
            assert!(
                all.iter().all(|(_, settings)| settings.max_codes.is_none() || settings.max_depth == depth),
                "{all:?}"
            );
            assert!(!all.iter().any(|(name, _)| name == ASKED), "{all:?}");
        }
    }

    #[test]
    fn three_are_shown_by_growing_time() {
        let named = |name: &str, ms, codes| (name.to_owned(), Some(ms), Some(codes), None);
        let all = [
            named("proved:0, double", 60.0, 0.0),
            named("proved:1", 20.0, 1.0),
            named("depth 3", 5.0, 90.0),
            named("depth 10", 10.0, 3.0),
        ];
        let choices = choices_of(&all);
        let names: Vec<&str> = choices.shown().iter().map(|&i| choices.all[i].name.as_str()).collect();
        assert_eq!(names, ["depth 10", "proved:1", "proved:0, double"]);
        // Where nothing is exact, the ends are shown.
        let choices = choices_of(&all[1..]);
        assert_eq!(choices.shown(), [0, 1, 2]);
        assert_eq!((choices_of(&all[1..2]).shown(), choices_of(&[]).shown()), (vec![0], vec![]));
    }
}
