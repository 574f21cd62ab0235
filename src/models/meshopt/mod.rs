//! Decoders of EXT_meshopt_compression and KHR_meshopt_compression, from the bit streams in appendix A of their specifications.
//!
//! What is read is as long as the file says, which is known before; a stream that ends too early is an error.

mod attributes;
mod filters;
mod indices;

pub(super) use attributes::attributes;
pub(super) use filters::{color, exponential, octahedral, quaternion};
pub(super) use indices::{indices, triangles};

type Decoded = Result<Vec<u8>, &'static str>;

const TOO_SHORT: &str = "end too early";
const CANCELLED: &str = "were not unpacked: loading was cancelled";

/// Bytes in their order.
struct Stream<'a>(&'a [u8]);

impl<'a> Stream<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], &'static str> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(TOO_SHORT)?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, &'static str> {
        self.take(1).map(|bytes| bytes[0])
    }

    /// A number in groups of seven bits, the lowest first.
    fn varint(&mut self) -> Result<u32, &'static str> {
        let mut number = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f).checked_shl(shift).unwrap_or(0);
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err("have a number of more than 32 bits")
    }
}

/// A difference whose sign is its lowest bit.
fn unzigzag(number: u32) -> u32 {
    (number >> 1) ^ (number & 1).wrapping_neg()
}

fn unzigzag8(number: u8) -> u8 {
    (number >> 1) ^ (number & 1).wrapping_neg()
}

fn unzigzag16(number: u16) -> u16 {
    (number >> 1) ^ (number & 1).wrapping_neg()
}
