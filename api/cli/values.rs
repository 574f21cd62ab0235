//! Values of flags as they are written.

use clap::builder::{PossibleValue, PossibleValuesParser, RangedU64ValueParser, TypedValueParser};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use strahl::enum_names::{choice, expected, words};
use strahl::film::Region;
use strahl::scene::limits::Limit;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_have_four_numbers() {
        assert_eq!(region("1, 2,3,4"), Ok(Region { x: 1, y: 2, width: 3, height: 4 }));
        assert!(region("1,2,3").is_err());
        assert!(region("1,2,3,-4").is_err());
    }
}
