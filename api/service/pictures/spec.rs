//! Which part of an image is shown, and how. Together with the image's id this is the name of a file, known before it is
//! rendered.

use super::render::RenderSpec;
use crate::service::error::Error;
use crate::service::limits::TILE;
use std::fmt::{Display, Write};
use strahl::camera::Window;
use strahl::film::{Adjustment, FileFormat, Region, Tone};
use strahl::render::Layers;
use strahl::scene::Scene;

/// A grid of pixels over an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Grid {
    /// The whole image, scaled down by 2^n, or enlarged if n is negative.
    Level(i32),
    /// The same in whole tiles. Tiles along the edges extend beyond the image.
    Tiles(i32),
    /// A rectangle of the image, scaled to any number of pixels.
    Part(Region, [u32; 2]),
}

/// A part of an image and how it is encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PictureSpec {
    /// The pixels.
    pub(crate) grid: Grid,
    /// The pixels that are shown. None: all.
    pub(crate) region: Option<Region>,
    /// Mirroring, rotation and tone.
    pub(crate) adjustment: Adjustment,
    /// The format of the file.
    pub(crate) format: FileFormat,
    /// Layers beside the colors, of formats that hold them.
    pub(crate) layers: Layers,
}

impl PictureSpec {
    /// The whole image, or a region of it.
    pub(crate) fn plain(region: Option<Region>, format: FileFormat) -> Self {
        Self { grid: Grid::Level(0), region, adjustment: Adjustment::default(), format, layers: Layers::default() }
    }

    /// Whether it is the whole image without changes, and nothing beside.
    pub(crate) fn is_whole(&self) -> bool {
        let changes = self.adjustment != Adjustment::default() || !self.layers.is_empty();
        self.grid == Grid::Level(0) && self.region.is_none() && !changes
    }

    /// The part of a name after the image's id.
    pub(crate) fn suffix(&self) -> String {
        let mut name = String::new();
        let list = |name: &mut String, region: Region| {
            let Region { x, y, width, height } = region;
            // Writing to a String cannot fail, here and below.
            let _ = write!(name, "{x}-{y}-{width}-{height}");
        };
        match self.grid {
            Grid::Level(0) => {}
            Grid::Level(level) => drop(write!(name, ".l{level}")),
            Grid::Tiles(level) => drop(write!(name, ".t{level}")),
            Grid::Part(from, [width, height]) => {
                name.push_str(".p");
                list(&mut name, from);
                let _ = write!(name, "-{width}-{height}");
            }
        }
        if let Some(region) = self.region {
            name.push('.');
            list(&mut name, region);
        }
        if self.adjustment != Adjustment::default() {
            let Adjustment { mirrored, quarters, tone } = self.adjustment;
            let tone = match tone {
                Tone::Color => "c",
                Tone::Gray => "g",
                Tone::Bitonal => "b",
            };
            let _ = write!(name, ".{}{quarters}{tone}", if mirrored { "m" } else { "r" });
        }
        if !self.layers.is_empty() {
            let _ = write!(name, ".{}", self.layers);
        }
        match self.format {
            FileFormat::Png16 => name.push_str(".png16"),
            FileFormat::Jpeg(quality) => drop(write!(name, ".jpg{quality}")),
            format => drop(write!(name, ".{}", format.names().0)),
        }
        name
    }

    /// The name for an image.
    pub(crate) fn name(&self, image: &impl Display) -> String {
        format!("{image}{}", self.suffix())
    }

    /// What to render of a scene that is opened as 2^zoom times its size.
    pub(crate) fn render_spec(&self, scene: &Scene, zoom: u32) -> Result<RenderSpec, Error> {
        let window = self.window(scene, zoom).ok_or_else(|| {
            Error::OutOfRange("the picture would be larger than this scene's numbers can tell apart".into())
        })?;
        let region = self.region.unwrap_or_else(|| Region::whole(window.width, window.height));
        if !region.fits(window.width, window.height) {
            let Region { x, y, width, height } = region;
            let what = format!("the region x={x}, y={y}, w={width}, h={height}");
            return Err(outside(&what, window.width, window.height));
        }
        self.layers.check(scene).map_err(Error::OutOfRange)?;
        let Self { adjustment, layers, .. } = *self;
        Ok(RenderSpec { window, adjustment, layers, ..RenderSpec::of(scene, region, self.format) })
    }

    fn window(&self, &Scene { width, height, .. }: &Scene, zoom: u32) -> Option<Window> {
        match self.grid {
            Grid::Level(level) => Window::level(width, height, level - zoom as i32),
            Grid::Tiles(level) => {
                let window = Window::level(width, height, level - zoom as i32)?;
                let whole = |length: u32| length.checked_next_multiple_of(TILE);
                Some(Window { width: whole(window.width)?, height: whole(window.height)?, ..window })
            }
            Grid::Part(from, [width, height]) => {
                let scale = f64::from(1_u32 << zoom);
                let scaled = |pair: [u32; 2]| pair.map(|length| f64::from(length) / scale);
                Some(Window::part(scaled([from.x, from.y]), scaled([from.width, from.height]), width, height))
            }
        }
    }
}

/// The error for a region or pixel outside of the picture.
pub(crate) fn outside(what: &str, width: u32, height: u32) -> Error {
    Error::OutOfRange(format!("{what} does not lie inside the picture of {width} x {height} pixels"))
}

/// Pixels across and down of a scene that is opened as 2^zoom times its size. Beyond 2^19 neighbouring pixels have the same
/// rays in single precision, beyond 2^30 tiles can no longer be counted.
pub(crate) fn size_of(scene: &Scene, zoom: u32) -> Option<[u32; 2]> {
    let most = match scene.world {
        strahl::scene::compile::Precise::Single(_) => 1 << 19,
        strahl::scene::compile::Precise::Double(_) => 1 << 30,
    };
    let window = Window::level(scene.width, scene.height, -(zoom as i32))?;
    (window.width.max(window.height) <= most).then_some([window.width, window.height])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_that_changes_the_bytes_changes_the_name() {
        let plain = PictureSpec::plain(None, FileFormat::Png8);
        let region = Region { x: 1, y: 2, width: 3, height: 4 };
        let adjustment =
            |mirrored, quarters, tone| PictureSpec { adjustment: Adjustment { mirrored, quarters, tone }, ..plain };
        let grid = |grid| PictureSpec { grid, ..plain };
        let layers = |layers: &str| PictureSpec { layers: layers.parse().unwrap(), ..plain };
        let all = [
            plain,
            PictureSpec::plain(Some(region), FileFormat::Png8),
            PictureSpec::plain(None, FileFormat::Png16),
            PictureSpec::plain(None, FileFormat::Jpeg(9)),
            PictureSpec::plain(None, FileFormat::Jpeg(90)),
            PictureSpec::plain(None, FileFormat::WebP),
            PictureSpec::plain(None, FileFormat::Exr),
            PictureSpec::plain(None, FileFormat::Pfm),
            grid(Grid::Level(1)),
            grid(Grid::Level(-1)),
            grid(Grid::Tiles(0)),
            grid(Grid::Part(region, [5, 6])),
            grid(Grid::Part(region, [5, 7])),
            adjustment(true, 0, Tone::Color),
            adjustment(false, 1, Tone::Color),
            adjustment(false, 0, Tone::Gray),
            adjustment(false, 0, Tone::Bitonal),
            layers("normal"),
            layers("share:/objects/1"),
            layers("share:/objects/2"),
            layers("normal,share:/objects/2"),
        ];
        let mut names: Vec<_> = all.iter().map(PictureSpec::suffix).collect();
        assert_eq!(names[..3], [".png", ".1-2-3-4.png", ".png16"]);
        names.sort();
        names.dedup();
        assert_eq!(names.len(), all.len(), "{names:?}");
    }
}
