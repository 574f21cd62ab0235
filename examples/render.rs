//! Renders a scene file into a PNG and says what it cost:
//!
//! ```sh
//! cargo run --release --example render -- scenes/whitted/whitted.json whitted.png
//! ```
#![allow(clippy::print_stdout, reason = "it reports what it did")]

use std::error::Error;
use std::path::Path;
use strahl::film::{FileFormat, Region, encode};
use strahl::render::{Control, render};
use strahl::scene::{Format, Overrides, load};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().collect();
    let [_, scene, picture] = args.as_slice() else { return Err("usage: render SCENE.json PICTURE.png".into()) };
    println!("{}", run(Path::new(scene), Path::new(picture))?);
    Ok(())
}

/// Renders `file` into `picture`; the cost in a few lines.
pub fn run(file: &Path, picture: &Path) -> Result<String, Box<dyn Error>> {
    // Loading is the only step that can fail. `Problems` lists everything that is wrong with a scene, with line and column.
    let loaded =
        load(&std::fs::read(file)?, Format::Json, &Overrides::default()).map_err(|problems| problems.to_string())?;
    let scene = &loaded.scene;

    // Rendering uses the current rayon pool. Another thread may watch `control`, or cancel the render through it.
    let control = Control::default();
    let rendered = render(scene, Region::whole(scene.width, scene.height), &control).map_err(|_| "cancelled")?;
    std::fs::write(picture, encode(&rendered.film, FileFormat::Png8))?;

    let (rays, proof) = (rendered.rays, rendered.proof());
    Ok(format!(
        "{} x {} pixels\n\
         loading   {:.1} ms\n\
         tracing   {:.1} ms\n\
         rays      {} camera, {} shadow, {} reflected, {} transmitted\n\
         proved    at most {} codes off, {:.1} % of the pixels exact",
        scene.width,
        scene.height,
        loaded.parse_ms + loaded.plan_ms + scene.bvh_ms,
        rendered.trace_ms,
        rays.camera,
        rays.shadow,
        rays.reflected,
        rays.transmitted,
        proof.max_codes,
        100.0 * proof.identical_fraction,
    ))
}
