//! Models that other programs wrote, as facts counted from the files by others (`tests/inputs/models/README.md`).

use crate::common::{read as file, root};
use glam::DVec3;
use strahl::models::{Choice, Faults, Model, ModelFormat, NameOrIndex, read};

/// Reads a model of `tests/inputs/models`, with the files beside it as parts.
pub(super) fn model(name: &str, choice: Choice) -> Result<Model, Faults> {
    let path = format!("tests/inputs/models/{name}");
    let folder = root().join(&path).parent().unwrap().to_owned();
    let parts = |part: &str| std::fs::read(folder.join(part)).map_err(|error| format!("cannot be read: {error}"));
    read(format_of(name), &file(&path), &parts, choice)
}

pub(super) fn format_of(name: &str) -> ModelFormat {
    match name.rsplit('.').next().unwrap() {
        "obj" => ModelFormat::Obj,
        "stl" => ModelFormat::Stl,
        "ply" => ModelFormat::Ply,
        _ => ModelFormat::Gltf,
    }
}

fn rest(name: &str) -> Model {
    model(name, Choice::default()).unwrap_or_else(|faults| panic!("{name}: {faults:?}"))
}

/// All vertices where they stand.
fn vertices(model: &Model) -> Vec<DVec3> {
    let of = |placement: &strahl::models::Placement| {
        let positions = model.geometries[placement.geometry].positions.clone();
        let at = move |matrix: &glam::DMat4| {
            let matrix = *matrix;
            positions.clone().into_iter().map(move |point| matrix.transform_point3(DVec3::from_array(point)))
        };
        placement.transforms.iter().flat_map(at).collect::<Vec<_>>()
    };
    model.placements.iter().flat_map(of).collect()
}

fn bounds(model: &Model) -> [DVec3; 2] {
    let all = vertices(model);
    [all.iter().copied().fold(DVec3::INFINITY, DVec3::min), all.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max)]
}

#[test]
fn triangles_and_boxes_are_those_that_others_have_counted() {
    for (name, triangles, low, high) in [
        ("Box.glb", 12, [-0.5; 3], [0.5; 3]),
        ("BoxInterleaved.glb", 12, [-0.5; 3], [0.5; 3]),
        ("Box_draco.glb", 12, [-0.5; 3], [0.5; 3]),
        ("BoxVertexColors.glb", 12, [0.0; 3], [1.0; 3]),
        ("SimpleSparseAccessor.glb", 12, [0.0; 3], [6.0, 4.0, 0.0]),
        ("AnimatedMorphCube_quantized.glb", 12, [-1.0; 3], [1.0; 3]),
        ("RiggedFigure.glb", 256, [-0.5895, 0.0, -0.1309], [0.5895, 1.4499, 0.195]),
        ("UnlitTest.glb", 88, [-2.2, -1.0, -1.0], [2.2, 1.0, 1.0]),
        ("own_instances_1000.glb", 12_000, [-7.25; 3], [7.25; 3]),
        ("SimpleSkin.glb", 8, [-0.5, 0.0, 0.0], [0.5, 2.0, 0.0]),
        ("obj/cornell_box.obj", 36, [0.0; 3], [556.0, 548.8, 559.2]),
        ("obj/cube.obj", 12, [0.0; 3], [2.0; 3]),
        ("obj/concave_polygon.obj", 64, [-1.146, 1.6575, 1.6055], [-1.146, 3.1425, 3.0905]),
        ("obj/negative_indices.obj", 12, [-1.0; 3], [1.0; 3]),
        ("ply/cube.ply", 12, [0.0; 3], [1.0; 3]),
        ("ply/tet.ply", 4, [-1.0; 3], [1.0; 3]),
        ("stl/20mm-xyz-cube.stl", 260, [-47.9519, -4.908, -30.9815], [-27.9519, 15.092, -10.9815]),
        ("stl/triangle_two_solids.stl", 2, [-1.0, -1.0, 0.0], [3.0, 3.0, 0.0]),
        ("stl/triangle_empty_solid.stl", 1, [-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]),
    ] {
        let model = rest(name);
        assert_eq!(model.triangles(), triangles, "{name}");
        let near = |a: DVec3, b: [f64; 3]| a.abs_diff_eq(DVec3::from_array(b), 1e-3);
        let [at, to] = bounds(&model);
        assert!(near(at, low) && near(to, high), "{name}: {at} {to}");
        for geometry in &model.geometries {
            let count = geometry.positions.len();
            assert!(geometry.triangles.iter().flatten().all(|i| (*i as usize) < count), "{name}");
            assert!(geometry.normals.iter().flatten().all(|n| (DVec3::from_array(*n).length() - 1.0).abs() < 1e-9));
        }
    }
}

#[test]
fn what_is_packed_is_what_was_packed() {
    let middles = |name: &str| -> Vec<DVec3> {
        let geometry = &rest(name).geometries[0];
        let at = |i: u32| DVec3::from_array(geometry.positions[i as usize]);
        geometry.triangles.iter().map(|[a, b, c]| (at(*a) + at(*b) + at(*c)) / 3.0).collect()
    };
    let plain = middles("RiggedFigure.glb");
    // Packers order vertices, triangles and joints anew, so sums of joints are rounded in another order; Draco has 11 bits for
    // a coordinate.
    for (name, error) in [("RiggedFigure_meshopt_c.glb", 1e-6), ("RiggedFigure_draco.glb", 1e-3)] {
        let packed = middles(name);
        assert_eq!(plain.len(), packed.len(), "{name}");
        for middle in &plain {
            assert!(packed.iter().any(|other| other.abs_diff_eq(*middle, error)), "{name}: {middle}");
        }
    }
    // One packer, two versions of its bit stream.
    let geometries = |name: &str| rest(name).geometries;
    assert_eq!(geometries("RiggedFigure_meshopt_khr.glb"), geometries("RiggedFigure_meshopt_c.glb"));
}

#[test]
fn the_same_cube_is_read_from_every_form_of_ply() {
    let cubes = ["ply/cube.ply", "ply/cube_binary.ply", "ply/cube_binary_crlf.ply"].map(rest);
    assert_eq!(cubes[1].geometries, cubes[2].geometries);
    let [text, binary] = [0, 1].map(|i: usize| (cubes[i].triangles(), bounds(&cubes[i])));
    assert_eq!(text, binary);
    let colored = rest("ply/float-color.ply");
    assert!(colored.geometries[0].colors.is_some());
}

#[test]
fn instances_share_one_geometry() {
    let model = rest("own_instances_1000.glb");
    assert_eq!((model.geometries.len(), model.placements[0].transforms.len()), (1, 1_000));
    assert_eq!(model.geometries[0].triangles.len(), 12);
}

#[test]
fn animations_are_played() {
    let at = |name: &str, seconds: f64| {
        vertices(&model(name, Choice { animation: Some(NameOrIndex::Index(0)), seconds, ..Choice::default() }).unwrap())
    };
    // Two targets move the third corner by (-1, 1, 0) and (1, 1, 0); their weights are 0 0, 0 1, 1 1, 1 0 and 0 0 at 0 to 4 s.
    for (seconds, tip) in
        [(0.0, [0.5, 0.5]), (1.0, [1.5, 1.5]), (2.0, [0.5, 2.5]), (3.0, [-0.5, 1.5]), (0.5, [1.0, 1.0])]
    {
        let vertices = at("SimpleMorph.glb", seconds);
        let [x, y] = tip;
        let is_there = vertices.iter().any(|vertex| vertex.abs_diff_eq(DVec3::new(x, y, 0.0), 1e-5));
        assert!(is_there, "{seconds}: {vertices:?}");
    }
    // The upper joint turns by 90 degrees around (0, 1, 0), and back.
    let [still, bent] = [0.0, 1.5].map(|seconds| at("SimpleSkin.glb", seconds));
    assert!(still.iter().any(|vertex| vertex.abs_diff_eq(DVec3::new(0.5, 2.0, 0.0), 1e-5)));
    assert!(bent.iter().all(|vertex| vertex.y < 1.9), "{bent:?}");
    // Long after the end is as at the end.
    assert_eq!(at("SimpleMorph.glb", 1e9), at("SimpleMorph.glb", 4.0));
}

#[test]
fn cameras_and_lamps_stand_where_their_nodes_are() {
    let model = rest("Cameras.glb");
    assert_eq!(model.cameras.len(), 2);
    let lights = rest("LightsPoint.glb");
    assert_eq!(lights.lamps.len(), 3);
    assert!(lights.lamps.iter().all(|lamp| lamp.range == Some(10.0) && lamp.intensity > 0.0));
}
