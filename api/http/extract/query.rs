//! Query parameters: all that are wrong are reported at once, unknown ones with a suggestion.

use super::accept::by_accept;
use crate::http::problem::{Kind, Problem};
use crate::service::scenes::ids::MAX_ZOOM;
use axum::extract::Query;
use axum::http::{HeaderMap, Uri};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use std::str::FromStr;
use strahl::film::{FileFormat, PictureFormat, Region};
use strahl::scene::description::Accuracy;
use strahl::scene::limits::{self, Limit};
use strahl::scene::nff::NffOptions;
use strahl::scene::problem::did_you_mean;
use strahl::scene::{Format, Overrides};
use strahl::words::{choice, expected};

/// The parameters of a request, taken out one by one.
#[derive(Debug)]
pub(crate) struct Parameters {
    given: Vec<(String, String)>,
    known: Vec<&'static str>,
    errors: Vec<Value>,
}

impl Parameters {
    /// Takes the query apart.
    pub(crate) fn of(uri: &Uri) -> Result<Self, Problem> {
        let Query(given) = Query::try_from_uri(uri)
            .map_err(|error| Problem::new(Kind::InvalidParameter, format!("the query cannot be read: {error}")))?;
        Ok(Self { given, known: Vec::new(), errors: Vec::new() })
    }

    /// Whether a parameter is given.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.given.iter().any(|(given, _)| given == name)
    }

    /// `zoom`: as how many times its size, 2^zoom, a scene is opened.
    pub(crate) fn zoom(&mut self) -> u32 {
        let expected = format!("a whole number from 0 to {MAX_ZOOM}");
        self.take_as("zoom", &expected, |text| text.parse().ok().filter(|zoom| *zoom <= MAX_ZOOM)).unwrap_or(0)
    }

    /// Parameters that are keys of a JSON object, with numbers, words and truth values.
    pub(crate) fn given(object: Map<String, Value>) -> Self {
        let text = |value: Value| if let Value::String(text) = value { text } else { value.to_string() };
        let given = object.into_iter().map(|(name, value)| (name, text(value))).collect();
        Self { given, known: Vec::new(), errors: Vec::new() }
    }

    /// Any text.
    pub(crate) fn text(&mut self, name: &'static str) -> Option<String> {
        self.take(name, "text")
    }

    /// A whole number, of those that the contract's format int64 holds.
    pub(crate) fn number(&mut self, name: &'static str) -> Option<u64> {
        let read = |text: &str| text.parse().ok().filter(|n| i64::try_from(*n).is_ok());
        self.take_as(name, "a whole number below 2^63", read)
    }

    /// A parameter that is given once or several times, but at most so often.
    pub(crate) fn several(&mut self, name: &'static str, most: usize) -> Vec<String> {
        let mut values = Vec::new();
        while let Some(value) = self.text(name) {
            values.push(value);
        }
        if !(1..=most).contains(&values.len()) {
            let detail = format!("expected 1 to {most} of them, got {}", values.len());
            self.wrong(name, "out-of-range", detail);
        }
        values
    }

    /// A whole number from 1 to `most`.
    pub(crate) fn count(&mut self, name: &'static str, most: usize) -> Option<usize> {
        let expected = format!("a whole number from 1 to {most}");
        self.take_as(name, &expected, |text| text.parse().ok().filter(|n| (1..=most).contains(n)))
    }

    /// The value of a parameter, as `read` understands it.
    fn take_as<T>(&mut self, name: &'static str, expected: &str, read: impl FnOnce(&str) -> Option<T>) -> Option<T> {
        self.known.push(name);
        let at = self.given.iter().position(|(given, _)| given == name)?;
        let (_, text) = self.given.remove(at);
        let value = read(&text);
        if value.is_none() {
            self.wrong(name, "out-of-range", format!("expected {expected}, got \"{text}\""));
        }
        value
    }

    fn take<T: FromStr>(&mut self, name: &'static str, expected: &str) -> Option<T> {
        self.take_as(name, expected, |text| text.parse().ok())
    }

    /// A whole number from 1 to a limit.
    fn take_up_to(&mut self, name: &'static str, limit: Limit) -> Option<u32> {
        let expected = format!("a whole number from 1 to {} ({})", limit.max, limit.name);
        self.take_as(name, &expected, |text| text.parse().ok().filter(|n| (1..=limit.max).contains(&u64::from(*n))))
    }

    fn require(&mut self, name: &'static str) -> u32 {
        if !self.has(name) {
            self.wrong(name, "missing-key", "it is required: a whole number of pixels".into());
        }
        // With an error noted, `finish` fails, and nobody sees the 0.
        self.take(name, "a whole number of pixels").unwrap_or(0)
    }

    fn wrong(&mut self, parameter: &str, code: &str, detail: String) {
        self.errors.push(json!({ "parameter": parameter, "code": code, "detail": detail }));
    }

    /// The settings that a query may put over the scene's.
    pub(crate) fn overrides(&mut self, format: Format) -> Overrides {
        let two_sided = self.take("two_sided", "true or false");
        if two_sided.is_some() && format == Format::Json {
            let detail = "it is for NFF; in JSON, materials have \"one_sided\"";
            self.wrong("two_sided", "unsupported", detail.into());
        }
        Overrides {
            width: self.take_up_to("width", limits::IMAGE_SIDE),
            height: self.take_up_to("height", limits::IMAGE_SIDE),
            max_depth: self.take_up_to("max_depth", limits::MAX_DEPTH),
            min_weight: self.number_within("min_weight", 0.0, 1.0),
            accuracy: self.take("accuracy", Accuracy::WRITTEN),
            samples: self.take_up_to("samples", limits::SAMPLES),
            antialias: self.take("antialias", "true or false"),
            precision: self.word("precision"),
            nff: NffOptions { two_sided: two_sided.unwrap_or(false), ..NffOptions::default() },
        }
    }

    /// The format of the picture: `format`, else what the client accepts, with `bits` or `quality`.
    pub(crate) fn picture_format(&mut self, headers: &HeaderMap) -> Result<FileFormat, Problem> {
        let named = self.take_as("format", &expected::<PictureFormat>(), PictureFormat::by_name);
        let format = named.map_or_else(|| by_accept(headers), Ok)?;
        Ok(self.format_with_details(format))
    }

    /// `bits` of a PNG, `quality` of a JPEG.
    pub(crate) fn format_with_details(&mut self, format: PictureFormat) -> FileFormat {
        let bits = self.take_as("bits", "8 or 16", |text| text.parse().ok().filter(|bits| matches!(bits, 8 | 16)));
        let quality = self.count("quality", 100).map(|quality| quality as u8);
        format.with(bits, quality).unwrap_or_else(|wrong| {
            wrong.iter().for_each(|wrong| self.wrong(wrong.parameter, "unsupported", wrong.why.into()));
            // With an error noted, `finish` fails, and nobody sees this.
            FileFormat::Png8
        })
    }

    /// `x`, `y`, `w` and `h`.
    pub(crate) fn region(&mut self) -> Region {
        Region { x: self.require("x"), y: self.require("y"), width: self.require("w"), height: self.require("h") }
    }

    /// `x` and `y`.
    pub(crate) fn pixel(&mut self) -> [u32; 2] {
        [self.require("x"), self.require("y")]
    }

    /// `seconds`: a number from 0.1 to a limit.
    pub(crate) fn seconds(&mut self, most: f64) -> Option<f64> {
        let expected = format!("a number of seconds from 0.1 to {most:.3} (max_tradeoff_seconds)");
        self.take_as("seconds", &expected, |text| text.parse().ok().filter(|s| (0.1..=most).contains(s)))
    }

    /// A number from `least` to `most`.
    fn number_within(&mut self, name: &'static str, least: f64, most: f64) -> Option<f64> {
        let expected = format!("a number from {least} to {most}");
        self.take_as(name, &expected, |text| text.parse().ok().filter(|number| (least..=most).contains(number)))
    }

    /// One of the words of an enum.
    pub(crate) fn word<T: JsonSchema + DeserializeOwned>(&mut self, name: &'static str) -> Option<T> {
        self.take_as(name, &expected::<T>(), choice)
    }

    /// One of some names, by default the first.
    pub(crate) fn choice<T: Copy>(&mut self, name: &'static str, choices: &[(&str, T)], default: T) -> T {
        let names: Vec<_> = choices.iter().map(|(name, _)| *name).collect();
        let by_name = |text: &str| choices.iter().find(|(name, _)| *name == text).map(|(_, value)| *value);
        self.take_as(name, &format!("one of {}", names.join(", ")), by_name).unwrap_or(default)
    }

    /// Everything has been taken: what is left is unknown or there twice.
    pub(crate) fn finish(mut self) -> Result<(), Problem> {
        for (name, _) in std::mem::take(&mut self.given) {
            if self.known.contains(&name.as_str()) {
                self.wrong(&name, "duplicate-name", "it is given twice".into());
            } else {
                let suggestion = did_you_mean(&name, self.known.iter().copied());
                self.wrong(&name, "unknown-key", format!("there is no parameter \"{name}\"{suggestion}"));
            }
        }
        if self.errors.is_empty() {
            return Ok(());
        }
        let sentences: Vec<_> = self
            .errors
            .iter()
            .map(|error| format!("{}: {}", text(&error["parameter"]), text(&error["detail"])))
            .collect();
        Err(Problem::new(Kind::InvalidParameter, sentences.join("; ")).with("errors", self.errors.into()))
    }
}

/// A region or pixel of a request that the picture does not have.
pub(crate) fn outside(what: &str, width: u32, height: u32) -> Problem {
    let detail = format!("{what} does not lie inside the picture of {width} x {height} pixels");
    Problem::new(Kind::InvalidParameter, detail)
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters(query: &str) -> Parameters {
        Parameters::of(&format!("/v1/render?{query}").parse().unwrap()).unwrap()
    }

    fn complaint(query: &str) -> String {
        let mut parameters = parameters(query);
        parameters.overrides(Format::Json);
        parameters.picture_format(&HeaderMap::new()).unwrap();
        parameters.finish().err().map(|problem| format!("{problem:?}")).unwrap_or_default()
    }

    #[test]
    fn good_parameters_are_taken() {
        let mut parameters = parameters("width=64&min_weight=0.5&precision=double&antialias=false&bits=16");
        let overrides = parameters.overrides(Format::Json);
        assert_eq!((overrides.width, overrides.height), (Some(64), None));
        assert_eq!((overrides.min_weight, overrides.antialias), (Some(0.5), Some(false)));
        assert_eq!(parameters.picture_format(&HeaderMap::new()).unwrap(), FileFormat::Png16);
        assert!(parameters.finish().is_ok());
    }

    #[test]
    fn every_wrong_parameter_is_reported() {
        let message = complaint("widht=64&samples=-1&width=1&width=2");
        for part in ["did you mean", "width", "samples", "twice"] {
            assert!(message.contains(part), "{part} in {message}");
        }
        assert!(complaint("min_weight=NaN").contains("min_weight"));
        assert!(complaint("two_sided=true").contains("NFF"));
        assert!(complaint("format=exr&bits=16").contains("bits"));
        assert!(complaint("format=jpg&bits=8").contains("bits"));
        assert!(complaint("format=jpg&quality=0").contains("1 to 100"));
        assert!(complaint("format=webp&quality=50").contains("JPEG"));
        assert!(complaint("spd_counts=true").contains("no parameter"));
    }

    #[test]
    fn tiles_need_all_four_numbers() {
        let mut parameters = parameters("x=0&y=0&w=8");
        parameters.region();
        assert!(format!("{:?}", parameters.finish()).contains("required"));
    }
}
