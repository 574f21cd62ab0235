//! The format of an answer: `?format=`, else the `Accept` header with its quality values (RFC 9110 section 12.5.1).

use crate::http::problem::{Kind, Problem};
use axum::http::{HeaderMap, header};
use strahl::film::PictureFormat;

/// The picture format that the client prefers.
pub(crate) fn by_accept(headers: &HeaderMap) -> Result<PictureFormat, Problem> {
    best(headers, &PictureFormat::ALL.map(|format| (format.names().1, format)))
}

/// The media type that the client prefers, and of equally acceptable ones the first.
pub(crate) fn best<T: Copy>(headers: &HeaderMap, available: &[(&'static str, T)]) -> Result<T, Problem> {
    let accept: Vec<&str> = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok()).collect();
    let accept = accept.join(",");
    // Without the header anything is acceptable.
    let accept = if accept.trim().is_empty() { "*/*".to_owned() } else { accept };
    let ranges: Vec<(&str, f32)> = accept.split(',').filter_map(range).collect();
    // `max_by` takes the last of equals; the list runs backwards so that the first wins.
    available
        .iter()
        .rev()
        .map(|(media_type, value)| (quality(&ranges, media_type), *value))
        .filter(|(quality, _)| *quality > 0.0)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, value)| value)
        .ok_or_else(|| {
            let available: Vec<_> = available.iter().map(|(media_type, _)| *media_type).collect();
            let detail = format!("Accept: {accept} asks for none of {}", available.join(", "));
            Problem::new(Kind::NotAcceptable, detail).with_available(available)
        })
}

/// Whether the client names a media type among those that it takes.
pub(crate) fn names(headers: &HeaderMap, media_type: &str) -> bool {
    let values = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok());
    values
        .flat_map(|value| value.split(','))
        .filter_map(range)
        .any(|(range, quality)| range.eq_ignore_ascii_case(media_type) && quality > 0.0)
}

/// Whether the client names a media type, and likes it better than another one.
pub(crate) fn prefers(headers: &HeaderMap, media_type: &str, other: &str) -> bool {
    let accept: Vec<&str> = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok()).collect();
    let accept = accept.join(",");
    let ranges: Vec<(&str, f32)> = accept.split(',').filter_map(range).collect();
    let named = ranges.iter().filter(|(range, _)| range.eq_ignore_ascii_case(media_type));
    let family = other.split('/').next().unwrap_or_default();
    let is_other = |range: &str| range.split('/').next().is_some_and(|it| it.eq_ignore_ascii_case(family));
    let others = ranges.iter().filter(|(range, _)| is_other(range)).map(|(_, quality)| *quality);
    let any = ranges.iter().find(|(range, _)| *range == "*/*").map_or(0.0, |(_, quality)| *quality);
    let named = named.map(|(_, quality)| *quality).fold(0.0, f32::max);
    named > others.fold(0.0, f32::max) && named >= any
}

/// Whether the client takes gzip. Without the header the answer is plain.
pub(crate) fn takes_gzip(headers: &HeaderMap) -> bool {
    let accept: Vec<&str> =
        headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok()).collect();
    let accept = accept.join(",");
    let codings: Vec<(&str, f32)> = accept.split(',').filter_map(range).collect();
    let of = |name: &str| codings.iter().find(|(coding, _)| coding.eq_ignore_ascii_case(name));
    of("gzip").or_else(|| of("x-gzip")).or_else(|| of("*")).is_some_and(|(_, quality)| *quality > 0.0)
}

/// Parses `type/subtype;q=0.5`, or `gzip;q=0.5`. A malformed quality value counts as 0.
fn range(text: &str) -> Option<(&str, f32)> {
    let mut parts = text.split(';').map(str::trim);
    let media_range = parts.next().filter(|range| !range.is_empty())?;
    let quality = parts
        .find_map(|part| part.strip_prefix("q=").or_else(|| part.strip_prefix("Q=")))
        .map_or(1.0, |q| q.parse().ok().filter(|q| (0.0..=1.0).contains(q)).unwrap_or(0.0));
    Some((media_range, quality))
}

/// The most specific range that matches decides.
fn quality(ranges: &[(&str, f32)], media_type: &str) -> f32 {
    let family = media_type.split('/').next().unwrap_or_default();
    let family = format!("{family}/*");
    [media_type, &family, "*/*"]
        .iter()
        .find_map(|wanted| ranges.iter().find(|(range, _)| range.eq_ignore_ascii_case(wanted)))
        .map_or(0.0, |(_, quality)| *quality)
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn of(accept: &'static str) -> Option<PictureFormat> {
        by_accept(&HeaderMap::from_iter([(header::ACCEPT, HeaderValue::from_static(accept))])).ok()
    }

    #[test]
    fn a_named_type_is_preferred_if_it_is_liked_better() {
        let of = |accept| {
            let headers = HeaderMap::from_iter([(header::ACCEPT, HeaderValue::from_static(accept))]);
            prefers(&headers, "multipart/mixed", "image/*")
        };
        for accept in ["multipart/mixed", "Multipart/Mixed, image/png;q=0.5", "image/webp;q=0.9, */*, multipart/mixed"]
        {
            assert!(of(accept), "{accept}");
        }
        for accept in [
            "",
            "*/*",
            "multipart/*",
            "multipart/mixed;q=0",
            "image/png, multipart/mixed;q=0.9",
            "image/*, multipart/mixed",
            "*/*;q=0.9, multipart/mixed;q=0.1",
        ] {
            assert!(!of(accept), "{accept}");
        }
    }

    #[test]
    fn gzip_is_taken_by_its_quality() {
        let of =
            |accept| takes_gzip(&HeaderMap::from_iter([(header::ACCEPT_ENCODING, HeaderValue::from_static(accept))]));
        assert!(!takes_gzip(&HeaderMap::new()));
        for accept in ["gzip", "br, GZIP;q=0.5", "x-gzip", "*", "identity, *;q=0.1"] {
            assert!(of(accept), "{accept}");
        }
        for accept in ["", "br", "identity, gzip;q=0", "gzip;q=0, *", "*;q=0", "notgzip"] {
            assert!(!of(accept), "{accept}");
        }
    }

    #[test]
    fn the_best_liked_format_wins() {
        assert_eq!(by_accept(&HeaderMap::new()).ok(), Some(PictureFormat::Png));
        for (accept, format) in [
            ("*/*", PictureFormat::Png),
            ("image/*", PictureFormat::Png),
            ("image/avif,image/webp,image/apng,image/*,*/*;q=0.8", PictureFormat::Png),
            ("image/x-exr", PictureFormat::Exr),
            ("image/png;q=0.5, image/x-exr", PictureFormat::Exr),
            ("image/png;q=0, */*", PictureFormat::Jpg),
            ("IMAGE/X-EXR;q=0.1, text/html", PictureFormat::Exr),
            ("image/x-portable-floatmap", PictureFormat::Pfm),
            ("image/jpeg, image/png;q=0.9", PictureFormat::Jpg),
            ("image/webp", PictureFormat::Webp),
        ] {
            assert_eq!(of(accept), Some(format), "{accept}");
        }
        for accept in ["text/html", "image/avif, image/png;q=0", "image/png;q=nan", "*/*;q=0"] {
            assert_eq!(of(accept), None, "{accept}");
        }
    }
}
