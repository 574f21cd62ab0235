//! Pictures that a number of rays or a clock ends: how good they are beside the other ways to spend so many rays.

use crate::common::load_scene;
use serde_json::json;
use strahl::camera::Window;
use strahl::film::{Film, Region};
use strahl::render::{Control, Picture, Stop, render, render_until};
use strahl::scene::{Format, Overrides};

/// Mirrors, glass, edges, textures, small details, a mesh, and what needs many samples.
const SCENES: [&str; 12] = [
    "mirrors/hall",
    "whitted/whitted",
    "shapes/all",
    "refraction/water_glass_diamond",
    "spheres/flake_4",
    "meshes/knot",
    "effects/textures",
    "effects/soft_shadows",
    "effects/gloss",
    "effects/depth_of_field",
    "lights/stage",
    "effects/fresnel",
];
const WIDTH: u32 = 128;

fn picture(name: &str, width: u32, overrides: Overrides) -> Picture {
    let scene = load_scene(name, width, overrides).scene;
    render(&scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap()
}

/// The picture of a scene for a number of rays.
fn stopped(name: &str, overrides: Overrides, rays: u64) -> Picture {
    let scene = load_scene(name, WIDTH, overrides).scene;
    let (window, region) = (Window::whole(scene.width, scene.height), Region::whole(scene.width, scene.height));
    render_until(&scene, &window, region, &Control::default(), Stop::Rays(rays)).unwrap()
}

/// Root mean square of the differences of 8-bit codes.
fn rms(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let code = |linear: &f32| f64::from(strahl::film::srgb::code8(*linear));
    let squares = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (code(a) - code(b)).powi(2));
    (squares.sum::<f64>() / (3 * a.len()) as f64).sqrt()
}

/// A small picture at the size of a larger one, interpolated.
fn scaled_up(small: &Film, large: Region) -> Vec<[f32; 3]> {
    let Region { width, height, .. } = small.region;
    let place = |at: u32, of: u32, size: u32| {
        let at = ((f64::from(at) + 0.5) * f64::from(of) / f64::from(size) - 0.5).clamp(0.0, f64::from(of - 1));
        (at as usize, (at as usize + 1).min(of as usize - 1), at.fract() as f32)
    };
    let pixel = |x: usize, y: usize| small.pixels[y * width as usize + x];
    let of = |[x, y]: [u32; 2]| {
        let ((left, right, across), (top, bottom, down)) =
            (place(x, width, large.width), place(y, height, large.height));
        std::array::from_fn(|c| {
            let row = |y: usize| pixel(left, y)[c] * (1.0 - across) + pixel(right, y)[c] * across;
            row(top) * (1.0 - down) + row(bottom) * down
        })
    };
    large.iter().map(of).collect()
}

/// Whether a picture that has to stop at a quarter, half and three quarters of its rays is at least as close to the reference as
/// each other picture that takes no more.
fn is_the_best(name: &str, antialias: Option<bool>, reference: &[[f32; 3]]) {
    let settings = Overrides { antialias, ..Overrides::default() };
    let whole = picture(name, WIDTH, settings);
    let region = whole.film.region;
    let mut others = Vec::new();
    for antialias in [antialias, Some(false)] {
        for percent in (35..=95).step_by(10) {
            let overrides = Overrides { antialias, ..Overrides::default() };
            let small = picture(name, WIDTH * percent / 100, overrides);
            others.push((format!("{percent} %"), small.rays.total(), rms(&scaled_up(&small.film, region), reference)));
        }
        for max_depth in [None, Some(3)] {
            let other = picture(name, WIDTH, Overrides { antialias, max_depth, ..Overrides::default() });
            others.push((format!("depth {max_depth:?}"), other.rays.total(), rms(&other.film.pixels, reference)));
        }
    }
    for quarters in 1..=3 {
        let rays = whole.rays.total() * quarters / 4;
        let here = stopped(name, settings, rays);
        let error = rms(&here.film.pixels, reference);
        let others = others.iter().filter(|(_, others, _)| *others <= here.rays.total());
        let (best, _, least) = others.min_by(|a, b| a.2.total_cmp(&b.2)).unwrap();
        println!("{name:<30} {antialias:?} {quarters}/4: {error:5.2} codes, {least:5.2} with {best}");
        assert!(error <= *least, "{name}, {quarters}/4 of the rays: {error} codes, {least} with {best}");
    }
}

#[test]
fn no_other_picture_of_so_many_rays_is_better() {
    for name in SCENES {
        let samples = Overrides { samples: Some(128), antialias: Some(false), ..Overrides::default() };
        is_the_best(name, None, &picture(name, WIDTH, samples).film.pixels);
    }
}

#[test]
fn nor_without_antialiasing() {
    for name in SCENES {
        let whole = picture(name, WIDTH, Overrides { antialias: Some(false), ..Overrides::default() });
        is_the_best(name, Some(false), &whole.film.pixels);
    }
}

/// Three bodies of glass in each other, whose rays split at every surface: one pixel can take millions of rays.
#[test]
fn few_rays_stay_few_where_one_pixel_takes_very_many() {
    let ball = |radius: f64| json!({ "sphere": { "center": [0, 0, 0], "radius": radius, "material": "glass" } });
    let scene = json!({
        "version": 1,
        "image": { "width": 24, "height": 18 },
        "camera": { "pinhole": { "eye": [0.3, 0.4, 5], "look_at": [0, 0, 0] } },
        "lights": [{ "point": { "position": [3, 4, 5] } }],
        "materials": { "glass": { "diffuse": 0.1, "reflection": 0.1, "transmission": 0.85, "ior": 1.5 } },
        "objects": [
            { "box": { "min": [-1.5, -1.5, -1.5], "max": [1.5, 1.5, 1.5], "material": "glass" } },
            ball(1.2), ball(0.7),
            { "plane": { "point": [0, -1.5, 0], "normal": [0, 1, 0], "material": "glass" } },
        ],
    });
    let scene = strahl::scene::load(scene.to_string().as_bytes(), Format::Json, &Overrides::default()).unwrap().scene;
    let whole = Region::whole(scene.width, scene.height);
    let until = |rays: u64, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (window, stop) = (Window::whole(scene.width, scene.height), Stop::Rays(rays));
        pool.install(|| render_until(&scene, &window, whole, &Control::default(), stop)).unwrap()
    };
    for rays in [1, 20_000, 100_000] {
        let picture = until(rays, 2);
        let progress = picture.progress.unwrap();
        println!("{rays}: {} rays, {progress:?}", picture.rays.total());
        assert!(picture.rays.total() <= 20 * rays.max(1_000), "{} rays", picture.rays.total());
        for threads in [1, 3] {
            let again = until(progress.count, threads);
            assert!(again.film == picture.film && again.rays == picture.rays);
        }
    }
}
