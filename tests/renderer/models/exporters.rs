//! What hurried people and careless exporters write is shown, not refused with a pointer into a scene that nobody wrote.

use super::default_look::{CUBE, FRONT, imported, matte, overrides, quads, seen};
use image::{ImageFormat, RgbaImage};
use serde_json::{Value, json};
use std::io::Cursor;
use strahl::models::ModelFormat;
use strahl::scene::description::Object;
use strahl::scene::model::{Imported, import};
use strahl::scene::{Files, Format, NoFiles, Overrides, load_with};

fn warnings(imported: &Imported) -> Vec<String> {
    imported.description.import_warnings.iter().map(|warning| warning.detail.clone()).collect()
}

fn warned(bytes: &[u8], what: &str) -> bool {
    warnings(&imported(bytes, ModelFormat::Gltf, &overrides("front"))).iter().any(|detail| detail.starts_with(what))
}

/// A library of materials, and a picture that is green at its upper left and red everywhere else.
struct Beside(&'static str);

impl Files for Beside {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        if name == "a.mtl" {
            return Ok(self.0.into());
        }
        let color = |x, y| if x + y == 0 { [0, 255, 0, 255] } else { [255, 0, 0, 255] };
        let mut png = Vec::new();
        let picture = RgbaImage::from_fn(8, 8, |x, y| image::Rgba(color(x, y)));
        picture.write_to(&mut Cursor::new(&mut png), ImageFormat::Png).map_err(|error| error.to_string())?;
        Ok(png)
    }
}

fn obj(lines: &str) -> Vec<u8> {
    [b"mtllib a.mtl\nusemtl a\n", CUBE, lines.as_bytes()].concat()
}

#[test]
fn pictures_on_meshes_without_texture_coordinates_are_their_corner() {
    let files = Beside("newmtl a\nKd 1 1 1\nmap_Kd a.png\nmap_Pr a.png\nnorm a.png\n");
    let loaded = load_with(obj(""), Format::Obj, &overrides("front"), &files).unwrap();
    let Object::Mesh(mesh) = &loaded.description.objects[0] else { panic!("a mesh") };
    assert!(mesh.uvs.iter().flatten().all(|uv| *uv == [0.0, 1.0]), "{:?}", mesh.uvs);
    let said = loaded.scene.warnings.iter().any(|it| it.detail.starts_with("approximated: no-texture-coordinates"));
    assert!(said, "{:?}", loaded.scene.warnings);
    let whole = load_with(obj("vt 0 1\nf 1/1 2/1 3/1\n"), Format::Obj, &overrides("front"), &files).unwrap();
    assert!(!whole.scene.warnings.iter().any(|it| it.detail.contains("texture-coordinates")));
}

#[test]
fn numbers_of_vertices_without_measure_are_shown() {
    for lines in ["vt 1e20 -1e300\nf 1/1 2/1 3/1\n", "vn 1e200 0 0\nf 1//1 2//1 3//1\n"] {
        let bytes = [CUBE, lines.as_bytes()].concat();
        assert!(seen(&bytes, Format::Obj, &overrides("three_quarter")).opaque() > 1_000, "{lines}");
    }
}

/// A square at each of some nodes.
fn squares(nodes: Value) -> Vec<u8> {
    let all: Vec<usize> = (0..nodes.as_array().unwrap().len()).collect();
    quads(&[(FRONT, matte([0.8; 3]))], json!({ "nodes": nodes, "scenes": [{ "nodes": all }] }))
}

/// Animations hide nodes so.
#[test]
fn what_a_scale_of_zero_hides_is_not_there() {
    let alone = imported(&squares(json!([{ "mesh": 0 }])), ModelFormat::Gltf, &overrides("front")).description;
    let hidden = json!({ "mesh": 0, "scale": [0, 0, 0], "translation": [5, 0, 0], "rotation": [0, 0.6, 0, 0.8] });
    let beside = squares(json!([{ "mesh": 0 }, hidden]));
    assert_eq!(imported(&beside, ModelFormat::Gltf, &overrides("front")).description, alone);
    // Nor is what scales make a line of.
    for scale in [[1.0, 0.0, 0.0], [0.0, 1e-30, 0.0]] {
        let line = json!({ "mesh": 0, "scale": scale, "rotation": [0, 0.6, 0, 0.8] });
        let beside = squares(json!([{ "mesh": 0 }, line]));
        assert_eq!(imported(&beside, ModelFormat::Gltf, &overrides("front")).description, alone, "{scale:?}");
    }
    let nothing = import(ModelFormat::Gltf, &squares(json!([hidden])), &Overrides::default(), &NoFiles).unwrap_err();
    assert!(nothing.to_string().contains("nothing to see"), "{nothing}");
    // Faces of which none has three corners are no body of their own.
    let bytes = obj("usemtl b\nv 9 9 9\nv 9 9 9\nv 9 9 9\nf -1 -2 -3\n");
    let files = Beside("newmtl a\nnewmtl b\n");
    let loaded = load_with(&bytes, Format::Obj, &overrides("front"), &files).unwrap();
    assert_eq!(loaded.description.objects.len(), 1, "the cube alone");
}

#[test]
fn what_stands_flat_in_one_of_several_places_is_seen() {
    let flat = json!({ "mesh": 0, "scale": [1, 1, 0], "translation": [4, 0, 0] });
    let several = |nodes: Value| seen(&squares(nodes), Format::Gltf, &overrides("front")).opaque();
    let plain = several(json!([{ "mesh": 0 }, { "mesh": 0, "translation": [4, 0, 0] }]));
    assert!(plain > 1_000);
    assert_eq!(several(json!([{ "mesh": 0 }, flat])), plain);
    assert_eq!(several(json!([{ "mesh": 0, "scale": [1, 1, 0] }, flat])), plain);
    let many: Vec<Value> = (0..3).map(|i| json!({ "mesh": 0, "translation": [4 * i, 0, 0] })).collect();
    let mut and_flat = many.clone();
    and_flat.push(json!({ "mesh": 0, "scale": [1, 1, 0], "translation": [4, 0, 0] }));
    assert_eq!(several(json!(and_flat)), several(json!(many)));
}

#[test]
fn lamps_that_are_switched_off_leave_the_studio_on() {
    let lit = |lamp: Value| {
        let more = json!({
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": { "KHR_lights_punctual": { "lights": [lamp] } },
            "nodes": [{ "mesh": 0 }, { "translation": [0, 0, 2], "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
            "scenes": [{ "nodes": [0, 1] }]
        });
        imported(&quads(&[(FRONT, matte([0.8; 3]))], more), ModelFormat::Gltf, &overrides("front")).description
    };
    let studio = imported(&squares(json!([{ "mesh": 0 }])), ModelFormat::Gltf, &overrides("front")).description;
    assert_eq!(lit(json!({ "type": "point", "intensity": 0 })), studio);
    assert_eq!(lit(json!({ "type": "spot", "color": [0, 0, 0] })), studio);
    assert_ne!(lit(json!({ "type": "point" })), studio);
}

#[test]
fn colors_to_255_and_models_that_nobody_sees_are_said() {
    let with = |color: Value, mode: &str| {
        let material = json!({ "pbrMetallicRoughness": { "baseColorFactor": color }, "alphaMode": mode });
        quads(&[(FRONT, material)], json!({}))
    };
    for (color, mode, what, is_said) in [
        (json!([200, 50, 0, 1]), "OPAQUE", "approximated: colors", true),
        (json!([1, 0.5, 0, 1]), "OPAQUE", "approximated: colors", false),
        (json!([1, 1, 1, 0]), "BLEND", "skipped: invisible", true),
        (json!([1, 1, 1, 0.1]), "BLEND", "skipped: invisible", false),
        (json!([1, 1, 1, 0]), "OPAQUE", "skipped: invisible", false),
    ] {
        assert_eq!(warned(&with(color.clone(), mode), what), is_said, "{color} {mode}");
    }
    let files = Beside("newmtl a\nTr 1\n");
    let gone = import(ModelFormat::Obj, &obj(""), &overrides("front"), &files).unwrap();
    assert!(warnings(&gone).iter().any(|detail| detail.starts_with("skipped: invisible")), "{:?}", warnings(&gone));
}

/// Programs write them to 255 where they go to 1.
#[test]
fn vertex_colors_above_one_are_shown_and_warned_of() {
    let ply = |most: &str| {
        let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            property float red\nproperty float green\nproperty float blue\nelement face 1\n\
            property list uchar int vertex_indices\nend_header\n";
        let corners = ["-1 -1 0", "1 -1 0", "0 1 0"].map(|corner| format!("{corner} {most} 0 0\n"));
        format!("{head}{}3 0 1 2\n", corners.concat())
    };
    let obj = |most: &str| {
        let corners = ["-1 -1 0", "1 -1 0", "0 1 0"].map(|corner| format!("v {corner} {most} 0 0\n"));
        format!("{}f 1 2 3\n", corners.concat())
    };
    for (format, text) in [(ModelFormat::Ply, &ply as &dyn Fn(&str) -> String), (ModelFormat::Obj, &obj)] {
        for (most, is_beyond) in [("1", false), ("255", true), ("1e300", true)] {
            let imported = imported(text(most).as_bytes(), format, &overrides("front"));
            let said =
                warnings(&imported).iter().any(|detail| detail.starts_with("approximated: colors: colors above 1"));
            assert_eq!(said, is_beyond, "{format:?} {most}: {:?}", warnings(&imported));
            let Object::Mesh(mesh) = &imported.description.objects[0] else { panic!("a mesh") };
            assert!(mesh.colors.iter().flatten().all(|color| color[..3] == [1.0, 0.0, 0.0]), "{:?}", mesh.colors);
        }
    }
}

/// C libraries write NaN in many ways, and scanners leave holes in what no face needs.
#[test]
fn numbers_that_are_missing_refuse_a_model_only_where_they_are_places() {
    let obj = |point: &str, normal: &str, uv: &str| {
        format!("v 0 0 0\nv 1 0 {point}\nv 0 1 0\nvt {uv} 0\nvn {normal} 0 0\nf 1/1/1 2/1/1 3/1/1\n")
    };
    let ply = |point: &str, normal: &str, quality: &str| {
        let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            property float nx\nproperty float ny\nproperty float nz\nproperty float quality\nelement face 1\n\
            property list uchar int vertex_indices\nend_header\n";
        let corners =
            ["0 0 0", &format!("1 0 {point}"), "0 1 0"].map(|corner| format!("{corner} {normal} 0 0 {quality}\n"));
        format!("{head}{}3 0 1 2\n", corners.concat())
    };
    let read = |format, text: &str| imported(text.as_bytes(), format, &overrides("front"));
    let warned = |imported: &_| warnings(imported).iter().any(|detail| detail.starts_with("assumed: numbers"));
    for missing in ["nan", "-nan(ind)", "NaN", "-1.#IND", "1.#QNAN00", "inf", "1e999"] {
        for (format, text) in [
            (ModelFormat::Obj, obj("0", missing, "0")),
            (ModelFormat::Obj, obj("0", "0", missing)),
            (ModelFormat::Obj, obj("0 0.5 0.5 0.5", "0", "0").replacen("0.5", missing, 1)),
            (ModelFormat::Ply, ply("0", missing, "1")),
        ] {
            let imported = read(format, &text);
            assert!(warned(&imported), "{text}");
            let Object::Mesh(mesh) = &imported.description.objects[0] else { panic!("a mesh") };
            let toward_z = |normal: &[f64; 3]| normal[2].abs() == 1.0;
            assert!(mesh.normals.as_ref().is_none_or(|normals| normals.iter().all(toward_z)), "{:?}", mesh.normals);
        }
        assert!(!warned(&read(ModelFormat::Ply, &ply("0", "0", missing))), "nobody asks for the quality of a point");
        for (format, text, line) in [
            (ModelFormat::Obj, obj(missing, "0", "0"), "line 2"),
            (ModelFormat::Ply, ply(missing, "1", "1"), "line 15"),
        ] {
            let refused = import(format, text.as_bytes(), &overrides("front"), &NoFiles).unwrap_err();
            assert!(refused.to_string().contains(line) && refused.to_string().contains(missing), "{refused}");
        }
    }
}
