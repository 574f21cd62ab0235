//! Rules and mistakes of NFF, in snippets; files that others wrote are read in `tests/renderer/scene/nff_files.rs`.

use super::*;
use crate::scene::description::{Camera, Light, Object, PinholeCamera};

const VIEW: &str = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 90\nhither 1\nresolution 100 50\n";
const OPAQUE: &str = "f 1 .5 .25 .8 .1 10 0 0\n";
const GLASS: &str = "f 1 1 1 .1 .1 100 .9 1.5\n";

fn read(text: &str) -> Description {
    read_nff(text.as_bytes(), NffOptions::default()).unwrap_or_else(|problems| panic!("{problems}"))
}

/// With the view on lines 1 to 7 before it.
fn scene(text: &str) -> Description {
    read(&format!("{VIEW}{text}"))
}

fn problems(text: &str) -> Vec<Problem> {
    read_nff(text.as_bytes(), NffOptions::default()).expect_err(text).0
}

/// The one problem of a text that follows the view's seven lines; `line` counts from the text's first.
#[track_caller]
fn refused(text: &str, line: u32, column: u32, code: Code, words: &str) {
    let found = problems(&format!("{VIEW}{text}"));
    assert_eq!(found.len(), 1, "{found:?}");
    let problem = &found[0];
    assert!(problem.detail.contains(words), "{problem}");
    assert_eq!((problem.line, problem.column, problem.code), (Some(line + 7), Some(column), code), "{problem}");
    assert_eq!(problem.pointer, "");
}

fn vfov(description: &Description) -> f64 {
    let Camera::Pinhole(PinholeCamera { vfov_deg, .. }) = description.camera else { panic!("not a pinhole") };
    vfov_deg
}

fn tan_half(description: &Description) -> f64 {
    crate::math::tan(0.5 * vfov(description).to_radians())
}

#[test]
fn a_view_and_a_sphere() {
    let found = scene("s 1 2 3 4");
    let camera = PinholeCamera {
        eye: [0.0, 0.0, 5.0],
        look_at: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        vfov_deg: vfov(&found),
        aperture: 0.0,
        focus_distance: None,
    };
    assert_eq!(found.camera, Camera::Pinhole(camera));
    assert_eq!((found.image.width, found.image.height), (100, 50));
    assert_eq!(found.background.0.to_array(), [0.0; 3]);
    assert_eq!((found.version, found.name, found.lights.len()), (1, None, 0));
    assert_eq!(found.ambient.0.to_array(), [0.5; 3]);
    let Object::Sphere(sphere) = &found.objects[0] else { panic!("{:?}", found.objects) };
    assert_eq!((sphere.center, sphere.radius, sphere.hollow), ([1.0, 2.0, 3.0], 4.0, false));
    let material = found.materials.get(sphere.material.as_deref().unwrap()).unwrap();
    assert!(material.one_sided);
}

#[test]
fn line_ends_mean_nothing_inside_an_entity() {
    let lines = scene("f 1 1 1 .5 .5 3 0 1\nc 0 0 0 1 0 0 2 1\ns 0 0 0 1\np 3 0 0 0 1 0 0 0 1 0");
    let words = format!("{VIEW}f 1 1 1 .5 .5 3 0 1 c 0 0 0 1 0 0 2 1 s 0 0 0 1 p 3 0 0 0 1 0 0 0 1 0");
    assert_eq!(read(&words.replace(' ', "\r")), lines);
    assert_eq!(read(&words.replace(['\n', ' '], "\t\x0c")), lines);
    assert_eq!(read(&words.replace(' ', " # caf\u{e9}\r\n ")), lines);
}

#[test]
fn comments_may_be_latin_1() {
    let bytes = [b"# Stra\xDFe \xFF\n", VIEW.as_bytes(), b"s 0 0 0 1 # gr\xFC\xDF dich"].concat();
    assert!(read_nff(&bytes, NffOptions::default()).is_ok());
}

#[test]
fn hither_and_resolution_may_be_missing() {
    let view = "v from 0 0 5 at 0 0 0 up 0 1 0 angle 45";
    for tail in ["", " hither 0", " resolution 512 512"] {
        let found = read(&format!("{view}{tail} s 0 0 0 1"));
        assert_eq!((found.image.width, found.image.height), (512, 512));
    }
}

#[test]
fn the_angle_ends_in_the_centres_of_the_edge_rows() {
    assert!((tan_half(&scene("s 0 0 0 1")) - 50.0 / 49.0).abs() < 1e-12);
    let row = read(&format!("{}s 0 0 0 1", VIEW.replace("100 50", "100 1")));
    assert!((vfov(&row) - 90.0).abs() < 1e-12);
}

#[test]
fn counting_rays_takes_the_conditions_of_the_spd() {
    let options = NffOptions { spd_counts: true, two_sided: false };
    let found = read_nff(format!("{VIEW}s 0 0 0 1").as_bytes(), options).unwrap();
    assert_eq!((found.image.width, found.image.height), (513, 513));
    assert!((tan_half(&found) - 513.0 / 511.0).abs() < 1e-12);
    let render = found.render;
    assert_eq!(
        (render.max_depth, render.min_weight, render.samples, render.antialias),
        (Some(5), Some(0.0), Some(1), false)
    );
}

#[test]
fn background_may_come_first_or_last_before_the_objects() {
    for text in [format!("b .1 .2 .3\n{VIEW}s 0 0 0 1"), format!("{VIEW}l 1 1 1\nb .1 .2 .3\ns 0 0 0 1")] {
        assert_eq!(read(&text).background.0.to_array(), [0.1, 0.2, 0.3]);
    }
}

#[test]
fn lights_share_their_intensity_and_may_have_a_color() {
    let found = scene("l 1 2 3\nl 4 5 6 1 .5 0\nl 7 8 9 l 0 0 1\ns 0 0 0 1");
    let lights: Vec<_> = found
        .lights
        .iter()
        .map(|light| {
            let Light::Point(point) = light else { panic!("{light:?}") };
            assert_eq!((point.intensity, point.falloff), (0.25, Default::default()));
            (point.position, point.color.0.to_array())
        })
        .collect();
    let white = [1.0; 3];
    let expected = [([1., 2., 3.], white), ([4., 5., 6.], [1., 0.5, 0.]), ([7., 8., 9.], white), ([0., 0., 1.], white)];
    assert_eq!(lights, expected);
    assert_eq!(found.ambient.0.to_array(), [0.25; 3]);
}

#[test]
fn fills_become_materials() {
    let text = format!("{OPAQUE}s 0 0 0 1\n{GLASS}s 1 0 0 1\n{OPAQUE}s 2 0 0 1\nf 0 0 0 0 0 0 0 0\n");
    let found = scene(&text);
    assert_eq!(found.materials.keys().collect::<Vec<_>>(), ["fill_1", "fill_2"]);
    let names: Vec<_> = found.objects.iter().map(material_of).collect();
    assert_eq!(names, ["fill_1", "fill_2", "fill_1"]);
    let opaque = serde_json::to_value(found.materials.get("fill_1").unwrap()).unwrap();
    let expected = serde_json::json!({
        "diffuse": [0.8, 0.4, 0.2], "specular": [0.1, 0.1, 0.1], "shininess": 10.0, "reflection": [0.1, 0.1, 0.1],
        "transmission": [0.0, 0.0, 0.0], "ior": 1.0, "one_sided": true
    });
    assert_eq!(opaque, expected);
    let glass = found.materials.get("fill_2").unwrap();
    assert_eq!((glass.transmission.0.to_array(), glass.ior, glass.one_sided), ([0.9; 3], 1.5, false));
    let two_sided = NffOptions { two_sided: true, spd_counts: false };
    let found = read_nff(format!("{VIEW}{text}").as_bytes(), two_sided).unwrap();
    assert!(found.materials.iter().all(|(_, material)| !material.one_sided));
}

fn material_of(object: &Object) -> &str {
    let material = match object {
        Object::Sphere(body) => &body.material,
        Object::Mesh(body) => &body.material,
        Object::Triangle(body) => &body.material,
        Object::Polygon(body) => &body.material,
        other => panic!("{other:?}"),
    };
    material.as_deref().unwrap()
}

#[test]
fn cones_cylinders_and_what_is_visible_inside() {
    let found = scene("c 0 0 0 2 0 0 4 1\nc 0 0 0 1 0 0 4 3\nc 0 0 0 1 0 0 4 1\nc 0 0 0 -2 0 0 4 0\ns 0 0 0 -3\n");
    let cone = |i: usize| {
        let Object::Cone(cone) = &found.objects[i] else { panic!("{:?}", found.objects[i]) };
        (cone.base_radius, cone.top_radius, cone.capped, cone.hollow)
    };
    assert_eq!(cone(0), (2.0, 1.0, false, false));
    assert_eq!(cone(1), (1.0, 3.0, false, false));
    assert_eq!(cone(3), (2.0, 0.0, false, true));
    let Object::Cylinder(cylinder) = &found.objects[2] else { panic!("{:?}", found.objects[2]) };
    assert_eq!((cylinder.radius, cylinder.capped, cylinder.top), (1.0, false, [0.0, 0.0, 4.0]));
    let Object::Sphere(sphere) = &found.objects[4] else { panic!("{:?}", found.objects[4]) };
    assert_eq!((sphere.radius, sphere.hollow), (3.0, true));
}

const QUAD: &str = "p 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
const TRIANGLE: &str = "p 3\n0 0 0\n1 0 0\n0 1 0\n";
const PATCH: &str = "pp 3\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 -0 0 0 1\n";

fn kinds(description: &Description) -> Vec<&'static str> {
    description.objects.iter().map(Object::kind).collect()
}

#[test]
fn opaque_polygons_stay_and_many_triangles_become_a_mesh() {
    assert_eq!(kinds(&scene(&QUAD.repeat(3))), ["polygon"; 3]);
    assert_eq!(kinds(&scene(&TRIANGLE.repeat(2))), ["triangle"; 2]);
    let found = scene(&[OPAQUE, TRIANGLE, QUAD, TRIANGLE, OPAQUE, TRIANGLE, GLASS, "s 0 0 0 1"].concat());
    assert_eq!(kinds(&found), ["polygon", "mesh", "sphere"]);
    let Object::Mesh(mesh) = &found.objects[1] else { panic!("{:?}", found.objects[1]) };
    assert_eq!((mesh.vertices.len(), mesh.faces.len(), &mesh.normals), (3, 3, &None));
    assert_eq!(mesh.material.as_deref(), Some("fill_1"));
}

#[test]
fn transmitting_faces_become_one_mesh_for_each_fill() {
    let found = scene(&[GLASS, QUAD, "s 0 0 0 1\n", TRIANGLE, OPAQUE, GLASS, TRIANGLE].concat());
    assert_eq!(kinds(&found), ["sphere", "mesh", "mesh"]);
    let Object::Mesh(mesh) = &found.objects[1] else { panic!("{:?}", found.objects[1]) };
    assert_eq!((mesh.vertices.len(), mesh.faces.len()), (4, 3));
}

#[test]
fn patches_are_smooth_meshes_apart_from_polygons() {
    for fill in [OPAQUE, GLASS] {
        let found = scene(&[fill, &TRIANGLE.repeat(3), PATCH, &PATCH.replace("0 1 -0", "0 1 0")].concat());
        assert_eq!(kinds(&found), ["mesh", "mesh"]);
        let Object::Mesh(mesh) = &found.objects[1] else { panic!("{:?}", found.objects[1]) };
        assert_eq!((mesh.vertices.len(), mesh.faces.len()), (3, 2));
        assert_eq!(mesh.normals, Some(vec![[0.0, 0.0, 1.0]; 3]));
    }
}

#[test]
fn the_first_corner_tells_the_front() {
    // concave at its second vertex: the formula's normal is the other side's
    let found = scene("p 4 2 0 0 1 1 0 0 0 0 0 4 0\np 4 4 0 0 0 4 0 1 1 0 0 0 0\n");
    let fronts: Vec<_> = found
        .objects
        .iter()
        .map(|object| {
            let Object::Polygon(polygon) = object else { panic!("{object:?}") };
            crate::shape::ear_clipping::newell_normal(&polygon.vertices).z
        })
        .collect();
    assert!(fronts.iter().all(|z| *z > 0.0), "{fronts:?}");
}

#[test]
fn mistakes_in_numbers() {
    use Code::{InvalidNff, OutOfRange};
    refused("s 0 0 x 1\n", 1, 7, InvalidNff, "expected a number for the centre, found \"x\"; line 8 starts a sphere");
    refused("s 0 0 0\ns 0 0 0 1", 2, 1, InvalidNff, "expected a number for the radius, found \"s\"; line 8");
    refused("s 0 0 0 1\ns 0 0 0", 2, 8, InvalidNff, "found the end of the file; line 9");
    for odd in ["nan", "inf", "-inf", "0x1p3", "1e", "1,5"] {
        refused(&format!("s 0 0 0 {odd}"), 1, 9, InvalidNff, odd);
    }
    refused("s 0 0 0 1e999", 1, 9, OutOfRange, "numbers go up to 1e15");
    refused("s 0 2e15 0 1", 1, 5, OutOfRange, "numbers go up to 1e15");
    refused("b 0 -1 0\ns 0 0 0 1", 1, 5, OutOfRange, "the color is -1, but must be at least 0");
    refused("l 0 0 0 1 1\ns 0 0 0 1", 2, 1, InvalidNff, "a number for the color");
    refused("l 0 0 0 1 1 1 1\ns 0 0 0 1", 1, 15, InvalidNff, "one number too many: line 8 starts a light");
}

#[test]
fn mistakes_in_fills() {
    use Code::{InvalidNff, OutOfRange};
    let tail = "s 0 0 0 1";
    refused(&format!("f 1 1 1 .1 .1 .9 30 1.5\n{tail}"), 1, 18, OutOfRange, "T is 30, but must be from 0 to 1; are Sh");
    refused(&format!("f 1 1 1 .1 .1 2e6 0 1\n{tail}"), 1, 15, OutOfRange, "from 0 to 1e6");
    refused(&format!("f 1 1 1 .1 .1 1 .5 0\n{tail}"), 1, 20, OutOfRange, "from 0.01 to 100");
    refused(&format!("f 1 1 1 .1 .1\n{tail}"), 2, 1, InvalidNff, "expected a number for Shine, found \"s\"");
    refused(&format!("f 1 1 1 1 1 1 0 1 1\n{tail}"), 1, 19, InvalidNff, "one number too many");
}

#[test]
fn mistakes_in_bodies() {
    use Code::{Degenerate, InvalidNff, Limit};
    refused("s 0 0 0 0", 1, 1, Degenerate, "radius is 0");
    refused("c 1 1 1 2 1 1 1 1", 1, 1, Degenerate, "same point");
    refused("c 1 1 1 0 1 1 2 0", 1, 1, Degenerate, "both radii");
    refused("c 1 1 1 -1 1 1 2 1", 1, 1, Degenerate, "one radius of the cone is negative");
    refused("p 2 0 0 0 1 1 1", 1, 3, Code::OutOfRange, "at least 3");
    refused("p 3.5 0 0 0 1 1 1", 1, 3, Code::OutOfRange, "whole number");
    refused("p 10001 0 0 0", 1, 3, Limit, "polygon_vertices");
    refused("p 3\n0 0 0\n1 0 0\n1 0 0\n", 1, 1, Degenerate, "no area: its vertices 2 and 3 are the same");
    refused("p 3\n0 0 0\n1 0 0\n3 0 0\n", 1, 1, Degenerate, "lie on a line");
    refused("p 4 0 0 0 1 1 0 1 0 0 0 3 0\n", 1, 1, Degenerate, "cross");
    refused(&format!("{TRIANGLE}1 1 0\n"), 5, 1, InvalidNff, "line 8 announces fewer vertices than follow");
    refused(&format!("{}s 0 0 0 1", TRIANGLE.replace('3', "4")), 5, 1, InvalidNff, "for vertex 4 of 4, found \"s\"");
    refused(&PATCH.replace("-0 0 0 1", "-0 0 -0 0"), 4, 8, Degenerate, "normal of vertex 3 is 0 0 0");
}

#[test]
fn mistakes_in_views() {
    let with = |from: &str, to: &str| problems(&format!("{}s 0 0 0 1", VIEW.replace(from, to)));
    let check = |from: &str, to: &str, line: u32, words: &str| {
        let found = with(from, to);
        assert_eq!((found.len(), found[0].line), (1, Some(line)), "{found:?}");
        assert!(found[0].detail.contains(words), "{found:?}");
    };
    check("from 0 0 5", "from 0 0 0", 1, "the same point");
    check("up 0 1 0", "up 0 0 -2", 1, "parallel");
    check("up 0 1 0", "up 0 0 0", 1, "0 0 0");
    check("angle 90", "angle 180", 5, "below 180");
    check("angle 90", "angle 0", 5, "above 0");
    check(
        "at 0 0 0\nup 0 1 0",
        "up 0 1 0\nat 0 0 0",
        3,
        "expected the word \"at\", found \"up\"; line 1 starts the view",
    );
    check("100 50", "100 0", 7, "at least 1");
    check("100 50", "1.5 50", 7, "whole number");
    check("100 50", "100 16385", 7, "image_side");
    check("100 50", "16384 16384", 1, "pixels");
}

#[test]
fn order_matters() {
    refused(&format!("{VIEW}s 0 0 0 1"), 1, 1, Code::InvalidNff, "second view");
    let found = problems(&format!("s 0 0 0 1\n{VIEW}l 0 0 0\nb 0 0 0\n"));
    assert_eq!(found.iter().map(|problem| problem.line).collect::<Vec<_>>(), [Some(2), Some(9), Some(10)]);
    assert!(found.iter().all(|problem| problem.detail.contains("before the first object, which is on line 1")));
    refused("b 0 0 0\nb 0 0 0\ns 0 0 0 1", 2, 1, Code::InvalidNff, "second background \"b\"; the first is on line 8");
    refused("l 0 0 0\n", 2, 1, Code::InvalidNff, "no objects");
    for (text, line) in [("\nl 0 0 1\n\ns 0 0 0 1\n", 4), ("# nothing\n", 2), ("", 1)] {
        let found = problems(text);
        assert_eq!((found.len(), found[0].line), (1, Some(line)), "{found:?}");
        assert!(found[0].detail.contains("no view"));
    }
}

#[test]
fn all_problems_are_found_up_to_the_limit() {
    let found = problems(&format!("{VIEW}q 1\ns 1 x 1 1\np 3 0 0 0\n  1 y 0\n  1 1 1\nl 1 1\ns 1 1 1 1\n"));
    assert_eq!(found.iter().map(|problem| problem.line).collect::<Vec<_>>(), [Some(8), Some(9), Some(11), Some(14)]);
    assert!(found[0].detail.contains("entities are v, b, l, f, c, s, p and pp"), "{}", found[0]);
    assert!(problems("S 1 1 1 1")[0].detail.starts_with("\"S\" starts no entity"));
    // one view that cannot be read is not missing, too
    assert_eq!(problems("v\nfrom 0 0 z\ns 0 0 0 1\n").len(), 1);
    let many = Problems(problems(&"s 0 0 0 x\n".repeat(100)));
    assert_eq!((many.reported().0.len(), many.reported().1), (50, 51), "a hundred, and that there is no view");
}

#[test]
fn other_formats_are_refused_by_name() {
    for text in ["nff\nversion 3.00\n", "# x\nVersion 2.1\n"] {
        let found = problems(text);
        assert_eq!((found.len(), found[0].code), (1, Code::Unsupported));
        assert!(found[0].detail.contains("Sense8"), "{found:?}");
    }
    let assimp = "assimp's dialect";
    refused("tess 4\ns 0 0 0 1", 1, 1, Code::Unsupported, assimp);
    refused("f 1 1 1 .5 .5 45 0 1 a.png\ns 0 0 0 1", 1, 22, Code::Unsupported, assimp);
    refused("s 0 0 0 1 2 3\ns 0 0 0 1", 1, 11, Code::Unsupported, assimp);
}

#[test]
fn gzip_is_unpacked_within_the_limit() {
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;
    let pack = |text: &[u8]| {
        let mut packer = GzEncoder::new(Vec::new(), Compression::fast());
        packer.write_all(text).unwrap();
        packer.finish().unwrap()
    };
    let packed = pack(format!("{VIEW}s 0 0 0 1").as_bytes());
    assert_eq!(read_nff(&packed, NffOptions::default()), Ok(scene("s 0 0 0 1")));
    let cut = read_nff(&packed[..packed.len() - 12], NffOptions::default()).unwrap_err();
    assert!(cut.0[0].detail.contains("gzip data is damaged"), "{cut}");
    let json = read_nff(&pack(b" {\"version\": 1}"), NffOptions::default()).unwrap_err();
    assert!(json.0[0].detail.contains("JSON in a gzip file"), "{json}");
    let blank = vec![b' '; 32 << 20];
    let bomb = pack(&blank).repeat(8);
    let large = read_nff(&[bomb, pack(b"#")].concat(), NffOptions::default()).unwrap_err();
    assert_eq!(large.0[0].code, Code::Limit);
    assert!(large.0[0].detail.contains("scene_bytes"), "{large}");
}

proptest::proptest! {
    /// Whatever the tokens, there is an answer, and each problem says where.
    #[test]
    fn any_tokens_have_an_answer(picks in proptest::collection::vec((0..TOKENS.len(), 0..3_usize), 0..60)) {
        let soup: String = picks.iter().flat_map(|&(token, space)| [TOKENS[token], ["\n", " ", " "][space]]).collect();
        for text in [soup.clone(), format!("{VIEW}{soup}"), format!("{VIEW}{GLASS}{PATCH}{soup}")] {
            match read_nff(text.as_bytes(), NffOptions::default()) {
                Ok(found) => assert!(!found.objects.is_empty()),
                Err(Problems(found)) => {
                    assert!((1..=50).contains(&found.len()));
                    assert!(found.iter().all(|problem| problem.line.is_some()), "{found:?}");
                }
            }
        }
    }
}

const TOKENS: [&str; 23] = [
    "v", "from", "at", "b", "l", "f", "c", "s", "p", "pp", "0", "1", "-1", "3", "3", ".5", "1e16", "x", "#", "tess",
    "4", "2", "0",
];
