//! The filters of EXT_meshopt_compression and KHR_meshopt_compression (appendix B of their specifications): what is done to elements after unpacking.

use super::super::budget::worked;

type Filtered = Result<(), &'static str>;

const WRONG_STRIDE: &str = "have a stride that the filter does not allow";
const CANCELLED: &str = "were not filtered: loading was cancelled";

/// Filters all elements of `BYTES` bytes.
fn each<const BYTES: usize>(bytes: &mut [u8], filter: impl Fn(&mut [u8])) -> Filtered {
    for part in bytes.chunks_mut(BYTES << 12) {
        worked(part.len() as u64).map_err(|_| CANCELLED)?;
        part.chunks_exact_mut(BYTES).for_each(&filter);
    }
    Ok(())
}

/// Rounds half away from zero.
fn rounded(number: f32) -> i32 {
    (number + if number >= 0.0 { 0.5 } else { -0.5 }) as i32
}

/// Unit vectors of four bytes or four shorts, folded onto an octahedron.
pub(in crate::models) fn octahedral(bytes: &mut [u8], stride: usize) -> Filtered {
    match stride {
        4 => each::<4>(bytes, |element| {
            let folded = [0, 1, 2].map(|i: usize| f32::from(element[i] as i8));
            let unfolded = unfold(folded, 127.0);
            (0..3).for_each(|i| element[i] = unfolded[i] as i8 as u8);
        }),
        8 => each::<8>(bytes, |element| {
            let folded = [0, 1, 2].map(|i: usize| f32::from(short(element, i)));
            let unfolded = unfold(folded, 32_767.0);
            (0..3).for_each(|i| put_short(element, i, unfolded[i]));
        }),
        _ => Err(WRONG_STRIDE),
    }
}

/// From the octahedron, on which `one` is 1, to the sphere.
fn unfold([x, y, one]: [f32; 3], most: f32) -> [i32; 3] {
    let z = one - x.abs() - y.abs();
    let fold = z.min(0.0);
    let out = |c: f32| c + if c >= 0.0 { fold } else { -fold };
    let [x, y] = [out(x), out(y)];
    let length = (x * x + y * y + z * z).sqrt();
    let scale = if length > 0.0 { most / length } else { 0.0 };
    [x, y, z].map(|c| rounded(c * scale))
}

fn short(element: &[u8], i: usize) -> i16 {
    i16::from_le_bytes([element[2 * i], element[2 * i + 1]])
}

fn put_short(element: &mut [u8], i: usize, number: i32) {
    let [low, high] = (number.clamp(-32_768, 32_767) as i16).to_le_bytes();
    (element[2 * i], element[2 * i + 1]) = (low, high);
}

/// Unit quaternions without their largest component.
pub(in crate::models) fn quaternion(bytes: &mut [u8], stride: usize) -> Filtered {
    if stride != 8 {
        return Err(WRONG_STRIDE);
    }
    each::<8>(bytes, |element| {
        let packed = [0, 1, 2, 3].map(|i| short(element, i));
        let largest = (packed[3] & 3) as usize;
        let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(packed[3] | 3);
        let [x, y, z] = [0, 1, 2].map(|i| f32::from(packed[i]) * scale);
        let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        for (i, c) in [w, x, y, z].into_iter().enumerate() {
            put_short(element, (largest + i) & 3, rounded(c * 32_767.0));
        }
    })
}

/// Numbers of 24 bits and a power of two, which become floats.
pub(in crate::models) fn exponential(bytes: &mut [u8], stride: usize) -> Filtered {
    if !stride.is_multiple_of(4) {
        return Err(WRONG_STRIDE);
    }
    each::<4>(bytes, |element| {
        let packed = i32::from_le_bytes([element[0], element[1], element[2], element[3]]);
        let (mantissa, exponent) = ((packed << 8) >> 8, packed >> 24);
        let number = crate::math::scale_by_power(f64::from(mantissa), exponent) as f32;
        element.copy_from_slice(&number.to_le_bytes());
    })
}

/// Colors of four bytes or four shorts as luma, orange, green (YCoCg) and opacity, of as many bits as opacity says.
pub(in crate::models) fn color(bytes: &mut [u8], stride: usize) -> Filtered {
    match stride {
        4 => each::<4>(bytes, |element| {
            let [y, orange, green, alpha] = [0, 1, 2, 3].map(|i: usize| element[i]);
            let packed = [i32::from(y), i32::from(orange as i8), i32::from(green as i8), i32::from(alpha)];
            let color = of_luma(packed, 255.0);
            (0..4).for_each(|i| element[i] = color[i] as u8);
        }),
        8 => each::<8>(bytes, |element| {
            let [y, orange, green, alpha] = [0, 1, 2, 3].map(|i| short(element, i));
            let packed = [i32::from(y as u16), i32::from(orange), i32::from(green), i32::from(alpha as u16)];
            let color = of_luma(packed, 65_535.0);
            (0..4).for_each(|i| element[2 * i..2 * i + 2].copy_from_slice(&(color[i] as u16).to_le_bytes()));
        }),
        _ => Err(WRONG_STRIDE),
    }
}

fn of_luma([y, orange, green, alpha]: [i32; 4], most: f32) -> [i32; 4] {
    // The highest bit of opacity says how many bits there are; its lowest bit stands for two.
    let full = (1 << (32 - alpha.leading_zeros())) - 1;
    let opacity = alpha & (full >> 1);
    let color = [y + orange - green, y + green, y - orange - green, opacity << 1 | opacity & 1];
    let scale = if full > 0 { most / full as f32 } else { 0.0 };
    color.map(|channel| rounded((channel as f32 * scale).clamp(0.0, most)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_undo_what_the_specification_packs() {
        let mut up = [0, 0, 127, 5];
        octahedral(&mut up, 4).unwrap();
        assert_eq!(up, [0, 0, 127, 5]);
        // 1.5 is 3 / 2.
        let mut number = ((-1_i32 << 24) | 3).to_le_bytes();
        exponential(&mut number, 4).unwrap();
        assert_eq!(f32::from_le_bytes(number), 1.5);
        // The largest component is w, the last: all others are 0.
        let mut turn = [0, 0, 0, 0, 0, 0, 0xff, 0x7f];
        quaternion(&mut turn, 8).unwrap();
        assert_eq!(short(&turn, 3), 32_767);
    }

    #[test]
    fn colors_are_of_as_many_bits_as_their_opacity_says() {
        // 8 bits: y = 100, orange = 20, green = -30; opacity 127 of 127.
        let mut color = [100, 20, -30_i8 as u8, 0xff];
        super::color(&mut color, 4).unwrap();
        assert_eq!(color, [150, 70, 110, 255]);
        // 5 bits: white at half opacity, 8 of 15, which is 16 of 31.
        let mut color = [31, 0, 0, 0x18];
        super::color(&mut color, 4).unwrap();
        assert_eq!(color, [255, 255, 255, 132]);
        let mut wide: Vec<u8> = [1_023_u16, 0, 0, 0x3ff].iter().flat_map(|n| n.to_le_bytes()).collect();
        super::color(&mut wide, 8).unwrap();
        assert_eq!(wide, [0xff; 8]);
        // No opacity at all is no color.
        let mut none = [9, 9, 9, 0];
        super::color(&mut none, 4).unwrap();
        assert_eq!(none, [0; 4]);
        assert!(super::color(&mut none, 12).is_err());
    }
}
