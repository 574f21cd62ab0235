//! Says what accuracy costs for a scene: renders it at growing depth, and compares each picture with one that is proved to
//! be exact. `strahl tradeoff` does this thoroughly; this is its idea in a page:
//!
//! ```sh
//! cargo run --release --example tradeoff -- scenes/mirrors/hall.json
//! ```
#![allow(clippy::print_stdout, reason = "it reports what it measured")]

use std::error::Error;
use std::path::Path;
use strahl::film::Region;
use strahl::metrics::{Image8, code_errors};
use strahl::render::{Control, Picture, render};
use strahl::scene::description::{Accuracy, Precision, Proved};
use strahl::scene::{Format, Overrides, load};

const DEPTHS: [u32; 5] = [2, 3, 5, 10, 100];

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().collect();
    let [_, scene] = args.as_slice() else { return Err("usage: tradeoff SCENE.json".into()) };
    println!("{}", run(Path::new(scene), 320, 200)?);
    Ok(())
}

/// A table of depths with their rays, times and errors.
pub fn run(file: &Path, width: u32, height: u32) -> Result<String, Box<dyn Error>> {
    let bytes = std::fs::read(file)?;
    // Overrides replace settings of the scene, as flags of the command and parameters of a request do.
    let size = Overrides { width: Some(width), height: Some(height), antialias: Some(false), ..Overrides::default() };
    let picture = |overrides: Overrides| -> Result<Picture, Box<dyn Error>> {
        let scene = load(&bytes, Format::Json, &overrides).map_err(|problems| problems.to_string())?.scene;
        Ok(render(&scene, Region::whole(width, height), &Control::default()).map_err(|_| "cancelled")?)
    };
    let exact = Accuracy::Proved(Proved { max_codes: 0 });
    let reference = picture(Overrides { accuracy: Some(exact), precision: Some(Precision::Double), ..size })?;
    let reference = Image8::from(&reference.film);

    let mut text = "depth        rays      ms   mean error   largest   proved\n".to_owned();
    for depth in DEPTHS {
        let picture =
            picture(Overrides { max_depth: Some(depth), accuracy: Some(Accuracy::Fixed(Default::default())), ..size })?;
        let error = code_errors(&reference, &Image8::from(&picture.film)).error;
        text += &format!(
            "{depth:>5}{:>12}{:>8.1}{:>13.2}{:>10}{:>9}\n",
            picture.rays.total(),
            picture.trace_ms,
            error.mean,
            error.max,
            picture.proof().max_codes,
        );
    }
    Ok(text)
}
