//! Reads NFF files that others wrote, and counts what is in them.

use strahl::scene::Description;
use strahl::scene::description::Object;
use strahl::scene::nff::{NffOptions, read_nff};
use strahl::scene::problem::{Code, Problems};

fn read(name: &str) -> Result<Description, Problems> {
    let path = format!("{}/tests/inputs/nff/{name}", env!("CARGO_MANIFEST_DIR"));
    read_nff(&std::fs::read(&path).unwrap_or_else(|error| panic!("{path}: {error}")), NffOptions::default())
}

/// Lights, materials, spheres, cones and cylinders, polygons, triangles of flat meshes, triangles of smooth meshes.
fn count(name: &str) -> [usize; 7] {
    let description = read(name).unwrap_or_else(|problems| panic!("{name}: {problems}"));
    let mut counts = [description.lights.len(), description.materials.len(), 0, 0, 0, 0, 0];
    for object in description.objects.iter() {
        match object {
            Object::Sphere(_) => counts[2] += 1,
            Object::Cylinder(_) | Object::Cone(_) => counts[3] += 1,
            Object::Polygon(_) => counts[4] += 1,
            Object::Mesh(mesh) if mesh.normals.is_none() => counts[5] += mesh.faces.len(),
            Object::Mesh(mesh) => counts[6] += mesh.faces.len(),
            other => panic!("{name}: {other:?}"),
        }
    }
    counts
}

#[test]
fn files_have_the_bodies_their_generators_count() {
    assert_eq!(count("balls_s1.nff"), [3, 2, 10, 0, 1, 0, 0]);
    assert_eq!(count("balls_s4.nff.gz"), [3, 2, 7381, 0, 1, 0, 0]);
    // one floor; the gears transmit: 144 quads and two polygons of 144 corners
    assert_eq!(count("gears_s1.nff"), [5, 2, 0, 0, 1, 144 * 2 + 2 * 142, 0]);
    assert_eq!(count("jacks_s2.nff"), [1, 1, 54, 27, 0, 0, 0]);
    assert_eq!(count("mount_s2.nff"), [1, 2, 4, 0, 0, 32, 0]);
    assert_eq!(count("mount_s6.nff.gz"), [1, 2, 4, 0, 0, 8192, 0]);
    assert_eq!(count("shells_s1.nff"), [1, 1, 361, 0, 0, 0, 0]);
    assert_eq!(count("teapot_s3.nff"), [2, 3, 0, 0, 9, 0, 552]);
    assert_eq!(count("teapot_s12.nff.gz"), [2, 3, 0, 0, 144, 0, 9120]);
    assert_eq!(count("tetra_s3.nff"), [1, 1, 0, 0, 0, 64, 0]);
    assert_eq!(count("tetra_s6.nff.gz"), [1, 1, 0, 0, 0, 4096, 0]);
    assert_eq!(count("assimp_WithCamera.nff"), [0, 4, 3, 0, 1, 0, 0]);
}

#[test]
fn the_dialect_of_assimp_is_refused() {
    let problems = read("assimp_cone.nff").unwrap_err().0;
    let found: Vec<_> = problems.iter().map(|problem| (problem.line, problem.code)).collect();
    let expected = [
        (Some(3), Code::Unsupported),
        (Some(6), Code::Unsupported),
        (Some(10), Code::InvalidNff),
        (Some(15), Code::Unsupported),
        (Some(21), Code::Unsupported),
    ];
    assert_eq!(found, expected, "{problems:#?}");
}

#[test]
fn a_picture_need_not_be_square() {
    let description = read("assimp_WithCamera.nff").unwrap();
    assert_eq!((description.image.width, description.image.height), (640, 480));
}
