//! What plans say about depth: 1 suffices only where no ray leaves a surface, and analysis tells how deep rays went.

use crate::common::{load_scene, on_own_threads, scene_names};
use serde_json::{Value, json};
use strahl::film::Region;
use strahl::plan::Plan;
use strahl::plan::depth::Depth;
use strahl::plan::pilot::Effort;
use strahl::render::{Control, render};
use strahl::scene::{Format, Loaded, Overrides, load};

/// The plan's depth before and after rendering a small picture, and rays in its longest chain.
fn depths(mut loaded: Loaded) -> (Depth, Depth, u32) {
    let (scene, control) = (&loaded.scene, Control::default());
    let region = Region::whole(scene.width, scene.height);
    let mut plan = Plan::new(&mut loaded.description, scene);
    let planned = plan.depth.clone();
    let pilot = plan.estimate(scene, region, &control, Effort::QUICK).unwrap();
    let picture = render(scene, region, &control).unwrap();
    plan.measure(&pilot, &picture.rays, &picture.refined, picture.trace_ms);
    (planned, plan.depth, picture.rays.deepest)
}

fn of(material: Value, render: Value) -> (Depth, Depth, u32) {
    let scene = json!({
        "version": 1,
        "image": { "width": 24, "height": 16 },
        "camera": { "pinhole": { "eye": [0, 1, 6], "look_at": [0, 0.5, 0] } },
        "background": 0.2,
        "materials": { "asked": material, "matt": { "diffuse": 0.6 } },
        "objects": [
            { "sphere": { "center": [0, 1, 0], "radius": 1, "material": "asked" } },
            { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "matt" } }
        ],
        "render": render
    });
    depths(load(scene.to_string().as_bytes(), Format::Json, &Overrides::default()).unwrap())
}

#[test]
fn one_suffices_only_where_no_ray_leaves_a_surface() {
    let matt = json!({ "diffuse": 0.5 });
    for (what, material, render, suffices, reached) in [
        ("matt", matt.clone(), json!({ "max_depth": 9 }), Some(1), 1..2),
        ("a mirror", json!({ "reflection": 0.8 }), json!({}), None, 2..3),
        ("a mirror, cut off", json!({ "reflection": 0.8 }), json!({ "max_depth": 1 }), None, 1..2),
        ("glass", json!({ "diffuse": 0, "transmission": 1, "ior": 1.5 }), json!({ "max_depth": 5 }), None, 3..6),
        ("gold", json!({ "diffuse": 0, "reflection": 1, "fresnel": "conductor" }), json!({}), None, 2..3),
        ("color bleeding", matt, json!({ "color_bleeding": true }), None, 2..3),
    ] {
        let (planned, analyzed, deepest) = of(material, render.clone());
        assert_eq!((planned.proved_sufficient, planned.reached), (suffices, None), "{what}: {planned:?}");
        assert_eq!(planned.because.is_empty(), suffices.is_some(), "{what}: {planned:?}");
        assert!(analyzed.reached == Some(deepest) && reached.contains(&deepest), "{what}: {analyzed:?}, {deepest}");
        assert_eq!(analyzed, Depth { reached: Some(deepest), ..planned }, "{what}");
        assert_eq!(analyzed.requested.map(Value::from), render.get("max_depth").cloned(), "{what}");
    }
}

#[test]
fn no_ray_goes_deeper_than_what_suffices() {
    let mut proved = 0;
    for name in scene_names().into_iter().filter(|name| name != "hard/corridor") {
        let overrides = Overrides { antialias: Some(false), samples: Some(1), ..Overrides::default() };
        let (planned, _, deepest) = on_own_threads(|| depths(load_scene(&name, 48, overrides)));
        proved += u32::from(planned.proved_sufficient.is_some());
        assert!(planned.proved_sufficient.is_none_or(|depth| deepest <= depth), "{name}: {planned:?}, {deepest}");
    }
    assert!(proved >= 3, "{proved} scenes");
}
