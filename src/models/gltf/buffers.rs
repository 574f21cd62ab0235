//! Buffers and their views: bytes of the file, of parts, of data URIs, or unpacked.

use super::super::budget::Budget;
use super::super::fault::{Fault, Faults, Kind};
use super::super::parts::{Uri, uri};
use super::super::{Parts, meshopt};
use super::draco;
use super::json::{Document, Meshopt};
use std::borrow::Cow;
use std::collections::HashMap;

/// All bytes of a file.
pub(super) struct Buffers<'a> {
    document: &'a Document,
    /// None for those that are only there for other readers.
    bytes: Vec<Option<Cow<'a, [u8]>>>,
    /// What compressed views hold, by their index.
    unpacked: Vec<Option<Vec<u8>>>,
    /// Elements of accessors that come out of Draco streams, one after the other, by the index of the accessor.
    pub(super) from_draco: HashMap<usize, Vec<u8>>,
    /// What may still be decoded.
    pub(super) budget: Budget,
    /// Whether any part was read.
    pub(super) has_parts: bool,
}

impl<'a> Buffers<'a> {
    /// Reads all buffers and unpacks all views. The ranges of views have been checked.
    pub(super) fn read(document: &'a Document, bin: Option<&'a [u8]>, parts: &Parts<'_>) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let mut buffers = Self {
            document,
            bytes: Vec::new(),
            unpacked: Vec::new(),
            from_draco: HashMap::new(),
            budget: Budget::default(),
            has_parts: false,
        };
        let mut is_read = vec![false; document.buffers.len()];
        for view in &document.views {
            match view.extensions.meshopt() {
                Some((_, packed)) => is_read.get_mut(packed.buffer),
                None => is_read.get_mut(view.buffer),
            }
            .into_iter()
            .for_each(|is_read| *is_read = true);
        }
        for (index, is_read) in is_read.into_iter().enumerate() {
            let bytes = buffers.buffer(index, is_read, bin, parts);
            buffers.bytes.push(faults.note(bytes).flatten());
        }
        faults.none_or_err()?;
        for (index, view) in document.views.iter().enumerate() {
            let pointer = format!("/bufferViews/{index}");
            let unpacked = match view.extensions.meshopt() {
                Some((name, packed)) => {
                    let pointer = format!("{pointer}/extensions/{name}");
                    faults.note(buffers.unpack(packed, view.byte_length).map_err(|fault| fault.under(&pointer)))
                }
                None => None,
            };
            buffers.unpacked.push(unpacked);
        }
        faults.none_or_err()?;
        buffers.from_draco = draco::unpack(document, &buffers, &mut faults);
        faults.none_or_err()?;
        Ok(buffers)
    }

    fn buffer(
        &mut self,
        index: usize,
        is_read: bool,
        bin: Option<&'a [u8]>,
        parts: &Parts<'_>,
    ) -> Result<Option<Cow<'a, [u8]>>, Fault> {
        let pointer = format!("/buffers/{index}");
        let buffer = &self.document.buffers[index];
        // Only there for readers that do not unpack views.
        let is_fallback = buffer.extensions.meshopt.as_ref().is_some_and(|meshopt| meshopt.fallback);
        let bytes: Cow<'_, [u8]> = match &buffer.uri {
            _ if is_fallback && !is_read => return Ok(None),
            Some(text) => {
                let (bytes, is_part) = fetch(text, parts, &format!("{pointer}/uri"))?;
                self.has_parts |= is_part;
                self.budget.take(bytes.len() as u64, 1)?;
                bytes.into()
            }
            None if is_fallback => return Ok(None),
            None if index > 0 && !is_read => return Ok(None),
            None => match bin.filter(|_| index == 0) {
                Some(bin) => bin.into(),
                None => {
                    let detail = "the buffer has no \"uri\", and the file has no chunk of bytes for it";
                    return Err(Fault::new(pointer, Kind::MissingKey, detail));
                }
            },
        };
        if (bytes.len() as u64) < buffer.byte_length {
            let detail = format!("\"byteLength\" is {}, and there are {} bytes", buffer.byte_length, bytes.len());
            return Err(Fault::new(pointer, Kind::OutOfBounds, detail));
        }
        Ok(Some(bytes))
    }

    fn unpack(&self, packed: &Meshopt, length: u64) -> Result<Vec<u8>, Fault> {
        let source = self.bytes.get(packed.buffer).and_then(|bytes| bytes.as_deref());
        let end = packed.byte_offset.checked_add(packed.byte_length);
        let source = source.zip(end).and_then(|(bytes, end)| bytes.get(packed.byte_offset as usize..end as usize));
        let Some(source) = source else {
            let detail = format!("buffer {} does not hold these {} bytes", packed.buffer, packed.byte_length);
            return Err(Fault::new("", Kind::OutOfBounds, detail));
        };
        let size = packed.count.checked_mul(packed.byte_stride);
        if size != Some(length) {
            let detail = format!(
                "{} elements of {} bytes are not the {length} bytes of the view",
                packed.count, packed.byte_stride
            );
            return Err(Fault::new("", Kind::OutOfRange, detail));
        }
        // No stream is shorter: 32 elements of a vertex take a byte or more, and a triangle takes one.
        self.budget.take(length, 1)?;
        let (count, stride) = (packed.count as usize, packed.byte_stride as usize);
        let invalid = |why: String| Fault::new("", Kind::Invalid, format!("the compressed bytes {why}"));
        let unpacked = match packed.mode.as_str() {
            "ATTRIBUTES" => meshopt::attributes(source, count, stride),
            "TRIANGLES" => meshopt::triangles(source, count, stride),
            "INDICES" => meshopt::indices(source, count, stride),
            other => {
                let detail = format!("the mode {other:?} is unknown");
                return Err(Fault::new("", Kind::Unsupported, detail));
            }
        };
        let mut unpacked = unpacked.map_err(|why| invalid(why.to_owned()))?;
        let filtered = match packed.filter.as_str() {
            "NONE" => Ok(()),
            "OCTAHEDRAL" => meshopt::octahedral(&mut unpacked, stride),
            "QUATERNION" => meshopt::quaternion(&mut unpacked, stride),
            "EXPONENTIAL" => meshopt::exponential(&mut unpacked, stride),
            "COLOR" => meshopt::color(&mut unpacked, stride),
            other => {
                let detail = format!("the filter {other:?} is not read");
                return Err(Fault::new("", Kind::Unsupported, detail));
            }
        };
        filtered.map_err(|why| invalid(why.to_owned()))?;
        Ok(unpacked)
    }

    /// The bytes of a view.
    pub(super) fn view(&self, index: usize) -> Result<&[u8], Fault> {
        if let Some(Some(unpacked)) = self.unpacked.get(index) {
            return Ok(unpacked);
        }
        let view = &self.document.views[index];
        let bytes = self.bytes.get(view.buffer).and_then(|bytes| bytes.as_deref());
        let range = view.byte_offset as usize..(view.byte_offset + view.byte_length) as usize;
        bytes.and_then(|bytes| bytes.get(range)).ok_or_else(|| {
            let detail = format!("buffer {} has no bytes for it", view.buffer);
            Fault::new(format!("/bufferViews/{index}/buffer"), Kind::OutOfBounds, detail)
        })
    }
}

/// The bytes of a URI, and whether they are a part.
pub(super) fn fetch(text: &str, parts: &Parts<'_>, pointer: &str) -> Result<(Vec<u8>, bool), Fault> {
    let shown: String = text.chars().take(60).collect();
    match uri(text) {
        Ok(Uri::Data(bytes)) => Ok((bytes, false)),
        Ok(Uri::Name(name)) => {
            // Names are compared as they are written, then as they are meant.
            let bytes = parts(text).or_else(|why| if name == text { Err(why) } else { parts(&name) });
            let missing = |why| Fault::new(pointer, Kind::MissingPart, format!("{shown:?} {why}"));
            bytes.map(|bytes| (bytes, true)).map_err(missing)
        }
        Err(why) => Err(Fault::new(pointer, Kind::Unsupported, format!("{shown:?} {why}"))),
    }
}
