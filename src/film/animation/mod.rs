//! Animations out of the files of their frames. The compressed pixels are taken as they are: each frame decodes to the codes of
//! its own picture, and nothing is encoded twice.

mod apng;
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
    /// Both, the usual one first.
    pub const ALL: [Self; 2] = [Self::Apng, Self::Webp];

    /// The format of the frames.
    pub fn frames(self) -> PictureFormat {
        match self {
            Self::Apng => PictureFormat::Png,
            Self::Webp => PictureFormat::Webp,
        }
    }

    /// The ending of its files, and its media type.
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Apng => ("png", "image/apng"),
            Self::Webp => ("webp", "image/webp"),
        }
    }

    /// The animation of frames in the format [`Self::frames`].
    pub fn join<F: AsRef<[u8]>>(self, frames: &[F], timing: Timing) -> Result<Vec<u8>, NoAnimation> {
        let frames: Vec<&[u8]> = frames.iter().map(AsRef::as_ref).collect();
        match self {
            Self::Apng => apng::join(&frames, timing),
            Self::Webp => webp::join(&frames, timing),
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

    fn films(transparent: bool) -> Vec<Film> {
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
            let frames = decoded(format, &joined);
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
        let lengths = decoded(AnimationFormat::Webp, &joined);
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
