//! Says which effects a scene calls for, why, and what they should take, without rendering it:
//!
//! ```sh
//! cargo run --release --example explain -- scenes/whitted/whitted.json
//! ```
#![allow(clippy::print_stdout, reason = "it reports what it found")]

use std::error::Error;
use std::path::Path;
use strahl::film::Region;
use strahl::plan::Plan;
use strahl::plan::explain::State;
use strahl::plan::pilot::Effort;
use strahl::render::Control;
use strahl::scene::{Format, Overrides, load};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().collect();
    let [_, scene] = args.as_slice() else { return Err("usage: explain SCENE.json".into()) };
    println!("{}", run(Path::new(scene))?);
    Ok(())
}

/// The effects of a scene that are on, one in each line, and what its picture should take.
pub fn run(file: &Path) -> Result<String, Box<dyn Error>> {
    let mut loaded =
        load(&std::fs::read(file)?, Format::Json, &Overrides::default()).map_err(|problems| problems.to_string())?;
    let scene = &loaded.scene;

    // The plan follows from the scene alone. The estimate traces a pilot: a small part of the pixels.
    let mut plan = Plan::new(&mut loaded.description, scene);
    let region = Region::whole(scene.width, scene.height);
    plan.estimate(scene, region, &Control::default(), Effort::QUICK).map_err(|_| "cancelled")?;

    let mut text = String::new();
    for effect in plan.explanation.effects.iter().filter(|effect| effect.state == State::On) {
        let pointer = effect.because.first().map_or("", String::as_str);
        text += &format!("{:<22}{} {pointer}\n", effect.effect, effect.reason);
    }
    if let Some(estimate) = plan.estimate {
        let [low, high] = estimate.rays_ci;
        text += &format!("about {} rays ({low} to {high}) and {:.0} ms\n", estimate.rays, estimate.ms);
    }
    Ok(text)
}
