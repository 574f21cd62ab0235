//! Which setting to take, in short sentences for somebody who has never heard of any.

use super::advice::{figure, percent};
use super::choices::{ASKED, CLEARLY_LESS, Choice, Choices, DEFAULT, NOISE};

/// The most 8-bit codes that are invisible, that are seen if two pictures take turns in one place, and side by side.
pub(super) const SEEN_UP_TO: [f64; 3] = [1.0, 10.0, 30.0];

/// How far a difference is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Seen {
    /// Not at all.
    Invisible,
    /// When the two pictures take turns in one place.
    Flicker,
    /// When they stand side by side.
    SideBySide,
    /// At once.
    Obvious,
}

impl Seen {
    /// How a difference of some 8-bit codes is seen.
    pub(super) fn of(codes: f64) -> Self {
        let all = [Self::Invisible, Self::Flicker, Self::SideBySide];
        let first = all.into_iter().zip(SEEN_UP_TO).find(|(_, most)| codes <= *most);
        first.map_or(Self::Obvious, |(seen, _)| seen)
    }

    /// After "which": how it is seen.
    fn verb(self) -> &'static str {
        match self {
            Self::Invisible => "nobody sees",
            Self::Flicker => "show only if the two pictures take turns",
            Self::SideBySide => "show when pictures stand side by side",
            Self::Obvious => "are obvious",
        }
    }
}

/// The whole answer.
pub(super) fn sentences(choices: &Choices, scaled: bool) -> String {
    let measured = || choices.all.iter().filter(|choice| choice.request_ms.is_some());
    let Some((index, ms)) = choices.recommended.and_then(|i| Some((i, choices.all[i].request_ms?))) else {
        return match measured().count() {
            0 => "Nothing could be measured in the time there was: allow more seconds, or ask for a smaller picture.",
            _ => "No setting can be judged, as there was no time for a picture to compare with: allow more seconds.",
        }
        .into();
    };
    let recommended = &choices.all[index];
    let in_words = |choice: &Choice| in_words(choices, choice);
    let about = if scaled { "about " } else { "" };
    let mut all = Vec::new();
    if measured().count() > 1 && measured().all(Choice::is_exact) {
        let last_bit = if choices.knows_exact() { ", to the last bit" } else { "" };
        let name = capital(&in_words(recommended));
        all.push(format!("{name} takes {about}{}. Every other setting gives the same picture{last_bit}", duration(ms)));
        if let Some((quicker, part)) = choices.quicker.and_then(|i| Some((&choices.all[i], choices.all[i].request_ms?)))
        {
            all.push(format!("{} takes {} that time", capital(&in_words(quicker)), share(part / ms)));
        }
    } else {
        all.push(format!("Take {}: {about}{}{}", in_words(recommended), duration(ms), loss(choices, recommended)));
        if measured().count() == 1 {
            all.push("There was no time to measure other settings".to_owned());
        } else if measured().all(|choice| choice.difference.is_none()) {
            all.push(
                "No other setting can be judged, as there was no time for a picture to compare with: allow more seconds".to_owned(),
            );
        } else {
            let parts = [quicker(choices, ms), default(choices, index, ms), exact(choices, index, ms)];
            all.extend(parts.into_iter().flatten());
        }
    }
    if let Some(codes) = choices.reference.as_ref().and_then(|reference| reference.max_codes) {
        all.push(format!(
            "Differences are from proved:{codes} in double precision, as there was no time for the exact picture"
        ));
    }
    all.join(". ") + "."
}

/// A setting for those who do not know it.
fn in_words(choices: &Choices, choice: &Choice) -> String {
    let name = choice.name.as_str();
    match name.split_once(' ') {
        _ if name == DEFAULT && choices.has_default() => format!("the default ({DEFAULT})"),
        _ if name == ASKED => "the scene's own settings".to_owned(),
        Some(("depth", rays)) => format!("{name} (at most {rays} rays in a chain)"),
        Some(("weight", _)) => format!("{name} (fainter rays are left out)"),
        _ => name.replace(", double", " in double precision"),
    }
}

/// What a picture lacks, after "14 ms".
fn loss(choices: &Choices, choice: &Choice) -> String {
    let mut text = match (choice.codes(), choice.proved_codes) {
        (Some(_), _) if choice.is_exact() => format!(", {}", same(choices)),
        (Some(codes), _) if Seen::of(codes) == Seen::Invisible => ", and nothing you can see is missing".to_owned(),
        (Some(codes), _) => format!(", off by {}, which {}", of_255(codes), Seen::of(codes).verb()),
        (None, Some(codes)) => format!(", proved to be off by at most {}", of_255(f64::from(codes))),
        (None, None) => String::new(),
    };
    if let (Some(codes), Some(most)) = (choice.codes(), choice.most_codes())
        && Seen::of(most) > Seen::of(codes).max(Seen::Flicker)
    {
        text.push_str(&format!(" (but for fewer than 1 pixel in 1000, up to {} off)", figure(most)));
    }
    text
}

/// What a picture is that does not differ from the reference.
fn same(choices: &Choices) -> &'static str {
    if choices.knows_exact() { "exact to the last bit" } else { "the same as the best picture there was time for" }
}

/// What clearly less time costs.
fn quicker(choices: &Choices, ms: f64) -> Option<String> {
    let Some(quicker) = choices.quicker.map(|index| &choices.all[index]) else {
        return Some(format!("No other setting takes less than {} of that time", percent(CLEARLY_LESS)));
    };
    let (codes, part) = (quicker.codes()?, share(quicker.request_ms? / ms));
    let takes = format!("Quicker: {} takes {part} that time and is", in_words(choices, quicker));
    Some(match Seen::of(codes) {
        _ if quicker.is_exact() => format!("{takes} {}, too", same(choices)),
        seen => format!("{takes} off by {}, which {}", of_255(codes), seen.verb()),
    })
}

/// What the default costs and gains, where it is not the one to take.
fn default(choices: &Choices, recommended: usize, ms: f64) -> Option<String> {
    let known = |index: &Option<usize>| index.is_some_and(|index| choices.all[index].name == DEFAULT);
    if [Some(recommended), choices.quicker, choices.exact].iter().any(known) {
        return None;
    }
    let default = choices.all.iter().find(|choice| choice.name == DEFAULT)?;
    let Some(its) = default.request_ms else {
        return Some(format!("There was no time for {}", in_words(choices, default)));
    };
    let gain = match (default.codes()?, choices.all[recommended].codes()?) {
        (a, b) if a < b => format!("off by {} instead of {}", figure(a), figure(b)),
        (a, b) if a == b => "no nearer".to_owned(),
        (a, _) => format!("off by {}", of_255(a)),
    };
    Some(format!("{} takes {}, {gain}", capital(&in_words(choices, default)), as_long(its / ms)))
}

/// What the exact picture costs, if it is another one.
fn exact(choices: &Choices, recommended: usize, ms: f64) -> Option<String> {
    if choices.all[recommended].is_exact() {
        return None;
    }
    if let Some(index) = choices.exact {
        let exact = &choices.all[index];
        let is_new = index != recommended && Some(index) != choices.quicker;
        let takes = as_long(exact.request_ms? / ms);
        return is_new.then(|| format!("{}: {} takes {takes}", capital(same(choices)), in_words(choices, exact)));
    }
    let known = choices.all.iter().enumerate().filter_map(|(i, choice)| Some((i, choice, choice.codes()?)));
    let (index, nearest, codes) = known.min_by(|a, b| a.2.total_cmp(&b.2))?;
    // The default was spoken of already.
    if index == recommended || Some(index) == choices.quicker || nearest.name == DEFAULT {
        return None;
    }
    let off = if codes > 0.0 {
        format!("off by {}", of_255(codes))
    } else {
        format!("exact but for fewer than 1 pixel in 1000 (up to {} off)", figure(nearest.most_codes()?))
    };
    Some(format!("Nearest: {} takes {} and is {off}", in_words(choices, nearest), as_long(nearest.request_ms? / ms)))
}

/// A time beside another, after "takes".
fn as_long(ratio: f64) -> String {
    match ratio {
        ratio if ratio < 0.9 => format!("{} that time", share(ratio)),
        ratio if ratio < NOISE => "as long".to_owned(),
        _ => format!("{} times as long", times(ratio)),
    }
}

/// "3 of 255 codes".
fn of_255(codes: f64) -> String {
    format!("{} of 255 codes", figure(codes))
}

fn counted(codes: f64) -> String {
    format!("{} code{}", figure(codes), if codes == 1.0 { "" } else { "s" })
}

/// A part of a time in words, to be followed by "the time".
fn share(ratio: f64) -> String {
    match ratio {
        0.45..0.56 => "half".to_owned(),
        0.30..0.37 => "a third of".to_owned(),
        0.22..0.28 => "a quarter of".to_owned(),
        _ => format!("{:.0} % of", (100.0 * ratio).max(1.0)),
    }
}

/// A ratio in two digits.
fn times(ratio: f64) -> String {
    if ratio < 2.95 {
        let text = format!("{ratio:.1}");
        return text.strip_suffix(".0").map_or(text.clone(), str::to_owned);
    }
    let rounded = format!("{ratio:.0}");
    if rounded.len() < 3 { rounded } else { figure(ratio) }
}

/// A time in a fitting unit.
pub fn duration(ms: f64) -> String {
    match ms {
        ..0.995 => format!("{ms:.2} ms"),
        ..9.95 => format!("{} ms", trimmed(ms)),
        ..995.0 => format!("{ms:.0} ms"),
        ..9950.0 => format!("{} s", trimmed(ms / 1e3)),
        ..119_500.0 => format!("{:.0} s", ms / 1e3),
        _ => format!("{:.0} min", ms / 6e4),
    }
}

/// One decimal, unless it is 0.
fn trimmed(x: f64) -> String {
    let text = format!("{x:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

fn capital(name: &str) -> String {
    // A setting is spelt as it is asked for.
    if name.starts_with("proved:") {
        return name.to_owned();
    }
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// How a picture differs, in few words for its caption.
pub(super) fn in_short(choices: &Choices, choice: &Choice) -> String {
    let Some(codes) = choice.codes() else {
        return choice.proved_codes.map_or_else(
            || "difference not measured".to_owned(),
            |codes| format!("proved: at most {} off", counted(f64::from(codes))),
        );
    };
    match Seen::of(codes) {
        _ if choice.is_exact() && choices.knows_exact() => "exact to the last bit".to_owned(),
        _ if choice.is_exact() => "as the best picture".to_owned(),
        Seen::Invisible => "nothing you can see is missing".to_owned(),
        Seen::Flicker => format!("{} off: seen only if pictures take turns", counted(codes)),
        Seen::SideBySide => format!("{} off: seen side by side", counted(codes)),
        Seen::Obvious => format!("{} off: obvious", counted(codes)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::choices::tests::{choices, choices_of, difference};
    use super::*;

    type Measured = (&'static str, Option<f64>, Option<f64>, Option<u8>);

    fn answer(all: &[Measured]) -> String {
        let all: Vec<_> = all.iter().map(|&(name, ms, codes, proved)| (name.to_owned(), ms, codes, proved)).collect();
        choices_of(&all).answer
    }

    const DEPTH: Measured = ("depth 5", Some(7.0), Some(3.0), None);
    const PROVED: Measured = ("proved:1", Some(14.0), Some(1.0), Some(1));
    const EXACT: Measured = ("proved:0, double", Some(56.0), Some(0.0), Some(0));

    #[test]
    fn it_says_what_to_take_what_half_the_time_costs_and_what_exactness_does() {
        assert_eq!(
            answer(&[DEPTH, PROVED, EXACT]),
            "Take the default (proved:1): 14 ms, and nothing you can see is missing. Quicker: depth 5 (at most 5 rays in a chain) \
             takes half that time and is off by 3 of 255 codes, which show only if the two pictures take turns. Exact to the last \
             bit: proved:0 in double precision takes 4 times as long."
        );
    }

    #[test]
    fn it_holds_in_all_extremes() {
        let cases: [(&[Measured], &str); 10] = [
            (&[], "Nothing could be measured in the time there was: allow more seconds, or ask for a smaller picture."),
            (
                &[PROVED],
                "Take the default (proved:1): 14 ms, and nothing you can see is missing. There was no time to measure other \
                 settings.",
            ),
            (
                &[
                    ("depth 3", Some(13.0), Some(0.0), None),
                    ("proved:1", Some(14.0), Some(0.0), Some(0)),
                    ("proved:0, double", Some(15.0), Some(0.0), Some(0)),
                ],
                "The default (proved:1) takes 14 ms. Every other setting gives the same picture, to the last bit.",
            ),
            // A proof that did not close.
            (
                &[DEPTH, ("proved:1", Some(1400.0), Some(0.5), Some(6))],
                "Take the default (proved:1): 1.4 s, and nothing you can see is missing. Quicker: depth 5 (at most 5 rays in a \
                 chain) takes 1 % of that time and is off by 3 of 255 codes, which show only if the two pictures take turns.",
            ),
            // The default was not done in time.
            (
                &[DEPTH, ("depth 3", Some(2.0), Some(120.0), None), ("proved:1", None, None, None)],
                "Take depth 5 (at most 5 rays in a chain): 7 ms, off by 3 of 255 codes, which show only if the two pictures take \
                 turns. Quicker: depth 3 (at most 3 rays in a chain) takes 29 % of that time and is off by 120 of 255 codes, which \
                 are obvious. There was no time for the default (proved:1).",
            ),
            // No reference, and nothing proved.
            (
                &[("depth 3", Some(7.0), None, None), ("depth 5", Some(14.0), None, None)],
                "No setting can be judged, as there was no time for a picture to compare with: allow more seconds.",
            ),
            // No reference.
            (
                &[("proved:1", Some(14.0), None, Some(1)), ("depth 3", Some(7.0), None, None)],
                "Take the default (proved:1): 14 ms, proved to be off by at most 1 of 255 codes. No other setting can be judged, as \
                 there was no time for a picture to compare with: allow more seconds.",
            ),
            (
                &[
                    ("depth 3", Some(12.0), Some(20.0), None),
                    PROVED,
                    ("proved:0, double", Some(16.5), Some(0.0), Some(0)),
                ],
                "Take the default (proved:1): 14 ms, and nothing you can see is missing. No other setting takes less than 75 % of \
                 that time. Exact to the last bit: proved:0 in double precision takes 1.2 times as long.",
            ),
            // Something quicker looks the same.
            (
                &[("weight 0.03", Some(7.0), Some(1.0), None), PROVED, EXACT],
                "Take weight 0.03 (fainter rays are left out): 7 ms, and nothing you can see is missing. No other setting takes less \
                 than 75 % of that time. The default (proved:1) takes 2 times as long, no nearer. Exact to the last bit: proved:0 in \
                 double precision takes 8 times as long.",
            ),
            (
                &[("as the scene says", Some(7.0), Some(0.5), None), ("proved:1", Some(14.0), Some(0.0), None)],
                "Take the scene's own settings: 7 ms, and nothing you can see is missing. No other setting takes less than 75 % of \
                 that time. Exact to the last bit: proved:1 takes 2 times as long.",
            ),
        ];
        for (measured, text) in cases {
            assert_eq!(answer(measured), text);
        }
    }

    #[test]
    fn exactness_is_not_denied_where_only_single_pixels_differ() {
        let mut all = choices(&[(14.0, 1.0), (28.0, 0.0)]);
        all.all[1].difference = Some(difference(0.0, 2.0));
        all.exact = None;
        let said = sentences(&all, false);
        assert!(said.ends_with("is exact but for fewer than 1 pixel in 1000 (up to 2 off)."), "{said}");
    }

    #[test]
    fn a_reference_that_is_not_exact_is_named() {
        let mut all = choices(&[(14.0, 1.0), (28.0, 0.0)]);
        all.reference.as_mut().unwrap().max_codes = Some(1);
        let said = sentences(&all, false);
        assert!(said.ends_with(
            "Differences are from proved:1 in double precision, as there was no time for the exact picture."
        ));
        assert!(!said.contains("last bit"), "{said}");
    }

    #[test]
    fn single_pixels_that_are_far_off_are_not_concealed() {
        let mut all = choices(&[(14.0, 1.0)]);
        all.all[0].difference = Some(difference(1.0, 240.0));
        assert_eq!(
            loss(&all, &all.all[0]),
            ", and nothing you can see is missing (but for fewer than 1 pixel in 1000, up to 240 off)"
        );
    }

    #[test]
    fn it_is_short_whatever_was_measured() {
        let mut state = 1_u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1_u32 << 24)
        };
        for _ in 0..2000 {
            let count = (11.0 * random()) as usize;
            let all: Vec<(f64, f64)> = (0..count)
                .map(|_| {
                    (crate::math::pow(10.0, 7.0 * random() - 1.0), libm::floor(crate::math::pow(256.0, random())) - 1.0)
                })
                .collect();
            let text = choices(&all).answer;
            assert!(text.ends_with('.') && !text.contains("..") && text.len() < 560, "{text}");
            for bad in ["  ", "NaN", "inf", "e-", " 0 ms", "1 codes", ";;", "; ;", " ;", " ,", " 0 of 255"] {
                assert!(!text.contains(bad), "{bad:?} in {text}");
            }
            assert_eq!(text.matches('(').count(), text.matches(')').count(), "{text}");
        }
    }

    #[test]
    fn times_have_units_that_fit() {
        let said = [0.25, 1.0, 9.96, 14.2, 994.0, 996.0, 1234.0, 9960.0, 119_400.0, 600_000.0].map(duration);
        assert_eq!(said, ["0.25 ms", "1 ms", "10 ms", "14 ms", "994 ms", "1 s", "1.2 s", "10 s", "119 s", "10 min"]);
    }
}
