//! Pictures of a glTF file, as the bytes of their files.

use super::super::Parts;
use super::super::fault::{Fault, Faults, Kind};
use super::super::ktx2::{self, Ktx2};
use super::super::model::Picture;
use super::buffers::{Buffers, fetch};
use super::json::Document;
use image::ImageReader;
use std::io::Cursor;

/// Reads a picture; whether it is a part.
pub(super) fn read(
    document: &Document,
    buffers: &Buffers<'_>,
    parts: &Parts<'_>,
    index: usize,
) -> Result<(Picture, bool), Fault> {
    let pointer = format!("/images/{index}");
    let image = &document.images[index];
    let (bytes, is_part) = match (&image.uri, image.buffer_view) {
        (_, Some(view)) => (buffers.view(view)?.to_vec(), false),
        (Some(uri), None) => fetch(uri, parts, &format!("{pointer}/uri"))?,
        (None, None) => {
            return Err(Fault::new(pointer, Kind::MissingKey, "a picture has a \"uri\" or a \"bufferView\""));
        }
    };
    buffers.budget.take(bytes.len() as u64, 1)?;
    if media_type(&bytes).is_none() {
        let detail = "the picture is of no known format: use PNG, JPEG, WebP or KTX 2.0";
        return Err(Fault::new(pointer, Kind::Unsupported, detail));
    }
    Ok((Picture { bytes, pointer }, is_part))
}

/// The media type of a picture by its first bytes, if it is one that is decoded.
pub(crate) fn media_type(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"\x89PNG") {
        Some("image/png")
    } else if bytes.starts_with(b"\xff\xd8\xff") {
        Some("image/jpeg")
    } else if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        Some("image/webp")
    } else if bytes.starts_with(ktx2::MAGIC) {
        Some("image/ktx2")
    } else {
        None
    }
}

/// Notes pictures that cannot be read, without decoding them.
pub(super) fn check_all(document: &Document, buffers: &Buffers<'_>, parts: &Parts<'_>, faults: &mut Faults) {
    for index in 0..document.images.len() {
        let Some((picture, _)) = faults.note(read(document, buffers, parts, index)) else { continue };
        if let Err(why) = check(&picture.bytes) {
            faults.push(Fault::new(picture.pointer, Kind::Degenerate, why));
        }
    }
}

/// Reads how large a picture is.
fn check(bytes: &[u8]) -> Result<(), String> {
    if bytes.starts_with(ktx2::MAGIC) {
        return Ktx2::read(bytes).map(drop).map_err(|why| format!("the picture {why}"));
    }
    let size = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(Into::into);
    let size = size.and_then(ImageReader::into_dimensions);
    size.map(drop).map_err(|error| format!("the picture cannot be decoded: {error}"))
}
