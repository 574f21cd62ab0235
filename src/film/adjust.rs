//! Adjustments of a picture of 8-bit codes before it is written: mirror, rotation, gray, black and white.

/// What is done, in this order: mirror, rotate, remove color.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Adjustment {
    /// Left becomes right.
    pub mirrored: bool,
    /// Quarters of a turn clockwise, 0 to 3.
    pub quarters: u8,
    /// Which colors are left.
    pub tone: Tone,
}

/// Which colors remain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Tone {
    /// All.
    #[default]
    Color,
    /// The luma of BT.709, of the codes.
    Gray,
    /// White from half of that on, else black.
    Bitonal,
}

impl Adjustment {
    /// Applies it to a picture with three codes for each pixel, or four with alpha. Returns the new size and codes.
    pub(super) fn apply<const CHANNELS: usize>(self, [width, height]: [u32; 2], codes: Vec<u8>) -> ([u32; 2], Vec<u8>) {
        if self == Self::default() {
            return ([width, height], codes);
        }
        let (from, _) = codes.as_chunks::<CHANNELS>();
        let (across, down) = (width as usize, height as usize);
        let turned = !self.quarters.is_multiple_of(2);
        let size = if turned { [height, width] } else { [width, height] };
        let mut seen = Vec::with_capacity(codes.len());
        for y in 0..size[1] as usize {
            for x in 0..size[0] as usize {
                // Where this pixel was before the rotation, and before the mirror.
                let (before, row) = match self.quarters % 4 {
                    0 => (x, y),
                    1 => (y, down - 1 - x),
                    2 => (across - 1 - x, down - 1 - y),
                    _ => (across - 1 - y, x),
                };
                let column = if self.mirrored { across - 1 - before } else { before };
                let pixel = &from[row * across + column];
                seen.extend_from_slice(&self.tone.of([pixel[0], pixel[1], pixel[2]]));
                seen.extend_from_slice(&pixel[3..]);
            }
        }
        (size, seen)
    }
}

impl Tone {
    fn of(self, [r, g, b]: [u8; 3]) -> [u8; 3] {
        // Weights of BT.709 in 256ths.
        let luma = ((54 * u32::from(r) + 183 * u32::from(g) + 19 * u32::from(b) + 128) >> 8) as u8;
        match self {
            Self::Color => [r, g, b],
            Self::Gray => [luma; 3],
            Self::Bitonal => [if luma >= 128 { 255 } else { 0 }; 3],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3 x 2 pixels: 1 2 3 / 4 5 6.
    fn seen(mirrored: bool, quarters: u8) -> ([u32; 2], Vec<u8>) {
        let codes = (1..=6).flat_map(|i| [i; 3]).collect();
        let (size, codes) = Adjustment { mirrored, quarters, tone: Tone::Color }.apply::<3>([3, 2], codes);
        (size, codes.chunks(3).map(|pixel| pixel[0]).collect())
    }

    #[test]
    fn pictures_are_mirrored_and_then_turned_clockwise() {
        assert_eq!(seen(false, 0), ([3, 2], vec![1, 2, 3, 4, 5, 6]));
        assert_eq!(seen(true, 0), ([3, 2], vec![3, 2, 1, 6, 5, 4]));
        assert_eq!(seen(false, 1), ([2, 3], vec![4, 1, 5, 2, 6, 3]));
        assert_eq!(seen(false, 2), ([3, 2], vec![6, 5, 4, 3, 2, 1]));
        assert_eq!(seen(false, 3), ([2, 3], vec![3, 6, 2, 5, 1, 4]));
        assert_eq!(seen(true, 1), ([2, 3], vec![6, 3, 5, 2, 4, 1]));
    }

    #[test]
    fn gray_keeps_white_and_black_apart() {
        let of = |tone: Tone, code| tone.of(code);
        assert_eq!(of(Tone::Gray, [255; 3]), [255; 3]);
        assert_eq!(of(Tone::Gray, [0, 255, 0]), [182; 3]);
        assert_eq!(of(Tone::Bitonal, [0, 255, 0]), [255; 3]);
        assert_eq!(of(Tone::Bitonal, [255, 0, 255]), [0; 3]);
    }
}
