//! UASTC (Basis Universal, UASTC LDR 4x4 Texture Specification): blocks of 4 x 4 pixels in 16 bytes, which are a part of what
//! ASTC can say.

use super::patterns::{self, Pattern};
use super::{BLOCK, Failure, Pixels, fill};
use crate::control;
use std::io::Read;

/// How a block is written.
#[derive(Debug, Clone, Copy)]
struct Mode {
    /// The bits that a block begins with, and how many.
    code: (u8, u8),
    /// How endpoints are quantised.
    range: Range,
    channels: Channels,
    weight_bits: u32,
    planes: usize,
    subsets: Subsets,
    /// Bits that only help to write other formats.
    hints: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channels {
    Rgb,
    Rgba,
    /// Luminance and alpha.
    La,
}

#[derive(Debug, Clone, Copy)]
enum Subsets {
    One,
    /// Patterns that other formats have, too, by the bits of their number.
    Many(u32, &'static [Pattern]),
}

/// Numbers of some bits, and of a digit to the base of 3 or 5 above them.
#[derive(Debug, Clone, Copy)]
struct Range {
    base: u32,
    bits: u32,
    /// How the bits beside the lowest fill nine bits, and what the digit counts (ASTC, section 23.13 of the Khronos Data Format
    /// Specification).
    spread: &'static [u8; 9],
    factor: u32,
}

const fn range(base: u32, bits: u32, spread: &'static [u8; 9], factor: u32) -> Range {
    Range { base, bits, spread, factor }
}

const BITS_4: Range = range(1, 4, b"000000000", 0);
const BITS_5: Range = range(1, 5, b"000000000", 0);
const BITS_8: Range = range(1, 8, b"000000000", 0);
const TRIT_2: Range = range(3, 2, b"b000b0bb0", 93);
const TRIT_4: Range = range(3, 4, b"dcb000dcb", 22);
const TRIT_6: Range = range(3, 6, b"fedcb000f", 5);
const QUINT_3: Range = range(5, 3, b"cb0000cbc", 26);
const QUINT_5: Range = range(5, 5, b"edcb0000e", 6);

use Channels::{La, Rgb, Rgba};
use Subsets::One;
const TWO: Subsets = Subsets::Many(5, &patterns::TWO);
const TWO_OF_THREE: Subsets = Subsets::Many(5, &patterns::TWO_OF_THREE);
const THREE: Subsets = Subsets::Many(4, &patterns::THREE);

const fn mode(
    code: (u8, u8),
    range: Range,
    channels: Channels,
    weight_bits: u32,
    planes: usize,
    subsets: Subsets,
    hints: u32,
) -> Mode {
    Mode { code, range, channels, weight_bits, planes, subsets, hints }
}

/// All modes but that of blocks of one color.
static MODES: [Mode; 18] = [
    mode((0b0001, 4), TRIT_6, Rgb, 4, 1, One, 15),
    mode((0b11_0101, 6), BITS_8, Rgb, 2, 1, One, 15),
    mode((0b1_1101, 5), BITS_4, Rgb, 3, 1, TWO, 15),
    mode((0b0_0011, 5), TRIT_2, Rgb, 2, 1, THREE, 15),
    mode((0b1_0011, 5), QUINT_3, Rgb, 2, 1, TWO, 15),
    mode((0b0_1011, 5), BITS_8, Rgb, 3, 1, One, 15),
    mode((0b1_1011, 5), QUINT_5, Rgb, 2, 2, One, 15),
    mode((0b0_0111, 5), QUINT_3, Rgb, 2, 1, TWO_OF_THREE, 15),
    mode((0b0_1111, 5), BITS_4, Rgba, 2, 1, TWO, 23),
    mode((0b010, 3), TRIT_4, Rgba, 4, 1, One, 17),
    mode((0b00, 2), TRIT_4, Rgba, 2, 2, One, 17),
    mode((0b110, 3), TRIT_6, Rgba, 3, 1, One, 17),
    mode((0b1_1111, 5), BITS_8, Rgba, 1, 2, One, 23),
    mode((0b0_1101, 5), BITS_8, Rgba, 2, 1, One, 23),
    mode((0b000_0101, 7), BITS_8, La, 4, 1, One, 23),
    mode((0b01_0101, 6), BITS_8, La, 2, 1, TWO, 23),
    mode((0b10_0101, 6), BITS_8, La, 2, 2, One, 23),
    mode((0b1001, 4), BITS_5, Rgb, 5, 1, One, 15),
];
/// The code of blocks of one color, of five bits.
const PLAIN: u128 = 0b1_0111;

/// Weights of 64 by their numbers.
const WEIGHTS: [&[u32]; 5] = [
    &[0, 64],
    &[0, 21, 43, 64],
    &[0, 9, 18, 27, 37, 46, 55, 64],
    &[0, 4, 8, 12, 17, 21, 25, 29, 35, 39, 43, 47, 52, 56, 60, 64],
    &[
        0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 34, 36, 38, 40, 42, 44, 46, 48, 50, 52, 54, 56, 58,
        60, 62, 64,
    ],
];

/// Unpacks all blocks, row by row.
pub(super) fn decode(from: &mut dyn Read, pixels: &mut Pixels) -> Result<(), Failure> {
    let [columns, rows] = pixels.blocks();
    let mut row = vec![0; columns * BLOCK];
    for y in 0..rows {
        if control::step(columns as u32 / 4 + 1) {
            return Err("was not unpacked: loading was cancelled".into());
        }
        fill(from, &mut row)?;
        for (x, block) in row.as_chunks::<BLOCK>().0.iter().enumerate() {
            let colors = colors(u128::from_le_bytes(*block));
            let colors = colors.ok_or_else(|| format!("has a block of no known mode at {}, {}", 4 * x, 4 * y))?;
            pixels.change([x, y], |i, pixel| *pixel = colors[i]);
        }
    }
    Ok(())
}

/// The bits of a block, the lowest first.
struct Block(u128);

impl Block {
    fn take(&mut self, count: u32) -> u32 {
        let bits = (self.0 & ((1 << count) - 1)) as u32;
        self.0 >>= count;
        bits
    }
}

/// The colors of a block, if it is one.
fn colors(bits: u128) -> Option<[[u8; 4]; 16]> {
    if bits & 31 == PLAIN {
        return Some([((bits >> 5) as u32).to_le_bytes(); 16]);
    }
    let is_of = |mode: &&Mode| bits & ((1 << mode.code.1) - 1) == u128::from(mode.code.0);
    let mode = MODES.iter().find(is_of)?;
    let mut block = Block(bits >> (u32::from(mode.code.1) + mode.hints));
    let second = match (mode.planes, mode.channels) {
        (1, _) => None,
        (_, La) => Some(3),
        _ => Some(block.take(2) as usize),
    };
    let pattern = match mode.subsets {
        One => &[0; 16],
        Subsets::Many(bits, patterns) => patterns.get(block.take(bits) as usize)?,
    };
    let subsets = usize::from(pattern.iter().copied().max().unwrap_or(0)) + 1;
    let channels = match mode.channels {
        Rgb => 3,
        Rgba => 4,
        La => 2,
    };
    let numbers = endpoints(&mut block, mode.range, 2 * channels * subsets);
    let mut colors = [[0; 4]; 16];
    let mut is_begun = [false; 3];
    for (color, subset) in colors.iter_mut().zip(pattern.iter().map(|subset| usize::from(*subset))) {
        // The first weight of each subset has one bit less: its ends are ordered so that the highest is 0.
        let count = mode.weight_bits - u32::from(!std::mem::replace(&mut is_begun[subset], true));
        let mut weight = || WEIGHTS[mode.weight_bits as usize - 1][block.take(count) as usize];
        let first = weight();
        let other = if second.is_some() { weight() } else { first };
        let ends = &numbers[2 * channels * subset..];
        *color = std::array::from_fn(|c| {
            let pair = match (mode.channels, c) {
                (Rgb, 3) => return 0xff,
                (La, 3) => 1,
                (La, _) => 0,
                _ => c,
            };
            between([ends[2 * pair], ends[2 * pair + 1]], if second == Some(c) { other } else { first })
        });
    }
    Some(colors)
}

/// Between two numbers, at a weight of 64.
fn between(ends: [u8; 2], weight: u32) -> u8 {
    let [low, high] = ends.map(|end| u32::from(end) * 257);
    ((low * (64 - weight) + high * weight + 32) >> 6 >> 8) as u8
}

/// The ends of colors, at most 18: digits first, three to the base of 5 in 7 bits or five to the base of 3 in 8, then bits.
fn endpoints(block: &mut Block, range: Range, count: usize) -> [u8; 18] {
    let mut digits = [0; 18];
    // Bits for groups of one digit and more.
    let sizes: &[u32] = match range.base {
        3 => &[2, 4, 5, 7, 8],
        5 => &[3, 5, 7],
        _ => &[],
    };
    if !sizes.is_empty() {
        for group in digits[..count].chunks_mut(sizes.len()) {
            let mut packed = block.take(sizes[group.len() - 1]);
            for digit in group {
                (*digit, packed) = (packed % range.base, packed / range.base);
            }
        }
    }
    let mut numbers = [0; 18];
    for (number, digit) in numbers.iter_mut().zip(digits).take(count) {
        *number = unquantised(range, digit, block.take(range.bits));
    }
    numbers
}

/// A number as a part of 255.
fn unquantised(range: Range, digit: u32, bits: u32) -> u8 {
    if range.base == 1 {
        // The bits again and again.
        return (bits << (8 - range.bits) | bits >> (2 * range.bits - 8)) as u8;
    }
    let spread = range.spread.iter().fold(0, |spread, letter| {
        let bit = if *letter == b'0' { 0 } else { bits >> (letter - b'a') & 1 };
        spread << 1 | bit
    });
    let mirror = if bits & 1 == 1 { 511 } else { 0 };
    let number = (digit * range.factor + spread) ^ mirror;
    (mirror & 0x80 | number >> 2) as u8
}
