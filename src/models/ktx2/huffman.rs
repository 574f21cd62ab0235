//! Canonical Huffman codes, stored as Deflate stores them (BasisLZ bit stream, KTX 2.0, appendix C; RFC 1951, section 3.2.2).

use super::Failure;
use super::bits::Bits;

/// The longest code.
const LONGEST: u32 = 16;
/// The order in which the lengths of the codes for lengths are stored.
const ORDER: [usize; 21] = [17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16];

/// What the next bits mean.
#[derive(Debug)]
pub(super) struct Huffman {
    /// The longest code that is there.
    bits: u32,
    /// The symbol and the length of its code for each sequence of so many bits; a length of 0 is no code.
    symbols: Vec<(u16, u8)>,
}

impl Huffman {
    /// Reads a table.
    pub(super) fn read(bits: &mut Bits<'_>) -> Result<Self, Failure> {
        let count = bits.take(14)? as usize;
        if count == 0 {
            return Self::new(&[]);
        }
        let of_lengths = bits.take(5)? as usize;
        let mut lengths = [0; ORDER.len()];
        for place in ORDER.get(..of_lengths).filter(|order| !order.is_empty()).ok_or("has a broken Huffman table")? {
            lengths[*place] = bits.take(3)? as u8;
        }
        let of_lengths = Self::new(&lengths)?;
        let mut lengths: Vec<u8> = Vec::with_capacity(count);
        while lengths.len() < count {
            let (length, run) = match of_lengths.next(bits)? {
                17 => (0, 3 + bits.take(3)?),
                18 => (0, 11 + bits.take(7)?),
                symbol @ (19 | 20) => {
                    let last = lengths.last().copied().filter(|length| *length != 0);
                    let run = if symbol == 19 { 3 + bits.take(2)? } else { 7 + bits.take(7)? };
                    (last.ok_or("has a Huffman table that repeats nothing")?, run)
                }
                length => (length as u8, 1),
            };
            lengths.extend(std::iter::repeat_n(length, run as usize));
        }
        if lengths.len() > count {
            return Err("has a Huffman table with too many symbols".into());
        }
        Self::new(&lengths)
    }

    /// The codes of symbols by their lengths.
    fn new(lengths: &[u8]) -> Result<Self, Failure> {
        let bits = u32::from(lengths.iter().copied().max().unwrap_or(0));
        let mut symbols = vec![(0, 0); 1_usize << bits];
        let mut code = 0_u32;
        for length in 1..=bits {
            code <<= 1;
            for (symbol, _) in lengths.iter().enumerate().filter(|(_, of)| u32::from(**of) == length) {
                if code >> length != 0 {
                    return Err("has a Huffman table with too many codes".into());
                }
                // The first bit of a code is the lowest here.
                let first = code.reverse_bits() >> (32 - length);
                let places = symbols.iter_mut().skip(first as usize).step_by(1 << length);
                places.for_each(|place| *place = (symbol as u16, length as u8));
                code += 1;
            }
        }
        debug_assert!(bits <= LONGEST, "lengths are symbols up to 16");
        Ok(Self { bits, symbols })
    }

    /// The next symbol.
    pub(super) fn next(&self, bits: &mut Bits<'_>) -> Result<u32, Failure> {
        let (symbol, length) = self.symbols[bits.peek(self.bits) as usize];
        if length == 0 {
            return Err("has bits that are no code".into());
        }
        bits.skip(length.into())?;
        Ok(symbol.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of RFC 1951: the lengths 3, 3, 3, 3, 3, 2, 4, 4 of A to H give 010, 011, 100, 101, 110, 00, 1110, 1111.
    #[test]
    fn codes_are_those_of_the_example_of_deflate() {
        let codes = Huffman::new(&[3, 3, 3, 3, 3, 2, 4, 4]).unwrap();
        for (code, symbol) in ["010", "011", "100", "101", "110", "00", "1110", "1111"].iter().zip(0..) {
            let byte = code.bytes().rev().fold(0, |byte, bit| byte << 1 | (bit - b'0'));
            assert_eq!(codes.next(&mut Bits::new(&[byte])), Ok(symbol), "{code}");
        }
        assert!(Huffman::new(&[1, 1, 1]).is_err());
        assert!(codes.next(&mut Bits::new(&[])).is_err());
        assert!(Huffman::new(&[]).unwrap().next(&mut Bits::new(&[0])).is_err());
    }
}
