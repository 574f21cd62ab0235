//! From scene text to a compiled scene, and hierarchies alone.

use crate::time;
use std::sync::Arc;
use strahl::accel::{BvhKind, Geometry, Item, Mesh, Shape};
use strahl::math::sin_cos;
use strahl::scene::compile::compile;
use strahl::scene::{Format, Overrides, load};
use strahl::shape::Sides;

pub(crate) fn scenes() {
    for name in ["meshes/knot", "spheres/flake_9"] {
        let path = format!("{}/scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read(path).unwrap();
        let description = load(&text, Format::Json, &Overrides::default()).unwrap().description;
        time(&format!("compile {name}"), || (), |()| compile(&description));
        time(&format!("load {name}"), || (), |()| load(&text, Format::Json, &Overrides::default()));
    }
}

/// A wavy sheet of 2 n^2 triangles.
fn sheet(n: u32) -> Item<f32> {
    let wave = |x: f32| sin_cos(f64::from(x)).0 as f32;
    let height = |x: f32, y: f32| 0.1 * wave(20.0 * x) * wave(30.0 * y);
    let vertex = |i: u32| {
        let [x, y] = [i % (n + 1), i / (n + 1)].map(|k| k as f32 / n as f32);
        [x, y, height(x, y)]
    };
    let square = |i: u32| {
        let a = i / n * (n + 1) + i % n;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    Item {
        shape: Shape::Mesh(Arc::new(Mesh {
            vertices: (0..(n + 1) * (n + 1)).map(vertex).collect(),
            faces: Arc::new((0..n * n).flat_map(square).collect()),
            normals: Vec::new(),
            uvs: Vec::new(),
            attributes: None,
        })),
        material: 0,
        sides: Sides::Both,
        hollow: false,
        closed: true,
        may_touch: false,
        has_holes: false,
        volume: 0.0,
        transmission: [0.0; 3],
        source: 0,
        offset: 0,
        expanded: u64::from(2 * n * n),
    }
}

pub(crate) fn hierarchies() {
    for n in [70, 224] {
        let item = sheet(n);
        let name = format!("hierarchy of {} triangles", item.expanded);
        time(&name, || vec![item.clone()], |items| Geometry::new(items, &[None], BvhKind::Sah));
    }
}
