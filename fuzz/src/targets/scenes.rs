//! Scenes: each is refused with its problems, or rendered.

use strahl::film::Region;
use strahl::render::{Control, render};
use strahl::scene::description::{Accuracy, Fixed};
use strahl::scene::limits::PROBLEMS;
use strahl::scene::{Format, Overrides, load};

/// Text that is longer says nothing new.
const MOST: usize = 1 << 16;
/// Pixels of a side.
const SIDE: u32 = 4;

pub(super) fn json(text: &[u8]) {
    read(text, Format::Json);
}

pub(super) fn nff(text: &[u8]) {
    read(text, Format::Nff);
}

pub(super) fn gltf(bytes: &[u8]) {
    read(bytes, Format::Gltf);
}

pub(super) fn obj(text: &[u8]) {
    read(text, Format::Obj);
}

pub(super) fn stl(bytes: &[u8]) {
    read(bytes, Format::Stl);
}

pub(super) fn ply(bytes: &[u8]) {
    read(bytes, Format::Ply);
}

pub(super) fn parts(bytes: &[u8]) {
    read(bytes, Format::Parts);
}

/// Loading is the only step that can fail, and says why; what is rendered is light.
fn read(text: &[u8], format: Format) {
    if text.len() > MOST {
        return;
    }
    // Of the scene's own settings all but those that say how long it takes.
    let settings = Overrides {
        width: Some(SIDE),
        height: Some(SIDE),
        max_depth: Some(3),
        samples: Some(1),
        accuracy: Some(Accuracy::Fixed(Fixed {})),
        antialias: Some(false),
        ..Overrides::default()
    };
    match load(text, format, &settings) {
        Ok(loaded) => {
            let picture =
                render(&loaded.scene, Region::whole(SIDE, SIDE), &Control::default()).expect("nobody cancels it");
            let light = picture.film.pixels.as_flattened();
            assert!(light.iter().all(|channel| channel.is_finite() && *channel >= 0.0), "{light:?}");
        }
        Err(problems) => {
            let count = problems.reported().0.len();
            assert!((1..=PROBLEMS.max as usize).contains(&count), "{count} problems");
        }
    }
}
