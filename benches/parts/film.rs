//! Encoding a 1920 x 1080 picture.

use crate::time;
use strahl::film::{FileFormat, Film, Region, encode};

pub(crate) fn formats() {
    let (width, height) = (1920, 1080);
    let pixel = |[x, y]: [u32; 2]| {
        let tile = if (x / 40 + y / 40) % 2 == 0 { 0.8 } else { 0.2 };
        [tile, x as f32 / width as f32, y as f32 / height as f32 * tile]
    };
    let region = Region::whole(width, height);
    let film = Film {
        region,
        full_width: width,
        full_height: height,
        pixels: region.iter().map(pixel).collect(),
        ..Film::default()
    };
    for format in
        [FileFormat::Png8, FileFormat::Png16, FileFormat::Jpeg(90), FileFormat::WebP, FileFormat::Exr, FileFormat::Pfm]
    {
        time(&format!("encode {format:?}"), || (), |()| encode(&film, format));
    }
}
