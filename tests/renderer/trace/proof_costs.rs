//! How many rays proofs take, where they are given up, and that it is each pixel's own matter.

use super::random_scenes::{fixed, loaded, proved, scene, shoot};
use crate::common::{load_scene, scene_names};
use fearless_simd::Level;
use serde_json::json;
use strahl::film::Region;
use strahl::render::{Control, RenderOptions, render, render_with};
use strahl::scene::Overrides;

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
    // What lamps send over many bounces has a test of its own.
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

/// Rays that stand for others weigh as much as their parents, so few are too light to be followed, by either rule.
#[test]
fn proofs_of_light_from_lamps_cost_as_many_rays() {
    let [cut_off, one, none] = rays_of([LAMPS.to_owned()], Some(10))[0];
    println!("max_codes 1: {:.2}, max_codes 0: {:.2} of the rays of a cut-off of 1/255", one / cut_off, none / cut_off);
    assert!((0.9..1.1).contains(&(one / cut_off)) && none >= one);
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
