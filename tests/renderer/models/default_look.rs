//! What models look like where the file does not say: brightness, sides, shadows, and where they stand.

use data_encoding::BASE64;
use serde_json::{Value, json};
use strahl::film::{Display, Film, Region, ToneMapping};
use strahl::math;
use strahl::models::{Choice, Model, ModelFormat, read};
use strahl::render::{Control, render};
use strahl::scene::description::{Light, Object};
use strahl::scene::model::{Imported, LightChoice, ModelOptions, import};
use strahl::scene::{Format, NoFiles, Overrides, load};

const SIDE: u32 = 96;

pub(super) fn overrides(view: &str) -> Overrides {
    let model = ModelOptions { view: Some(view.parse().unwrap()), ..ModelOptions::default() };
    Overrides { model, width: Some(SIDE), height: Some(SIDE), ..Overrides::default() }
}

/// A model's codes, and how much of each pixel is covered.
pub(super) struct Seen {
    pub(super) codes: Vec<[u8; 3]>,
    alpha: Vec<f32>,
}

impl Seen {
    fn at(&self, x: u32, y: u32) -> ([u8; 3], f32) {
        let i = (y * SIDE + x) as usize;
        (self.codes[i], self.alpha[i])
    }

    pub(super) fn middle(&self) -> [u8; 3] {
        let (codes, alpha) = self.at(SIDE / 2, SIDE / 2);
        assert!(alpha > 0.999, "nothing is in the middle: {alpha}");
        codes
    }

    pub(super) fn opaque(&self) -> usize {
        self.alpha.iter().filter(|alpha| **alpha > 0.999).count()
    }
}

pub(super) fn seen(bytes: &[u8], format: Format, overrides: &Overrides) -> Seen {
    let loaded = load(bytes, format, overrides).unwrap_or_else(|problems| panic!("{problems}"));
    let scene = &loaded.scene;
    let Film { pixels, alpha, .. } =
        render(scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap().film;
    let film = loaded.description.film;
    let display = Display::new(film.exposure, film.tone);
    Seen { codes: pixels.into_iter().map(|pixel| display.codes(pixel)).collect(), alpha }
}

pub(super) type Corners = [[f32; 3]; 4];

/// A square from -1 to 1 that faces +z.
pub(super) const FRONT: Corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];

/// A glTF with a quad for each material.
pub(super) fn quads(quads: &[(Corners, Value)], more: Value) -> Vec<u8> {
    let points: Vec<u8> =
        quads.iter().flat_map(|(corners, _)| corners.iter().flatten().flat_map(|x| x.to_le_bytes())).collect();
    let indices: Vec<u8> = [0_u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    let data = [indices, points].concat();
    let views: Vec<Value> = std::iter::once(json!({ "buffer": 0, "byteLength": 12 }))
        .chain((0..quads.len()).map(|i| json!({ "buffer": 0, "byteOffset": 12 + 48 * i, "byteLength": 48 })))
        .collect();
    let limits = |corners: &Corners| {
        [f32::min, f32::max].map(|pick| [0, 1, 2].map(|c| corners.iter().map(|p| p[c]).reduce(pick).unwrap()))
    };
    let accessors: Vec<Value> =
        std::iter::once(json!({ "bufferView": 0, "componentType": 5123, "count": 6, "type": "SCALAR" }))
            .chain(quads.iter().enumerate().map(|(i, (corners, _))| {
                let [min, max] = limits(corners);
                json!({
                    "bufferView": i + 1, "componentType": 5126, "count": 4, "type": "VEC3", "min": min, "max": max
                })
            }))
            .collect();
    let meshes: Vec<Value> = (0..quads.len())
        .map(|i| json!({ "primitives": [{ "attributes": { "POSITION": i + 1 }, "indices": 0, "material": i }] }))
        .collect();
    let mut document = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": data.len(), "uri": format!("data:application/octet-stream;base64,{}", BASE64.encode(&data)) }],
        "bufferViews": views, "accessors": accessors, "meshes": meshes,
        "nodes": (0..quads.len()).map(|i| json!({ "mesh": i })).collect::<Vec<_>>(),
        "scenes": [{ "nodes": (0..quads.len()).collect::<Vec<_>>() }], "scene": 0,
        "materials": quads.iter().map(|(_, material)| material.clone()).collect::<Vec<_>>()
    });
    document.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    document.to_string().into_bytes()
}

pub(super) fn matte(color: [f64; 3]) -> Value {
    let [r, g, b] = color;
    json!({ "doubleSided": true, "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1], "metallicFactor": 0 } })
}

fn unlit(color: [f64; 3]) -> Value {
    let mut material = matte(color);
    material["extensions"] = json!({ "KHR_materials_unlit": {} });
    material
}

pub(super) fn imported(bytes: &[u8], format: ModelFormat, overrides: &Overrides) -> Imported {
    import(format, bytes, overrides, &NoFiles).unwrap_or_else(|problems| panic!("{problems}"))
}

fn warns(imported: &Imported, what: &str) -> bool {
    imported.description.import_warnings.iter().any(|warning| warning.detail.starts_with(what))
}

#[test]
fn unlit_models_show_their_codes() {
    let bytes = crate::common::read("tests/inputs/models/UnlitTest.glb");
    let seen = seen(&bytes, Format::Gltf, &overrides("front"));
    for wanted in [[255, 128, 0], [0, 128, 255]] {
        let found = seen.codes.iter().filter(|code| **code == wanted).count();
        assert!(found > 500, "{found} pixels show {wanted:?}");
    }
}

/// Lamps of hundreds of candela lower the exposure, and the tone curve takes 0.04 of each channel: neither is seen.
#[test]
fn unlit_colors_beside_lit_ones_are_shown_as_they_are() {
    let color = [0.5, 0.2, 0.01];
    let lamp = json!({
        "extensionsUsed": ["KHR_materials_unlit", "KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "directional", "intensity": 900 }] } },
        "nodes": [{ "mesh": 0 }, { "mesh": 1 }, { "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
        "scenes": [{ "nodes": [0, 1, 2] }]
    });
    let behind = FRONT.map(|[x, y, z]| [x * 0.5, y * 0.5, z - 0.1]);
    for more in [json!({ "extensionsUsed": ["KHR_materials_unlit"] }), lamp] {
        let bytes = quads(&[(FRONT, unlit(color)), (behind, matte([0.5; 3]))], more);
        let shown = seen(&bytes, Format::Gltf, &overrides("front")).middle();
        let expected = Display::new(0.0, ToneMapping::None).codes(color.map(|channel| channel as f32));
        assert!((0..3).all(|c| shown[c].abs_diff(expected[c]) <= 1), "{shown:?} instead of {expected:?}");
        assert!(warns(&imported(&bytes, ModelFormat::Gltf, &overrides("front")), "approximated: unlit"));
    }
}

#[test]
fn white_that_faces_the_camera_is_white_and_tops_are_not_more() {
    let top = FRONT.map(|[x, y, _]| [x, 0.0, -y]);
    let white = |corners: Corners, view: &str| {
        let [red, green, blue] =
            seen(&quads(&[(corners, matte([1.0; 3]))], json!({})), Format::Gltf, &overrides(view)).middle();
        assert!(red == green && green == blue, "{red} {green} {blue}");
        red
    };
    let [front, above] = [white(FRONT, "front"), white(top, "three_quarter")];
    assert!((227..=238).contains(&front), "{front}");
    assert!(above > front && above < 253, "{above}");
    // The material of what has none is a rough white metal, which keeps the light that its facets pass on.
    let metal = json!({ "doubleSided": true });
    let [red, ..] = seen(&quads(&[(FRONT, metal)], json!({})), Format::Gltf, &overrides("front")).middle();
    assert!(red > 200, "{red}");
}

#[test]
fn what_is_single_sided_is_not_seen_from_behind() {
    let with = |double_sided: bool, extensions: Value| {
        let material = json!({ "doubleSided": double_sided, "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": extensions });
        quads(&[(FRONT, material)], json!({ "extensionsUsed": ["KHR_materials_transmission"] }))
    };
    let opaque = |bytes: &[u8], view: &str| seen(bytes, Format::Gltf, &overrides(view)).opaque();
    let front = opaque(&with(false, json!({})), "front");
    assert!(front > 7_000, "{front}");
    assert_eq!(opaque(&with(false, json!({})), "back"), 0);
    assert_eq!(opaque(&with(true, json!({})), "back"), front);
    let one_sided = |bytes: &[u8]| {
        imported(bytes, ModelFormat::Gltf, &overrides("front")).description.materials["material"].one_sided
    };
    // What enters glass must be able to leave it.
    let glass = with(false, json!({ "KHR_materials_transmission": { "transmissionFactor": 0.5 } }));
    assert!(!one_sided(&glass) && one_sided(&with(false, json!({}))));
}

/// An OBJ file with a triangle around a place.
fn triangle([x, y, z]: [f64; 3]) -> Vec<u8> {
    let point = |dx: f64, dy: f64, dz: f64| format!("v {} {} {}\n", x + dx, y + dy, z + dz);
    [point(-1.0, -1.0, 0.25), point(1.0, -1.0, 0.0), point(0.0, 1.0, -0.25), "f 1 2 3\n".to_owned()].concat().into()
}

#[test]
fn models_far_away_are_those_near_the_origin() {
    let scene = |at: [f64; 3]| imported(&triangle(at), ModelFormat::Obj, &overrides("three_quarter"));
    let near = scene([0.0; 3]);
    assert!(!warns(&near, "assumed: origin"));
    for at in [[1e6, 0.0, 0.0], [500_000.0, 4_649_776.0, -300.0]] {
        let mut far = scene(at);
        assert!(warns(&far, "assumed: origin"), "{at:?}");
        far.description.import_warnings.clear();
        assert_eq!(far.description, near.description);
    }
    // Instances, too: their vertices stay where they are.
    let far = FRONT.map(|[x, y, z]| [x + 262_144.0, y, z]);
    let more = json!({
        "nodes": [{ "mesh": 0, "translation": [-262_144, 0, 0] }, { "mesh": 0, "translation": [-262_144, 0, 2] }],
        "scenes": [{ "nodes": [0, 1] }]
    });
    let description =
        imported(&quads(&[(far, matte([0.8; 3]))], more), ModelFormat::Gltf, &overrides("front")).description;
    let Object::Mesh(mesh) = &description.definitions["mesh 0"][0] else { panic!("a mesh") };
    assert!(mesh.vertices.as_flattened().iter().all(|x| x.abs() <= 1.0), "{:?}", mesh.vertices);
    let Object::Instance(first) = &description.objects[0] else { panic!("an instance") };
    assert_eq!(first.transform.matrix.unwrap()[12..15], [0.0; 3]);
}

pub(super) const CUBE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 1 5 8 4\nf 2 3 7 6\n";

/// Pixels that are covered by a shadow alone.
fn shadow(seen: &Seen) -> impl Iterator<Item = f32> {
    seen.codes
        .iter()
        .zip(&seen.alpha)
        .filter(|(code, alpha)| **code == [0; 3] && **alpha > 0.0)
        .map(|(_, alpha)| *alpha)
}

#[test]
fn shadows_fade_before_the_picture_ends() {
    let seen = seen(CUBE, Format::Obj, &overrides("three_quarter"));
    assert!(shadow(&seen).filter(|alpha| *alpha > 0.1).count() > 100);
    let edges = (0..SIDE).flat_map(|i| [(0, i), (SIDE - 1, i), (i, 0), (i, SIDE - 1)]);
    let cut = edges.map(|(x, y)| seen.at(x, y).1).fold(0.0, f32::max);
    assert!(cut < 0.04, "{cut}");
}

#[test]
fn what_lies_flat_has_a_shadow_beside_it() {
    let flat = FRONT.map(|[x, y, _]| [x, 0.0, -y]);
    let bytes = quads(&[(flat, matte([0.8; 3]))], json!({}));
    let seen = seen(&bytes, Format::Gltf, &overrides("three_quarter"));
    let darkest = shadow(&seen).fold(0.0, f32::max);
    assert!(darkest > 0.08, "{darkest}");
}

#[test]
fn lamps_of_the_file_keep_their_colors_beside_the_studio() {
    let bytes = crate::common::read("tests/inputs/models/LightsPoint.glb");
    let description = imported(&bytes, ModelFormat::Gltf, &Overrides::default()).description;
    let studio = description.environment.unwrap().intensity * math::pow(2.0, description.film.exposure);
    assert!((studio - 0.2).abs() < 1e-9, "{studio}");
    let seen = seen(&bytes, Format::Gltf, &overrides("three_quarter"));
    let colorful = |[r, g, b]: [u8; 3]| r.max(g).max(b) - r.min(g).min(b) > 90;
    assert!(seen.codes.iter().filter(|code| colorful(**code)).count() > 200);
}

#[test]
fn an_exposure_that_was_asked_for_is_not_called_assumed() {
    let bytes = crate::common::read("tests/inputs/models/LightsPoint.glb");
    let assumed = |exposure| {
        let overrides = Overrides { exposure, ..overrides("front") };
        warns(&imported(&bytes, ModelFormat::Gltf, &overrides), "assumed: exposure")
    };
    assert!(assumed(None) && !assumed(Some(0.0)) && !assumed(Some(-3.0)));
}

/// KHR_lights_punctual: a lamp shines along the node's -z, and scale is "ignored except for its effect on position and orientation".
#[test]
fn lamps_of_mirrored_nodes_shine_where_their_minus_z_points() {
    let spot = |node: Value| {
        let mut node = node;
        if node.get("matrix").is_none() {
            node["translation"] = json!([0, 0, 2]);
        }
        node["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
        let more = json!({
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "spot", "intensity": 100 }] } },
            "nodes": [{ "mesh": 0 }, node],
            "scenes": [{ "nodes": [0, 1] }]
        });
        let model = ModelOptions { light: Some(LightChoice::File), ..overrides("front").model };
        let overrides = Overrides { model, ..overrides("front") };
        let bytes = quads(&[(FRONT, matte([0.8; 3]))], more);
        let Light::Spot(light) = imported(&bytes, ModelFormat::Gltf, &overrides).description.lights[0] else {
            panic!("a spot");
        };
        (light.direction, light.outer_deg, seen(&bytes, Format::Gltf, &overrides).middle()[0] > 50)
    };
    let (towards, away) = (([0.0, 0.0, -1.0], 45.0, true), ([0.0, 0.0, 1.0], 45.0, false));
    for (node, wanted) in [
        (json!({}), towards),
        (json!({ "scale": [-1, 3, 0.5] }), towards),
        (json!({ "scale": [1, 1, -1] }), away),
        (json!({ "rotation": [0, 1, 0, 0] }), away),
        (json!({ "rotation": [0, 1, 0, 0], "scale": [1, 1, -2] }), towards),
        (json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 2, 1] }), away),
    ] {
        assert_eq!(spot(node.clone()), wanted, "{node}");
    }
}

/// A prism around the y axis with so many sides, and a file's first line.
fn prism(sides: u32, first: &str) -> Model {
    let mut text = format!("{first}\n");
    for y in [0, 1] {
        for i in 0..sides {
            let (sin, cos) = math::sin_cos(f64::from(i) / f64::from(sides) * std::f64::consts::TAU);
            text += &format!("v {cos} {y} {}\n", -sin);
        }
    }
    for i in 0..sides {
        let j = (i + 1) % sides;
        text += &format!("f {} {} {} {}\n", i + 1, j + 1, sides + j + 1, sides + i + 1);
    }
    let top: Vec<String> = (0..sides).map(|i| (sides + i + 1).to_string()).collect();
    text += &format!("f {}\n", top.join(" "));
    let none = |_: &str| Err("is not there".to_owned());
    read(ModelFormat::Obj, text.as_bytes(), &none, Choice::default()).unwrap()
}

#[test]
fn obj_without_normals_is_smooth_up_to_creases() {
    let round = prism(16, "# 22.5 degrees between sides");
    assert!(round.warnings.iter().any(|warning| warning.what == "normals"));
    let geometry = &round.geometries[0];
    let normals = geometry.normals.as_ref().unwrap();
    for ([x, y, z], [nx, ny, nz]) in geometry.positions.iter().zip(normals) {
        // Away from the axis, or upwards on top.
        let off = math::hypot(nx - x, nz - z) + ny.abs();
        let is_top = *y == 1.0 && (ny - 1.0).abs() < 1e-9;
        assert!(off < 1e-2 || is_top, "{x} {y} {z}: {nx} {ny} {nz}");
    }
    assert_eq!(geometry.positions.len(), 48);
    for flat in [prism(8, "# 45 degrees"), prism(16, "s off")] {
        assert!(flat.geometries[0].normals.is_none() && flat.warnings.is_empty());
    }
}

#[test]
fn models_that_cannot_be_seen_are_refused_as_models() {
    let point = b"v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n";
    let huge = b"v 0 0 0\nv 3e70 0 0\nv 0 1 0\nf 1 2 3\n";
    for (bytes, why) in [(point.as_slice(), "nothing to see"), (huge, "units large")] {
        let problems = import(ModelFormat::Obj, bytes, &Overrides::default(), &NoFiles).unwrap_err();
        assert!(problems.0.len() == 1 && problems.0[0].pointer.is_empty(), "{problems}");
        assert!(problems.to_string().contains(why), "{problems}");
    }
    let options = ModelOptions { light: Some(LightChoice::File), ..ModelOptions::default() };
    let dark = Overrides { model: options, ..Overrides::default() };
    assert!(warns(&imported(CUBE, ModelFormat::Obj, &dark), "assumed: no-lamps"));
}

/// A flat model shows from another side; one of lines never does.
#[test]
fn what_is_seen_from_its_edge_is_said() {
    let upright = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let line = b"v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n";
    let cases: [(&[u8], &str, bool); 4] =
        [(upright, "left", true), (upright, "front", false), (line, "front", true), (line, "-20,40", true)];
    for (bytes, view, is_unseen) in cases {
        let warned = warns(&imported(bytes, ModelFormat::Obj, &overrides(view)), "skipped: edges");
        let empty = seen(bytes, Format::Obj, &overrides(view)).codes.iter().all(|codes| *codes == [0; 3]);
        assert_eq!((warned, empty), (is_unseen, is_unseen), "{view}");
    }
}

/// A triangle that looks to the front, as a file and the node that places it.
fn gltf_triangle(node: &Value, material: &Value) -> Vec<u8> {
    let points = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let file = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [node],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "materials": [material],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": format!("data:application/octet-stream;base64,{}", BASE64.encode(&bytes)) }],
    });
    file.to_string().into_bytes()
}

/// What shows its front alone is seen from one side, also where it is mirrored.
#[test]
fn what_turns_its_back_is_said() {
    let (plain, both) = (json!({}), json!({ "doubleSided": true }));
    let at = json!({ "mesh": 0 });
    let mirrored = json!({ "mesh": 0, "scale": [-1, 1, 1] });
    let turned = json!({ "mesh": 0, "scale": [1, 1, -1] });
    let cases = [
        (&at, &plain, "front", false),
        (&at, &plain, "back", true),
        (&at, &both, "back", false),
        (&mirrored, &plain, "front", false),
        (&mirrored, &plain, "back", true),
        (&turned, &plain, "front", true),
        (&turned, &plain, "back", false),
    ];
    for (node, material, view, is_unseen) in cases {
        let bytes = gltf_triangle(node, material);
        let warned = warns(&imported(&bytes, ModelFormat::Gltf, &overrides(view)), "skipped: backs");
        let empty = seen(&bytes, Format::Gltf, &overrides(view)).codes.iter().all(|codes| *codes == [0; 3]);
        assert_eq!((warned, empty), (is_unseen, is_unseen), "{node} {material} {view}");
    }
}

/// The pole of a lamp stands on the model's axis, and is narrower than a pixel: between two columns all samples would miss it.
#[test]
fn what_is_thin_and_upright_is_seen() {
    let dark = || matte([0.0; 3]);
    let pole = [[-0.008, -1.0, 0.0], [0.008, -1.0, 0.0], [0.008, 1.0, 0.0], [-0.008, 1.0, 0.0]];
    let foot = [[-1.0, -1.1, 0.0], [1.0, -1.1, 0.0], [1.0, -1.0, 0.0], [-1.0, -1.0, 0.0]];
    let bytes = quads(&[(pole, dark()), (foot, dark())], json!({}));
    let seen = seen(&bytes, Format::Gltf, &overrides("front"));
    let of_row = |y: u32| (0..SIDE).map(|x| seen.at(x, y).1).sum::<f32>();
    let rows = (0..SIDE).filter(|y| of_row(*y) > 0.4).count();
    assert!(rows > 70, "{rows} rows show the pole");
}

/// A side that nobody asked for is that of a square.
#[test]
fn one_side_is_enough() {
    let bytes = quads(&[(FRONT, matte([0.8; 3]))], json!({}));
    for (width, height, expected) in [(None, None, [512; 2]), (Some(100), None, [100; 2]), (None, Some(64), [64; 2])] {
        let overrides = Overrides { width, height, ..Overrides::default() };
        let image = imported(&bytes, ModelFormat::Gltf, &overrides).description.image;
        assert_eq!([image.width, image.height], expected);
    }
}
