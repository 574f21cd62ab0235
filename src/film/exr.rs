//! OpenEXR 2: linear RGB as 32-bit floats, ZIP-compressed scan lines.
//!
//! The data window is the film's region and the display window the whole picture: stitchers put tiles together from
//! just that.

use super::Film;
use super::sink::Sink;
use exr::prelude::{
    Blocks, Compression, Encoding, Image, ImageAttributes, IntegerBounds, Layer, LayerAttributes, LineOrder,
    SpecificChannels, Vec2, WritableImage,
};

/// One part with the channels R, G and B.
pub(super) fn encode(film: &Film) -> Vec<u8> {
    let region = film.region;
    let width = region.width as usize;
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let [r, g, b] = film.pixels[at.y() * width + at.x()];
        (r, g, b)
    });
    let layer = Layer::new(
        (width, region.height as usize),
        LayerAttributes { layer_position: Vec2(region.x as i32, region.y as i32), ..LayerAttributes::default() },
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing },
        channels,
    );
    let display = IntegerBounds::new((0, 0), (film.full_width as usize, film.full_height as usize));
    // One thread: the bytes must not depend on which block is ready first.
    let image = Image::new(ImageAttributes::new(display), layer);
    Sink::collect(|file| image.write().non_parallel().to_buffered(file))
}

#[cfg(test)]
mod tests {
    use super::super::{FileFormat, Region, encode, encode::test_film};
    use super::*;
    use exr::prelude::{ReadChannels, ReadLayers, read};
    use std::io::Cursor;

    #[test]
    fn keeps_floats_and_windows() {
        let mut film = test_film(Region { x: 3, y: 2, width: 20, height: 17 }, 40, 30);
        film.pixels[5] = [1e30, -2.5, 1e-40];
        let file = encode(&film, FileFormat::Exr);
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(
                |size, _| (size.width(), vec![[0.0_f32; 3]; size.area()]),
                |(width, pixels), at, (r, g, b): (f32, f32, f32)| pixels[at.y() * *width + at.x()] = [r, g, b],
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(&file))
            .unwrap();
        assert_eq!(image.layer_data.channel_data.pixels.1, film.pixels);
        assert_eq!(image.layer_data.attributes.layer_position, Vec2(3, 2));
        assert_eq!(image.layer_data.size, Vec2(20, 17));
        assert_eq!(image.attributes.display_window, IntegerBounds::new((0, 0), (40, 30)));
        assert_eq!(file, encode(&film, FileFormat::Exr));
    }
}
