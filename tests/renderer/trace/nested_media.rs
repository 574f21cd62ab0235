//! Bodies that nest, overlap and touch: which index of refraction decides where.

use serde_json::{Value, json};
use strahl::inspect::tree::{Node, NodeKind, trace_pixel};
use strahl::scene::{Format, Overrides, load};

/// One pixel whose ray runs along +x from x = -5 through the objects; each material's name is its index of refraction.
fn ray_along_x(objects: Value, precision: &str, height: f64) -> Vec<Node> {
    let clear = |ior: f64| json!({ "diffuse": 0, "transmission": 1, "ior": ior });
    let scene = json!({
        "version": 1,
        "image": { "width": 1, "height": 1 },
        "camera": { "orthographic": { "eye": [-5, height, 0.013], "look_at": [5, height, 0.013], "height": 0.001 } },
        "background": 1,
        "lights": [],
        "materials": { "1.5": clear(1.5), "1.33": clear(1.33), "2.4": clear(2.4), "opaque": { "diffuse": 0.5 } },
        "objects": objects,
        "render": { "max_depth": 30, "antialias": false, "precision": precision }
    });
    let loaded = load(&serde_json::to_vec(&scene).unwrap(), Format::Json, &Overrides::default()).unwrap();
    trace_pixel(&loaded.scene, 0, 0).rays
}

/// n1 and n2 of each surface the ray passes, in hundredths.
fn indices(objects: Value, height: f64) -> Vec<[i32; 2]> {
    let of = |precision: &str| -> Vec<[i32; 2]> {
        let hundredths = |n: f64| (n * 100.0).round() as i32;
        let rays = ray_along_x(objects.clone(), precision, height);
        rays.iter().filter_map(|ray| ray.snell).map(|s| [hundredths(s.n1), hundredths(s.n2)]).collect()
    };
    let single = of("single");
    assert_eq!(single, of("double"));
    single
}

fn cuboid(from: f64, to: f64, material: &str) -> Value {
    json!({ "box": { "min": [from, -1, -1], "max": [to, 1, 1], "material": material } })
}

#[test]
fn nested_bodies_need_no_order() {
    let (outer, inner) = (cuboid(-2.0, 2.0, "1.33"), cuboid(-1.0, 1.0, "1.5"));
    let expected = [[100, 133], [133, 150], [150, 133], [133, 100]];
    assert_eq!(indices(json!([outer, inner]), 0.1), expected);
    assert_eq!(indices(json!([inner, outer]), 0.1), expected);
}

#[test]
fn where_bodies_overlap_the_smaller_one_decides_from_both_sides() {
    let (large, small) = (cuboid(-2.0, 0.5, "1.5"), cuboid(0.0, 1.0, "1.33"));
    // Into the small one at 0; leaving the large one at 0.5 is not noticed.
    assert_eq!(indices(json!([large, small]), 0.1), [[100, 150], [150, 133], [133, 133], [133, 100]]);
    let (large, small) = (cuboid(-0.5, 2.0, "1.5"), cuboid(-1.0, 0.0, "1.33"));
    assert_eq!(indices(json!([large, small]), 0.1), [[100, 133], [133, 133], [133, 150], [150, 100]]);
}

#[test]
fn touching_bodies_have_one_interface() {
    let expected = [[100, 150], [150, 133], [133, 100]];
    for place in [0.0, 0.1, 1.0 / 3.0, 0.7] {
        let pair = json!([cuboid(-1.0, place, "1.5"), cuboid(place, 1.0, "1.33")]);
        assert_eq!(indices(pair.clone(), 0.1), expected, "{place}");
        let swapped = json!([pair[1], pair[0]]);
        assert_eq!(indices(swapped, 0.1), expected, "{place}");
    }
}

#[test]
fn a_stack_of_equal_plates_is_one_plate() {
    let plates: Vec<Value> = (0..20).map(|i| cuboid(0.05 * f64::from(i), 0.05 * f64::from(i + 1), "1.5")).collect();
    let passed = indices(json!(plates), 0.1);
    assert_eq!(passed.first(), Some(&[100, 150]));
    assert_eq!(passed.last(), Some(&[150, 100]));
    assert!(passed[1..passed.len() - 1].iter().all(|n| *n == [150, 150]), "{passed:?}");
}

#[test]
fn liquid_may_fill_its_glass_to_the_wall() {
    let cylinder = |radius: f64, top: f64, material: &str, hollow: bool| json!({ "cylinder": { "base": [0, -1, 0], "top": [0, top, 0], "radius": radius, "material": material, "hollow": hollow } });
    let expected = [[100, 150], [150, 133], [133, 150], [150, 100]];
    for liquid in [0.8, 0.8 + 1e-3, 0.8 + 1e-5] {
        let glass =
            [cylinder(1.0, 1.0, "1.5", false), cylinder(0.8, 1.1, "1.5", true), cylinder(liquid, 0.5, "1.33", false)];
        let mut passed = indices(json!(glass), 0.1);
        // Overlap adds the cavity's own surface, inside the liquid, where nothing bends.
        passed.retain(|[n1, n2]| n1 != n2);
        assert_eq!(passed, expected, "liquid of radius {liquid}");
        let mut passed = indices(json!([glass[2], glass[0], glass[1]]), 0.1);
        passed.retain(|[n1, n2]| n1 != n2);
        assert_eq!(passed, expected, "liquid of radius {liquid}, written first");
    }
}

#[test]
fn an_opaque_surface_in_the_same_place_hides_the_glass() {
    for (wall, glass) in [(1.0, 1.0), (0.3, 0.3), (0.7, 0.7)] {
        let floor = json!({ "quad": { "vertices": [[wall, -50, -50], [wall, 50, -50], [wall, 50, 50], [wall, -50, 50]], "material": "opaque", "name": "wall" } });
        let block = cuboid(0.0, glass, "1.5");
        for objects in [json!([floor, block]), json!([block, floor])] {
            for precision in ["single", "double"] {
                for step in 0..40 {
                    let rays = ray_along_x(objects.clone(), precision, -0.9 + 0.045 * f64::from(step));
                    let last = rays.iter().rfind(|ray| ray.kind != NodeKind::Shadow).unwrap();
                    assert_eq!(last.hit.as_ref().unwrap().name.as_deref(), Some("wall"), "{precision}, step {step}");
                    assert_eq!(last.media.len(), 1, "the ray is in the block");
                }
            }
        }
    }
}

#[test]
fn a_narrow_gap_stays_a_gap() {
    for gap in [1e-2, 1e-4] {
        let pair = json!([cuboid(-1.0, 0.0, "1.5"), cuboid(gap, 1.0, "1.33")]);
        assert_eq!(indices(pair, 0.1), [[100, 150], [150, 100], [100, 133], [133, 100]], "{gap}");
    }
}
