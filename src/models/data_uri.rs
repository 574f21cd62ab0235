//! Data URIs (RFC 2397): bytes inside of a text, in base64 or with percent signs.

use data_encoding::{BASE64, BASE64_NOPAD};
use std::borrow::Cow;

/// The bytes of a data URI; none if a text is none. An error is the end of a sentence that begins with it.
pub fn decoded(text: &str) -> Option<Result<Vec<u8>, String>> {
    let rest = text.get(5..).filter(|_| text[..5].eq_ignore_ascii_case("data:"))?;
    Some(bytes(rest))
}

fn bytes(rest: &str) -> Result<Vec<u8>, String> {
    let (kind, data) = rest.split_once(',').ok_or("is a data URI without a comma before its data")?;
    let data = percent_decoded(data);
    let is_base64 = kind.rsplit_once(';').is_some_and(|(_, last)| last.trim().eq_ignore_ascii_case("base64"));
    if !is_base64 {
        return Ok(data.into_owned());
    }
    let base64 = if data.ends_with(b"=") { BASE64 } else { BASE64_NOPAD };
    base64.decode(&data).map_err(|error| format!("is no base64: {error}"))
}

/// The bytes of a text in which `%20` is a blank. A percent sign without two digits stands for itself.
pub(super) fn percent_decoded(text: &str) -> Cow<'_, [u8]> {
    let bytes = text.as_bytes();
    if !bytes.contains(&b'%') {
        return Cow::Borrowed(bytes);
    }
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    let digit = |at: usize| bytes.get(at).and_then(|byte| char::from(*byte).to_digit(16));
    while at < bytes.len() {
        let code = digit(at + 1).zip(digit(at + 2)).filter(|_| bytes[at] == b'%');
        decoded.push(code.map_or(bytes[at], |(high, low)| (16 * high + low) as u8));
        at += if code.is_some() { 3 } else { 1 };
    }
    Cow::Owned(decoded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_forms_give_their_bytes() {
        let of = |text| decoded(text).and_then(Result::ok);
        assert_eq!(of("data:x/y;base64,AAE="), Some(vec![0, 1]));
        assert_eq!(of("data:;base64,AAE"), Some(vec![0, 1]));
        assert_eq!(of("DATA:x/y;charset=utf-8;BASE64,AAE%3D"), Some(vec![0, 1]));
        assert_eq!(of("data:,a%20b%,c"), Some(b"a b%,c".to_vec()));
        assert_eq!(of("data:image/png,%89PNG%0d%0A"), Some(b"\x89PNG\r\n".to_vec()));
        for wrong in ["data:", "data:x/y;base64", "data:;base64,!"] {
            assert!(decoded(wrong).is_some_and(|bytes| bytes.is_err()), "{wrong}");
        }
        assert!(decoded("data").is_none() && decoded("a.png").is_none() && decoded("d\u{e4}ta:,").is_none());
    }
}
