//! Parsers of settings, as flags, environment variables and the configuration file write them.

use clap::builder::RangedU64ValueParser;
use serde::Serializer;
use std::time::Duration;
use strahl::scene::limits::MAGNITUDE;

/// A number of threads.
pub(crate) fn threads() -> RangedU64ValueParser {
    clap::value_parser!(u64).range(1..=1_024)
}

/// How long to wait: up to a day.
pub(crate) fn seconds(text: &str) -> Result<Duration, &'static str> {
    let seconds: f64 = text.parse().map_err(|_| "expected a number of seconds")?;
    if seconds > 0.0 && seconds <= 86_400.0 {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err("expected a number of seconds above 0, at most 86400")
    }
}

/// How long to keep something: up to a year.
pub(crate) fn long_seconds(text: &str) -> Result<Duration, &'static str> {
    let seconds = text.parse().ok().filter(|seconds| (1..=31_536_000).contains(seconds));
    seconds.map(Duration::from_secs).ok_or("expected a whole number of seconds from 1 to 31536000, a year")
}

/// A point of a scene.
pub(crate) fn point(text: &str) -> Result<[f64; 3], &'static str> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let point = numbers.ok().and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    let is_sound = |point: &[f64; 3]| point.iter().all(|x| x.abs() <= MAGNITUDE);
    point.filter(is_sound).ok_or("expected three numbers, as 1,-2.5,3")
}

/// A time as a number of seconds, in answers.
pub(crate) fn as_seconds<S: Serializer>(time: &Duration, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_f64(time.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timeout_is_finite_and_above_0() {
        assert_eq!(seconds("0.5"), Ok(Duration::from_millis(500)));
        for wrong in ["0", "-1", "inf", "NaN", "soon"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
