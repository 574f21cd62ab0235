//! Animations out of the files of their frames. PNG and WebP take the compressed pixels as they are: each frame decodes to the
//! codes of its own picture, and nothing is encoded twice. GIF loses colors, and says how many codes.

mod apng;
mod gif;
mod webp;

use super::PictureFormat;

/// How frames are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Frames a second, 0.1 to 100.
    pub rate: f64,
    /// How often they are shown; 0: again and again.
    pub loops: u16,
}

/// Formats of animations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnimationFormat {
    /// Animated PNG (PNG specification, third edition).
    Apng,
    /// Animated lossless WebP.
    Webp,
    /// Animated GIF: 256 colors for each frame, and nothing is half transparent.
    Gif,
}

/// An animation.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Its file.
    pub file: Vec<u8>,
    /// The largest difference of a channel from the frames, in 8-bit codes: 0 where the format loses nothing.
    pub largest: u8,
    /// The mean of all differences.
    pub mean: f64,
}

impl Animation {
    /// One of a format that loses nothing.
    fn exact(file: Vec<u8>) -> Self {
        Self { file, largest: 0, mean: 0.0 }
    }

    /// What it has lost, as a warning.
    pub fn warning(&self) -> Option<String> {
        let Self { largest, mean, .. } = self;
        (*largest > 0).then(|| {
            format!("GIF has 256 colors a picture: up to {largest} of 255 codes off, {mean:.1} in the mean; png and webp lose nothing")
        })
    }
}

/// Why frames make no animation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoAnimation {
    /// There is none, or one of them is no such file.
    NoPicture,
    /// They differ in size, in depth, or in that some are transparent.
    Different,
    /// The file would be larger than the format can say.
    TooLarge,
}

impl AnimationFormat {
    /// All of them, the usual one first.
    pub const ALL: [Self; 3] = [Self::Apng, Self::Webp, Self::Gif];

    /// The format whose files it takes as they are; none if it takes any.
    pub fn frames(self) -> Option<PictureFormat> {
        match self {
            Self::Apng => Some(PictureFormat::Png),
            Self::Webp => Some(PictureFormat::Webp),
            Self::Gif => None,
        }
    }

    /// The format that an ending or a query names.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.names().0 == name)
    }

    /// The ending of its files, and its media type.
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Apng => ("png", "image/apng"),
            Self::Webp => ("webp", "image/webp"),
            Self::Gif => ("gif", "image/gif"),
        }
    }

    /// The animation of frames in the format [`Self::frames`].
    pub fn join<F: AsRef<[u8]>>(self, frames: &[F], timing: Timing) -> Result<Animation, NoAnimation> {
        let frames: Vec<&[u8]> = frames.iter().map(AsRef::as_ref).collect();
        match self {
            Self::Apng => apng::join(&frames, timing).map(Animation::exact),
            Self::Webp => webp::join(&frames, timing).map(Animation::exact),
            Self::Gif => gif::join(&frames, timing),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FileFormat, Film, Region, encode, encode::test_film};
    use super::*;
    use image::codecs::png::PngDecoder;
    use image::codecs::webp::WebPDecoder;
    use image::{AnimationDecoder, Frame};
    use std::io::Cursor;

    pub(super) fn films(transparent: bool) -> Vec<Film> {
        let film = |n: u32| {
            let film = test_film(Region { x: n, y: 2 * n, width: 21, height: 10 }, 64, 48);
            let alpha = if transparent { vec![0.25 * n as f32; film.pixels.len()] } else { Vec::new() };
            Film { alpha, ..film }
        };
        (0..4).map(film).collect()
    }

    fn decoded(format: AnimationFormat, file: &[u8]) -> Vec<Frame> {
        let file = Cursor::new(file);
        let frames = match format {
            AnimationFormat::Apng => PngDecoder::new(file).unwrap().apng().unwrap().into_frames().collect_frames(),
            AnimationFormat::Webp => WebPDecoder::new(file).unwrap().into_frames().collect_frames(),
            AnimationFormat::Gif => panic!("read by the crate that writes it"),
        };
        frames.unwrap()
    }

    #[test]
    fn frames_decode_to_their_own_pictures() {
        for (format, of, transparent) in [
            (AnimationFormat::Apng, FileFormat::Png8, false),
            (AnimationFormat::Apng, FileFormat::Png8, true),
            (AnimationFormat::Webp, FileFormat::WebP, false),
            (AnimationFormat::Webp, FileFormat::WebP, true),
        ] {
            let files: Vec<_> = films(transparent).iter().map(|film| encode(film, of)).collect();
            let joined = format.join(&files, Timing { rate: 25.0, loops: 0 }).unwrap();
            assert_eq!(joined.warning(), None);
            let frames = decoded(format, &joined.file);
            assert_eq!(frames.len(), files.len());
            for (frame, file) in frames.iter().zip(&files) {
                assert_eq!(frame.buffer(), &image::load_from_memory(file).unwrap().to_rgba8(), "{format:?}");
                assert_eq!(frame.delay().numer_denom_ms(), (40, 1));
            }
        }
    }

    /// Milliseconds are rounded, but the error does not grow: a second takes a second.
    #[test]
    fn the_rate_is_kept() {
        let files: Vec<_> = (0..24).map(|_| encode(&films(false)[0], FileFormat::WebP)).collect();
        let joined = AnimationFormat::Webp.join(&files, Timing { rate: 24.0, loops: 3 }).unwrap();
        let lengths = decoded(AnimationFormat::Webp, &joined.file);
        let lengths: Vec<u32> = lengths.iter().map(|frame| frame.delay().numer_denom_ms().0).collect();
        assert_eq!((lengths[..3].to_vec(), lengths.iter().sum::<u32>()), (vec![42, 41, 42], 1_000));
    }

    #[test]
    fn what_does_not_fit_together_is_refused() {
        let [plain, clear] = [false, true].map(|transparent| encode(&films(transparent)[1], FileFormat::Png8));
        let join = |files: &[&Vec<u8>]| AnimationFormat::Apng.join(files, Timing { rate: 24.0, loops: 0 });
        assert_eq!(join(&[&plain, &clear]), Err(NoAnimation::Different));
        assert_eq!(join(&[]), Err(NoAnimation::NoPicture));
        assert_eq!(join(&[&plain, &Vec::new()]), Err(NoAnimation::NoPicture));
        for end in 0..plain.len() {
            assert!(join(&[&plain[..end].to_vec()]).is_err(), "{end}");
        }
    }
}
