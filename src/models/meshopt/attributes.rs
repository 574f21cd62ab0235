//! Elements of any kind, byte by byte (mode 0).

use super::super::budget::worked;
use super::{CANCELLED, Decoded, Stream, TOO_SHORT, unzigzag8};

/// Elements of `stride` bytes, as differences of each byte from that of the element before.
pub(in crate::models) fn attributes(packed: &[u8], count: usize, stride: usize) -> Decoded {
    if stride == 0 || stride > 256 || !stride.is_multiple_of(4) {
        return Err("have a stride that is no multiple of 4 up to 256");
    }
    let mut stream = Stream(packed);
    match stream.byte()? {
        0xa0 => {}
        0xa1 => {
            return Err(
                "are of version 1 (KHR_meshopt_compression), and version 0 is read: pack them with gltfpack -cc",
            );
        }
        _ => return Err("do not begin with 0xa0"),
    }
    let tail = stride.max(32);
    let (data, tail) =
        stream.0.split_at_checked(stream.0.len().checked_sub(tail).ok_or(TOO_SHORT)?).ok_or(TOO_SHORT)?;
    let mut last = tail[tail.len() - stride..].to_vec();
    let mut stream = Stream(data);
    let most = ((8_192 / stride) & !15).min(256);
    let mut all = vec![0; count * stride];
    for block in all.chunks_mut(most * stride) {
        worked(most as u64).map_err(|_| CANCELLED)?;
        let elements = block.len() / stride;
        let groups = elements.div_ceil(16);
        for (byte, last) in last.iter_mut().enumerate() {
            let headers = stream.take(groups.div_ceil(4))?;
            for group in 0..groups {
                let mode = (headers[group / 4] >> (group % 4 * 2)) & 3;
                let differences = group_of_16(&mut stream, mode)?;
                for (i, difference) in differences.into_iter().enumerate().take(elements - group * 16) {
                    *last = last.wrapping_add(unzigzag8(difference));
                    block[(group * 16 + i) * stride + byte] = *last;
                }
            }
        }
    }
    Ok(all)
}

/// Sixteen bytes, of which small ones take 0, 2 or 4 bits; one with all bits set stands for a whole byte further on.
fn group_of_16(stream: &mut Stream<'_>, mode: u8) -> Result<[u8; 16], &'static str> {
    let mut bytes = [0; 16];
    let bits = match mode {
        0 => return Ok(bytes),
        1 => 2,
        2 => 4,
        _ => {
            bytes.copy_from_slice(stream.take(16)?);
            return Ok(bytes);
        }
    };
    let packed = stream.take(2 * bits)?;
    let escape = (1_u8 << bits) - 1;
    let each = 8 / bits;
    for (i, byte) in bytes.iter_mut().enumerate() {
        let code = (packed[i / each] >> (8 - bits - i % each * bits)) & escape;
        *byte = if code == escape { stream.byte()? } else { code };
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of the specification.
    #[test]
    fn differences_are_those_of_the_specification() {
        let packed = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut stream = Stream(&packed);
        let group = group_of_16(&mut stream, 2).unwrap();
        let differences = group.map(|code| unzigzag8(code) as i8);
        assert_eq!(differences, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
        assert!(stream.0.is_empty());
        for (bytes, number) in [(&[0x7f][..], 0x7f), (&[0x81, 0x04], 0x201), (&[0xff, 0xa0, 0x05], 0x1_507f)] {
            assert_eq!(Stream(bytes).varint(), Ok(number));
        }
    }
}
