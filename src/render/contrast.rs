//! The contrast between neighbouring pixels, which decides what antialiasing refines.

use super::packets::Traced;
use crate::film::srgb::Codes8;
use crate::film::{Display, Region};
use rayon::prelude::*;

/// Difference of neighbouring pixels, in 8-bit sRGB codes of any channel, from which on both are refined.
pub(crate) const CONTRAST: u8 = 8;

/// Pixels whose codes one thread makes at a time.
const CHUNK: usize = 1 << 12;

/// The largest difference of each traced pixel from one of its eight neighbours, row by row: over black, and over what is behind a
/// transparent background.
pub(super) fn contrasts_of(display: &Display, traced: &Traced, width: u32) -> Vec<u8> {
    let shown = display.all(&traced.pixels);
    let mut of_colors = contrasts(&codes_of_shown(&shown), width);
    if !traced.alpha.is_empty() {
        let over_background = contrasts(&codes_of_shown_over_background(display, &shown, &traced.alpha), width);
        of_colors.iter_mut().zip(over_background).for_each(|(most, contrast)| *most = contrast.max(*most));
    }
    of_colors
}

/// The 8-bit codes of a few pixels over black, and [over the background](over_background).
pub(super) fn codes_over_both(display: &Display, pixels: &[[f32; 3]], alpha: &[f32]) -> Vec<[u8; 6]> {
    let alpha = alpha.iter().copied().chain(std::iter::repeat(1.0));
    let both = |(pixel, alpha): (&[f32; 3], f32)| {
        let [red, green, blue] = display.codes(*pixel);
        let [over_red, over_green, over_blue] = over_background(display, *pixel, alpha);
        [red, green, blue, over_red, over_green, over_blue]
    };
    pixels.iter().zip(alpha).map(both).collect()
}

/// The same over the background alone; of none without alpha.
pub(super) fn codes_over_background(display: &Display, pixels: &[[f32; 3]], alpha: &[f32]) -> Vec<[u8; 3]> {
    codes_of_shown_over_background(display, &display.all(pixels), alpha)
}

fn codes_of_shown_over_background(display: &Display, shown: &[[f32; 3]], alpha: &[f32]) -> Vec<[u8; 3]> {
    let behind = display.backdrop();
    let over = |(shown, alpha): (&[f32; 3], &f32)| -> [f32; 3] {
        let behind = behind.unwrap_or([1.0; 3]);
        std::array::from_fn(|c| shown[c] + behind[c] * (1.0 - alpha))
    };
    let mut codes = vec![[0; 3]; shown.len().min(alpha.len())];
    let chunks = shown.par_chunks(CHUNK).zip(alpha.par_chunks(CHUNK)).zip(codes.par_chunks_mut(CHUNK));
    chunks.for_each(|((shown, alpha), codes)| {
        let shown: Vec<[f32; 3]> = shown.iter().zip(alpha).map(over).collect();
        let codes = codes.as_flattened_mut();
        Codes8::get().codes(shown.as_flattened(), codes);
        if behind.is_none() {
            codes.iter_mut().for_each(|code| *code /= 2);
        }
    });
    codes
}

/// The 8-bit codes of a pixel over the backdrop, or half of those over white: what a page shows behind it will be something between
/// black and white. If differences over white counted in full, pictures of glass would take 1.2 times the rays.
pub(super) fn over_background(display: &Display, pixel: [f32; 3], alpha: f32) -> [u8; 3] {
    shown_over_background(display, display.show(pixel), alpha)
}

fn shown_over_background(display: &Display, shown: [f32; 3], alpha: f32) -> [u8; 3] {
    let code = |channel: f32, behind: f32| Codes8::get().code(channel + behind * (1.0 - alpha));
    match display.backdrop() {
        Some(behind) => std::array::from_fn(|c| code(shown[c], behind[c])),
        None => shown.map(|channel| code(channel, 1.0) / 2),
    }
}

/// The 8-bit codes of pixels.
pub(super) fn codes_of(display: &Display, pixels: &[[f32; 3]]) -> Vec<[u8; 3]> {
    codes_of_shown(&display.all(pixels))
}

fn codes_of_shown(shown: &[[f32; 3]]) -> Vec<[u8; 3]> {
    let mut codes = vec![[0; 3]; shown.len()];
    shown.par_chunks(CHUNK).zip(codes.par_chunks_mut(CHUNK)).for_each(|(shown, codes)| {
        Codes8::get().codes(shown.as_flattened(), codes.as_flattened_mut());
    });
    codes
}

/// The largest difference of each pixel from one of its eight neighbours, in codes, row by row.
pub(super) fn contrasts(codes: &[[u8; 3]], width: u32) -> Vec<u8> {
    let width = width as usize;
    let rows: Vec<&[[u8; 3]]> = codes.chunks(width).collect();
    let mut contrasts = vec![0; codes.len()];
    contrasts.par_chunks_mut(width).with_min_len(8).enumerate().for_each(|(y, contrasts)| {
        let here = rows[y].as_flattened();
        let mut most = vec![0; here.len()];
        let around = &rows[y.saturating_sub(1)..(y + 2).min(rows.len())];
        for row in around.iter().map(|row| row.as_flattened()) {
            differ(&mut most, here, row);
            // The neighbour to the right, and that to the left.
            differ(&mut most[..here.len() - 3], &here[..here.len() - 3], &row[3..]);
            differ(&mut most[3..], &here[3..], &row[..here.len() - 3]);
        }
        for (contrast, most) in contrasts.iter_mut().zip(most.as_chunks::<3>().0) {
            *contrast = most[0].max(most[1]).max(most[2]);
        }
    });
    contrasts
}

/// Raises `most` to the differences of two rows, byte by byte, which the compiler vectorises.
fn differ(most: &mut [u8], a: &[u8], b: &[u8]) {
    for ((most, a), b) in most.iter_mut().zip(a).zip(b) {
        *most = (*most).max(a.abs_diff(*b));
    }
}

/// The largest difference of one pixel from its eight neighbours, as far as they lie in `part`, in codes. `codes` are those of
/// `around`, row by row.
pub(crate) fn contrast_within<const N: usize>(codes: &[[u8; N]], around: Region, part: Region, [x, y]: [u32; 2]) -> u8 {
    let here = codes[around.index([x, y])];
    let columns = x.saturating_sub(1).max(part.x)..=(x + 1).min(part.x + part.width - 1);
    let rows = y.saturating_sub(1).max(part.y)..=(y + 1).min(part.y + part.height - 1);
    let beside = rows.flat_map(|y| columns.clone().map(move |x| codes[around.index([x, y])]));
    beside.flat_map(|codes| (0..N).map(move |c| codes[c].abs_diff(here[c]))).fold(0, u8::max)
}

/// The same of all neighbours in `around`.
pub(crate) fn contrast_in<const N: usize>(codes: &[[u8; N]], around: Region, at: [u32; 2]) -> u8 {
    contrast_within(codes, around, around, at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::ToneMapping;

    #[test]
    fn codes_over_the_background_are_those_of_each_pixel() {
        let pixels: Vec<[f32; 3]> = (0..200).map(|i| [0.01 * i as f32, 0.3, 1.0 - 0.004 * i as f32]).collect();
        let alpha: Vec<f32> = (0..200).map(|i| (i % 11) as f32 / 10.0).collect();
        let display = Display::new(0.5, ToneMapping::KhronosPbrNeutral);
        for display in [display, display.over([0.2, 0.4, 0.6])] {
            let codes = codes_over_background(&display, &pixels, &alpha);
            for i in 0..200 {
                assert_eq!(codes[i], over_background(&display, pixels[i], alpha[i]));
            }
        }
    }

    #[test]
    fn all_pixels_at_once_and_each_alone_are_the_same() {
        for (width, height) in [(1, 1), (2, 3), (1, 5), (7, 1), (33, 9)] {
            let around = Region { x: 4, y: 5, width, height };
            // Codes from 0 to 9, of which few pairs differ by the threshold.
            let noise = |i: u64| ((i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) % 10) as u8;
            let codes: Vec<[u8; 3]> =
                (0..around.pixels()).map(|i| [noise(i), noise(i + 1_000), noise(i + 2_000)]).collect();
            let contrasts = contrasts(&codes, width);
            let mut seen = [0, 0];
            for [x, y] in around.iter() {
                let contrast = contrast_in(&codes, around, [x, y]);
                assert_eq!(contrasts[around.index([x, y])], contrast, "{x} {y}");
                seen[usize::from(contrast >= CONTRAST)] += 1;
            }
            assert!(width < 33 || seen.iter().all(|count| *count > 20), "{seen:?}");
        }
    }
}
