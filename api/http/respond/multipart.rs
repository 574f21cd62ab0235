//! Answers in parts (RFC 2046, `multipart/mixed`), each sent when it is there.

use axum::body::Bytes;
use std::fmt::Write;

/// The boundary. No part is searched for it: PNG files and JSON texts without line breaks cannot contain it.
const BOUNDARY: &str = "strahl-3f9c1d7a64e0b582";

/// The media type of the answer.
pub(super) const MEDIA_TYPE: &str = "multipart/mixed; boundary=strahl-3f9c1d7a64e0b582";

/// What comes before the bytes of a part.
pub(super) fn begin(media_type: &str, length: usize) -> Bytes {
    let mut head = String::new();
    // Writing to a String cannot fail.
    let _ = write!(head, "--{BOUNDARY}\r\nContent-Type: {media_type}\r\nContent-Length: {length}\r\n\r\n");
    head.into()
}

/// What comes after them.
pub(super) const END_OF_PART: Bytes = Bytes::from_static(b"\r\n");

/// What comes after the last part.
pub(super) fn end() -> Bytes {
    format!("--{BOUNDARY}--\r\n").into()
}
