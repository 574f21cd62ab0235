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
        for preference in values.flat_map(|value| value.split([',', ';'])).map(str::trim) {
            match preference.split_once('=').map(|(name, value)| (name.trim(), value.trim().trim_matches('"'))) {
                None => prefer.respond_async |= preference.eq_ignore_ascii_case("respond-async"),
                Some((name, seconds)) if name.eq_ignore_ascii_case("wait") => {
                    let wait = seconds.parse().ok().map(Duration::from_secs);
                    prefer.wait = prefer.wait.or(wait).map(|wait| wait.min(Self::LONGEST));
                }
                Some(_) => {}
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_are_read_and_others_ignored() {
        let of = |value: &'static str| Prefer::of(&HeaderMap::from_iter([(PREFER, HeaderValue::from_static(value))]));
        let seconds = |n| Some(Duration::from_secs(n));
        assert_eq!(of("respond-async, wait=10"), Prefer { respond_async: true, wait: seconds(10) });
        assert_eq!(of("Wait=5; Respond-Async"), Prefer { respond_async: true, wait: seconds(5) });
        assert_eq!(of("wait=100000"), Prefer { respond_async: false, wait: seconds(60) });
        assert_eq!(of("return=minimal, wait=soon"), Prefer::default());
    }
}
