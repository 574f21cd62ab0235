//! Animated GIF (version 89a), for chats, mails and programs that take nothing else. It has 256 colors for a picture, chosen by
//! NeuQuant (Dekker 1994) where there are more, and pixels are there or not: transparent frames lie over white, as in JPEG.

use super::{Animation, NoAnimation, Timing};
use crate::control;
use crate::film::srgb::Codes8;
use crate::math::srgb_to_linear;
use gif::{Encoder, Frame, Repeat};
use rayon::prelude::*;

/// About so many pixels of a picture teach NeuQuant its colors, which takes most of the time.
const TAUGHT: usize = 1 << 16;

/// A frame, and how far its colors are from those of its file.
struct Indexed {
    frame: Frame<'static>,
    /// The largest difference, and the sum of all, in codes.
    largest: u8,
    all: u64,
}

pub(super) fn join(files: &[&[u8]], timing: Timing) -> Result<Animation, NoAnimation> {
    let mut indexed = Vec::new();
    // Frames take much more memory as colors than as indices, so few are colors at a time.
    for some in files.chunks(rayon::current_num_threads()) {
        let some: Option<Vec<Indexed>> = some.par_iter().map(|file| index(file)).collect();
        indexed.extend(some.ok_or(NoAnimation::NoPicture)?);
    }
    let Some(first) = indexed.first() else { return Err(NoAnimation::NoPicture) };
    let (width, height) = (first.frame.width, first.frame.height);
    if indexed.iter().any(|indexed| (indexed.frame.width, indexed.frame.height) != (width, height)) {
        return Err(NoAnimation::Different);
    }
    let numbers = 3 * indexed.len() as u64 * u64::from(width) * u64::from(height);
    let (largest, all) =
        indexed.iter().fold((0, 0), |(largest, all), indexed| (indexed.largest.max(largest), indexed.all + all));
    let file = write(indexed.into_iter().map(|indexed| indexed.frame), [width, height], timing);
    Ok(Animation { file: file.ok_or(NoAnimation::TooLarge)?, largest, mean: all as f64 / numbers as f64 })
}

/// Writes a file; none if a format or memory does not take it.
fn write(frames: impl Iterator<Item = Frame<'static>>, [width, height]: [u16; 2], timing: Timing) -> Option<Vec<u8>> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height, &[]).ok()?;
    // The number in the file is that of repetitions.
    encoder.set_repeat(timing.loops.checked_sub(1).map_or(Repeat::Infinite, Repeat::Finite)).ok()?;
    // Whole hundredths of a second, whose sum does not drift away from the rate.
    let begins = |frame: usize| (100.0 * frame as f64 / timing.rate).round() as u64;
    for (number, mut frame) in frames.enumerate() {
        frame.delay = u16::try_from(begins(number + 1) - begins(number)).ok()?;
        encoder.write_lzw_pre_encoded_frame(&frame).ok()?;
    }
    drop(encoder);
    Some(file)
}

/// The frame of a picture file; none, too, if the work is cancelled.
fn index(file: &[u8]) -> Option<Indexed> {
    control::look_now().ok()?;
    let picture = image::load_from_memory(file).ok()?;
    let (width, height) = (u16::try_from(picture.width()).ok()?, u16::try_from(picture.height()).ok()?);
    let mut codes = picture.into_rgba8().into_raw();
    codes.as_chunks_mut::<4>().0.iter_mut().for_each(over_white);
    control::look_now().ok()?;
    let one_of = (codes.len() / 4 / TAUGHT).clamp(1, 30) as i32;
    let mut frame = Frame::from_rgba_speed(width, height, &mut codes, one_of);
    let palette = frame.palette.as_deref().unwrap_or_default().as_chunks::<3>().0;
    let (mut largest, mut all) = (0, 0);
    for (index, [red, green, blue, _]) in frame.buffer.iter().zip(codes.as_chunks::<4>().0) {
        let off = |channel: usize, code: u8| palette[usize::from(*index)][channel].abs_diff(code);
        for off in [off(0, *red), off(1, *green), off(2, *blue)] {
            (largest, all) = (off.max(largest), all + u64::from(off));
        }
    }
    frame.make_lzw_pre_encoded();
    Some(Indexed { frame, largest, all })
}

/// Puts a pixel of a transparent picture over white, as light.
fn over_white(pixel: &mut [u8; 4]) {
    let [colors @ .., alpha] = pixel;
    if *alpha < u8::MAX {
        let there = f64::from(*alpha) / 255.0;
        for code in colors {
            let light = srgb_to_linear(f64::from(*code) / 255.0) * there + (1.0 - there);
            *code = Codes8::get().code(light as f32);
        }
        *alpha = u8::MAX;
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::films;
    use super::super::{AnimationFormat, NoAnimation, Timing};
    use crate::control::Control;
    use crate::film::encode::test_film;
    use crate::film::srgb::code8;
    use crate::film::{FileFormat, Film, Region, encode};
    use gif::{ColorOutput, DecodeOptions, Repeat};

    /// The pictures of a GIF, three codes for each pixel, their lengths in hundredths of a second, and its repetitions.
    fn read_gif(file: &[u8]) -> (Vec<Vec<u8>>, Vec<u16>, Repeat) {
        let mut options = DecodeOptions::new();
        options.set_color_output(ColorOutput::RGBA);
        let mut decoder = options.read_info(file).unwrap();
        let (mut pictures, mut lengths) = (Vec::new(), Vec::new());
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            assert_eq!((frame.left, frame.top, frame.width, frame.height), (0, 0, 21, 10));
            let codes = frame.buffer.as_chunks::<4>().0;
            assert!(codes.iter().all(|[.., alpha]| *alpha == 255));
            pictures.push(codes.iter().flat_map(|[red, green, blue, _]| [*red, *green, *blue]).collect());
            lengths.push(frame.delay);
        }
        (pictures, lengths, decoder.repeat())
    }

    #[test]
    fn a_gif_is_as_far_off_as_it_says() {
        for of in [FileFormat::Png8, FileFormat::WebP, FileFormat::Png16] {
            let films = films(false);
            let files: Vec<_> = films.iter().map(|film| encode(film, of)).collect();
            let made = AnimationFormat::Gif.join(&files, Timing { rate: 24.0, loops: 3 }).unwrap();
            let (pictures, lengths, repeat) = read_gif(&made.file);
            // 210 colors fit into 256.
            assert_eq!((made.largest, made.mean, made.warning()), (0, 0.0, None));
            for (picture, file) in pictures.iter().zip(&files) {
                assert_eq!(picture, image::load_from_memory(file).unwrap().to_rgb8().as_raw(), "{of:?}");
            }
            assert_eq!((lengths, repeat), (vec![4, 4, 5, 4], Repeat::Finite(2)));
        }
        // A picture of more colors: none of them further off than is said.
        let film = test_film(Region { x: 0, y: 0, width: 64, height: 48 }, 64, 48);
        let file = encode(&film, FileFormat::Png8);
        let made = AnimationFormat::Gif.join(&[&file], Timing { rate: 1.0, loops: 1 }).unwrap();
        let mut decoder = DecodeOptions::new();
        decoder.set_color_output(ColorOutput::RGBA);
        let mut decoder = decoder.read_info(&made.file[..]).unwrap();
        let shown = decoder.read_next_frame().unwrap().unwrap().buffer.to_vec();
        let exact = image::load_from_memory(&file).unwrap().to_rgba8().into_raw();
        let off: Vec<u8> = shown.iter().zip(&exact).map(|(a, b)| a.abs_diff(*b)).collect();
        let mean = off.iter().map(|off| f64::from(*off)).sum::<f64>() / (0.75 * off.len() as f64);
        assert_eq!((made.largest, made.mean), (*off.iter().max().unwrap(), mean));
        assert!(made.largest > 0 && mean < 4.0, "{} {mean}", made.largest);
        let warning = format!("up to {} of 255 codes off, {mean:.1} in the mean", made.largest);
        assert!(made.warning().unwrap().contains(&warning), "{:?}", made.warning());
    }

    #[test]
    fn a_gif_that_nobody_waits_for_ends() {
        let file = encode(&films(false)[0], FileFormat::Png8);
        let threads = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let control = Control::default();
        let join = || {
            let _entered = control.enter();
            AnimationFormat::Gif.join(&[&file], Timing { rate: 1.0, loops: 0 }).map(drop)
        };
        assert_eq!(threads.install(join), Ok(()));
        control.cancel();
        assert_eq!(threads.install(join), Err(NoAnimation::NoPicture));
    }

    /// As a JPEG of it does, but for the roundings of alpha.
    #[test]
    fn transparent_frames_of_a_gif_lie_over_white() {
        let premultiplied = |film: Film| Film {
            pixels: film
                .pixels
                .iter()
                .zip(&film.alpha)
                .map(|(pixel, alpha)| pixel.map(|c| c.min(1.0) * alpha))
                .collect(),
            ..film
        };
        let films: Vec<Film> = films(true).into_iter().map(premultiplied).collect();
        let files: Vec<_> = films.iter().map(|film| encode(film, FileFormat::Png8)).collect();
        let made = AnimationFormat::Gif.join(&files, Timing { rate: 1.0, loops: 0 }).unwrap();
        let (pictures, _, repeat) = read_gif(&made.file);
        assert_eq!(repeat, Repeat::Infinite);
        assert!(pictures[0].iter().all(|code| *code == 255), "nothing is there");
        for (picture, film) in pictures.iter().zip(&films) {
            let light = film.pixels.iter().zip(&film.alpha).flat_map(|(pixel, alpha)| pixel.map(|c| c + 1.0 - alpha));
            for (code, light) in picture.iter().zip(light) {
                assert!(code.abs_diff(code8(light)) <= 1, "{code} {light}");
            }
        }
    }
}
