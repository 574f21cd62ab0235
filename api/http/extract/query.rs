//! Query parameters. All that are wrong are reported at once, unknown ones with a suggestion. The same code that reads them
//! describes them for the contract ([`Query::describe`]).

use super::parameter::{MAX_PIXELS, MAX_WHOLE, Parameter, Values};
use crate::http::problem::{ErrorEntry, Kind, Problem, fragment};
use axum::extract::Query as Pairs;
use axum::http::Uri;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use strahl::enum_names::{choice, words};
use strahl::scene::limits::Limit;
use strahl::scene::problem::{did_you_mean, push_token};

/// The parameters of a request, taken out one by one.
#[derive(Debug, Default)]
pub(crate) struct Query {
    given: Vec<(String, String)>,
    /// The pointer of the object that they are in, if they are no query.
    place: String,
    known: Vec<&'static str>,
    errors: Vec<ErrorEntry>,
    /// Collects the parameters that are read, when the contract is made.
    pub(super) described: Option<Vec<Parameter>>,
}

impl Query {
    /// Parses the query of a request.
    pub(crate) fn of(uri: &Uri) -> Result<Self, Problem> {
        let Pairs(given) = Pairs::try_from_uri(uri)
            .map_err(|error| Problem::new(Kind::InvalidParameter, format!("the query cannot be read: {error}")))?;
        Ok(Self { given, ..Self::default() })
    }

    /// The keys of a JSON object in the body as parameters. `place` is its pointer.
    pub(crate) fn given(object: Map<String, Value>, place: impl Into<String>) -> Self {
        let text = |value: Value| if let Value::String(text) = value { text } else { value.to_string() };
        let given = object.into_iter().map(|(name, value)| (name, text(value))).collect();
        Self { given, place: place.into(), ..Self::default() }
    }

    /// The parameters that some code reads.
    pub(crate) fn describe<T>(read: impl FnOnce(&mut Self) -> T) -> Vec<Parameter> {
        let mut query = Self { described: Some(Vec::new()), ..Self::default() };
        read(&mut query);
        query.described.unwrap_or_default()
    }

    /// Reads everything with one function.
    pub(crate) fn read<T>(uri: &Uri, read: impl FnOnce(&mut Self) -> T) -> Result<T, Problem> {
        let mut query = Self::of(uri)?;
        let read = read(&mut query);
        query.finish().map(|()| read)
    }

    /// Any text.
    pub(crate) fn text(&mut self, name: &'static str, about: &'static str) -> Option<String> {
        self.take(name, about, Values::Text, |text| Some(text.to_owned()))
    }

    /// A whole number, of those that the contract's format int64 holds.
    pub(crate) fn whole(&mut self, name: &'static str, about: &'static str) -> Option<u64> {
        self.take(name, about, Values::Whole(0, MAX_WHOLE, None), |text| text.parse().ok().filter(|n| *n <= MAX_WHOLE))
    }

    /// A parameter that is given any number of times up to `most`.
    pub(crate) fn several(&mut self, name: &'static str, about: &'static str, most: usize) -> Vec<String> {
        if self.described.is_some() {
            self.note(name, about, false, Values::Texts);
            return Vec::new();
        }
        let mut values = Vec::new();
        while let Some(value) = self.text(name, about) {
            values.push(value);
        }
        if values.len() > most {
            let detail = format!("expected at most {most} of them, got {}", values.len());
            self.wrong(name, "out-of-range", detail);
        }
        values
    }

    /// A whole number from 1 to `most`.
    pub(crate) fn count(&mut self, name: &'static str, about: &'static str, most: u32) -> Option<u32> {
        self.within(name, about, 1, u64::from(most), None)
    }

    /// Likewise, or none.
    pub(crate) fn count_or_0(&mut self, name: &'static str, about: &'static str, most: u32) -> Option<u32> {
        self.within(name, about, 0, u64::from(most), None)
    }

    pub(super) fn within(
        &mut self,
        name: &'static str,
        about: &'static str,
        least: u32,
        most: u64,
        limit: Option<&'static str>,
    ) -> Option<u32> {
        let values = Values::Whole(u64::from(least), most, limit);
        self.take(name, about, values, |text| text.parse().ok().filter(|n| *n >= least && u64::from(*n) <= most))
    }

    /// A whole number from 1 to a limit of scenes.
    pub(super) fn up_to(&mut self, name: &'static str, about: &'static str, limit: Limit) -> Option<u32> {
        self.within(name, about, 1, limit.max, Some(limit.name))
    }

    /// `true` or `false`.
    pub(crate) fn flag(&mut self, name: &'static str, about: &'static str) -> Option<bool> {
        self.take(name, about, Values::Flag, |text| match text {
            "true" | "1" => Some(true),
            "false" | "0" => Some(false),
            _ => None,
        })
    }

    /// One of the words of an enum.
    pub(crate) fn word<T: JsonSchema + DeserializeOwned>(
        &mut self,
        name: &'static str,
        about: &'static str,
    ) -> Option<T> {
        let names = words::<T>().into_iter().map(|word| word.name).collect();
        self.take(name, about, Values::Words(names), choice)
    }

    /// The value of a parameter, as `read` understands it.
    pub(super) fn take<T>(
        &mut self,
        name: &'static str,
        about: &'static str,
        values: Values,
        read: impl FnOnce(&str) -> Option<T>,
    ) -> Option<T> {
        if self.described.is_some() {
            self.note(name, about, false, values);
            return None;
        }
        self.known.push(name);
        let at = self.given.iter().position(|(given, _)| given == name)?;
        let (_, text) = self.given.remove(at);
        let value = read(&text);
        if value.is_none() {
            self.wrong(name, "out-of-range", format!("expected {}, got \"{text}\"", values.expected()));
        }
        value
    }

    fn note(&mut self, name: &'static str, about: &'static str, required: bool, values: Values) {
        self.described.iter_mut().for_each(|all| all.push(Parameter { name, about, required, values: values.clone() }));
    }

    /// A number of pixels that must be given.
    pub(super) fn pixels(&mut self, name: &'static str, about: &'static str, least: u32) -> u32 {
        if self.described.is_some() {
            self.note(name, about, true, Values::Whole(u64::from(least), MAX_PIXELS, None));
            return 0;
        }
        if !self.given.iter().any(|(given, _)| given == name) {
            self.wrong(name, "missing-key", "it is required: a whole number of pixels".into());
        }
        // With an error noted, `finish` fails, and the 0 is not used.
        self.within(name, about, 0, MAX_PIXELS, None).unwrap_or(0)
    }

    /// Whether something was wrong with a parameter.
    pub(crate) fn is_refused(&self, parameter: &str) -> bool {
        self.errors.iter().any(|error| error.parameter.as_deref() == Some(parameter))
    }

    /// Refuses a parameter.
    pub(crate) fn wrong(&mut self, parameter: &str, code: &'static str, detail: String) {
        let pointer = push_token(&self.place, parameter);
        let pointer = (!self.place.is_empty()).then(|| format!("#{}", fragment(&pointer)));
        self.errors.push(ErrorEntry { parameter: Some(parameter.into()), pointer, ..ErrorEntry::new(code, detail) });
    }

    /// Refuses a parameter that is known elsewhere, if it is given.
    pub(crate) fn refuse(&mut self, name: &str, why: &str) {
        if self.given.iter().any(|(given, _)| given == name) {
            self.given.retain(|(given, _)| given != name);
            self.wrong(name, "unsupported", why.to_owned());
        }
    }

    /// Ends reading where nothing may be given. Says why of parameters that some code reads elsewhere.
    pub(crate) fn refuse_all<T>(mut self, read: impl FnOnce(&mut Self) -> T, why: &str) -> Result<(), Problem> {
        for known in Self::describe(read) {
            self.refuse(known.name, why);
        }
        self.finish()
    }

    /// Ends reading. Parameters that are left are unknown or repeated.
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
        let place = if self.place.is_empty() { String::new() } else { format!("{}/", self.place) };
        let sentence =
            |error: &ErrorEntry| format!("{place}{}: {}", error.parameter.as_deref().unwrap_or_default(), error.detail);
        let sentences: Vec<_> = self.errors.iter().map(sentence).collect();
        Err(Problem::new(Kind::InvalidParameter, sentences.join("; ")).with_errors(self.errors))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderMap;
    use serde_json::json;
    use strahl::film::FileFormat;
    use strahl::scene::Format;
    use strahl::scene::limits;

    fn query(query: &str) -> Query {
        Query::of(&format!("/v1/render?{query}").parse().unwrap()).unwrap()
    }

    fn complaint(text: &str) -> String {
        let mut query = query(text);
        query.settings(Format::Json);
        let output = query.output();
        query.picture_format(output, &HeaderMap::new()).unwrap();
        query.finish().err().map(|problem| format!("{problem:?}")).unwrap_or_default()
    }

    #[test]
    fn good_parameters_are_taken() {
        let mut query = query("width=64&min_weight=0.5&precision=double&antialias=false&bits=16");
        let overrides = query.settings(Format::Json);
        assert_eq!((overrides.width, overrides.height), (Some(64), None));
        assert_eq!((overrides.min_weight, overrides.antialias), (Some(0.5), Some(false)));
        let output = query.output();
        assert_eq!(query.picture_format(output, &HeaderMap::new()).unwrap(), FileFormat::Png16);
        assert!(query.finish().is_ok());
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
        let mut query = query("x=0&y=0&w=8");
        query.region();
        assert!(format!("{:?}", query.finish()).contains("required"));
    }

    #[test]
    fn what_is_read_is_described() {
        let all = Query::describe(|query| {
            query.settings(Format::Json);
            query.region();
        });
        let of = |name: &str| all.iter().find(|parameter| parameter.name == name).unwrap();
        assert_eq!(of("samples").schema()["maximum"], limits::SAMPLES.max);
        assert_eq!(of("precision").schema()["enum"], json!(["single", "double"]));
        assert!(of("w").required && !of("width").required);
    }
}
