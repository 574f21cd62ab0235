//! The text of an NFF file: unpacked if it is gzip, and refused if it is another format called NFF.

use super::tokens::Tokens;
use crate::scene::limits::SCENE_BYTES;
use crate::scene::problem::{Code, Problem};
use crate::scene::recognise::is_gzip;
use crate::scene::recognise::{Recognised, recognise_start};
use flate2::read::MultiGzDecoder;
use std::borrow::Cow;
use std::io::Read;

/// The text, plain.
pub(super) fn unpack(bytes: &[u8]) -> Result<Cow<'_, [u8]>, Problem> {
    let text = if is_gzip(bytes) { Cow::Owned(gunzip(bytes)?) } else { Cow::Borrowed(bytes) };
    if text.len() as u64 > SCENE_BYTES.max {
        let detail =
            format!("the file, unpacked, is larger than the limit {} of {}", SCENE_BYTES.name, SCENE_BYTES.max);
        return Err(Problem::new("", Code::Limit, detail));
    }
    Ok(text)
}

/// Unpacks up to one byte above the limit, since a small file may unpack to any size.
fn gunzip(bytes: &[u8]) -> Result<Vec<u8>, Problem> {
    let mut text = Vec::new();
    let unpacked = MultiGzDecoder::new(bytes).take(SCENE_BYTES.max + 1).read_to_end(&mut text);
    unpacked.map_err(|error| Problem::new("", Code::InvalidNff, format!("the gzip data is damaged: {error}")))?;
    let what = match recognise_start(&text) {
        Recognised::Nff | Recognised::Unknown => return Ok(text),
        Recognised::Json => "JSON",
        Recognised::Glb | Recognised::Gltf => "glTF",
        Recognised::Obj => "OBJ",
        Recognised::Stl => "STL",
        Recognised::Ply => "PLY",
        Recognised::Parts => "a multipart body",
        Recognised::Other(name) => name,
    };
    let detail =
        format!("this is {what} in a gzip file: unpack it (gunzip -c), or POST it with Content-Encoding: gzip");
    Err(Problem::new("", Code::OtherFormat, detail))
}

/// Sense8's WorldToolKit has a format of the same name and extension.
pub(super) fn refuse_sense8(text: &[u8]) -> Result<(), Problem> {
    let first = Tokens::new(text).peek();
    let Some(token) = first.filter(|t| [&b"nff"[..], b"version"].iter().any(|w| t.text.eq_ignore_ascii_case(w))) else {
        return Ok(());
    };
    let detail = format!(
        "{} starts a Sense8 (WorldToolKit) NFF file; only the SPD's Neutral File Format is supported, a different format",
        token.quoted()
    );
    Err(token.place.problem(Code::Unsupported, detail))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    #[test]
    fn other_formats_in_gzip_are_named() {
        for (text, name) in [
            ("{}", Some("JSON")),
            ("# a cube\nv 0 0 0\nv 1 0 0\n", Some("OBJ")),
            ("glTF\u{2}\0\0\0", Some("glTF")),
            ("ply\n", Some("PLY")),
            ("solid x\n", Some("STL")),
            ("%PDF-1.7", Some("PDF")),
            ("v\nfrom 0 0 1\n", None),
        ] {
            let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
            gzip.write_all(text.as_bytes()).unwrap();
            let problem = unpack(&gzip.finish().unwrap()).map(Cow::into_owned).err();
            assert_eq!(problem.is_some(), name.is_some(), "{text:?}");
            if let (Some(problem), Some(name)) = (problem, name) {
                assert!(problem.detail.starts_with(&format!("this is {name} in a gzip file")), "{}", problem.detail);
            }
        }
    }
}
