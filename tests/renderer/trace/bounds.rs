//! What is proved about pictures: held against pictures whose rays were followed far further.

use super::random_scenes::{HEIGHT, WIDTH, bleeding, fixed, loaded, proved, scene, shoot, traced, transparent};
use crate::common::{load_scene, on_own_threads, scene_names};
use rayon::prelude::*;
use serde_json::json;
use std::ops::AddAssign;
use strahl::film::srgb::code8;
use strahl::render::Picture;
use strahl::scene::compile::Precise;
use strahl::scene::description::{Accuracy, Precision, Rays};
use strahl::scene::world::Pruning;
use strahl::scene::{Loaded, Overrides, Scene};

/// Random scenes: with six settings each, 1.1 million pixels.
const SCENES: u64 = 400;

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

/// Also where rays stand for others that are not followed.
#[test]
fn no_pixel_of_random_scenes_of_traced_light_leaves_its_bounds() {
    let tally = judge_all(&(0..80).map(traced).collect::<Vec<_>>(), 1.0);
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

/// What moves is as far from a light as the ball around its path, and follows from that as from a body at rest.
#[test]
fn lights_beside_what_moves_have_a_bound() {
    let hall = |position: [f64; 3], motion: &str| {
        format!(
            r#"{{ "version": 1, "image": {{ "width": 48, "height": 36 }}, "background": 0.2,
            "camera": {{ "pinhole": {{ "eye": [0, 1.2, 6], "look_at": [0, 0.9, 0] }} }},
            "lights": [ {{ "point": {{ "position": {position:?}, "falloff": "inverse_square", "intensity": 10 }} }} ],
            "materials": {{ "mirror": {{ "diffuse": 0.05, "reflection": 0.95 }} }},
            "objects": [
                {{ "plane": {{ "point": [0, 0, -2], "normal": [0, 0, 1], "material": "mirror" }} }},
                {{ "plane": {{ "point": [0, 0, 7], "normal": [0, 0, -1], "material": "mirror" }} }},
                {{ "group": {{ "objects": [ {{ "sphere": {{ "center": [0, 1, 0], "radius": 0.5 }} }} ], "motion": {{ {motion} }} }} }}
            ], "render": {{ "samples": 4, "antialias": false }} }}"#
        )
    };
    for motion in [r#""translate": [0.3, 0, 0]"#, r#""rotate_deg": { "axis": [0, 1, 0], "angle": 50 }"#] {
        let text = hall([-3.0, 5.0, 3.0], motion);
        let mine = loaded(text.as_bytes(), proved(1)).scene;
        assert!(mine.ceiling().reach.ceiling.is_some(), "{motion}: {:?}", mine.ceiling().reach);
        let (mine, deep) = (shoot(&mine), shoot(&loaded(text.as_bytes(), fixed(300, 0.0)).scene));
        let codes = |picture: &Picture| picture.film.pixels.iter().map(|p| p.map(code8)).collect::<Vec<_>>();
        let off =
            codes(&mine).as_flattened().iter().zip(codes(&deep).as_flattened()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(off <= Some(1), "{motion}: {off:?}");
        // In the ball around the path nothing is known.
        let near = loaded(hall([0.0, 1.0, 0.4], motion).as_bytes(), proved(1)).scene;
        assert_eq!(near.ceiling().reach.because, ["/lights/0"], "{motion}");
    }
}

/// Definitions that double over 31 levels place two billion balls. How far they are from a light is told in bounded time, and no
/// farther than the nearest is.
#[test]
fn lights_beside_billions_of_bodies_have_a_bound() {
    let mut definitions = serde_json::Map::new();
    let mut last = json!([{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "mirror" } }]);
    for level in 0..31 {
        let name = format!("d{level}");
        definitions.insert(name.clone(), last);
        let half =
            |x: f64| json!({ "instance": { "of": name, "transform": { "scale": 0.5, "translate": [x, 0, 0] } } });
        last = json!([half(-0.5), half(0.5)]);
    }
    let text = json!({
        "version": 1, "image": { "width": 16, "height": 12 }, "background": 0.2, "definitions": definitions,
        "camera": { "pinhole": { "eye": [0, 1, 6], "look_at": [0, 0, 0] } },
        "lights": [ { "point": { "position": [0, 4, 0], "falloff": "inverse_square" } } ],
        "materials": { "mirror": { "diffuse": 0.5, "reflection": 0.5 } },
        "objects": last, "render": { "antialias": false }
    });
    let scene = loaded(text.to_string().as_bytes(), proved(1)).scene;
    let ceiling = scene.ceiling().reach.ceiling.expect("a bound");
    // The light is at least 3 away from the ball around all of them, half of which is diffuse.
    assert!(ceiling[0] > 0.05, "{ceiling:?}");
    assert!(shoot(&scene).film.pixels.iter().flatten().all(|channel| channel.is_finite()));
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
