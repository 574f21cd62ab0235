//! What is proved about pictures: held against pictures whose rays were followed far further.

use crate::common::{Random, load_scene, on_own_threads, scene_names};
use fearless_simd::Level;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::ops::AddAssign;
use std::sync::atomic::{AtomicBool, Ordering};
use strahl::camera::Window;
use strahl::film::Region;
use strahl::film::srgb::code8;
use strahl::render::{Control, Picture, RenderOptions, Stop, render, render_until, render_with};
use strahl::scene::compile::Precise;
use strahl::scene::description::{Accuracy, Fixed, Precision, Proved, Rays};
use strahl::scene::world::Pruning;
use strahl::scene::{Format, Loaded, Overrides, Scene, load};

const WIDTH: u32 = 26;
const HEIGHT: u32 = 18;
/// Random scenes: with six settings each, 1.1 million pixels.
const SCENES: u64 = 400;

/// A room's worth of glass, mirrors and matt things, some of which amplify light with their neighbours.
fn scene(seed: u64) -> Vec<u8> {
    let mut random = Random::new(seed);
    let r = &mut random;
    let color = |r: &mut Random, most: f64| -> [f64; 3] { std::array::from_fn(|_| r.between(0.0, most)) };
    let mut materials = serde_json::Map::new();
    for i in 0..4 {
        let reflection = [0.0, r.between(0.0, 0.9), r.between(0.0, 0.3)][r.below(3)];
        let transmission = if r.below(2) == 0 { 0.0 } else { r.between(0.0, 0.98 - reflection) };
        let fresnel = ["none", "none", "dielectric", "conductor"][r.below(4)];
        let material = json!({
            "diffuse": color(r, 0.9), "specular": r.between(0.0, 0.6), "shininess": r.between(1.0, 200.0),
            "reflection": reflection, "transmission": transmission, "ior": r.between(1.1, 2.0), "fresnel": fresnel,
            "emission": if r.below(6) == 0 { color(r, 0.5) } else { [0.0; 3] },
            "absorption": if r.below(4) == 0 { color(r, 1.0) } else { [0.0; 3] },
        });
        materials.insert(format!("m{i}"), material);
    }
    let name = |r: &mut Random| format!("m{}", r.below(4));
    let mut objects: Vec<Value> = (0..3 + r.below(6))
        .map(|_| json!({ "sphere": { "center": r.point(2.0), "radius": r.between(0.3, 1.0), "material": name(r) } }))
        .collect();
    for axis in 0..3 {
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        let point = normal.map(|n| -3.0 * n);
        if r.below(2) == 0 {
            objects.push(json!({ "plane": { "point": point, "normal": normal, "material": name(r) } }));
        }
    }
    let lights: Vec<Value> = (0..1 + r.below(3))
        .map(|_| {
            let falloff = if r.below(3) == 0 { "inverse_square" } else { "none" };
            let intensity = if falloff == "none" { r.between(0.3, 3.0) } else { r.between(3.0, 30.0) };
            let position = [r.between(-2.5, 2.5), r.between(3.2, 6.0), r.between(3.2, 6.0)];
            json!({ "point": { "position": position, "intensity": intensity, "falloff": falloff } })
        })
        .collect();
    let fog = if r.below(5) == 0 { json!({ "color": color(r, 1.0), "density": 0.1 }) } else { Value::Null };
    let (shadows, precision) = (["opaque", "transmissive"][r.below(2)], ["single", "double"][r.below(2)]);
    let mut scene = json!({
        "version": 1, "image": { "width": WIDTH, "height": HEIGHT },
        "camera": { "pinhole": { "eye": [0.5, 0.8, 6.0], "look_at": [0, 0, 0], "vfov_deg": 50 } },
        "background": color(r, 1.0), "ambient": color(r, 0.3), "lights": lights, "materials": materials,
        "objects": objects,
        "render": { "antialias": false, "shadows": shadows, "precision": precision }
    });
    if !fog.is_null() {
        scene["fog"] = fog;
    }
    serde_json::to_vec(&scene).unwrap()
}

/// The same before nothing, of which alpha tells how much is seen.
fn transparent(seed: u64) -> Vec<u8> {
    let mut scene: Value = serde_json::from_slice(&scene(seed)).unwrap();
    scene["film"] = json!({ "background": "transparent" });
    serde_json::to_vec(&scene).unwrap()
}

/// The same, where surfaces gather what others scatter.
fn bleeding(seed: u64) -> Vec<u8> {
    let mut scene: Value = serde_json::from_slice(&scene(seed)).unwrap();
    scene["render"]["color_bleeding"] = json!(true);
    scene["render"]["samples"] = json!(1);
    serde_json::to_vec(&scene).unwrap()
}

fn fixed(max_depth: u32, min_weight: f64) -> Overrides {
    Overrides {
        max_depth: Some(max_depth),
        min_weight: Some(min_weight),
        accuracy: Some(Accuracy::Fixed(Fixed {})),
        ..Overrides::default()
    }
}

fn proved(max_codes: u8) -> Overrides {
    Overrides { accuracy: Some(Accuracy::Proved(Proved { max_codes })), ..Overrides::default() }
}

fn shoot(scene: &Scene) -> Picture {
    render(scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap()
}

/// Numbers of channels.
#[derive(Debug, Default, Clone, Copy)]
struct Tally {
    channels: u64,
    /// Outside of their bounds.
    violations: u64,
    /// Off by more codes than were proved.
    codes: u64,
    /// Alphas that are less with more rays.
    clearer: u64,
    /// More than their bounds need to be, in all.
    slack: f64,
    error: f64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, o: Self) {
        self.channels += o.channels;
        self.violations += o.violations;
        self.codes += o.codes;
        self.clearer += o.clearer;
        self.slack += o.slack;
        self.error += o.error;
    }
}

/// The least alpha of each pixel; empty where the background is opaque.
fn least_alpha(picture: &Picture) -> Vec<f32> {
    let mut least = picture.film.alpha.clone();
    for bounded in picture.bounded.iter() {
        if let Some(least) = least.get_mut(picture.film.region.index(bounded.at)) {
            *least = bounded.least_alpha;
        }
    }
    least
}

/// Holds a picture against one whose rays were followed further.
fn hold(picture: &Picture, deep: &Picture, roundings: f64, tally: &mut Tally) {
    let proof = picture.proof();
    let (highest, deepest) = (picture.highest(), deep.highest());
    let deeper = deep.film.pixels.iter().zip(&deepest);
    let [least, least_deep] = [picture, deep].map(least_alpha);
    // Where light is brighter than alpha, files have more alpha.
    let raised = |alpha: f32, light: [f32; 3]| light.into_iter().fold(alpha, f32::max).min(1.0);
    for (i, alpha) in picture.film.alpha.iter().enumerate() {
        let (deep_alpha, slack) = (deep.film.alpha[i], roundings as f32);
        tally.channels += 1;
        // The deep picture has seen more of the background, and not all of it.
        tally.violations += u64::from(deep_alpha + slack < least[i] || least_deep[i] > alpha + slack);
        tally.clearer += u64::from(deep_alpha + 0.001 < *alpha);
        let file = raised(*alpha, picture.film.pixels[i]);
        let [low, high] = [raised(least_deep[i], deep.film.pixels[i]), raised(deep_alpha, deepest[i])];
        let [file, nearest] =
            [file, file.clamp(low - slack, high + slack)].map(|alpha| (255.0 * f64::from(alpha)).round());
        tally.codes += u64::from((file - nearest).abs() > f64::from(proof.max_codes));
    }
    for ((shown, highest), (deep, deepest)) in picture.film.pixels.iter().zip(&highest).zip(deeper) {
        for c in 0..3 {
            tally.channels += 1;
            // The deep picture lacks something, too, and all sums are rounded.
            let (deep, deepest) = (f64::from(deep[c]), f64::from(deepest[c]) * (1.0 + roundings));
            let highest = f64::from(highest[c]);
            tally.violations += u64::from(deep > highest * (1.0 + roundings));
            let nearest = f64::from(shown[c]).clamp(deep * (1.0 - roundings), deepest);
            let codes = code8(nearest as f32).abs_diff(code8(shown[c]));
            tally.codes += u64::from(codes > proof.max_codes);
            tally.slack += highest - f64::from(shown[c]);
            tally.error += (deep - f64::from(shown[c])).max(0.0);
        }
    }
}

/// Puts a multiple of a scene's ceiling in its place.
fn scale_ceiling(scene: &mut Scene, factor: f64) {
    match &mut scene.world {
        Precise::Single(world) => world.ceiling.scale(factor),
        Precise::Double(world) => world.ceiling.scale(factor),
    }
}

fn loaded(text: &[u8], overrides: Overrides) -> Loaded {
    load(text, Format::Json, &overrides).unwrap_or_else(|problems| panic!("{problems}"))
}

/// All settings of one random scene, with its ceiling scaled.
fn judge(text: &[u8], factor: f64) -> Tally {
    let Loaded { scene, description, .. } = loaded(text, proved(1));
    let depth = scene.ceiling().reach.max_depth;
    let deep = shoot(&loaded(text, fixed(depth.unwrap_or(300), 1e-8)).scene);
    let roundings = if description.render.precision == Precision::Single { 2e-5 } else { 1e-7 };
    let mut tally = Tally::default();
    let settings = [
        proved(0),
        proved(1),
        proved(2),
        fixed(1, 0.0),
        fixed(3, 0.0),
        fixed(5, 1e-3),
        fixed(depth.unwrap_or(300), 1.0 / 255.0),
    ];
    for overrides in settings {
        let mut scene = loaded(text, overrides).scene;
        // A fixed depth is held against its own where nothing bounds what lies beyond.
        if scene.ceiling().reach.max_depth != depth {
            continue;
        }
        scale_ceiling(&mut scene, factor);
        hold(&shoot(&scene), &deep, roundings, &mut tally);
    }
    tally
}

fn judge_all(scenes: &[Vec<u8>], factor: f64) -> Tally {
    let all: Vec<Tally> = on_own_threads(|| scenes.par_iter().map(|text| judge(text, factor)).collect());
    let mut tally = Tally::default();
    all.into_iter().for_each(|one| tally += one);
    println!("{} channels: {tally:?}", tally.channels);
    tally
}

#[test]
fn no_pixel_of_random_scenes_leaves_its_bounds() {
    let tally = judge_all(&(0..SCENES).map(scene).collect::<Vec<_>>(), 1.0);
    assert!(tally.channels > 2_000_000, "{tally:?}");
    assert_eq!((tally.violations, tally.codes), (0, 0), "{tally:?}");
}

#[test]
fn no_alpha_of_random_scenes_leaves_its_bounds() {
    let tally = judge_all(&(0..SCENES / 4).map(transparent).collect::<Vec<_>>(), 1.0);
    assert!(tally.clearer > 1_000, "{tally:?}");
    assert_eq!((tally.violations, tally.codes), (0, 0), "{tally:?}");
}

/// The test above has teeth: if what is missed of the background counted half, it would fail.
#[test]
fn with_half_of_what_is_missed_alphas_leave_their_bounds() {
    let tally = judge_all(&(0..SCENES / 8).map(transparent).collect::<Vec<_>>(), 0.5);
    let opaque = judge_all(&(0..SCENES / 8).map(scene).collect::<Vec<_>>(), 0.5);
    assert!(tally.violations > opaque.violations + 100, "{tally:?} {opaque:?}");
}

/// Also by way of mirrors and through glass.
#[test]
fn no_pixel_of_random_scenes_that_bleed_leaves_its_bounds() {
    let tally = judge_all(&(0..80).map(bleeding).collect::<Vec<_>>(), 1.0);
    assert_eq!((tally.violations, tally.codes), (0, 0), "{tally:?}");
}

/// The tests above have teeth: with ceilings half as high they would fail.
#[test]
fn with_half_the_ceiling_pixels_leave_their_bounds() {
    let tally = judge_all(&(0..SCENES / 4).map(scene).collect::<Vec<_>>(), 0.5);
    assert!(tally.violations > 100, "{tally:?}");
}

#[test]
fn no_pixel_of_the_scenes_leaves_its_bounds() {
    let mut tally = Tally::default();
    for name in scene_names() {
        let small = |overrides: Overrides| {
            let samples = Some(1);
            load_scene(&name, 96, Overrides { samples, antialias: Some(false), ..overrides }).scene
        };
        let probe = small(proved(1));
        let Some(_) = probe.ceiling().reach.ceiling else { continue };
        let depth = probe.ceiling().reach.max_depth;
        let deep = shoot(&small(fixed(depth.unwrap_or(300), 1e-7)));
        for codes in 0..=2 {
            let picture = shoot(&small(proved(codes)));
            let proof = picture.proof();
            // A proof may have fewer rays than the corridor is deep.
            let is_reachable = depth.is_none_or(|depth| depth < Pruning::most_rays(1));
            assert!(!is_reachable || proof.max_codes <= codes.max(1), "{name}: {proof:?}");
            let before = (tally.violations, tally.codes);
            hold(&picture, &deep, 2e-5, &mut tally);
            assert_eq!((tally.violations, tally.codes), before, "{name}, max_codes {codes}");
        }
    }
    println!("{tally:?}");
    assert!(tally.channels > 1_000_000, "{tally:?}");
}

/// Of mirrors of which no ray is followed, too, at every angle.
#[test]
fn what_mirrors_could_show_is_known_to_be_lacking() {
    for material in [json!({ "diffuse": 0, "reflection": 0.5 }), json!({ "diffuse": 0, "fresnel": "conductor" })] {
        let text = serde_json::to_vec(&json!({
            "version": 1, "image": { "width": WIDTH, "height": HEIGHT }, "background": 0.5,
            "camera": { "pinhole": { "eye": [0, 1, 4], "look_at": [0, 0, 0] } },
            "materials": { "mirror": material }, "render": { "antialias": false },
            "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "mirror" } }]
        }));
        let text = text.unwrap();
        let (shallow, deep) = (shoot(&loaded(&text, fixed(1, 0.0)).scene), shoot(&loaded(&text, fixed(9, 0.0)).scene));
        assert!(shallow.proof().max_codes > 100 && deep.proof().max_codes == 0);
        let mut tally = Tally::default();
        hold(&shallow, &deep, 2e-5, &mut tally);
        assert_eq!((tally.violations, tally.codes), (0, 0), "{tally:?}");
    }
}

/// `max_codes` 0 gives the PNG of recursion without end, with no depth to choose; antialiasing decides the same.
#[test]
fn proved_to_no_code_is_the_picture_of_recursion_without_end() {
    let mut differing = 0;
    let mut pixels = 0;
    for seed in 0..60 {
        let smooth = |overrides: Overrides| Overrides { antialias: Some(true), ..overrides };
        let text = scene(seed);
        let mine = loaded(&text, smooth(proved(0)));
        let depth = mine.scene.ceiling().reach.max_depth;
        let deep = shoot(&loaded(&text, smooth(fixed(depth.unwrap_or(300), 1e-8))).scene);
        let mine = shoot(&mine.scene);
        let codes = |p: &Picture| p.film.pixels.iter().map(|p| p.map(code8)).collect::<Vec<_>>();
        pixels += mine.film.pixels.len();
        differing += codes(&mine).iter().zip(codes(&deep)).filter(|(a, b)| **a != *b).count();
    }
    println!("{differing} of {pixels} pixels differ");
    assert_eq!(differing, 0, "of {pixels}");
}

/// Where a proof is given up, that does not cost much more than the fixed mode, which proves nothing.
const MOST_TIMES_FIXED: u64 = 20;

#[test]
fn nearly_all_scenes_of_glass_and_mirrors_are_proved() {
    let mut proved_scenes = [0, 0];
    for seed in 0..300 {
        let text = scene(seed);
        let cheap = shoot(&loaded(&text, Overrides { accuracy: fixed(1, 0.0).accuracy, ..Overrides::default() }).scene);
        for codes in [0, 1] {
            let picture = shoot(&loaded(&text, proved(codes)).scene);
            let closed = picture.proof().max_codes <= codes;
            proved_scenes[usize::from(codes)] += u32::from(closed);
            let rays = [picture.rays.total(), cheap.rays.total()];
            assert!(closed || rays[0] <= MOST_TIMES_FIXED * rays[1], "seed {seed}: {rays:?}");
            assert_eq!(picture.rays.given_up > 0, !closed, "seed {seed}");
        }
    }
    println!("{proved_scenes:?} of 300 proved to 0 and 1 codes");
    assert!(proved_scenes[0] >= 291 && proved_scenes[1] >= 297, "{proved_scenes:?}");
}

/// Two balls in a box, all of the same glass: facets split rays again and again, and hardly any light is lost.
#[test]
fn light_that_is_trapped_in_glass_is_given_up_soon() {
    let text = serde_json::to_vec(&json!({
        "version": 1, "image": { "width": 24, "height": 18 }, "background": [0.6, 0.7, 0.9], "ambient": 0.2,
        "camera": { "pinhole": { "eye": [0.5, 0.8, 6], "look_at": [0, 0, 0], "vfov_deg": 40 } },
        "lights": [{ "point": { "position": [3, 5, 4] } }],
        "materials": { "glass": {
            "diffuse": 0.05, "specular": 0.4, "shininess": 80, "reflection": 0.1, "transmission": 0.85, "ior": 1.5
        } },
        "objects": [
            { "box": { "min": [-1.5, -1.2, -1.5], "max": [1.5, 1.2, 1.5], "material": "glass" } },
            { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "glass" } },
            { "sphere": { "center": [0, 0, 0], "radius": 0.6, "material": "glass" } }
        ]
    }))
    .unwrap();
    let cheap = shoot(&loaded(&text, Overrides { accuracy: fixed(1, 0.0).accuracy, ..Overrides::default() }).scene);
    for codes in 0..=2 {
        let picture = shoot(&loaded(&text, proved(codes)).scene);
        let (proof, rays) = (picture.proof(), [picture.rays.total(), cheap.rays.total()]);
        println!("{proof:?} {rays:?}");
        assert!(rays[0] <= MOST_TIMES_FIXED * rays[1], "{rays:?}");
        assert!(proof.max_codes > codes && proof.beyond[usize::from(codes)] > 0, "{proof:?}");
        assert!(proof.beyond[usize::from(codes)] < 24 * 18 / 4, "{proof:?}");
    }
}

/// A wavelength of split light weighs up to four times as much as white light in one channel. In this pixel one is reflected
/// inside of a prism more than 64 times, and was taken for light that loses nothing.
#[test]
fn split_light_that_fades_is_not_given_up() {
    let scene = load_scene("effects/dispersion", 960, Overrides::default()).scene;
    let pixel = Region { x: 777, y: 185, width: 1, height: 1 };
    let picture = render(&scene, pixel, &Control::default()).unwrap();
    assert_eq!((picture.rays.given_up, picture.rays.dropped), (0, 0));
    assert!(picture.proof().max_codes <= 1, "{:?}", picture.proof());
}

/// Rays of each scene that a contribution cut-off of 1/255 follows, POV-Ray's rule, which asks every light, and those of
/// `max_codes` 1 and 0.
fn rays_of_proofs(max_depth: Option<u32>) -> Vec<[f64; 3]> {
    // What lamps send over many bounces is dear to prove: it has a test of its own.
    rays_of(scene_names().into_iter().filter(|name| name != LAMPS), max_depth)
}

/// A room that is lit by what glows in it, bounce by bounce.
const LAMPS: &str = "effects/global_illumination";

fn rays_of(names: impl IntoIterator<Item = String>, max_depth: Option<u32>) -> Vec<[f64; 3]> {
    let mut all = Vec::new();
    for name in names {
        let small = |overrides: Overrides| {
            let depth = overrides.max_depth.or(max_depth);
            let overrides = Overrides { samples: Some(1), antialias: Some(false), max_depth: depth, ..overrides };
            load_scene(&name, 160, overrides).scene
        };
        let probe = small(proved(1));
        if probe.ceiling().reach.ceiling.is_none() {
            continue;
        }
        let depth = probe.ceiling().reach.max_depth.unwrap_or(1000);
        let [adc, one, none] =
            [fixed(depth, 1.0 / 255.0), proved(1), proved(0)].map(|settings| shoot(&small(settings)).rays);
        all.push([adc.total() + adc.shadow_skipped, one.total(), none.total()].map(|rays| rays as f64));
    }
    all
}

/// A cut-off looks at weights only; a proof knows how bright lamps are.
#[test]
fn proofs_of_light_from_lamps_cost_more_rays() {
    let [cut_off, one, none] = rays_of([LAMPS.to_owned()], Some(10))[0];
    println!("max_codes 1: {:.2}, max_codes 0: {:.2} of the rays of a cut-off of 1/255", one / cut_off, none / cut_off);
    assert!((1.0..4.0).contains(&(one / cut_off)) && none >= one);
}

#[test]
fn proofs_cost_few_rays() {
    let rays = rays_of_proofs(Some(10));
    let [cut_off, one, none] = std::array::from_fn(|i| rays.iter().map(|rays| rays[i]).sum::<f64>());
    let (one, none) = (one / cut_off, none / cut_off);
    println!("max_codes 1: {one:.3}, max_codes 0: {none:.3} of the rays of a cut-off of 1/255");
    assert!(one <= 1.05 && none <= 2.0);
}

/// Glass that loses hardly any light takes several times as many.
#[test]
fn proofs_of_recursion_without_end_cost_few_rays_in_most_scenes() {
    for (codes, most_of_half, most) in [(1, 1.01, 4.0), (0, 1.05, 12.0)] {
        let mut shares: Vec<f64> = rays_of_proofs(None).iter().map(|rays| rays[2 - codes] / rays[0]).collect();
        shares.sort_by(f64::total_cmp);
        let (median, worst) = (shares[shares.len() / 2], shares[shares.len() - 1]);
        println!(
            "max_codes {codes}: {median:.3} of the rays of a cut-off of 1/255 in half of the scenes, at most {worst:.3}"
        );
        assert!(median <= most_of_half && worst <= most);
    }
}

/// A number of rays makes the same picture on any number of threads, and what a clock has stopped can be made again.
#[test]
fn a_number_of_rays_makes_the_same_picture_on_any_number_of_threads() {
    let text = scene(3);
    let scene =
        loaded(&text, Overrides { width: Some(120), height: Some(90), antialias: Some(true), ..proved(1) }).scene;
    let whole = Region::whole(120, 90);
    let run = |threads: usize, stop: Stop| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render_until(&scene, &Window::whole(120, 90), whole, &Control::default(), stop)).unwrap()
    };
    let all = run(1, Stop::Rays(1 << 53));
    assert!(all.progress.unwrap().finished);
    for part in [1, 500, all.rays.total() / 3, all.rays.total() * 2 / 3, all.rays.total() - 1] {
        let pictures = [1, 2, 3].map(|threads| run(threads, Stop::Rays(part)));
        for picture in &pictures {
            assert_eq!(picture.film, pictures[0].film, "{part} rays");
            assert_eq!((picture.rays, picture.highest() == pictures[0].highest()), (pictures[0].rays, true));
        }
        let count = pictures[0].progress.unwrap().count;
        assert!(count >= part, "{count} {part}");
        assert_eq!(run(2, Stop::Rays(count)).film, pictures[0].film, "the count that it names");
    }
    for ms in [0, 1, 4, 12] {
        let end = std::time::Instant::now() + std::time::Duration::from_millis(ms);
        let stopped = run(2, Stop::At(end));
        let count = stopped.progress.unwrap().count;
        assert_eq!(run(1, Stop::Rays(count)).film, stopped.film, "{ms} ms, {count} rays");
    }
    // However often it is paused.
    let (control, over) = (Control::default(), AtomicBool::new(false));
    let paused = std::thread::scope(|scope| {
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                control.pause();
                std::thread::sleep(std::time::Duration::from_millis(1));
                control.resume();
                std::thread::yield_now();
            }
        });
        let window = Window::whole(120, 90);
        let paused = render_until(&scene, &window, whole, &control, Stop::Rays(1 << 53)).unwrap();
        over.store(true, Ordering::Relaxed);
        paused
    });
    assert!(paused.film == all.film && paused.rays == all.rays && paused.highest() == all.highest());
}

/// However little time there is, every pixel shows something, and is said to be unsure.
#[test]
fn a_picture_without_time_shows_something_everywhere() {
    let scene = load_scene("whitted/whitted", 200, Overrides::default()).scene;
    let (window, region) = (Window::whole(scene.width, scene.height), Region::whole(scene.width, scene.height));
    for stop in [Stop::At(std::time::Instant::now()), Stop::Rays(0)] {
        let picture = render_until(&scene, &window, region, &Control::default(), stop).unwrap();
        let colors: std::collections::HashSet<[u32; 3]> =
            picture.film.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect();
        assert!(picture.film.pixels.iter().all(|pixel| *pixel != [0.0; 3]) && colors.len() >= 8, "{colors:?}");
        assert!(picture.sampling.widths.at_share(0.95).unwrap() > 40);
        assert_eq!(picture.progress.unwrap().traced_pixels, 28);
    }
}

/// Threads look at the clock themselves: with more of them than processors, a watcher among them sees the end far too late.
#[test]
fn no_thread_goes_on_once_the_time_is_up() {
    let scene = load_scene("whitted/whitted", 200, Overrides { antialias: Some(false), ..Overrides::default() }).scene;
    let (window, region) = (Window::whole(scene.width, scene.height), Region::whole(scene.width, scene.height));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(16).build().unwrap();
    for _ in 0..100 {
        let stop = Stop::At(std::time::Instant::now());
        let picture = pool.install(|| render_until(&scene, &window, region, &Control::default(), stop)).unwrap();
        assert_eq!(picture.progress.unwrap().traced_pixels, 28);
    }
}

#[test]
fn what_has_no_bound_says_why() {
    let text = br#"{ "version": 1, "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "lights": [ { "point": { "position": [0, 1, 0], "falloff": "inverse_square" } } ],
        "materials": { "mirror": { "diffuse": 0.5, "reflection": 0.5 } },
        "objects": [ { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "mirror" } } ] }"#;
    let scene = loaded(text, Overrides::default()).scene;
    let reach = &scene.ceiling().reach;
    assert_eq!((reach.ceiling, reach.because.as_slice()), (None, ["/lights/0".to_owned()].as_slice()), "{reach:?}");
    let overrides = Overrides { accuracy: Some(Accuracy::Rays(Rays { count: 1 })), ..Overrides::default() };
    assert!(loaded(text, overrides).scene.ceiling().reach.why.contains("inverse-square"));
}

/// Where nothing bounds a light, rays are followed all the same, also those that are black in some channel.
#[test]
fn without_a_bound_mirrors_of_one_color_still_mirror() {
    let text = br#"{ "version": 1, "image": { "width": 24, "height": 24 }, "background": [0.5, 0.5, 0.5],
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "lights": [ { "point": { "position": [0, 1, 0], "falloff": "inverse_square" } } ],
        "materials": { "red": { "diffuse": 0, "reflection": [0.5, 0, 0] } },
        "objects": [ { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "red" } } ] }"#;
    let one = |overrides: Overrides| Overrides { antialias: Some(false), ..overrides };
    let scene = loaded(text, one(proved(1))).scene;
    assert_eq!(scene.ceiling().reach.ceiling, None);
    let middle = shoot(&scene).film.pixels[12 * 24 + 12];
    assert_eq!(middle, shoot(&loaded(text, one(fixed(10, 0.0))).scene).film.pixels[12 * 24 + 12]);
    assert!(middle[0] > 0.2, "{middle:?}");
}

/// Balls of glass in each other between two mirrors, whose pixels would defer millions of rays.
fn hall_of_glass(precision: &str) -> Vec<u8> {
    let balls = (0..5)
        .map(|i| json!({ "sphere": { "center": [0, 0, 0], "radius": 1.0 + 0.1 * f64::from(i), "material": "glass" } }));
    let mirrors =
        [-8, 8].map(|z| json!({ "plane": { "point": [0, 0, z], "normal": [0, 0, -z], "material": "mirror" } }));
    let scene = json!({
        "version": 1, "image": { "width": 3, "height": 2 }, "background": 0.5, "ambient": 0.3,
        "camera": { "pinhole": { "eye": [0.3, 0.2, 6], "look_at": [0, 0, 0], "vfov_deg": 30 } },
        "lights": [{ "point": { "position": [0, 5, 5] } }],
        "materials": {
            "glass": { "transmission": 0.5, "reflection": 0.5, "ior": 1.5 },
            "mirror": { "reflection": 0.98, "diffuse": 0.02 }
        },
        "objects": balls.chain(mirrors).collect::<Vec<_>>(),
        "render": { "max_depth": 1_000, "accuracy": { "proved": { "max_codes": 0 } }, "precision": precision, "antialias": false }
    });
    serde_json::to_vec(&scene).unwrap()
}

/// How many rays a pixel defers is its own matter: what shares a packet with it changes neither it nor its bound.
#[test]
fn what_pixels_defer_does_not_depend_on_their_packet() {
    for (precision, codes) in [("single", 0), ("single", 1), ("double", 0)] {
        let scene = loaded(&hall_of_glass(precision), proved(codes)).scene;
        let whole = Region::whole(scene.width, scene.height);
        let packets = shoot(&scene);
        for pixel in whole.iter() {
            let alone = Region { x: pixel[0], y: pixel[1], width: 1, height: 1 };
            let alone = render(&scene, alone, &Control::default()).unwrap();
            let at = (pixel[1] * scene.width + pixel[0]) as usize;
            assert_eq!((alone.film.pixels[0], alone.highest()[0]), (packets.film.pixels[at], packets.highest()[at]));
        }
        let slow = RenderOptions {
            level: Level::new().as_sse2().map_or(Level::new(), Level::Sse2),
            ..RenderOptions::default()
        };
        let slow = render_with(&scene, whole, &Control::default(), slow).unwrap();
        assert!(slow.film == packets.film && slow.highest() == packets.highest(), "{precision}, {codes}");
    }
}
