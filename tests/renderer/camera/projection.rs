//! Where a point of the scene is seen: the inverse of the rays that cameras make.

use glam::DVec3;
use proptest::prelude::*;
use strahl::camera::{Basis, Camera, Primary, Window};
use strahl::lanes::{Lanes, Mask, Real};
use strahl::scene::compile::camera_of;
use strahl::scene::description::Camera as Described;

const SIZE: [u32; 2] = [48, 32];

/// One of each kind, and the angles that are special.
fn cameras() -> Vec<Described> {
    let place = r#""eye": [1, 2, 3], "look_at": [8, 1, 2], "up": [0.2, 1, 0.1]"#;
    let kinds = [
        r#""pinhole": { PLACE, "vfov_deg": 60 }"#,
        r#""pinhole": { PLACE, "vfov_deg": 20, "aperture": 0.5 }"#,
        r#""orthographic": { PLACE, "height": 7 }"#,
        r#""fisheye": { PLACE, "fov_deg": 180 }"#,
        r#""fisheye": { PLACE, "fov_deg": 360 }"#,
        r#""omnimax": { PLACE, "fov_deg": 165 }"#,
        r#""panorama": { PLACE }"#,
        r#""panorama": { PLACE, "hfov_deg": 100, "vfov_deg": 50 }"#,
        r#""cylinder": { PLACE, "hfov_deg": 270 }"#,
    ];
    let read = |kind: &str| serde_json::from_str(&format!("{{ {} }}", kind.replace("PLACE", place))).unwrap();
    kinds.into_iter().map(read).collect()
}

fn wide<L: Lanes>(v: strahl::lanes::V3<L>) -> DVec3 {
    DVec3::from_array(v.lane(0).map(Real::to_f64))
}

/// How many pixels away from (x, y) the points of its ray are seen.
fn off<L>(described: &Described, window: &Window, [x, y]: [f64; 2], t: f64) -> Option<f64>
where
    L: Lanes<Simd = ()>,
{
    let basis = Basis::new(&described.view()).unwrap();
    let camera: Camera<L::Real> = camera_of(described, &basis, SIZE[0], SIZE[1]).through(window);
    let narrow = |x: f64| L::splat((), L::Real::from_f64(x));
    let ray: Primary<L> = camera.primary((), narrow(x), narrow(y));
    if !ray.seen.any() {
        return None;
    }
    let seen = camera.project(wide(ray.origin) + wide(ray.dir) * t).unwrap_or([f64::NAN; 2]);
    Some(strahl::math::hypot(seen[0] - x, seen[1] - y))
}

proptest! {
    #[test]
    fn a_point_of_a_ray_is_seen_at_its_pixel(
        x in 0.01..47.99_f64, y in 0.01..31.99_f64, t in 0.01..1e4_f64, level in 0..2_u8,
    ) {
        let whole = Window::whole(SIZE[0], SIZE[1]);
        let window = if level == 0 { whole } else { Window { origin: [3.0, 5.0], step: [0.5, 0.25], ..whole } };
        // Rays know their pixel as exactly as the numbers of their precision do, near to the eye as exactly as the eye.
        for camera in cameras() {
            // A full circle's border is one point: directly behind the eye.
            let (x, y) = (x.clamp(1.0, 47.0), y.clamp(1.0, 31.0));
            if let Some(off) = off::<f64>(&camera, &window, [x, y], t) {
                prop_assert!(off < 1e-6, "{} in double: {off}", camera.kind());
            }
            if let Some(off) = off::<f32>(&camera, &window, [x, y], t) {
                prop_assert!(off < 0.01, "{} in single: {off}", camera.kind());
            }
        }
    }
}

#[test]
fn what_lies_behind_is_seen_only_where_the_picture_goes_around() {
    let seen: Vec<bool> = cameras()
        .iter()
        .map(|described| {
            let basis = Basis::new(&described.view()).unwrap();
            let camera: Camera<f64> = camera_of(described, &basis, SIZE[0], SIZE[1]);
            camera.project(basis.eye - basis.forward * 3.0 + basis.right).is_some()
        })
        .collect();
    assert_eq!(seen, [false, false, false, false, true, false, true, true, true]);
}

#[test]
fn segments_are_cut_at_the_eye() {
    let described = &cameras()[0];
    let basis = Basis::new(&described.view()).unwrap();
    let camera: Camera<f64> = camera_of(described, &basis, SIZE[0], SIZE[1]);
    let at = |depth: f64| basis.eye + basis.forward * depth + basis.right;
    let [a, b] = camera.clip([at(-4.0), at(6.0)]).unwrap();
    assert!((a - at(6e-6)).length() < 1e-9 && b == at(6.0), "{a} {b}");
    assert_eq!(camera.clip([at(2.0), at(6.0)]), Some([at(2.0), at(6.0)]));
    assert_eq!(camera.clip([at(-4.0), at(-1.0)]), None);
}
