//! PLY (G. Turk, 1994): lists of elements whose properties the header declares, as text or binary of either byte order.

mod elements;
mod header;
mod numbers;

use super::fault::{Fault, Faults, Kind, Subject, warn};
use super::model::Model;
use super::text::Text;
use elements::Reader;
use header::{Encoding, Header, Property, header};
use numbers::Numbers;

/// Reads a file.
pub(super) fn read(bytes: &[u8]) -> Result<Model, Faults> {
    let mut text = Text::new(bytes);
    let Header { encoding, elements, names_picture } = header(&mut text)?;
    let rest = text.rest();
    let mut numbers = match encoding {
        Encoding::Text => Numbers::Text(text),
        _ => Numbers::Binary {
            bytes: rest,
            start: (bytes.len() - rest.len()) as u64,
            at: 0,
            is_big: encoding == Encoding::BigEndian,
        },
    };
    let mut reader = Reader::default();
    for element in elements.iter().filter(|element| !element.properties.is_empty()) {
        // A number takes a byte or more, and in text a space too.
        let least = |property: &Property| match encoding {
            Encoding::Text => 2,
            _ => property.length.unwrap_or(property.scalar).size() as u64,
        };
        let each: u64 = element.properties.iter().map(least).sum();
        if element.count.checked_mul(each).is_none_or(|needs| needs > numbers.left() + 1) {
            let detail = format!("{} elements do not fit into the {} bytes that follow", element.count, numbers.left());
            return Err(Faults::one(Fault::new("", Kind::OutOfBounds, detail).at(element.place)));
        }
        reader.elements(element, &mut numbers)?;
    }
    let mut model = reader.into_model();
    if names_picture {
        let detail = "the picture that the file names as TextureFile is left out";
        warn(&mut model.warnings, Subject::Skipped, "pictures", String::new(), detail);
    }
    Ok(model)
}
