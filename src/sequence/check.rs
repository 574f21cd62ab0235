//! Checks of a sequence, before there is a scene.

use super::path::{Key, NUMBERS, VECTORS};
use super::{FRAMES, Sequence};
use crate::scene::limits::{MAGNITUDE, ROTATION};
use crate::scene::problem::{Code, Problem, Problems};

/// Most keys of a path.
const KEYS: usize = 1_000;

/// All problems of a sequence, with pointers into the request.
pub(super) fn check(sequence: &Sequence) -> Result<(), Problems> {
    let mut problems = Vec::new();
    let mut wrong = |at: &str, code, detail: String| problems.push(Problem::new(format!("/frames{at}"), code, detail));
    let &Sequence { count, rate, ref turntable, ref camera, closed, shutter, play, ref patches, .. } = sequence;
    let max = FRAMES.max;
    match count {
        None if patches.is_empty() => wrong("/count", Code::MissingKey, "it is required without patches".into()),
        _ if !(1..=max).contains(&u64::from(sequence.count())) || patches.len() as u64 > max => {
            let given = count.map_or(patches.len() as u64, u64::from);
            let detail = format!("must be a whole number from 1 to {max} ({}), not {given}", FRAMES.name);
            wrong("/count", Code::OutOfRange, detail);
        }
        Some(count) if !patches.is_empty() && patches.len() as u64 != u64::from(count) => {
            let detail = format!("there must be one for each of the {count} frames, not {}", patches.len());
            wrong("/patches", Code::OutOfRange, detail);
        }
        _ => {}
    }
    if !(0.1..=100.0).contains(&rate) {
        wrong("/rate", Code::OutOfRange, format!("must be from 0.1 to 100 frames a second, not {rate}"));
    }
    if let Some(turntable) = turntable {
        if !(-ROTATION..=ROTATION).contains(&turntable.degrees) {
            let detail = format!("must be from -{ROTATION} to {ROTATION}, not {}", turntable.degrees);
            wrong("/turntable/degrees", Code::OutOfRange, detail);
        }
        if let Some(axis) = turntable.axis
            && !(is_within(&axis) && axis.iter().any(|x| x.abs() >= 1e-9))
        {
            wrong("/turntable/axis", Code::Degenerate, "must be a direction: three numbers, not all 0".into());
        }
        if turntable.center.is_some_and(|center| !is_within(&center)) {
            wrong("/turntable/center", Code::OutOfRange, format!("must have numbers between ±{MAGNITUDE:e}"));
        }
    }
    if camera.len() > KEYS {
        wrong("/camera", Code::Limit, format!("has {} keys; at most {KEYS}", camera.len()));
    }
    let mut before = None;
    for (i, key) in camera.iter().enumerate().take(KEYS) {
        check_key(key, before.replace(key.t), closed, &mut |at, code, detail| {
            wrong(&format!("/camera/{i}{at}"), code, detail);
        });
    }
    if shutter.is_some_and(|share| !(share > 0.0 && share <= 1.0)) {
        wrong("/shutter", Code::OutOfRange, "must be above 0, at most 1".into());
    }
    if play.is_some_and(|speed| !(speed > 0.0 && speed <= 1_000.0)) {
        wrong("/play", Code::OutOfRange, "must be above 0, at most 1000".into());
    }
    if problems.is_empty() { Ok(()) } else { Err(Problems(problems)) }
}

fn check_key(key: &Key, before: Option<f64>, closed: bool, wrong: &mut impl FnMut(&str, Code, String)) {
    let t = key.t;
    if !(0.0..=1.0).contains(&t) || (closed && t == 1.0) {
        let range = if closed { "from 0 to below 1, where a closed path begins again" } else { "from 0 to 1" };
        wrong("/t", Code::OutOfRange, format!("must be {range}, not {t}"));
    } else if before.is_some_and(|before| t <= before) {
        wrong("/t", Code::OutOfRange, format!("must be later than that of the key before, not {t}"));
    }
    let vectors = VECTORS.map(|(name, get)| (name, get(key).is_none_or(|point| is_within(&point)), get(key).is_some()));
    let numbers = NUMBERS.map(|(name, get)| {
        let number = get(key);
        (name, number.is_none_or(|number| is_within(&[number])), number.is_some())
    });
    for (name, is_sound, _) in vectors.iter().chain(&numbers) {
        if !is_sound {
            wrong(&format!("/{name}"), Code::OutOfRange, format!("must have numbers between ±{MAGNITUDE:e}"));
        }
    }
    if !vectors.iter().chain(&numbers).any(|(_, _, is_given)| *is_given) {
        wrong("", Code::MissingKey, "says nothing about the camera: give eye, look_at, vfov_deg or another".into());
    }
}

fn is_within(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.abs() <= MAGNITUDE)
}
