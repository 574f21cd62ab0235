//! The tracing kernel on whole pictures.

use crate::time;
use strahl::film::Region;
use strahl::render::{Control, render};
use strahl::scene::description::Precision;
use strahl::scene::{Format, Overrides, load};

pub(crate) fn pictures() {
    let one_sample = Overrides { antialias: Some(false), ..Overrides::default() };
    for (name, overrides) in [
        ("whitted/whitted", one_sample),
        ("whitted/whitted", Overrides { precision: Some(Precision::Double), ..one_sample }),
        ("mirrors/hall", one_sample),
        ("meshes/knot", one_sample),
        ("spheres/flake_4", Overrides { width: Some(256), height: Some(256), ..one_sample }),
        ("spheres/flake_9", Overrides { width: Some(128), height: Some(128), ..one_sample }),
    ] {
        let path = format!("{}/scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let scene = load(&std::fs::read(path).unwrap(), Format::Json, &overrides).unwrap().scene;
        let precision = if overrides.precision.is_some() { "double" } else { "single" };
        let whole = Region::whole(scene.width, scene.height);
        time(&format!("trace {name}, {precision}"), || (), |()| render(&scene, whole, &Control::default()));
    }
}
