//! Broken models: each is refused where a validator finds its fault, and nothing that a file says breaks the reader.

use super::files::{format_of, model};
use crate::common::{read as file, root};
use serde_json::Value;
use std::path::{Path, PathBuf};
use strahl::models::{Choice, Kind, ModelFormat, NameOrIndex, Place, read};
use strahl::scene::model::import;
use strahl::scene::{NoFiles, Overrides};

fn files(folder: &Path, ending: &[&str], into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, ending, into);
        } else if path.extension().is_some_and(|found| ending.iter().any(|ending| found == *ending)) {
            into.push(path);
        }
    }
}

/// The reports are those of the Khronos validator: errors have severity 0.
#[test]
fn broken_files_are_refused_where_the_validator_finds_their_faults() {
    let mut broken = Vec::new();
    files(&root().join("tests/inputs/models/bad"), &["gltf", "glb"], &mut broken);
    broken.sort();
    assert_eq!(broken.len(), 30);
    for path in broken {
        let name = path.strip_prefix(root().join("tests/inputs/models")).unwrap().to_str().unwrap().to_owned();
        let faults = model(&name, Choice::default()).expect_err(&name);
        let bytes = std::fs::read(&path).unwrap();
        let problems = {
            let folder = path.parent().unwrap().to_owned();
            let parts = Beside(folder);
            import(format_of(&name), &bytes, &Overrides::default(), &parts).expect_err(&name)
        };
        let report: Value =
            serde_json::from_slice(&std::fs::read(format!("{}.report.json", path.display())).unwrap()).unwrap();
        let issues = report["issues"]["messages"].as_array().unwrap();
        // A picture of an unknown format is only a warning to the validator.
        let is_picture = name.contains("unrecognized_format");
        let errors = issues.iter().filter(|issue| issue["severity"] == 0 || is_picture);
        let is_found = |issue: &Value| match (&issue["pointer"], &issue["offset"]) {
            (Value::String(pointer), _) if !pointer.is_empty() => {
                problems.0.iter().any(|problem| problem.pointer == *pointer)
            }
            (_, Value::Number(offset)) => problems.0.iter().any(|problem| problem.offset == offset.as_u64()),
            _ => problems.0.iter().any(|problem| problem.line == Some(1)),
        };
        assert!(errors.into_iter().any(is_found), "{name}: {problems:?}\n{faults:?}");
        assert!(problems.0.iter().all(|problem| !problem.detail.is_empty()), "{name}");
    }
}

/// The files beside a model.
struct Beside(PathBuf);

impl strahl::scene::Files for Beside {
    fn read(&self, name: &str) -> Result<Vec<u8>, String> {
        std::fs::read(self.0.join(name)).map_err(|error| format!("cannot be read: {error}"))
    }
}

#[test]
fn what_is_not_read_is_refused_by_name() {
    let refused = |name: &str| model(name, Choice::default()).unwrap_err().0[0].clone();
    assert!(refused("ply/points_ascii.ply").detail.contains("only points"));
    assert!(refused("stl/empty.stl").detail.contains("nothing to see"));
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty list int float tags\n{xyz}end_header\n-0.927566 0.5 1 2 3\n"
    );
    let list = &read(ModelFormat::Ply, ply.as_bytes(), &|_| Err("none".into()), Choice::default()).unwrap_err().0[0];
    assert!(list.detail.contains("how many numbers it has, and -0.927566 is no such number"), "{}", list.detail);
    assert_eq!(list.place, Place::Line(9, 1));
    let relative = refused("obj/invalid-relative-vertex-index.obj");
    assert_eq!((relative.kind, relative.place), (Kind::UnknownReference, Place::Line(1, 3)));
    assert_eq!(refused("obj/number_formats.obj").place, Place::Line(11, 14));
    assert_eq!(refused("assimp_IndexOutOfRange.glb").pointer, "/meshes/0/primitives/0/indices");
    let normals = model("assimp_BoxBadNormals.glb", Choice::default()).unwrap();
    assert_eq!(normals.warnings[0].what, "normals");
    for (choice, pointer) in [
        (Choice { scene: Some(7), ..Choice::default() }, "/scenes"),
        (Choice { animation: Some(NameOrIndex::Index(7)), ..Choice::default() }, "/animations"),
        (Choice { variant: Some(NameOrIndex::Index(7)), ..Choice::default() }, "/extensions/KHR_materials_variants"),
    ] {
        assert_eq!(model("Box.glb", choice).unwrap_err().0[0].pointer, pointer);
    }
}

/// A stream gives what the accessors say, or nothing.
#[test]
fn draco_streams_that_are_not_as_their_accessors_say_are_refused() {
    let whole = file("tests/inputs/models/Box_draco.glb");
    let none = |_: &str| Err("is not there".to_owned());
    for (said, instead, pointer, kind) in [
        (
            "\"count\":36",
            "\"count\":33",
            "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression",
            Kind::OutOfRange,
        ),
        ("\"count\":36", "\"count\":39", "/accessors/0/count", Kind::OutOfRange),
        (
            "\"NORMAL\":0",
            "\"NORMAL\":7",
            "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression/attributes/NORMAL",
            Kind::UnknownReference,
        ),
        ("\"mode\":4", "\"mode\":5", "/meshes/0/primitives/0/mode", Kind::Unsupported),
        (
            "\"bufferView\":0",
            "\"bufferView\":9",
            "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression/bufferView",
            Kind::UnknownReference,
        ),
        ("\"componentType\":5123", "\"componentType\":5126", "/accessors/0/componentType", Kind::OutOfRange),
        ("DRACO", "DRAGO", "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression", Kind::Invalid),
    ] {
        let at = whole.windows(said.len()).position(|bytes| bytes == said.as_bytes()).unwrap();
        let mut changed = whole.clone();
        changed[at..at + said.len()].copy_from_slice(instead.as_bytes());
        let faults = read(format_of("a.glb"), &changed, &none, Choice::default()).unwrap_err();
        assert_eq!((faults.0[0].pointer.as_str(), faults.0[0].kind), (pointer, kind), "{instead}: {faults:?}");
    }
}

/// A cut-off file and a file with one changed byte are read or refused, and never more.
#[test]
fn cut_and_changed_files_break_nothing() {
    let none = |_: &str| Err("is not there".to_owned());
    for name in [
        "Box.glb",
        "SimpleSkin.glb",
        "SimpleSparseAccessor.glb",
        "Box_draco.glb",
        "ply/cube_binary.ply",
        "obj/cube.obj",
    ] {
        let whole = file(&format!("tests/inputs/models/{name}"));
        for end in (0..whole.len()).step_by(7) {
            let _ = read(format_of(name), &whole[..end], &none, Choice::default());
        }
        for at in (0..whole.len()).step_by(3) {
            for flip in [0x01, 0x80, 0xff] {
                let mut changed = whole.clone();
                changed[at] ^= flip;
                let _ = read(
                    format_of(name),
                    &changed,
                    &none,
                    Choice { animation: Some(NameOrIndex::Index(0)), ..Choice::default() },
                );
            }
        }
    }
    // A claim of many bytes allocates nothing.
    let claims =
        br#"{"asset":{"version":"2.0"},"accessors":[{"componentType":5126,"count":9007199254740991,"type":"VEC3"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]}"#;
    let problems = import(format_of("a.gltf"), claims, &Overrides::default(), &NoFiles).unwrap_err();
    assert!(problems.to_string().contains("decoded_bytes"), "{problems}");
    let ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    assert_eq!(read(format_of("a.ply"), ply, &none, Choice::default()).unwrap_err().0[0].kind, Kind::OutOfBounds);
}

/// A few kilobytes, packed, that would be gigabytes when they are read.
#[test]
fn what_is_small_and_says_much_is_refused_before_it_is_built() {
    let read_gltf = |json: &str| read(ModelFormat::Gltf, json.as_bytes(), &|_| Err("none".into()), Choice::default());
    let lists = ["materials", "nodes", "meshes", "accessors", "animations", "skins", "textures"];
    for list in lists {
        let elements = vec!["{}"; 1_000_000].join(",");
        let faults = read_gltf(&format!(r#"{{"asset": {{"version": "2.0"}}, "{list}": [{elements}]}}"#)).unwrap_err().0;
        assert!(!faults.is_empty(), "{list}");
        if list == "materials" {
            assert!(faults[0].kind == Kind::Limit && faults[0].pointer == "/materials", "{faults:?}");
        }
    }
    let instances = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["EXT_mesh_gpu_instancing"], "scene": 0,
        "scenes": [{"nodes": [0]}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}}],
        "accessors": [{"componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]},
                      {"componentType": 5126, "count": 1900000, "type": "VEC3"}]}"#;
    let faults = read_gltf(instances).unwrap_err().0;
    assert!(faults.iter().any(|fault| fault.kind == Kind::Limit), "{faults:?}");
}
