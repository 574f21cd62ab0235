//! Advice on settings, in sentences, from a measured trade-off.

use super::findings::{Cost, Front, Source};
use super::sweep::{Point, Sweep, brief};
use crate::scene::description::Precision;

/// Sentences about measured points only.
pub fn advice(points: &[Point], fronts: &[Front]) -> Vec<String> {
    let measured: Vec<&Point> = points.iter().filter(|p| p.time.is_some() && p.measured.truncation.is_some()).collect();
    let sentences =
        [depth(&measured), weight(&measured), sampling(&measured), smoothing(&measured), precision(&measured)];
    let mut advice: Vec<String> = sentences.into_iter().flatten().collect();
    advice.extend(knee(points, fronts));
    advice.extend(cheaper(points, fronts));
    advice
}

/// The members of a sweep in single precision.
fn members<'a>(points: &[&'a Point], sweep: Sweep) -> Vec<&'a Point> {
    let belongs = |p: &&&Point| p.sweeps.contains(&sweep) && p.settings.precision == Precision::Single;
    points.iter().filter(belongs).copied().collect()
}

fn worst(point: &Point) -> f64 {
    point.measured.truncation.map_or(f64::INFINITY, |error| error.codes.error.max)
}

fn nearly_worst(point: &Point) -> f64 {
    point.measured.truncation.map_or(f64::INFINITY, |error| error.codes.error.p999)
}

fn ms(point: &Point) -> f64 {
    point.cost(Cost::Time).unwrap_or(f64::NAN)
}

/// The first of some points, cheapest first, that is close enough to the reference, and how close: to 1 code everywhere, or
/// else in 99.9 % of the pixels.
fn close_enough<'a>(cheapest_first: &[&'a Point]) -> Option<(&'a Point, &'static str)> {
    let everywhere = cheapest_first.iter().find(|p| worst(p) <= 1.0).map(|p| {
        (
            *p,
            if worst(p) == 0.0 {
                "is the same picture as the reference"
            } else {
                "looks the same to 1 code as the reference"
            },
        )
    });
    let nearly = || cheapest_first.iter().find(|p| nearly_worst(p) <= 1.0);
    everywhere.or_else(|| nearly().map(|p| (*p, "is within 1 code of the reference in 99.9 % of the pixels")))
}

fn depth(points: &[&Point]) -> Option<String> {
    let mut depths = members(points, Sweep::Depth);
    depths.sort_by_key(|p| p.settings.max_depth);
    let name = |p: &Point| format!("depth {}", p.settings.max_depth.unwrap_or_default());
    enough_of(&depths, name)
}

fn weight(points: &[&Point]) -> Option<String> {
    let mut weights = members(points, Sweep::Weight);
    weights.sort_by(|a, b| b.settings.min_weight.total_cmp(&a.settings.min_weight));
    let all = weights.iter().map(|p| p.rays.map(|rays| rays.total()));
    if all.clone().all(|rays| rays == all.clone().next().flatten()) {
        return weights.first().map(|_| "min_weight changes nothing: every ray weighs enough.".into());
    }
    enough_of(&weights, |p| format!("min_weight {}", brief(p.settings.min_weight)))
}

/// Which of some points, the cheapest first and the finest last, is the first that is close enough.
fn enough_of(points: &[&Point], name: impl Fn(&Point) -> String) -> Option<String> {
    let (finest, coarser) = points.split_last()?;
    let sentence = match close_enough(points) {
        None => format!(
            "{} still errs by {} codes in 99.9 % of the pixels and by up to {} in the rest: what remains is for other settings to \
             mend.",
            name(finest),
            nearly_worst(finest),
            worst(finest)
        ),
        Some((enough, how)) if enough.settings == finest.settings => {
            let before =
                coarser.last().map_or(String::new(), |p| format!("; {} errs by up to {} codes", name(p), worst(p)));
            format!("{} {how}{before}.", name(finest))
        }
        // What takes as long saves nothing.
        Some((enough, how)) if ms(enough) >= 0.9 * ms(finest) => {
            format!("{} {how}; {} takes no longer.", name(enough), name(finest))
        }
        Some((enough, how)) => format!(
            "{} {how}, and takes {} of the time of {} ({} of {} ms).",
            name(enough),
            percent(ms(enough) / ms(finest)),
            name(finest),
            figure(ms(enough)),
            figure(ms(finest))
        ),
    };
    // Keys keep their spelling.
    Some(sentence.strip_prefix('d').map_or(sentence.clone(), |rest| format!("D{rest}")))
}

fn sampling(points: &[&Point]) -> Option<String> {
    let of = |n: u32| members(points, Sweep::Samples).into_iter().find(|p| p.settings.samples == n);
    let (one, many) = (of(1)?, of(16)?);
    let error = |p: &Point| Some(p.measured.sampling?.rms_codes);
    let (before, after) = (error(one)?, error(many)?);
    let truncated = one.measured.truncation?.rms_codes;
    if before == 0.0 {
        return Some("One sample for each pixel is as good as 64.".into());
    }
    let most = if truncated < before { "Too few samples are" } else { "Ending the recursion early is" };
    Some(format!(
        "{most} what one sample for each pixel, as deep as asked, errs by most: {} codes (root mean square) for sampling, {} for \
         recursion. 16 samples take {} times as long and leave {} for sampling.",
        figure(before),
        figure(truncated),
        figure(ms(many) / ms(one)),
        figure(after)
    ))
}

fn smoothing(points: &[&Point]) -> Option<String> {
    let even = members(points, Sweep::Samples).into_iter().find(|p| p.settings.samples == 16)?;
    let smooth = members(points, Sweep::Antialias).into_iter().find(|p| p.settings.samples == 1)?;
    let (a, b) = (smooth.measured.total?.rms_codes, even.measured.total?.rms_codes);
    Some(format!(
        "Antialiasing, more samples only where neighbours differ, errs by {} codes (root mean square) in {} of the time of 16 \
         samples everywhere, which err by {}.",
        figure(a),
        percent(ms(smooth) / ms(even)),
        figure(b)
    ))
}

fn precision(points: &[&Point]) -> Option<String> {
    let pairs: Vec<(&Point, &Point)> = points
        .iter()
        .filter(|p| p.settings.precision == Precision::Double)
        .filter_map(|double| {
            let same = |p: &&&Point| {
                p.settings.precision == Precision::Single
                    && double.settings == super::sweep::Settings { precision: Precision::Double, ..p.settings }
            };
            Some((*points.iter().find(same)?, *double))
        })
        .collect();
    let mut ratios: Vec<f64> = pairs.iter().map(|(single, double)| ms(double) / ms(single)).collect();
    ratios.sort_by(f64::total_cmp);
    let ratio = *ratios.get(ratios.len() / 2)?;
    // Where the recursion errs least, rounding shows most.
    let finest = |(_, double): &&(&Point, &Point)| double.measured.truncation.map_or(f64::MAX, |e| e.rms_codes);
    let (single, double) = pairs.iter().min_by(|a, b| finest(a).total_cmp(&finest(b)))?;
    let share = |p: &Point| p.measured.truncation.map_or(0.0, |error| error.codes.identical);
    Some(format!(
        "Double precision takes {} times as long as single (median of {} pairs). At {}, {} of the pixels are the reference's in \
         double, {} in single; the largest errors are {} and {} codes.",
        figure(ratio),
        pairs.len(),
        double.settings.label(double.sweeps[0]),
        percent(share(double)),
        percent(share(single)),
        worst(double),
        worst(single)
    ))
}

fn knee(points: &[Point], fronts: &[Front]) -> Option<String> {
    let front = fronts.iter().find(|front| (front.error, front.cost) == (Source::Total, Cost::Time))?;
    let Some(knee) = front.knee else {
        return (front.points.len() > 2)
            .then(|| "More time buys accuracy all along: nowhere does it clearly begin to gain less.".into());
    };
    let point = &points[knee];
    Some(format!(
        "After {} ({} ms, {} codes root mean square) more time gains ever less.",
        point.settings,
        figure(ms(point)),
        figure(point.measured.total?.rms_codes)
    ))
}

/// Whether something is at least as good as what the scene asks for, and cheaper.
fn cheaper(points: &[Point], fronts: &[Front]) -> Option<String> {
    let front = fronts.iter().find(|front| (front.error, front.cost) == (Source::Total, Cost::Time))?;
    let asked = points.iter().find(|p| p.sweeps.contains(&Sweep::AsAsked))?;
    let error = asked.measured.total?.rms_codes;
    let better = |p: &&Point| p.measured.total.is_some_and(|e| e.rms_codes <= error);
    let best = front.points.iter().map(|&i| &points[i]).find(better)?;
    // Times vary by up to a tenth.
    if ms(best) > 0.9 * ms(asked) {
        return Some(format!(
            "The scene's own settings ({}) are a good compromise: nothing measured here is as near in clearly less time.",
            asked.settings
        ));
    }
    Some(format!(
        "Instead of the scene's own settings ({}; {} ms, {} codes root mean square), {} takes {} ms and errs by {}.",
        asked.settings,
        figure(ms(asked)),
        figure(error),
        best.settings,
        figure(ms(best)),
        figure(best.measured.total?.rms_codes)
    ))
}

/// A share of 1.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    // Rounded down, so that 99.99 % does not become 100 %.
    if percent > 99.9 && percent < 100.0 {
        return "over 99.9 %".into();
    }
    match percent {
        99.0..100.0 => format!("{:.1} %", libm::floor(10.0 * percent) / 10.0),
        10.0.. => format!("{percent:.0} %"),
        _ => format!("{} %", figure(percent)),
    }
}

/// Three significant digits.
pub(super) fn figure(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let decimals = 2 - libm::floor(libm::log10(x.abs())) as i32;
    match decimals {
        ..=0 => format!("{x:.0}"),
        1..=5 => {
            let text = format!("{x:.*}", decimals as usize);
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
        _ => format!("{x:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::left_out::LeftOut;
    use super::super::sweep::{Errors, Settings, Times, points};
    use super::*;
    use crate::metrics::{Difference, Image8};

    /// Points with a truncation error in codes, the same everywhere, and a time in milliseconds.
    fn measured(codes: impl Fn(&Settings) -> u8, time: impl Fn(&Settings) -> f64) -> Vec<Point> {
        let asked = Settings {
            max_depth: Some(10),
            min_weight: 1e-3,
            max_codes: None,
            samples: 1,
            antialias: true,
            precision: Precision::Single,
        };
        let reference = Image8::opaque(1, vec![[100; 3]]);
        let mut points = points(asked, LeftOut::default(), None);
        for point in &mut points {
            let error = Difference::of(&reference, &Image8::opaque(1, vec![[100 + codes(&point.settings); 3]]));
            point.time = Times::of(&[time(&point.settings)]);
            point.measured = Errors { truncation: Some(error), sampling: Some(error), total: Some(error) };
        }
        points
    }

    #[test]
    fn the_first_depth_that_is_enough_is_named() {
        let depth = |s: &Settings| s.max_depth.unwrap_or(100);
        let points = measured(
            |s| if depth(s) < 5 { 40 } else { u8::from(depth(s) < 10) },
            |s| f64::from(depth(s).min(10)) * 3.0 * if s.precision == Precision::Double { 1.5 } else { 1.0 },
        );
        let said = advice(&points, &Front::all(&points)).join("\n");
        for part in [
            "Depth 5 looks the same to 1 code as the reference, and takes 50 % of the time of depth 100 (15 of 30 ms)",
            "Double precision takes 1.5 times as long",
        ] {
            assert!(said.contains(part), "{part} in:\n{said}");
        }
    }

    #[test]
    fn what_was_not_measured_is_not_spoken_of() {
        let mut points = measured(|_| 3, |_| 1.0);
        for point in &mut points {
            (point.time, point.measured) = (None, Errors::default());
        }
        assert!(advice(&points, &Front::all(&points)).is_empty());
        let points = measured(|_| 3, |_| 1.0);
        let said = advice(&points, &Front::all(&points)).join("\n");
        assert!(said.contains("Depth 100 still errs by 3 codes"), "{said}");
    }

    #[test]
    fn figures_have_three_digits() {
        for (x, text) in [(1234.4, "1234"), (12.34, "12.3"), (0.5, "0.5"), (0.01, "0.01"), (1e-5, "1.0e-5"), (0.0, "0")]
        {
            assert_eq!(figure(x), text);
        }
        assert_eq!((percent(0.404).as_str(), percent(0.99999).as_str()), ("40 %", "over 99.9 %"));
        assert_eq!((percent(1.0).as_str(), percent(0.9986).as_str()), ("100 %", "99.8 %"));
    }
}
