//! The `Prefer` header (RFC 7240): `respond-async` and `wait=N`.

use axum::http::{HeaderMap, HeaderName, HeaderValue};
use std::time::Duration;

/// The header's name.
const PREFER: HeaderName = HeaderName::from_static("prefer");

/// The preferences of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Prefer {
    /// Whether a job is preferred to a picture.
    pub(crate) respond_async: bool,
    /// Longest wait for the answer.
    pub(crate) wait: Option<Duration>,
}

impl Prefer {
    /// Longest wait.
    pub(crate) const LONGEST: Duration = Duration::from_secs(60);

    /// Reads the headers. Unknown preferences are ignored, as the standard requires.
    pub(crate) fn of(headers: &HeaderMap) -> Self {
        let mut prefer = Self::default();
        let values = headers.get_all(PREFER).iter().filter_map(|value| value.to_str().ok());
        for preference in values.flat_map(|value| split_unquoted(value, ',')) {
            // What follows are parameters, of which these preferences have none.
            let preference = split_unquoted(preference, ';').next().unwrap_or_default();
            let (name, value) = preference.split_once('=').unwrap_or((preference, ""));
            let value = value.trim();
            let value = value.strip_prefix('"').and_then(|value| value.strip_suffix('"')).unwrap_or(value);
            match name.trim().to_ascii_lowercase().as_str() {
                "respond-async" => prefer.respond_async |= value.is_empty(),
                "wait" => {
                    let wait = value.parse().ok().map(Duration::from_secs);
                    prefer.wait = prefer.wait.or(wait).map(|wait| wait.min(Self::LONGEST));
                }
                _ => {}
            }
        }
        prefer
    }

    /// Adds the header that tells which preferences were applied, if any was.
    pub(crate) fn add_applied(self, headers: &mut HeaderMap) {
        let wait = self.wait.map(|wait| format!("wait={}", wait.as_secs()));
        let respond_async = self.respond_async.then(|| "respond-async".to_owned());
        let applied: Vec<_> = respond_async.into_iter().chain(wait).collect();
        if let Ok(value) = HeaderValue::from_str(&applied.join(", "))
            && !applied.is_empty()
        {
            headers.insert(HeaderName::from_static("preference-applied"), value);
        }
    }
}

/// The parts of a text between separators that are not inside of a quoted string.
fn split_unquoted(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let (mut is_quoted, mut is_escaped) = (false, false);
    text.split(move |letter| {
        let was_escaped = std::mem::take(&mut is_escaped);
        match letter {
            '"' if !was_escaped => is_quoted = !is_quoted,
            '\\' => is_escaped = is_quoted && !was_escaped,
            _ => {}
        }
        letter == separator && !is_quoted
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_are_read_and_others_ignored() {
        let of = |value: &'static str| Prefer::of(&HeaderMap::from_iter([(PREFER, HeaderValue::from_static(value))]));
        let seconds = |n| Some(Duration::from_secs(n));
        assert_eq!(of("respond-async, wait=10"), Prefer { respond_async: true, wait: seconds(10) });
        assert_eq!(of("Wait=\"5\" , Respond-Async=\"\""), Prefer { respond_async: true, wait: seconds(5) });
        assert_eq!(of("wait=100000"), Prefer { respond_async: false, wait: seconds(60) });
        assert_eq!(of("return=minimal, wait=soon"), Prefer::default());
    }

    #[test]
    fn strings_and_parameters_are_no_preferences() {
        let of = |value: &'static str| Prefer::of(&HeaderMap::from_iter([(PREFER, HeaderValue::from_static(value))]));
        for other in [
            r#"foo="a,respond-async,b""#,
            r#"foo="respond-async, wait=0""#,
            r#"foo="\", respond-async, \\\"""#,
            r#"foo="respond-async, wait=0"#,
            "foo;wait=0",
            "foo; respond-async",
            r#"foo; bar="a;b,c"; wait=0"#,
            "respond-async=true",
        ] {
            assert_eq!(of(other), Prefer::default(), "{other}");
        }
        let both = Prefer { respond_async: true, wait: Some(Duration::from_secs(5)) };
        assert_eq!(of(r#"foo="\\", respond-async; a="b, c", wait=5; d"#), both);
    }
}
