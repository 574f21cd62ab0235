//! Conditional requests (RFC 9110 section 13).

use axum::http::{HeaderMap, HeaderName, Method, header};

/// The outcome of a request's conditions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Answer as without conditions.
    Proceed,
    /// 304: the client has the current version.
    NotModified,
    /// 412: the client has another version.
    Failed,
}

/// Whether a request has conditions.
pub(crate) fn has_any(headers: &HeaderMap) -> bool {
    headers.contains_key(header::IF_MATCH) || headers.contains_key(header::IF_NONE_MATCH)
}

/// Evaluates a request's conditions for an entity tag with its quotes. Without a tag only `*` can match.
pub(crate) fn weigh(method: &Method, headers: &HeaderMap, etag: Option<&str>) -> Verdict {
    if headers.contains_key(header::IF_MATCH) && !names(headers, header::IF_MATCH, etag, false) {
        return Verdict::Failed;
    }
    if !names(headers, header::IF_NONE_MATCH, etag, true) {
        return Verdict::Proceed;
    }
    // Safe methods get 304. QUERY is one of them (RFC 10008).
    if method.is_safe() { Verdict::NotModified } else { Verdict::Failed }
}

/// Whether a request may act by its conditions: on what has an entity tag with its quotes, or where nothing is.
pub(crate) fn may_act(headers: &HeaderMap, found: Option<&str>) -> bool {
    match found {
        // As of all methods that are not safe.
        Some(etag) => weigh(&Method::DELETE, headers, Some(etag)) == Verdict::Proceed,
        None => !headers.contains_key(header::IF_MATCH),
    }
}

/// Whether the client has the version with this entity tag.
pub(crate) fn is_known(headers: &HeaderMap, etag: &str) -> bool {
    names(headers, header::IF_NONE_MATCH, Some(etag), true)
}

/// Whether a header contains this tag. Weak tags match only in `weakly` comparison.
fn names(headers: &HeaderMap, name: HeaderName, etag: Option<&str>, weakly: bool) -> bool {
    let values = headers.get_all(name).into_iter().filter_map(|value| value.to_str().ok());
    // Our tags contain no commas: regions are written as `x-y-w-h`.
    values.flat_map(|value| value.split(',')).map(str::trim).any(|tag| {
        let tag = if weakly { tag.strip_prefix("W/").unwrap_or(tag) } else { tag };
        tag == "*" || Some(tag) == etag
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn verdict(method: &Method, name: HeaderName, value: &'static str) -> Verdict {
        weigh(method, &HeaderMap::from_iter([(name, HeaderValue::from_static(value))]), Some("\"a\""))
    }

    #[test]
    fn safe_methods_are_not_modified_and_others_fail() {
        for (value, same) in
            [("\"a\"", true), ("W/\"a\"", true), ("\"b\", \"a\"", true), ("*", true), ("\"b\"", false), ("a", false)]
        {
            let expected = |verdict| if same { verdict } else { Verdict::Proceed };
            for method in [Method::GET, Method::HEAD, Method::QUERY] {
                assert_eq!(verdict(&method, header::IF_NONE_MATCH, value), expected(Verdict::NotModified), "{value}");
            }
            assert_eq!(verdict(&Method::POST, header::IF_NONE_MATCH, value), expected(Verdict::Failed), "{value}");
        }
    }

    #[test]
    fn if_match_wants_exactly_this_one() {
        for (value, expected) in [
            ("\"a\"", Verdict::Proceed),
            ("*", Verdict::Proceed),
            ("W/\"a\"", Verdict::Failed),
            ("\"b\"", Verdict::Failed),
        ] {
            assert_eq!(verdict(&Method::POST, header::IF_MATCH, value), expected, "{value}");
        }
        let headers = HeaderMap::from_iter([(header::IF_NONE_MATCH, HeaderValue::from_static("\"a\""))]);
        assert_eq!(weigh(&Method::GET, &headers, None), Verdict::Proceed);
    }

    #[test]
    fn any_tag_is_one_of_what_is_there() {
        for (name, value, [there, absent]) in [
            (header::IF_MATCH, "*", [true, false]),
            (header::IF_MATCH, "\"a\"", [true, false]),
            (header::IF_MATCH, "\"b\"", [false, false]),
            (header::IF_NONE_MATCH, "*", [false, true]),
            (header::IF_NONE_MATCH, "\"a\"", [false, true]),
            (header::IF_NONE_MATCH, "\"b\"", [true, true]),
        ] {
            let headers = HeaderMap::from_iter([(name.clone(), HeaderValue::from_static(value))]);
            assert_eq!([Some("\"a\""), None].map(|found| may_act(&headers, found)), [there, absent], "{name} {value}");
        }
        assert!(may_act(&HeaderMap::new(), None) && may_act(&HeaderMap::new(), Some("\"a\"")));
    }
}
