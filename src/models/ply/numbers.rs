//! Numbers of a PLY file, as text or in either byte order.

use super::super::fault::{Fault, Kind, Place};
use super::super::text::{Text, Word};

/// Types of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    pub(super) fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Numbers one after the other.
pub(super) enum Numbers<'a> {
    Text(Text<'a>),
    Binary { bytes: &'a [u8], start: u64, at: usize, is_big: bool },
}

impl Numbers<'_> {
    /// The next number, which is finite.
    pub(super) fn next(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        let place = self.place();
        let number = self.take(scalar, |word| word.number())?;
        if number.is_finite() {
            return Ok(number);
        }
        Err(Fault::new("", Kind::OutOfRange, format!("{number} is no finite number")).at(place))
    }

    /// The next number, NaN if it is not finite.
    pub(super) fn next_or_nan(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        let number = self.take(scalar, |word| word.number_or_nan())?;
        Ok(if number.is_finite() { number } else { f64::NAN })
    }

    fn take(&mut self, scalar: Scalar, of_word: impl Fn(&Word<'_>) -> Result<f64, Fault>) -> Result<f64, Fault> {
        match self {
            Self::Text(text) => {
                let end = text.place();
                let word = text.any_word().ok_or_else(|| ends_early().at(end))?;
                of_word(&word)
            }
            Self::Binary { bytes, start, at, is_big } => {
                let place = Place::Offset(*start + *at as u64);
                let size = scalar.size();
                let taken = bytes.get(*at..*at + size).ok_or_else(|| ends_early().at(place))?;
                *at += size;
                let mut all = [0; 8];
                all[..size].copy_from_slice(taken);
                if *is_big {
                    all[..size].reverse();
                }
                let [a, b, c, d, ..] = all;
                Ok(match scalar {
                    Scalar::I8 => f64::from(a as i8),
                    Scalar::U8 => f64::from(a),
                    Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
                    Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
                    Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
                    Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
                    Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
                    Scalar::F64 => f64::from_le_bytes(all),
                })
            }
        }
    }

    pub(super) fn place(&self) -> Place {
        match self {
            Self::Text(text) => text.place(),
            Self::Binary { start, at, .. } => Place::Offset(*start + *at as u64),
        }
    }

    /// Bytes that are left.
    pub(super) fn left(&self) -> u64 {
        match self {
            Self::Text(text) => text.rest().len() as u64,
            Self::Binary { bytes, at, .. } => (bytes.len() - at) as u64,
        }
    }
}

fn ends_early() -> Fault {
    Fault::new("", Kind::OutOfBounds, "the file ends before its elements do")
}
