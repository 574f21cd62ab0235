//! Elements of any kind, byte by byte (mode 0, versions 0 and 1).

use super::super::budget::worked;
use super::{CANCELLED, Decoded, Stream, TOO_SHORT, unzigzag8, unzigzag16};

/// Bits of each difference in a group of sixteen, by the mode of the group.
const VERSION_0: [usize; 4] = [0, 2, 4, 8];
const VERSION_1: [[usize; 4]; 2] = [[0, 1, 2, 4], [1, 2, 4, 8]];

/// How four bytes of an element differ from those before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channel {
    Bytes,
    Shorts,
    /// Exclusive or of whole words, rotated so far to the left.
    Word(u32),
}

impl Channel {
    fn of(mode: u8) -> Result<Self, &'static str> {
        match mode {
            0 => Ok(Self::Bytes),
            1 => Ok(Self::Shorts),
            _ if mode & 15 == 2 => Ok(Self::Word(u32::from(mode >> 4))),
            _ => Err("have a channel of an unknown mode"),
        }
    }

    /// Adds differences to the values before.
    fn add(self, last: &mut [u8; 4], difference: [u8; 4]) {
        let shorts = |bytes: [u8; 4]| {
            let [a, b, c, d] = bytes;
            [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])]
        };
        *last = match self {
            Self::Bytes => [0, 1, 2, 3].map(|i| last[i].wrapping_add(unzigzag8(difference[i]))),
            Self::Shorts => {
                let (before, by) = (shorts(*last), shorts(difference));
                let [[a, b], [c, d]] = [0, 1].map(|i| before[i].wrapping_add(unzigzag16(by[i])).to_le_bytes());
                [a, b, c, d]
            }
            Self::Word(turn) => {
                (u32::from_le_bytes(*last) ^ u32::from_le_bytes(difference).rotate_right(turn)).to_le_bytes()
            }
        };
    }
}

/// Elements of `stride` bytes, as differences from the elements before.
pub(in crate::models) fn attributes(packed: &[u8], count: usize, stride: usize) -> Decoded {
    if stride == 0 || stride > 256 || !stride.is_multiple_of(4) {
        return Err("have a stride that is no multiple of 4 up to 256");
    }
    let mut stream = Stream(packed);
    let is_first_version = match stream.byte()? {
        0xa0 => true,
        0xa1 => false,
        _ => return Err("begin with neither 0xa0 nor 0xa1"),
    };
    let modes = if is_first_version { 0 } else { stride / 4 };
    let tail = (stride + modes).max(if is_first_version { 32 } else { 24 });
    let (data, tail) =
        stream.0.split_at_checked(stream.0.len().checked_sub(tail).ok_or(TOO_SHORT)?).ok_or(TOO_SHORT)?;
    let (base, modes) = tail[tail.len() - stride - modes..].split_at(stride);
    let mut last = base.as_chunks::<4>().0.to_vec();
    let channels: Vec<_> = match modes {
        [] => vec![Channel::Bytes; last.len()],
        modes => modes.iter().map(|mode| Channel::of(*mode)).collect::<Result<_, _>>()?,
    };
    let mut stream = Stream(data);
    let most = ((8_192 / stride) & !15).min(256);
    let mut all = vec![0; count * stride];
    for block in all.chunks_mut(most * stride) {
        worked(most as u64).map_err(|_| CANCELLED)?;
        let controls = if is_first_version { &[] } else { stream.take(stride / 4)? };
        for byte in 0..stride {
            let control = controls.get(byte / 4).map(|controls| (controls >> (byte % 4 * 2)) & 3);
            differences(&mut stream, control, block, byte, stride)?;
        }
        for element in block.chunks_exact_mut(stride) {
            let words = element.as_chunks_mut::<4>().0.iter_mut();
            for ((word, last), channel) in words.zip(&mut last).zip(&channels) {
                channel.add(last, *word);
                *word = *last;
            }
        }
    }
    if stream.0.is_empty() { Ok(all) } else { Err("go on after the last element") }
}

/// Reads the differences of one byte of all elements of a block into the place of that byte.
fn differences(
    stream: &mut Stream<'_>,
    control: Option<u8>,
    block: &mut [u8],
    byte: usize,
    stride: usize,
) -> Result<(), &'static str> {
    let elements = block.len() / stride;
    let places = block.iter_mut().skip(byte).step_by(stride);
    let bits = match control {
        None => VERSION_0,
        // They are 0, as all is from the start.
        Some(2) => return Ok(()),
        Some(3) => {
            places.zip(stream.take(elements)?).for_each(|(place, difference)| *place = *difference);
            return Ok(());
        }
        Some(control) => VERSION_1[usize::from(control)],
    };
    let groups = elements.div_ceil(16);
    let headers = stream.take(groups.div_ceil(4))?;
    let mut places = places;
    for group in 0..groups {
        let mode = (headers[group / 4] >> (group % 4 * 2)) & 3;
        let group = group_of_16(stream, bits[usize::from(mode)])?;
        places.by_ref().zip(group).for_each(|(place, difference)| *place = difference);
    }
    Ok(())
}

/// Sixteen bytes, of which small ones take so many bits; one with all bits set stands for a whole byte further on.
fn group_of_16(stream: &mut Stream<'_>, bits: usize) -> Result<[u8; 16], &'static str> {
    let mut bytes = [0; 16];
    match bits {
        0 => return Ok(bytes),
        8 => {
            bytes.copy_from_slice(stream.take(16)?);
            return Ok(bytes);
        }
        _ => {}
    }
    let packed = stream.take(2 * bits)?;
    let escape = (1_u8 << bits) - 1;
    let each = 8 / bits;
    for (i, byte) in bytes.iter_mut().enumerate() {
        // Single bits begin with the lowest, others with the highest.
        let shift = if bits == 1 { i % 8 } else { 8 - bits - i % each * bits };
        let code = (packed[i / each] >> shift) & escape;
        *byte = if code == escape { stream.byte()? } else { code };
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the specification.
    #[test]
    fn differences_are_those_of_the_specification() {
        let packed = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut stream = Stream(&packed);
        let group = group_of_16(&mut stream, 4).unwrap();
        let differences = group.map(|code| unzigzag8(code) as i8);
        assert_eq!(differences, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
        assert!(stream.0.is_empty());
        for (bytes, number) in [(&[0x7f][..], 0x7f), (&[0x81, 0x04], 0x201), (&[0xff, 0xa0, 0x05], 0x1_507f)] {
            assert_eq!(Stream(bytes).varint(), Ok(number));
        }
    }

    /// Two elements of 12 bytes, written by hand: one word of each kind of channel.
    #[test]
    fn version_1_has_channels_of_bytes_of_shorts_and_of_words() {
        let mut packed = vec![0xa1];
        // Bytes and shorts as they are; of the word only the first byte, in groups of single bits.
        packed.extend([0xff, 0xff, 0b1010_1001]);
        let words: [[u8; 2]; 8] = [[0, 2], [0, 1], [0, 0], [0, 0], [0, 0], [0, 2], [0, 1], [0, 0]];
        packed.extend(words.as_flattened());
        // One group in mode 0: a bit for each difference, of which the second is a byte further on.
        packed.extend([0, 0b10, 0, 0x0c]);
        packed.extend([0; 9]);
        packed.extend([10, 20, 30, 40, 0xff, 0x01, 0, 1, 0x0f, 0, 0, 0]);
        packed.extend([0, 1, 0x22]);
        let all = attributes(&packed, 2, 12).unwrap();
        assert_eq!(all[..12], [10, 20, 30, 40, 0xff, 0x01, 0, 1, 0x0f, 0, 0, 0]);
        // 511 + 256 = 767, and 256 - 1 = 255; the word is turned back by two bits: 0x0f ^ 3.
        assert_eq!(all[12..], [11, 19, 30, 40, 0xff, 0x02, 0xff, 0, 0x0c, 0, 0, 0]);
        assert!((0..packed.len()).all(|end| attributes(&packed[..end], 2, 12).is_err()));
        let last = packed.len() - 1;
        for mode in [0x10, 0x11, 3, 4] {
            packed[last] = mode;
            assert!(attributes(&packed, 2, 12).is_err());
        }
        assert!(attributes(&[0xa0; 40], 1_000_000, 4).is_err());
    }
}
