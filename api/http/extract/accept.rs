//! Which format an answer has: `?format=`, else the `Accept` header with its quality values (RFC 9110 12.5.1).

use crate::http::problem::{Kind, Problem};
use axum::http::{HeaderMap, header};
use serde_json::json;
use strahl::film::FileFormat;

/// Quality of JPEGs for which no other is asked.
pub(crate) const QUALITY: u8 = 90;

/// Formats by name and media type; of equally acceptable ones the first is taken.
pub(crate) const AVAILABLE: [(&str, &str, FileFormat); 5] = [
    ("png", "image/png", FileFormat::Png8),
    ("jpg", "image/jpeg", FileFormat::Jpeg(QUALITY)),
    ("webp", "image/webp", FileFormat::WebP),
    ("exr", "image/x-exr", FileFormat::Exr),
    ("pfm", "image/x-portable-floatmap", FileFormat::Pfm),
];

/// The format named in a query or as a file's ending.
pub(crate) fn by_name(name: &str) -> Option<FileFormat> {
    let name = if name == "jpeg" { "jpg" } else { name };
    AVAILABLE.iter().find(|(available, _, _)| *available == name).map(|(_, _, format)| *format)
}

/// A format's name and media type.
pub(crate) fn description(format: FileFormat) -> (&'static str, &'static str) {
    match format {
        FileFormat::Png8 | FileFormat::Png16 => ("png", "image/png"),
        FileFormat::Jpeg(_) => ("jpg", "image/jpeg"),
        FileFormat::WebP => ("webp", "image/webp"),
        FileFormat::Exr => ("exr", "image/x-exr"),
        FileFormat::Pfm => ("pfm", "image/x-portable-floatmap"),
    }
}

/// What the address of a picture has to say of its format beside the ending: a query or nothing.
pub(crate) fn details(format: FileFormat) -> String {
    match format {
        FileFormat::Png16 => "?bits=16".into(),
        FileFormat::Jpeg(quality) if quality != QUALITY => format!("?quality={quality}"),
        _ => String::new(),
    }
}

/// The picture format that the client likes best.
pub(crate) fn by_accept(headers: &HeaderMap) -> Result<FileFormat, Problem> {
    best(headers, &AVAILABLE.map(|(_, media_type, format)| (media_type, format)))
}

/// Of some media types the one that the client likes best, and of equally acceptable ones the first.
pub(crate) fn best<T: Copy>(headers: &HeaderMap, available: &[(&str, T)]) -> Result<T, Problem> {
    let accept: Vec<&str> = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok()).collect();
    let accept = accept.join(",");
    // No header accepts anything.
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
            Problem::new(Kind::NotAcceptable, detail).with("available", json!(available))
        })
}

/// `type/subtype;q=0.5` taken apart; a broken quality value counts as 0.
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

    fn of(accept: &'static str) -> Option<FileFormat> {
        by_accept(&HeaderMap::from_iter([(header::ACCEPT, HeaderValue::from_static(accept))])).ok()
    }

    #[test]
    fn the_best_liked_format_wins() {
        assert_eq!(by_accept(&HeaderMap::new()).ok(), Some(FileFormat::Png8));
        for (accept, format) in [
            ("*/*", FileFormat::Png8),
            ("image/*", FileFormat::Png8),
            ("image/avif,image/webp,image/apng,image/*,*/*;q=0.8", FileFormat::Png8),
            ("image/x-exr", FileFormat::Exr),
            ("image/png;q=0.5, image/x-exr", FileFormat::Exr),
            ("image/png;q=0, */*", FileFormat::Jpeg(QUALITY)),
            ("IMAGE/X-EXR;q=0.1, text/html", FileFormat::Exr),
            ("image/x-portable-floatmap", FileFormat::Pfm),
            ("image/jpeg, image/png;q=0.9", FileFormat::Jpeg(QUALITY)),
            ("image/webp", FileFormat::WebP),
        ] {
            assert_eq!(of(accept), Some(format), "{accept}");
        }
        for accept in ["text/html", "image/avif, image/png;q=0", "image/png;q=nan", "*/*;q=0"] {
            assert_eq!(of(accept), None, "{accept}");
        }
    }
}
