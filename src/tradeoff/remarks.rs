//! What numbers of a trade-off leave open: what is not compared, against what is proved, and why nothing is or less than was measured.

use super::choices::{Choice, Measurement, NO_ANTIALIASING};
use crate::bound::GIVEN_UP;
use crate::scene::description::Precision;

/// A sentence for each of them.
pub(super) fn remarks(all: &[Choice], measured: &Measurement) -> Vec<String> {
    let all: Vec<&Choice> = all.iter().filter(|choice| choice.request_ms.is_some()).collect();
    let mut said = measured.left_out.remarks();
    if all.iter().any(|choice| choice.proved_codes.is_some()) {
        said.extend([depth(measured), given_up(&all), beyond(&all)].into_iter().flatten());
    } else if !all.is_empty() {
        said.push(format!("Nothing is proved: {}.", measured.why_proved));
    }
    said
}

fn depth(measured: &Measurement) -> Option<String> {
    let depth = measured.proved_depth?;
    let why = &measured.why_proved;
    Some(format!(
        "\"Proved\" compares with recursion to depth {depth}, \"codes off\" with deeper recursion, too. The reason: {why}."
    ))
}

fn given_up(all: &[&Choice]) -> Option<String> {
    let is_given_up =
        |choice: &&&Choice| choice.settings.max_codes.zip(choice.proved_codes).is_some_and(|(a, b)| a < b);
    let names: Vec<&str> = all.iter().filter(is_given_up).map(|choice| choice.name.as_str()).collect();
    (!names.is_empty()).then(|| format!("Less is proved than asked for by {}: {GIVEN_UP}.", names.join("; ")))
}

/// Where more was measured than is proved. Proofs that are held against less depth say nothing about the reference.
fn beyond(all: &[&Choice]) -> Option<String> {
    let further = |choice: &Choice| {
        // That differs by its samples, not by its recursion.
        let is_comparable = choice.name != NO_ANTIALIASING;
        let endless = choice.settings.max_codes.is_none() || choice.settings.max_depth.is_none();
        let proved = choice.proved_codes.filter(|_| endless && is_comparable)?;
        let most = choice.most_codes()?;
        (most > f64::from(proved)).then_some((most, proved))
    };
    let found: Vec<(&Choice, f64, u8)> =
        all.iter().filter_map(|choice| further(choice).map(|(most, proved)| (*choice, most, proved))).collect();
    let (worst, most, proved) = found.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let why = if found.iter().all(|(choice, ..)| choice.settings.precision == Precision::Single) {
        "in single precision a ray that grazes a surface can miss it, which no proof about the recursion covers; double precision \
         avoids it"
    } else {
        "the picture compared with ends its rays, too"
    };
    Some(format!("Single pixels are further off than is proved ({}: {most}, proved {proved}): {why}.", worst.name))
}

#[cfg(test)]
mod tests {
    use super::super::choices::tests::{choices_of, difference, measured};
    use super::*;

    fn remarks_of(proved: [Option<u8>; 2], measured_codes: f64, depth: Option<u32>) -> Vec<String> {
        let named = [("proved:1", 1.0, proved[0]), ("proved:0, double", 2.0, proved[1])];
        let named = named.map(|(name, ms, proved)| (name.to_owned(), Some(ms), Some(0.0), proved));
        let mut all = choices_of(&named).all;
        all[0].difference = Some(difference(0.0, measured_codes));
        for choice in &mut all {
            choice.settings.max_depth = depth;
        }
        remarks(&all, &Measurement { proved_depth: depth, why_proved: "a mirror".to_owned(), ..measured() })
    }

    #[test]
    fn what_is_proved_and_measured_is_explained_where_they_differ() {
        assert!(remarks_of([Some(1), Some(0)], 1.0, None).is_empty());
        let one = |remarks: Vec<String>, begins: &str| {
            assert!(remarks.len() == 1 && remarks[0].starts_with(begins), "{remarks:?}");
        };
        one(remarks_of([None, None], 1.0, None), "Nothing is proved: a mirror.");
        one(
            remarks_of([Some(1), Some(0)], 14.0, None),
            "Single pixels are further off than is proved (proved:1: 14, proved 1)",
        );
        one(remarks_of([Some(1), Some(0)], 14.0, Some(10)), "\"Proved\" compares with recursion to depth 10");
        one(remarks_of([Some(6), Some(0)], 1.0, None), "Less is proved than asked for by proved:1: glass");
    }
}
