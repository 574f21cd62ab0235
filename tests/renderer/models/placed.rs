//! Models that scenes place: what the scene says about them is as if their meshes were its own.

use serde_json::{Value, json};
use std::collections::HashMap;
use strahl::film::Region;
use strahl::render::{Control, Picture, render};
use strahl::scene::{Files, Format, Loaded, Overrides, Problems, load_with};

/// Files by their names.
struct Folder(HashMap<&'static str, String>);

impl Files for Folder {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        self.0.get(name).map(|text| text.clone().into_bytes()).ok_or_else(|| "is not here".to_owned())
    }
}

/// The corners and faces of a box whose least corner is at `low`.
fn cuboid(low: [f64; 3], size: f64) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let corner = |i: usize| [0, 1, 2].map(|c| low[c] + if i >> c & 1 == 0 { 0.0 } else { size });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), faces)
}

/// Boxes as one OBJ without materials.
fn obj(boxes: &[([f64; 3], f64)]) -> String {
    let mut text = String::new();
    for (number, (low, size)) in boxes.iter().enumerate() {
        let (corners, faces) = cuboid(*low, *size);
        corners.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
        let first = 1 + 8 * number;
        faces.iter().for_each(|[a, b, c]| text += &format!("f {} {} {}\n", first + a, first + b, first + c));
    }
    text
}

fn mesh((low, size): ([f64; 3], f64), material: &str) -> Value {
    let (vertices, faces) = cuboid(low, size);
    json!({ "mesh": { "vertices": vertices, "faces": faces, "material": material } })
}

fn loaded(objects: &Value, materials: &Value, files: HashMap<&'static str, String>) -> Result<Loaded, Problems> {
    let scene = json!({
        "version": 1, "image": { "width": 48, "height": 36 },
        "camera": { "pinhole": { "eye": [2.5, 2, 4], "look_at": [0.5, 0.5, 0.5], "vfov_deg": 40 } },
        "background": [0.3, 0.5, 0.8], "lights": [{ "point": { "position": [3, 5, 4] } }],
        "materials": materials, "objects": objects, "render": { "antialias": false }
    });
    load_with(scene.to_string().as_bytes(), Format::Json, &Overrides::default(), &Folder(files))
}

fn picture(objects: &Value, materials: &Value, files: HashMap<&'static str, String>) -> Picture {
    let scene = loaded(objects, materials, files).unwrap_or_else(|problems| panic!("{problems}")).scene;
    render(&scene, Region::whole(48, 36), &Control::default()).unwrap()
}

fn most_apart(a: &Picture, b: &Picture) -> f32 {
    let pairs = a.film.pixels.as_flattened().iter().zip(b.film.pixels.as_flattened());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Closed parts that overlap are bodies of their own, whoever makes glass of them. What has no material is called "material".
#[test]
fn glass_that_a_scene_puts_on_a_model_is_glass_of_its_parts() {
    let boxes = [([0.0; 3], 1.0), ([0.5, 0.4, 0.3], 1.0)];
    let glass = json!({ "diffuse": 0.05, "transmission": 0.9, "reflection": 0.1, "ior": 1.5, "one_sided": false });
    let placed = json!([{ "model": { "asset": "two.obj", "materials": { "material": glass } } }]);
    let placed = picture(&placed, &json!({}), HashMap::from([("two.obj", obj(&boxes))]));
    let own = picture(&json!(boxes.map(|it| mesh(it, "glass"))), &json!({ "glass": glass }), HashMap::new());
    assert_eq!(placed.rays, own.rays);
    assert!(most_apart(&placed, &own) < 1e-3, "{}", most_apart(&placed, &own));
}

/// Single precision has few bits for the shape of what is far away.
#[test]
fn a_model_far_from_the_origin_keeps_its_shape_where_it_is_brought_back() {
    let far = [1e6, -3e6, 2e6];
    let back = json!([{ "model": { "asset": "far.obj", "transform": { "translate": far.map(|x| -x) } } }]);
    let back = picture(&back, &json!({}), HashMap::from([("far.obj", obj(&[(far, 1.0)]))]));
    let near = json!([{ "model": { "asset": "near.obj" } }]);
    let near = picture(&near, &json!({}), HashMap::from([("near.obj", obj(&[([0.0; 3], 1.0)]))]));
    assert!(most_apart(&back, &near) < 1e-4, "{}", most_apart(&back, &near));
}

#[test]
fn what_a_model_is_made_of_has_no_name_in_the_scene() {
    let files = || HashMap::from([("box.obj", obj(&[([0.0; 3], 1.0)]))]);
    let place = json!({ "model": { "asset": "box.obj" } });
    for (inside, pointer) in [
        (
            json!({ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "placed model 0: material" } }),
            "/objects/1/sphere/material",
        ),
        (json!({ "instance": { "of": "placed model 0" } }), "/objects/1/instance/of"),
    ] {
        let problems = loaded(&json!([place, inside]), &json!({}), files()).unwrap_err();
        assert_eq!(problems.0.iter().map(|problem| problem.pointer.as_str()).collect::<Vec<_>>(), [pointer]);
    }
    // Nor does it take long to find a name that nothing has.
    let odd = ["placed model", "placed model 0: material", &format!("placed model{}", "_".repeat(1_000_000))];
    let odd = odd.map(|name| json!({ "sphere": { "center": [0, 0, 0], "radius": 1, "material": name } }));
    let many = vec![odd[0].clone(); 20_000];
    let objects: Vec<Value> = [place.clone()].into_iter().chain(odd).chain(many).collect();
    let problems = loaded(&json!(objects), &json!({}), files()).unwrap_err();
    assert_eq!(problems.0[0].pointer, "/objects/1/sphere/material");
    let unknown = json!([{ "model": { "asset": "box.obj", "materials": { "Red": { "diffuse": 0.5 } } } }]);
    let problems = loaded(&unknown, &json!({}), files()).unwrap_err();
    assert!(problems.to_string().contains("it has \"material\""), "{problems}");
}

/// Sentences name materials as the scene and the file do.
#[test]
fn materials_of_models_are_called_what_they_are_called() {
    let image = json!({ "source": "data:,", "mapping": "uv" });
    let lacking =
        json!([{ "model": { "asset": "box.obj", "materials": { "material": { "diffuse": { "image": image } } } } }]);
    let problems = loaded(&lacking, &json!({}), HashMap::from([("box.obj", obj(&[([0.0; 3], 1.0)]))])).unwrap_err();
    let text = problems.to_string();
    assert!(text.contains("the material \"material\" lays a picture by uvs"), "{text}");
}

/// Only glTF has scenes, animations and variants.
#[test]
fn what_a_format_has_none_of_is_not_chosen() {
    for key in [json!({ "scene": 0 }), json!({ "animation": "walk" }), json!({ "t": 1 }), json!({ "variant": 2 })] {
        let mut model = json!({ "asset": "box.obj" });
        model.as_object_mut().unwrap().extend(key.as_object().unwrap().clone());
        let files = HashMap::from([("box.obj", obj(&[([0.0; 3], 1.0)]))]);
        let problems = loaded(&json!([{ "model": model }]), &json!({}), files).unwrap_err();
        assert!(problems.to_string().contains("only glTF has any"), "{problems}");
    }
}
