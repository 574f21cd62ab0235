//! The header of a PLY file: what elements follow, and how they are written.

use super::super::fault::{Fault, Kind, Place};
use super::super::text::Text;
use super::numbers::Scalar;

/// Most elements of any kind that a file declares, and most properties of one.
const DECLARED: usize = 256;

/// A property of an element; a list has a type for its length.
#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: Vec<u8>,
    pub(super) length: Option<Scalar>,
    pub(super) scalar: Scalar,
}

/// Elements of a kind.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: Vec<u8>,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    pub(super) place: Place,
}

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// What a header says.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Whether a comment names a picture, as MeshLab writes it.
    pub(super) names_picture: bool,
}

/// Reads the header.
pub(super) fn header(text: &mut Text<'_>) -> Result<Header, Fault> {
    let (mut encoding, mut names_picture) = (None, false);
    let mut elements: Vec<Element> = Vec::new();
    text.word();
    while text.next_line() {
        let Some(word) = text.word() else { continue };
        let is_full =
            elements.len() > DECLARED || elements.last().is_some_and(|element| element.properties.len() > DECLARED);
        if is_full {
            return Err(word.fault(Kind::Limit, format!("the header declares more than {DECLARED} of a kind")));
        }
        match word.text {
            b"format" => {
                let name = text.expected("a format")?;
                encoding = Some(match name.text {
                    b"ascii" => Encoding::Text,
                    b"binary_little_endian" => Encoding::LittleEndian,
                    b"binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(name.fault(Kind::Unsupported, format!("the format {} is unknown", name.quoted()))),
                });
            }
            b"comment" => names_picture |= text.word().is_some_and(|word| word.text == b"TextureFile"),
            b"obj_info" => {}
            b"element" => {
                let name = text.expected("the name of an element")?;
                let count = text.expected("a number of elements")?;
                let number = std::str::from_utf8(count.text).ok().and_then(|text| text.parse().ok());
                let number: u64 = number.ok_or_else(|| {
                    count.fault(Kind::WrongType, format!("{} is no number of elements", count.quoted()))
                })?;
                let (name, place) = (name.text.to_vec(), word.place);
                elements.push(Element { name, count: number, properties: Vec::new(), place });
            }
            b"property" => {
                let mut next = text.expected("a type")?;
                let scalar = |text: &mut Text<'_>| -> Result<Scalar, Fault> {
                    let word = text.expected("a type")?;
                    Scalar::named(word.text)
                        .ok_or_else(|| word.fault(Kind::Unsupported, format!("{} is no type", word.quoted())))
                };
                let (length, of) = if next.text == b"list" {
                    (Some(scalar(text)?), scalar(text)?)
                } else {
                    let of = Scalar::named(next.text);
                    (None, of.ok_or_else(|| next.fault(Kind::Unsupported, format!("{} is no type", next.quoted())))?)
                };
                next = text.expected("the name of a property")?;
                let element = elements.last_mut();
                let element =
                    element.ok_or_else(|| word.fault(Kind::Invalid, "a property before any element".into()))?;
                element.properties.push(Property { name: next.text.to_vec(), length, scalar: of });
            }
            b"end_header" => {
                text.next_line();
                let missing = || Fault::new("", Kind::MissingKey, "the header does not say the format").at(word.place);
                return Ok(Header { encoding: encoding.ok_or_else(missing)?, elements, names_picture });
            }
            _ => return Err(word.fault(Kind::Invalid, format!("{} is no word of a header", word.quoted()))),
        }
    }
    Err(Fault::new("", Kind::OutOfBounds, "the header does not end").at(text.place()))
}
