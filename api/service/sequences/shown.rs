//! All frames in one file: an animation or a contact sheet.

use rayon::prelude::*;
use strahl::control::{self, Cancelled};
use strahl::film::FileFormat;
use strahl::film::animation::{Animation, AnimationFormat, NoAnimation, Timing};
use strahl::film::encode::transcoded;

/// The formats that frames in a format can be animated in, the one that takes their files as they are first.
pub(crate) fn animations(frames: FileFormat) -> &'static [AnimationFormat] {
    match frames {
        FileFormat::Png8 => &[AnimationFormat::Apng, AnimationFormat::Webp, AnimationFormat::Gif],
        FileFormat::WebP => &[AnimationFormat::Webp, AnimationFormat::Apng, AnimationFormat::Gif],
        // WebP has no 16 bits.
        FileFormat::Png16 => &[AnimationFormat::Apng, AnimationFormat::Gif],
        FileFormat::Jpeg(_) | FileFormat::Exr | FileFormat::Pfm => &[],
    }
}

/// An animation of files in a format, which is one of [`animations`].
pub(crate) fn animation(
    files: &[&[u8]],
    frames: FileFormat,
    format: AnimationFormat,
    timing: Timing,
) -> Result<Animation, NoAnimation> {
    let Some(other) = format.frames().filter(|taken| *taken != frames.into()) else {
        return format.join(files, timing);
    };
    let again = |file: &&[u8]| {
        control::look_now().map_err(|Cancelled| NoAnimation::NoPicture)?;
        transcoded(file, other).ok_or(NoAnimation::NoPicture)
    };
    let files: Vec<Vec<u8>> = files.par_iter().map(again).collect::<Result<_, _>>()?;
    format.join(&files, timing)
}

/// Why frames cannot be animated, in words.
pub(crate) fn in_words(why: NoAnimation) -> &'static str {
    match why {
        NoAnimation::NoPicture => "the file of a frame is damaged or gone",
        NoAnimation::Different => "the frames differ: some are transparent, and some are not",
        NoAnimation::TooLarge => "the animation would be larger than its format can say",
    }
}
