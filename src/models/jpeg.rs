//! Whether a JPEG is all there: its decoder fills what is cut off with grey, and says nothing.

/// Whether the end of the picture is in the file (ITU-T T.81, annex B). What follows it does not count.
pub(crate) fn has_end(bytes: &[u8]) -> bool {
    let mut at = 2;
    loop {
        // In the data of a scan, 0xff is followed by 0 or by a restart marker.
        let Some(gap) = bytes.get(at..).and_then(|rest| rest.iter().position(|byte| *byte == 0xff)) else {
            return false;
        };
        at += gap + 1;
        match bytes.get(at) {
            Some(0xd9) => return true,
            // A byte of filling before a marker.
            Some(0xff) => {}
            Some(0x00 | 0x01 | 0xd0..=0xd8) => at += 1,
            Some(_) => {
                let Some(length) = bytes.get(at + 1..at + 3) else { return false };
                at += 1 + usize::from(u16::from_be_bytes([length[0], length[1]]));
            }
            None => return false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_inside_of_a_segment_is_none() {
        let start = b"\xff\xd8\xff\xe1\0\x06\xff\xd8\xff\xd9\xff\xda\0\x02ab\xff\0c\xff\xd0d";
        assert!(!has_end(start));
        assert!(has_end(&[&start[..], b"\xff\xff\xd9 and more"].concat()));
        for end in 0..start.len() {
            assert!(!has_end(&start[..end]), "{end}");
        }
    }
}
