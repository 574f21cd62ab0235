//! A picture that everybody knows: a node whose processor, memory or compiler makes another one of it takes no work.

use crate::service::error::panic_text;
use std::panic::catch_unwind;
use strahl::film::{FileFormat, Region, encode};
use strahl::render::{Control, render};
use strahl::scene::{Format, Overrides, load};

const SCENE: &[u8] = include_bytes!("../../../../scenes/whitted/whitted.json");
/// The picture that a person has looked at, as 8-bit codes.
const PICTURE: &[u8] = include_bytes!("../../../../tests/golden/whitted-whitted.png");

/// Renders it; how it differs, if it does.
pub(super) fn check() -> Result<(), String> {
    let made = catch_unwind(made).map_err(|panic| format!("rendering panics: {}", panic_text(&*panic)))??;
    let pixels = |png: &[u8]| image::load_from_memory(png).map(image::DynamicImage::into_rgb8);
    let (Ok(made), Ok(known)) = (pixels(&made), pixels(PICTURE)) else {
        return Err("the picture that is compared cannot be read".into());
    };
    let differing = made.pixels().zip(known.pixels()).filter(|(made, known)| made != known).count();
    match differing {
        0 if made.dimensions() == known.dimensions() => Ok(()),
        _ => Err(format!("{differing} pixels of a known picture are others than they should be")),
    }
}

fn made() -> Result<Vec<u8>, String> {
    let size = Overrides { width: Some(240), height: Some(135), ..Overrides::default() };
    let scene = load(SCENE, Format::Json, &size).map_err(|problems| problems.to_string())?.scene;
    let whole = Region::whole(scene.width, scene.height);
    let picture = render(&scene, whole, &Control::default()).map_err(|_| "the render ended early")?;
    Ok(encode(&picture.film, FileFormat::Png8))
}

#[cfg(test)]
mod tests {
    #[test]
    fn this_machine_may_be_a_node() {
        assert_eq!(super::check(), Ok(()));
    }
}
