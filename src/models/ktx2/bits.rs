//! Bits of a stream, the lowest of each byte first.

use super::Failure;

/// Bits that are left.
#[derive(Debug)]
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    held: u64,
    count: u32,
    /// Bits beyond the end that have been taken for zeros.
    beyond: u32,
}

impl<'a> Bits<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, held: 0, count: 0, beyond: 0 }
    }

    /// The next bits, at most 16, without taking them. There are zeros beyond the end.
    pub(super) fn peek(&mut self, count: u32) -> u32 {
        while self.count < count {
            let byte = match self.bytes.split_first() {
                Some((byte, rest)) => {
                    self.bytes = rest;
                    *byte
                }
                None => {
                    self.beyond += 8;
                    0
                }
            };
            self.held |= u64::from(byte) << self.count;
            self.count += 8;
        }
        (self.held & ((1 << count) - 1)) as u32
    }

    /// Takes bits that have been seen; fails if any of them lies beyond the end.
    pub(super) fn skip(&mut self, count: u32) -> Result<(), Failure> {
        self.held >>= count;
        self.count -= count;
        if self.count < self.beyond { Err("ends too early".into()) } else { Ok(()) }
    }

    /// The next bits, at most 16.
    pub(super) fn take(&mut self, count: u32) -> Result<u32, Failure> {
        let bits = self.peek(count);
        self.skip(count)?;
        Ok(bits)
    }

    /// A number in chunks of so many bits, the lowest first, each with a bit that says whether more follow.
    pub(super) fn number(&mut self, chunk: u32) -> Result<u32, Failure> {
        let mut number = 0_u32;
        for shift in (0..32).step_by(chunk as usize) {
            let bits = self.take(chunk + 1)?;
            number |= (bits & ((1 << chunk) - 1)) << shift;
            if bits >> chunk == 0 {
                return Ok(number);
            }
        }
        Err("has a number of more than 32 bits".into())
    }
}
