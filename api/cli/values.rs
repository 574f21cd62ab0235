//! Values of flags as they are written.

use clap::builder::{PossibleValue, PossibleValuesParser, RangedU64ValueParser, TypedValueParser};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use std::time::Duration;
use strahl::film::Region;
use strahl::scene::limits::Limit;
use strahl::words::{choice, expected, words};

/// One of the words of an enum.
pub(super) fn word<T>() -> impl TypedValueParser<Value = T>
where
    T: JsonSchema + DeserializeOwned + Clone + Send + Sync + 'static,
{
    let possible = words::<T>().into_iter().map(|word| {
        let about = word.about.unwrap_or_default();
        PossibleValue::new(word.name).help(about.trim_end_matches('.').to_owned())
    });
    PossibleValuesParser::new(possible.collect::<Vec<_>>())
        .try_map(|word| choice::<T>(&word).ok_or_else(|| format!("expected {}", expected::<T>())))
}

/// Threads of a pool.
pub(super) fn threads() -> RangedU64ValueParser {
    clap::value_parser!(u64).range(1..=1_024)
}

/// A whole number from 1 to a limit.
pub(super) fn up_to(limit: Limit) -> RangedU64ValueParser<u32> {
    RangedU64ValueParser::new().range(1..=limit.max)
}

/// A number from 0 to 1.
pub(super) fn weight(text: &str) -> Result<f64, String> {
    let weight: f64 = text.parse().map_err(|_| "expected a number from 0 to 1".to_owned())?;
    if (0.0..=1.0).contains(&weight) { Ok(weight) } else { Err("expected a number from 0 to 1".into()) }
}

fn numbers<const N: usize>(text: &str) -> Option<[u32; N]> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    numbers.ok()?.try_into().ok()
}

/// Left edge, upper edge, width and height.
pub(super) fn region(text: &str) -> Result<Region, &'static str> {
    let [x, y, width, height] =
        numbers(text).ok_or("expected four whole numbers: left edge, upper edge, width, height")?;
    Ok(Region { x, y, width, height })
}

/// Column and row.
pub(super) fn pixel(text: &str) -> Result<[u32; 2], &'static str> {
    numbers(text).ok_or("expected two whole numbers: column and row")
}

/// A time that somebody waits.
pub(super) fn seconds(text: &str) -> Result<Duration, &'static str> {
    let seconds: f64 = text.parse().map_err(|_| "expected a number of seconds")?;
    if seconds > 0.0 && seconds <= 86_400.0 {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err("expected a number of seconds above 0, at most 86400")
    }
}

/// A time that something is kept.
pub(super) fn long_seconds(text: &str) -> Result<Duration, &'static str> {
    let seconds = text.parse().ok().filter(|seconds| (1..=31_536_000).contains(seconds));
    seconds.map(Duration::from_secs).ok_or("expected a whole number of seconds from 1 to 31536000, a year")
}

/// Where clients see the service.
pub(super) fn public_url(text: &str) -> Result<String, &'static str> {
    let host = text.strip_prefix("https://").or_else(|| text.strip_prefix("http://"));
    match host.is_some_and(|host| !host.is_empty() && text.bytes().all(|byte| byte.is_ascii_graphic())) {
        true => Ok(text.trim_end_matches('/').to_owned()),
        false => Err("expected an address that begins with http:// or https://"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_have_four_numbers() {
        assert_eq!(region("1, 2,3,4"), Ok(Region { x: 1, y: 2, width: 3, height: 4 }));
        assert!(region("1,2,3").is_err());
        assert!(region("1,2,3,-4").is_err());
    }

    #[test]
    fn a_timeout_is_finite_and_above_0() {
        assert_eq!(seconds("0.5"), Ok(Duration::from_millis(500)));
        for wrong in ["0", "-1", "inf", "NaN", "soon"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
