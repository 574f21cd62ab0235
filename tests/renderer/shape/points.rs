//! Where rays meet floors that are far larger than what stands on them.

use crate::common::floors::{KINDS, floor, point_errors, with_material};
use crate::common::render_whole;
use serde_json::json;
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, load};

#[test]
fn points_on_large_triangles_are_as_good_as_those_on_planes() {
    let mut wrong = Vec::new();
    for size in [3.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6] {
        for (kind, level) in KINDS.map(|kind| [(kind, true), (kind, false)]).as_flattened().iter().copied() {
            let errors = point_errors(kind, size, level, Precision::Single, 2_000);
            if errors.worst.is_nan() || errors.worst > 4.0 {
                wrong.push(format!("{kind} of {size:e}, level {level}: {:.1} u (distance + 1)", errors.worst));
            }
        }
    }
    for kind in ["plane", "disc"] {
        let errors = point_errors(kind, 1e6, true, Precision::Single, 2_000);
        assert!(errors.worst <= 4.0, "{kind}: {:.1}", errors.worst);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A checkerboard of squares of 0.5, up to 10 away.
fn checkerboard(kind: &str, size: f64, precision: Precision) -> Vec<[f32; 3]> {
    let scene = json!({
        "version": 1, "image": { "width": 160, "height": 100 }, "lights": [], "ambient": 1,
        "camera": { "pinhole": { "eye": [0.3, 1.5, 4], "look_at": [0.1, 0, 2], "vfov_deg": 50 } },
        "materials": { "board": { "diffuse": { "checker": { "a": 1, "b": 0, "size": 0.5, "axes": "xz" } } } },
        "objects": [with_material(floor(kind, size, true).object, "board")],
        "render": { "antialias": false, "filter_checkers": false }
    });
    let overrides = Overrides { precision: Some(precision), ..Overrides::default() };
    let loaded = load(scene.to_string().as_bytes(), Format::Json, &overrides).unwrap_or_else(|p| panic!("{p}"));
    render_whole(&loaded).pixels
}

#[test]
fn checkers_on_large_floors_are_those_of_a_plane() {
    let exact = checkerboard("plane", 1.0, Precision::Double);
    let wrong = |kind: &str, size: f64| {
        let picture = checkerboard(kind, size, Precision::Single);
        picture.iter().zip(&exact).filter(|(a, b)| (a[0] - b[0]).abs() > 0.1).count()
    };
    let of_a_plane = wrong("plane", 1.0);
    for size in [30.0, 1e3, 1e5, 1e6] {
        for kind in KINDS {
            let wrong = wrong(kind, size);
            assert!(wrong <= of_a_plane, "{kind} of {size:e}: {wrong} of {} pixels, plane {of_a_plane}", exact.len());
        }
    }
}
