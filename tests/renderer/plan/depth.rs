//! The depth that is proved: exact on simple scenes, and never too small on random ones.

use crate::common::{Random, on_own_threads, render_whole};
use rayon::prelude::*;
use serde_json::{Value, json};
use strahl::film::Region;
use strahl::plan::depth::{Depth, depth};
use strahl::render::{Control, RayCounts, render};
use strahl::scene::{Format, Loaded, Overrides, load};

fn scene(objects: Value) -> Value {
    json!({
        "version": 1,
        "image": { "width": 40, "height": 30 },
        "camera": { "pinhole": { "eye": [0, 1, 6], "look_at": [0, 0.5, 0], "vfov_deg": 60 } },
        "background": [0.2, 0.3, 0.5],
        "materials": {
            "matt": { "diffuse": 0.6 },
            "mirror": { "diffuse": 0.1, "reflection": 0.8 },
            "front": { "diffuse": 0.1, "reflection": 0.8, "one_sided": true },
            "pane": { "diffuse": 0, "transmission": 0.9 },
            "coated": { "diffuse": 0, "transmission": 0.5, "reflection": 0.4 },
            "glass": { "diffuse": 0, "transmission": 0.9, "ior": 1.5 }
        },
        "objects": objects,
        "render": { "antialias": false, "max_depth": 30, "min_weight": 0 }
    })
}

fn loaded(scene: &Value, overrides: &Overrides) -> Option<Loaded> {
    load(scene.to_string().as_bytes(), Format::Json, overrides).ok()
}

fn depth_of(scene: &Value) -> Depth {
    let Loaded { description, scene, .. } = loaded(scene, &Overrides::default()).unwrap();
    depth(&description, &scene)
}

fn ball(x: f64, material: &str) -> Value {
    json!({ "sphere": { "center": [x, 1, 0], "radius": 0.9, "material": material } })
}

fn floor(material: &str) -> Value {
    json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": material } })
}

/// An upright square in the plane z, which faces +z or -z.
fn wall(z: f64, toward: f64, material: &str) -> Value {
    let w = toward;
    json!({ "quad": { "vertices": [[-w, 0, z], [w, 0, z], [w, 2, z], [-w, 2, z]], "material": material } })
}

#[test]
fn simple_scenes_have_the_depth_that_geometry_gives_them() {
    let rotated = |object: Value| {
        let turn = json!({ "rotate_deg": { "axis": [1, 2, 3], "angle": 40 }, "translate": [0.1, 0.2, 0.3] });
        json!({ "group": { "transform": turn, "objects": [object] } })
    };
    let cylinder = |capped: bool| json!({ "cylinder": { "base": [0, 0, 0], "top": [0, 2, 0], "radius": 1, "capped": capped, "material": "mirror" } });
    for (what, objects, expected) in [
        ("nothing mirrors", json!([ball(0.0, "matt"), floor("matt")]), Some(1)),
        ("a mirror ball over a matt floor", json!([ball(0.0, "mirror"), floor("matt")]), Some(2)),
        ("the same, turned", json!([rotated(ball(0.0, "mirror")), floor("matt")]), Some(2)),
        ("a mirror floor", json!([ball(0.0, "matt"), floor("mirror")]), Some(2)),
        ("a tilted mirror", json!([rotated(wall(0.0, 1.0, "mirror")), floor("matt")]), Some(2)),
        ("two mirror balls", json!([ball(-1.0, "mirror"), ball(1.0, "mirror")]), None),
        ("a mirror ball over a mirror floor", json!([ball(0.0, "mirror"), floor("mirror")]), None),
        ("two mirrors face to face", json!([wall(-3.0, 1.0, "mirror"), wall(3.0, -1.0, "mirror")]), None),
        ("mirrors in one plane", json!([wall(0.0, 1.0, "mirror"), wall(0.0, -1.0, "mirror")]), Some(2)),
        ("mirrors back to back", json!([wall(-1.0, 1.0, "front"), wall(-2.0, -1.0, "front")]), Some(2)),
        (
            "three panes in a row",
            json!([wall(1.0, 1.0, "pane"), wall(0.0, 1.0, "pane"), wall(-1.0, 1.0, "pane")]),
            Some(4),
        ),
        ("a pane before a mirror", json!([wall(1.0, 1.0, "pane"), wall(0.0, 1.0, "mirror")]), Some(4)),
        ("a coated pane before a mirror", json!([wall(1.0, 1.0, "coated"), wall(0.0, 1.0, "mirror")]), None),
        ("glass", json!([ball(0.0, "glass"), floor("matt")]), None),
        (
            "the eye in a mirror ball",
            json!([{ "sphere": { "center": [0, 1, 6], "radius": 2, "material": "mirror" } }]),
            None,
        ),
        ("a capped cylinder", json!([cylinder(true)]), Some(2)),
        ("an open cylinder", json!([cylinder(false)]), None),
        (
            "a torus",
            json!([{ "torus": { "center": [0, 1, 0], "major_radius": 1, "minor_radius": 0.3, "material": "mirror" } }]),
            None,
        ),
        ("a hundred mirror balls", (0..100).map(|i| ball(3.0 * f64::from(i), "mirror")).collect(), None),
    ] {
        let depth = depth_of(&scene(objects));
        assert_eq!(depth.proved_sufficient, expected, "{what}: {depth:?}");
        assert_eq!(depth.requested, Some(30));
        assert!(!depth.why.is_empty());
    }
}

#[test]
fn instances_count_as_often_as_they_are_placed() {
    let mut one = scene(json!([{ "instance": { "of": "ball" } }]));
    one["definitions"] = json!({ "ball": [ball(0.0, "mirror")] });
    assert_eq!(depth_of(&one).proved_sufficient, Some(2));
    assert_eq!(depth_of(&one).because, ["/definitions/ball/0/sphere"]);
    let mut two = one.clone();
    two["objects"] = json!([{ "instance": { "of": "ball" } }, { "instance": { "of": "ball", "transform": { "translate": [3, 0, 0] } } }]);
    assert_eq!(depth_of(&two).proved_sufficient, None);
}

#[test]
fn light_from_everywhere_gets_no_proof() {
    let mut parallel = scene(json!([ball(0.0, "mirror")]));
    parallel["camera"] = json!({ "orthographic": { "eye": [0, 1, 6], "look_at": [0, 1, 0], "height": 4 } });
    assert_eq!(depth_of(&parallel).proved_sufficient, None, "some eye might be inside the ball");
}

fn random_scene(seed: u64) -> Value {
    let random = &mut Random::new(seed);
    let material = |random: &mut Random| ["mirror", "mirror", "front", "pane", "coated", "matt"][random.below(6)];
    let object = |random: &mut Random| {
        // Half of them on a grid, so that some share their planes.
        let grid = random.below(2) == 0;
        let mut point = |size: f64| random.point(size).map(|x| if grid { x.round() } else { x });
        let (p, q, r) = (point(2.0), point(2.0), point(2.0));
        let size = random.between(0.2, 1.2);
        let material = material(random);
        match random.below(8) {
            0 => json!({ "sphere": { "center": p, "radius": size, "material": "mirror" } }),
            1 => json!({ "box": { "min": p, "max": p.map(|x| x + size), "material": "mirror" } }),
            2 => json!({ "disc": { "center": p, "normal": q, "radius": size, "material": material } }),
            3 => json!({ "plane": { "point": p, "normal": q, "material": "mirror" } }),
            4 => {
                let axis = random.below(3);
                let mut normal = [0.0; 3];
                normal[axis] = 1.0;
                json!({ "disc": { "center": p, "normal": normal, "radius": size, "material": material } })
            }
            _ => json!({ "triangle": { "vertices": [p, q, r], "material": material } }),
        }
    };
    let count = 1 + random.below(4);
    scene((0..count).map(|_| object(random)).collect())
}

/// Pixels and rays at the depth that is proved, and without a bound: the same. Returns the depth.
fn nothing_is_cut_off(seed: u64, precision: &str) -> Option<u32> {
    let mut scene = random_scene(seed);
    scene["render"]["precision"] = json!(precision);
    let all = loaded(&scene, &Overrides::default())?;
    let proved = depth(&all.description, &all.scene).proved_sufficient?;
    assert!(proved < 30, "seed {seed}: {proved}");
    let bounded = loaded(&scene, &Overrides { max_depth: Some(proved), ..Overrides::default() }).unwrap();
    let rays = |loaded: &Loaded| -> RayCounts {
        render(&loaded.scene, Region::whole(40, 30), &Control::default()).unwrap().rays
    };
    assert_eq!(rays(&all), rays(&bounded), "seed {seed}, {precision}, depth {proved}");
    assert_eq!(render_whole(&all), render_whole(&bounded), "seed {seed}, {precision}, depth {proved}");
    Some(proved)
}

#[test]
fn the_depth_that_is_proved_cuts_nothing_off() {
    for precision in ["single", "double"] {
        let depths: Vec<u32> = on_own_threads(|| {
            (0..2_000).into_par_iter().filter_map(|seed| nothing_is_cut_off(seed, precision)).collect()
        });
        let deep = depths.iter().filter(|depth| **depth > 2).count();
        println!("{precision}: proved for {} of 2000 random scenes, deeper than 2 for {deep}", depths.len());
        assert!(depths.len() > 500 && deep > 50, "too few proofs to test: {}, {deep}", depths.len());
    }
}
