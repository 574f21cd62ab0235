//! A pixel is the same whatever is traced beside it, in scenes with many effects at once.

use super::{judge, loaded, random_scene};
use crate::common::{Random, render_as, render_whole};
use fearless_simd::Level;
use serde_json::{Value, json};
use strahl::film::{Film, Region};
use strahl::render::{Control, RenderOptions, render};
use strahl::scene::{Format, Overrides, load};

/// Two bodies of two materials that meet in most packets, and what the random scene has.
fn crowded(seed: u64) -> Value {
    let mut scene = random_scene(seed);
    // Trees of any depth are for other tests.
    scene["render"]["max_depth"] = json!(5);
    scene["render"]["accuracy"] = json!({ "fixed": {} });
    let mut random = Random::new(seed);
    for material in ["a", "b"] {
        let corners: Vec<_> = (0..4).map(|_| random.point(2.0)).collect();
        let normals: Vec<_> = (0..4).map(|_| random.point(1.0)).collect();
        let faces = json!([[0, 1, 2], [0, 2, 3]]);
        let mesh = json!({ "vertices": corners, "faces": faces, "normals": normals, "material": material });
        let ball = json!({ "center": random.point(1.5), "radius": 0.8, "material": material });
        let objects = scene["objects"].as_array_mut().unwrap();
        objects.extend([json!({ "mesh": mesh }), json!({ "sphere": ball })]);
    }
    scene
}

fn differing(whole: &Film, part: &Film) -> usize {
    let at = |[x, y]: [u32; 2]| whole.pixels[(y * whole.region.width + x) as usize];
    let bits = |pixel: [f32; 3]| pixel.map(f32::to_bits);
    part.region.iter().zip(&part.pixels).filter(|(place, pixel)| bits(at(*place)) != bits(**pixel)).count()
}

#[test]
fn a_pixel_does_not_depend_on_its_neighbours() {
    let is_scene = |scene: &Value| load(scene.to_string().as_bytes(), Format::Json, &Overrides::default()).is_ok();
    let scenes = (0..).map(|seed| (format!("seed {seed}"), crowded(seed))).filter(|(_, scene)| is_scene(scene));
    judge(scenes.take(400).collect(), |scene| {
        let loaded = loaded(scene);
        let whole = render_whole(&loaded);
        let mut random = Random::new(whole.pixels.len() as u64);
        let mut wrong = Vec::new();
        for _ in 0..3 {
            let (x, y) = (random.below(15) as u32, random.below(9) as u32);
            let region = Region { x, y, width: 1 + (15 - x) / 2, height: 1 + (9 - y) / 2 };
            let part = render(&loaded.scene, region, &Control::default()).unwrap().film;
            wrong.push((format!("{region:?}"), differing(&whole, &part)));
        }
        if let Some(one_lane) = Level::new().as_sse2() {
            let alone = render_as(&loaded, RenderOptions { level: Level::Sse2(one_lane), ..RenderOptions::default() });
            wrong.push(("one lane".to_owned(), differing(&whole, &alone)));
        }
        wrong
            .into_iter()
            .filter(|(_, count)| *count > 0)
            .map(|(what, count)| format!("{what}: {count} pixels"))
            .collect()
    });
}
