//! JPEG (baseline, full color resolution) and lossless WebP, from 8-bit sRGB codes.

use super::sink::Sink;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder};

/// A JPEG file; quality 1 to 100.
pub(super) fn jpeg([width, height]: [u32; 2], codes: &[u8], quality: u8) -> Vec<u8> {
    Sink::collect(|file| {
        let encoder = JpegEncoder::new_with_quality(file, quality);
        encoder.write_image(codes, width, height, ExtendedColorType::Rgb8)
    })
}

/// A lossless WebP file, with three or four channels.
pub(super) fn webp([width, height]: [u32; 2], codes: &[u8], channels: usize) -> Vec<u8> {
    let color = if channels == 3 { ExtendedColorType::Rgb8 } else { ExtendedColorType::Rgba8 };
    Sink::collect(|file| {
        let encoder = WebPEncoder::new_lossless(file);
        encoder.write_image(codes, width, height, color)
    })
}

#[cfg(test)]
mod tests {
    use super::super::srgb::code8;
    use super::super::{FileFormat, Region, encode, encode::test_film};
    use image::ImageFormat;

    #[test]
    fn webp_holds_the_codes_and_jpeg_about_them() {
        let film = test_film(Region { x: 3, y: 1, width: 33, height: 20 }, 64, 48);
        let codes: Vec<u8> = film.pixels.as_flattened().iter().map(|&c| code8(c)).collect();
        let decoded = |format, as_what| {
            let file = encode(&film, format);
            image::load_from_memory_with_format(&file, as_what).unwrap().to_rgb8()
        };
        let exact = decoded(FileFormat::WebP, ImageFormat::WebP);
        assert_eq!(exact.dimensions(), (33, 20));
        assert_eq!(exact.as_raw(), &codes);

        let worst = |quality| {
            let near = decoded(FileFormat::Jpeg(quality), ImageFormat::Jpeg);
            assert_eq!(near.dimensions(), (33, 20));
            near.as_raw().iter().zip(&codes).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
        };
        let [fine, coarse] = [worst(95), worst(10)];
        assert!(fine <= 40 && fine < coarse, "{fine} {coarse}");
    }
}
