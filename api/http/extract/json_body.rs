//! Bodies of JSON that hold more than a scene. What is wrong with their shape is told as with scenes: all of it, with pointers.

use crate::http::problem::{Kind, Problem};
use schemars::JsonSchema;
use serde::Deserialize;
use strahl::scene::read::read_as;

/// Reads a body as a type. `about` says what the body is.
pub(crate) fn read<'a, T: Deserialize<'a> + JsonSchema>(text: &'a [u8], about: &str) -> Result<T, Problem> {
    read_or(Kind::InvalidRequest, text, about)
}

/// Reads a body as a type; JSON that is none is a problem of this kind.
pub(crate) fn read_or<'a, T>(kind: Kind, text: &'a [u8], about: &str) -> Result<T, Problem>
where
    T: Deserialize<'a> + JsonSchema,
{
    read_as(text, "body").map_err(|problems| Problem::body(kind, about, &problems))
}

/// Whether the first key of a JSON object is one of these, which no scene has.
pub(crate) fn begins_with(json: &[u8], keys: [&str; 2]) -> bool {
    let text = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json).trim_ascii_start();
    let inside = text.strip_prefix(b"{").and_then(|inside| inside.trim_ascii_start().strip_prefix(b"\""));
    let is_first =
        |key: &str, text: &[u8]| text.strip_prefix(key.as_bytes()).is_some_and(|rest| rest.starts_with(b"\""));
    inside.is_some_and(|text| keys.iter().any(|key| is_first(key, text)))
}
