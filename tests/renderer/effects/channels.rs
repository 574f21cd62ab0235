//! What changes a layered material from place to place: pictures on its channels, and colors of vertices.

use super::metallic_roughness::{in_front_of, in_url, quad, shows};
use super::*;
use image::{Rgba, RgbaImage};

/// A square mesh from -1 to 1 whose u grows along x and v along y.
fn square(z: f64, material: &str) -> Value {
    json!({ "mesh": {
        "vertices": [[-1, -1, z], [1, -1, z], [1, 1, z], [-1, 1, z]], "faces": [[0, 1, 2], [0, 2, 3]],
        "uvs": [[0, 0], [1, 0], [1, 1], [0, 1]], "uvs1": [[0, 0], [2, 0], [2, 2], [0, 2]],
        "colors": [[1, 0, 0, 1], [1, 0, 0, 0.5], [1, 1, 0, 0.5], [1, 1, 0, 1]], "material": material
    } })
}

#[test]
fn pictures_lie_on_every_channel_and_are_moved_as_gltf_says() {
    // Upper left, upper right, lower left, lower right.
    let picture = RgbaImage::from_fn(2, 2, |x, y| {
        [[Rgba([255, 0, 0, 255]), Rgba([0, 255, 0, 0])], [Rgba([0, 0, 255, 255]), Rgba([255, 255, 255, 128])]]
            [y as usize][x as usize]
    });
    let url = in_url(&picture);
    let seen = |textured: Value, x: f64, y: f64| {
        let materials = json!({ "it": { "pbr": { "unlit": true, "base_color": textured } } });
        // The middles of texels lie a quarter from the edge.
        let mut objects = square(0.0, "it");
        objects["mesh"].as_object_mut().unwrap().remove("colors");
        // Of the texel beside it there are some roundings.
        pixels(in_front_of(x, y, materials, json!([objects])), "double")[0].map(|channel| (channel * 1e6).round() / 1e6)
    };
    let [red, green, blue, white] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]];
    let all = |textured: Value| {
        [(-0.5, 0.5), (0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)].map(|(x, y)| seen(textured.clone(), x, y))
    };
    assert_eq!(all(json!({ "image": url })), [red, green, blue, white]);
    assert_eq!(all(json!({ "image": url, "transform": { "offset": [0.5, 0] } })), [green, red, white, blue]);
    // The picture turns clockwise around its upper left corner, and repeats.
    let turned = json!({ "image": url, "transform": { "rotate_deg": 90 } });
    assert_eq!(all(turned), [blue, red, white, green]);
    let twice = seen(json!({ "image": url, "uv": 1 }), -0.75, -0.75);
    assert_eq!(twice, blue);
    // Clamped, what lies beyond the edge is the last texel; mirrored, the picture comes back.
    let beyond = |wrap: &str| json!({ "image": url, "transform": { "offset": [1, 0] }, "wrap": [wrap, "repeat"] });
    assert_eq!(all(beyond("clamp")), [green, green, white, white]);
    assert_eq!(all(beyond("mirror")), [green, red, white, blue]);
    // Alpha is a number like others.
    let alpha = json!({ "alpha": { "image": url, "channel": "a" }, "mode": "mask" });
    let masked = |x: f64, y: f64| {
        let materials = json!({ "it": { "pbr": { "unlit": true, "opacity": alpha } } });
        let mut objects = square(0.0, "it");
        objects["mesh"].as_object_mut().unwrap().remove("colors");
        pixels(in_front_of(x, y, materials, json!([objects])), "single")[0][0]
    };
    assert_eq!([masked(-0.5, 0.5), masked(0.5, 0.5), masked(0.5, -0.5)], [1.0, 0.0, 1.0]);
}

#[test]
fn colors_of_vertices_multiply_the_base_color_and_alpha() {
    let materials = json!({
        "it": { "pbr": { "unlit": true, "base_color": [0.5, 1, 1], "opacity": {} } },
        "behind": { "pbr": { "unlit": true, "base_color": [0, 0, 1] } }
    });
    for (x, y) in [(0.0, 0.0), (0.5, -0.25), (-0.75, 0.5)] {
        let (green, alpha) = (0.5 + 0.5 * y, 0.75 - 0.25 * x);
        let scene = in_front_of(x, y, materials.clone(), json!([square(0.0, "it"), quad(-1.0, "behind")]));
        shows(&scene, [0.5 * alpha, green * alpha, 1.0 - alpha], 1e-3, &format!("{x} {y}"));
    }
}

#[test]
fn occlusion_dims_light_from_around_and_no_lamp() {
    let url = in_url(&RgbaImage::from_fn(2, 1, |x, _| Rgba([if x == 0 { 51 } else { 52 }, 0, 0, 255])));
    let dark = 51.0 / 255.0;
    let material =
        json!({ "it": { "pbr": { "metallic": 0, "occlusion": { "image": url, "factor": 0.5, "wrap": "clamp" } } } });
    let mut mesh = square(0.0, "it");
    mesh["mesh"].as_object_mut().unwrap().remove("colors");
    let mut scene = in_front_of(-0.9, 0.0, material, json!([mesh]));
    scene["ambient"] = json!(1);
    let seen = 1.0 + 0.5 * (dark - 1.0);
    shows(&scene, [seen; 3], 1e-5, "ambient");
}
