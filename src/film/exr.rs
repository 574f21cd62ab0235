//! OpenEXR 2: linear RGB as 32-bit floats, ZIP-compressed scan lines.
//!
//! The data window is the film's region and the display window the whole picture: stitchers put tiles together from
//! just that.

use super::layers::Channel;
use super::sink::Sink;
use super::{Film, Layer};
use exr::image::write::channels::WritableChannels;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image, ImageAttributes,
    IntegerBounds, LayerAttributes, LineOrder, SpecificChannels, Text, Vec2, WritableImage,
};
use std::ops::Range;

/// One part with the channels R, G and B, and A where the background is transparent: then the colors are multiplied by it,
/// as the format wants it.
pub(super) fn encode(film: &Film) -> Vec<u8> {
    let width = film.region.width as usize;
    // The writer wants channels that own what they read.
    let (pixels, alpha) = (film.pixels.clone(), film.alpha.clone());
    let attributes = LayerAttributes::default();
    if alpha.is_empty() {
        let channels = move |at: Vec2<usize>| <(f32, f32, f32)>::from(pixels[at.y() * width + at.x()]);
        return write(film, attributes, SpecificChannels::rgb(channels));
    }
    let channels = move |at: Vec2<usize>| {
        let index = at.y() * width + at.x();
        let [r, g, b] = pixels[index];
        (r, g, b, alpha[index])
    };
    write(film, attributes, SpecificChannels::rgba(channels))
}

/// The same part with the channels of layers, too. A dot in their names groups them.
pub fn encode_with(film: &Film, layers: Vec<Layer>) -> Vec<u8> {
    let mut attributes = LayerAttributes::default();
    for (name, value) in layers.iter().flat_map(Layer::attributes) {
        attributes.other.insert(Text::new_or_panic(name), AttributeValue::Text(Text::new_or_panic(value)));
    }
    let color = |(c, name): (usize, &str)| Channel {
        name: name.to_owned(),
        values: film.pixels.iter().map(|pixel| pixel[c]).collect(),
    };
    let colors = ["R", "G", "B"].into_iter().enumerate().map(color);
    let alpha = (!film.alpha.is_empty()).then(|| Channel { name: "A".to_owned(), values: film.alpha.clone() });
    let channels = colors.chain(alpha).chain(layers.into_iter().flat_map(Layer::channels));
    let channel = |Channel { name, values }| AnyChannel::new(name.as_str(), FlatSamples::F32(values));
    let mut file = write(film, attributes, AnyChannels::sort(channels.map(channel).collect()));
    sort_attributes(&mut file);
    file
}

fn write(film: &Film, attributes: LayerAttributes, channels: impl for<'a> WritableChannels<'a>) -> Vec<u8> {
    let region = film.region;
    let layer = exr::prelude::Layer::new(
        (region.width as usize, region.height as usize),
        LayerAttributes { layer_position: Vec2(region.x as i32, region.y as i32), ..attributes },
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing },
        channels,
    );
    let display = IntegerBounds::new((0, 0), (film.full_width as usize, film.full_height as usize));
    // One thread: the bytes must not depend on which block is ready first.
    let image = Image::new(ImageAttributes::new(display), layer);
    Sink::collect(|file| image.write().non_parallel().to_buffered(file))
}

/// Sorts the attributes in the head of a file by name: the writer has them in an order of chance. The head keeps its length.
fn sort_attributes(file: &mut [u8]) {
    /// Behind the magic number and the version.
    const START: usize = 8;
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut at = START;
    let text = |file: &[u8], at: usize| file.get(at..).and_then(|rest| rest.iter().position(|byte| *byte == 0));
    // Each is a name, a type, a length and a value; an empty name ends them.
    while let Some(name @ 1..) = text(file, at) {
        let Some(kind) = text(file, at + name + 1) else { return };
        let length = at + name + 1 + kind + 1;
        let Some(bytes) = file.get(length..).and_then(|rest| rest.first_chunk::<4>()) else { return };
        let end = length + 4 + u32::from_le_bytes(*bytes) as usize;
        ranges.push(at..end);
        at = end;
    }
    let Some(head) = file.get_mut(START..at) else { return };
    let mut attributes: Vec<Vec<u8>> =
        ranges.iter().map(|range| head[range.start - START..range.end - START].to_vec()).collect();
    attributes.sort();
    head.copy_from_slice(&attributes.concat());
}

#[cfg(test)]
mod tests {
    use super::super::{FileFormat, Region, encode, encode::test_film};
    use super::*;
    use crate::control::Control;
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

    /// Blocks are written at once, after milliseconds of compression.
    #[test]
    fn a_file_that_nobody_waits_for_ends() {
        let film = test_film(Region { x: 0, y: 0, width: 256, height: 256 }, 256, 256);
        let whole = encode(&film, FileFormat::Exr).len();
        let control = Control::default();
        control.cancel();
        let _entered = control.enter();
        assert!(encode(&film, FileFormat::Exr).len() < whole);
    }
}
