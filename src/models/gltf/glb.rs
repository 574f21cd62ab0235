//! The container of binary glTF (.glb, specification 2.0, section 4): a JSON chunk, and at most one of bytes.

use super::super::fault::{Fault, Faults, Kind, Place};

const JSON: u32 = 0x4e4f_534a;
const BIN: u32 = 0x004e_4942;
/// Bytes of the header of the file.
const HEADER: usize = 12;

/// What is in a file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chunks<'a> {
    /// The JSON.
    pub(crate) json: &'a [u8],
    /// The bytes of the first buffer, if there are any.
    pub(crate) bin: Option<&'a [u8]>,
}

/// Whether bytes begin as binary glTF does.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF")
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let word = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
}

fn fault(at: usize, kind: Kind, detail: String) -> Faults {
    Faults::one(Fault::new("", kind, detail).at(Place::Offset(at as u64)))
}

/// Takes a file apart; text is its own JSON.
pub(crate) fn chunks(bytes: &[u8]) -> Result<Chunks<'_>, Faults> {
    if !is_binary(bytes) {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
        if !text.starts_with(b"{") {
            let detail = "this is no glTF: it begins neither with \"glTF\", as binary files do, nor with \"{\"";
            return Err(fault(0, Kind::Invalid, detail.into()));
        }
        return Ok(Chunks { json: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), bin: None });
    }
    let (version, length) = match (word(bytes, 4), word(bytes, 8)) {
        (Some(version), Some(length)) => (version, length as usize),
        _ => return Err(fault(bytes.len(), Kind::OutOfBounds, "the file ends in its header of 12 bytes".into())),
    };
    if version != 2 {
        let detail = format!("this is binary glTF of version {version}, and version 2 is read: convert it");
        return Err(fault(4, Kind::Unsupported, detail));
    }
    let (mut at, mut json, mut bin) = (HEADER, None, None);
    // What follows the announced length is no part of the file.
    let end = length.min(bytes.len());
    while at < end {
        let (Some(size), Some(kind)) = (word(bytes, at), word(bytes, at + 4)) else {
            return Err(fault(bytes.len(), Kind::OutOfBounds, "the file ends in the header of a chunk".into()));
        };
        let (size, start) = (size as usize, at + 8);
        if json.is_none() && kind != JSON {
            let detail = format!("the first chunk must be of type JSON, and is {kind:#010x}");
            return Err(fault(at, Kind::Invalid, detail));
        }
        if size % 4 != 0 {
            return Err(fault(at, Kind::Invalid, format!("the chunk has {size} bytes, which is no multiple of 4")));
        }
        if start + size > length {
            let detail = format!("the chunk of {size} bytes does not fit into the length of the file, {length}");
            return Err(fault(at, Kind::OutOfBounds, detail));
        }
        let Some(data) = bytes.get(start..start + size) else {
            let detail = format!("the chunk ends {} bytes too early: the file is cut off", start + size - bytes.len());
            return Err(fault(bytes.len(), Kind::OutOfBounds, detail));
        };
        let place = match kind {
            JSON => Some(&mut json),
            BIN => Some(&mut bin),
            // Chunks of unknown types are ignored.
            _ => None,
        };
        if let Some(place) = place
            && place.replace(data).is_some()
        {
            return Err(fault(at, Kind::Invalid, "there is a chunk of this type already".into()));
        }
        at = start + size;
    }
    if length != bytes.len() {
        let detail = format!("the file has {} bytes, and its header says {length}", bytes.len());
        return Err(fault(bytes.len(), Kind::OutOfBounds, detail));
    }
    match json {
        Some(json) => Ok(Chunks { json, bin }),
        None => Err(fault(HEADER, Kind::Invalid, "there is no chunk of JSON".into())),
    }
}
