//! The fast tracer against the reference: an independent f64 tracer without hierarchies, packets or specialisation.
//!
//! Where a ray passes an edge, rounding decides which surface it meets, and the two tracers may differ by any amount;
//! glass multiplies such pixels. They are counted, and their share is bounded by name.

use crate::common::{load_scene, render_whole, scene_names};
use strahl::reference::Reference;
use strahl::scene::Overrides;
use strahl::scene::compile::compile;
use strahl::scene::description::Precision;

/// Largest difference of linear radiance in single precision, edges aside: a third of an sRGB code of mid grey.
const SINGLE: f64 = 1e-3;
/// The same in double precision; pixels are kept as f32, which is what limits it.
const DOUBLE: f64 = 2e-6;
/// Largest share of pixels at edges, in single and in double precision.
const SINGLE_EDGES: f64 = 0.003;
const DOUBLE_EDGES: f64 = 0.001;
/// The flakes are edges all over: mirrors on mirrors, down to spheres far smaller than a pixel.
const SINGLE_FRACTAL_EDGES: f64 = 0.11;
/// The reference recurses on the thread's stack.
const DEEPEST: u32 = 60;
/// Rays between the balls of a fractal part further with each reflection.
const DEEPEST_IN_FRACTALS: u32 = 5;

fn differences(name: &str, precision: Precision, tolerance: f64) -> (usize, usize, f64) {
    let deepest = if is_fractal(name) { DEEPEST_IN_FRACTALS } else { DEEPEST };
    let max_depth = load_scene(name, 8, Overrides::default()).description.render.fixed_depth().min(deepest);
    let overrides = Overrides {
        max_depth: Some(max_depth),
        precision: Some(precision),
        antialias: Some(false),
        ..Overrides::default()
    };
    let mut loaded = load_scene(name, 96, overrides);
    // The reference looks up checkers at points.
    loaded.description.render.filter_checkers = false;
    loaded.scene = compile(&loaded.description).unwrap();
    let film = render_whole(&loaded);
    let reference = Reference::new(&loaded.description);
    let mut off = 0;
    let mut worst: f64 = 0.0;
    for (i, pixel) in film.pixels.iter().enumerate() {
        let (x, y) = (i % loaded.scene.width as usize, i / loaded.scene.width as usize);
        let exact = reference.radiance_at(x as f64 + 0.5, y as f64 + 0.5);
        let error = (0..3).map(|c| (f64::from(pixel[c]) - exact[c]).abs() / exact[c].max(1.0)).fold(0.0, f64::max);
        if error <= tolerance {
            worst = worst.max(error);
        } else {
            off += 1;
        }
    }
    (off, film.pixels.len(), worst)
}

fn is_fractal(name: &str) -> bool {
    name.starts_with("spheres/flake")
}

fn agree(precision: Precision, tolerance: f64, edges: f64) {
    // Of surfaces in the same place the reference meets one and steps over the other.
    for name in scene_names().into_iter().filter(|name| name != "hard/touching") {
        if !Reference::knows(&load_scene(&name, 8, Overrides::default()).description) {
            println!("{name:<36} has effects that the reference does not know");
            continue;
        }
        let (off, all, worst) = differences(&name, precision, tolerance);
        let share = off as f64 / all as f64;
        println!("{name:<36} {off:>5} of {all} pixels at edges, the others within {worst:.1e}");
        let fractal = precision == Precision::Single && is_fractal(&name);
        let edges = if fractal { SINGLE_FRACTAL_EDGES } else { edges };
        assert!(share <= edges, "{name}: {off} of {all} pixels differ by more than {tolerance}");
    }
}

#[test]
fn single_precision_agrees_with_the_reference_on_every_scene() {
    agree(Precision::Single, SINGLE, SINGLE_EDGES);
}

#[test]
fn double_precision_agrees_with_the_reference_on_every_scene() {
    agree(Precision::Double, DOUBLE, DOUBLE_EDGES);
}
