//! Settings as flags and queries write them: `proved:1`.

use super::{Accuracy, Fixed, Proved, Rays, Statistical, Time};
use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

impl Accuracy {
    /// Milliseconds of a time.
    pub const MILLISECONDS: RangeInclusive<f64> = 1.0..=3.6e6;
    /// A number of rays.
    pub const RAYS: RangeInclusive<u64> = 1..=1 << 53;
    /// Codes of 255 on each side.
    pub const HALF_WIDTH: RangeInclusive<f64> = 0.25..=64.0;
    /// Share of the pixels that are within the half width.
    pub const CONFIDENCE: RangeInclusive<f64> = 0.5..=0.999;
    /// What is written as a regular expression of JSON Schema: all within the ranges above in the usual ways, none beyond them.
    pub const PATTERN: &'static str = "^(fixed|proved(:[0-2])?|time:([1-9][0-9]{0,5}([.][0-9]+)?|([12][0-9]{6}|3[0-5][0-9]{5})([.][0-9]+)?|3600000)|\
        rays:([1-9][0-9]{0,14}|[1-8][0-9]{15})|\
        statistical:(0[.](2[5-9]|[3-9])[0-9]*|([1-9]|[1-5][0-9]|6[0-3])([.][0-9]+)?|64([.]0+)?)\
        (,0[.]([5-8][0-9]*|9([0-8][0-9]*|9([0-8][0-9]*|90*)?)?))?)$";
    /// The ways to write one.
    pub const WRITTEN: &'static str = "fixed, proved:0 to proved:2, time:MILLISECONDS (1 to 3600000), rays:COUNT, \
        statistical:CODES (0.25 to 64) or statistical:CODES,CONFIDENCE (0.5 to 0.999)";
}

/// An accuracy mode with its parameters; the error says what is expected.
impl FromStr for Accuracy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (mode, parameters) = text.split_once(':').unwrap_or((text, ""));
        let accuracy = match mode {
            "fixed" if parameters.is_empty() => Some(Self::Fixed(Fixed {})),
            "proved" => match parameters {
                "" => Some(1),
                codes => codes.parse().ok().filter(|codes| *codes <= 2),
            }
            .map(|max_codes| Self::Proved(Proved { max_codes })),
            "time" => {
                let ms = parameters.parse().ok().filter(|ms| Self::MILLISECONDS.contains(ms));
                ms.map(|ms| Self::Time(Time { ms }))
            }
            "rays" => {
                let count = parameters.parse().ok().filter(|count| Self::RAYS.contains(count));
                count.map(|count| Self::Rays(Rays { count }))
            }
            "statistical" => statistical(parameters),
            _ => None,
        };
        accuracy.ok_or_else(|| format!("expected {}", Self::WRITTEN))
    }
}

/// As it is read.
impl fmt::Display for Accuracy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(_) => f.write_str("fixed"),
            Self::Proved(Proved { max_codes }) => write!(f, "proved:{max_codes}"),
            Self::Time(Time { ms }) => write!(f, "time:{ms}"),
            Self::Rays(Rays { count }) => write!(f, "rays:{count}"),
            Self::Statistical(Statistical { half_width, confidence }) => {
                write!(f, "statistical:{half_width},{confidence}")
            }
        }
    }
}

/// Half width and confidence: `1` or `1,0.99`.
fn statistical(parameters: &str) -> Option<Accuracy> {
    let (half_width, confidence) = parameters.split_once(',').unwrap_or((parameters, "0.95"));
    let half_width = half_width.parse().ok().filter(|width| Accuracy::HALF_WIDTH.contains(width))?;
    let confidence = confidence.parse().ok().filter(|confidence| Accuracy::CONFIDENCE.contains(confidence))?;
    Some(Accuracy::Statistical(Statistical { half_width, confidence }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pattern_says_what_is_read() {
        let validator = jsonschema::validator_for(&serde_json::json!({ "pattern": Accuracy::PATTERN })).unwrap();
        for text in
            "fixed proved proved:0 proved:2 time:1 time:999999.5 time:1000000 time:1500000.5 time:3600000 rays:1 rays:999999999999999 \
            rays:8999999999999999 statistical:0.25 statistical:0.3 statistical:1 statistical:63.9 statistical:64 statistical:64.0 \
            statistical:1,0.5 statistical:2.5,0.95 statistical:1,0.99 statistical:1,0.998 statistical:1,0.999"
                .split_whitespace()
        {
            assert!(text.parse::<Accuracy>().is_ok() && validator.is_valid(&text.into()), "{text}");
        }
        for text in
            "fixed:1 proved:3 time:0 time:3600001 time:4000000 rays:0 rays:1.5 rays:9999999999999999 statistical \
            statistical:0.2 statistical:64.5 statistical:65 statistical:1,0.4 statistical:1,0.9991 statistical:1,1 best"
                .split_whitespace()
        {
            assert!(text.parse::<Accuracy>().is_err() && !validator.is_valid(&text.into()), "{text}");
        }
    }

    #[test]
    fn every_mode_is_read_within_its_range() {
        for (text, accuracy) in [
            ("fixed", Accuracy::Fixed(Fixed {})),
            ("proved", Accuracy::Proved(Proved { max_codes: 1 })),
            ("proved:0", Accuracy::Proved(Proved { max_codes: 0 })),
            ("time:200", Accuracy::Time(Time { ms: 200.0 })),
            ("rays:9007199254740992", Accuracy::Rays(Rays { count: 1 << 53 })),
            ("statistical:1", Accuracy::Statistical(Statistical { half_width: 1.0, confidence: 0.95 })),
            ("statistical:1,0.99", Accuracy::Statistical(Statistical { half_width: 1.0, confidence: 0.99 })),
        ] {
            assert_eq!(text.parse(), Ok(accuracy), "{text}");
            assert_eq!(accuracy.to_string().parse(), Ok(accuracy), "{accuracy}");
        }
        for wrong in ["", "fixed:1", "proved:3", "time:0", "time:inf", "rays:0", "rays:1e3", "statistical", "exact"] {
            assert!(wrong.parse::<Accuracy>().is_err(), "{wrong}");
        }
    }
}
