//! Where cameras look.

use super::*;
use strahl::inspect::first_hits::first_hits;

/// First rays of pixels of a picture of 4 x 2 pixels, in single and double.
fn first_rays(camera: Value, x: u32, y: u32) -> Vec<(Node, f64)> {
    // Antialiasing would have other first rays at the edge of a circle.
    let render = json!({ "antialias": false });
    let more = json!({ "camera": camera, "image": { "width": 4, "height": 2 }, "background": 1, "render": render });
    let objects = json!([{ "sphere": { "center": [0, 0, 1e6], "radius": 1 } }]);
    let first = |tree: Tree| tree.rays[0].clone();
    worlds(objects, more).iter().map(|w| (first(trace_pixel(&w.scene, x, y)), w.small)).collect()
}

#[track_caller]
fn looks(camera: &Value, [x, y]: [u32; 2], origin: [f64; 3], direction: [f64; 3]) {
    for (ray, small) in first_rays(camera.clone(), x, y) {
        assert_vector(ray.origin, origin, small * 4.0);
        assert_vector(ray.direction, DVec3::from(direction).normalize().into(), small);
    }
}

#[track_caller]
fn sees_nothing(camera: &Value, [x, y]: [u32; 2]) {
    for (ray, _) in first_rays(camera.clone(), x, y) {
        assert_eq!((ray.direction, ray.contribution), ([0.0; 3], [0.0; 3]));
    }
}

/// From (1, 2, 3) along x with z up: right is -y.
fn aside(kind: &str, more: Value) -> Value {
    let mut camera = json!({ "eye": [1, 2, 3], "look_at": [8, 2, 3], "up": [1, 0, 2] });
    camera.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    json!({ kind: camera })
}

const EYE: [f64; 3] = [1.0, 2.0, 3.0];

/// Forward, right and up parts of a direction of [`aside`].
fn toward(forward: f64, right: f64, up: f64) -> [f64; 3] {
    [forward, -right, up]
}

#[test]
fn pinhole() {
    let camera = aside("pinhole", json!({ "vfov_deg": 90 }));
    looks(&camera, [0, 0], EYE, toward(1.0, -1.5, 0.5));
    looks(&camera, [3, 0], EYE, toward(1.0, 1.5, 0.5));
    looks(&camera, [0, 1], EYE, toward(1.0, -1.5, -0.5));
    looks(&camera, [3, 1], EYE, toward(1.0, 1.5, -0.5));
    looks(&camera, [2, 1], EYE, toward(1.0, 0.5, -0.5));
}

#[test]
fn orthographic() {
    let camera = aside("orthographic", json!({ "height": 4 }));
    for (pixel, [right, up]) in [
        ([0, 0], [-3.0, 1.0]),
        ([3, 0], [3.0, 1.0]),
        ([0, 1], [-3.0, -1.0]),
        ([3, 1], [3.0, -1.0]),
        ([2, 1], [1.0, -1.0]),
    ] {
        looks(&camera, pixel, [1.0, 2.0 - right, 3.0 + up], X);
    }
}

/// `r` of half the angle, in the direction (right, up).
fn equidistant(r: f64, half_angle: f64, right: f64, up: f64) -> [f64; 3] {
    let (sin, cos) = (r * half_angle.to_radians()).sin_cos();
    let length = right.hypot(up);
    toward(cos, sin * right / length, sin * up / length)
}

#[test]
fn fisheye() {
    // The circle touches the upper and the lower edge.
    for angle in [180.0, 360.0] {
        let camera = aside("fisheye", json!({ "fov_deg": angle }));
        let r = 0.5f64.sqrt();
        looks(&camera, [1, 0], EYE, equidistant(r, angle / 2.0, -1.0, 1.0));
        looks(&camera, [2, 0], EYE, equidistant(r, angle / 2.0, 1.0, 1.0));
        looks(&camera, [1, 1], EYE, equidistant(r, angle / 2.0, -1.0, -1.0));
        looks(&camera, [2, 1], EYE, equidistant(r, angle / 2.0, 1.0, -1.0));
        for corner in [[0, 0], [3, 0], [0, 1], [3, 1]] {
            sees_nothing(&camera, corner);
        }
    }
}

#[test]
fn omnimax() {
    // The circle is as wide as the picture and twice as high: its lower half is cut off.
    let camera = aside("omnimax", json!({ "fov_deg": 180 }));
    looks(&camera, [1, 0], EYE, equidistant(0.25f64.hypot(0.75), 90.0, -1.0, 3.0));
    looks(&camera, [2, 0], EYE, equidistant(0.25f64.hypot(0.75), 90.0, 1.0, 3.0));
    looks(&camera, [0, 1], EYE, equidistant(0.75f64.hypot(0.25), 90.0, -3.0, 1.0));
    looks(&camera, [3, 1], EYE, equidistant(0.75f64.hypot(0.25), 90.0, 3.0, 1.0));
    looks(&camera, [2, 1], EYE, equidistant(0.25f64.hypot(0.25), 90.0, 1.0, 1.0));
    sees_nothing(&camera, [0, 0]);
    sees_nothing(&camera, [3, 0]);
}

#[test]
fn panorama() {
    let camera = aside("panorama", json!({}));
    let h = 0.5f64.sqrt();
    looks(&camera, [0, 0], EYE, toward(-0.5, -0.5, h));
    looks(&camera, [1, 0], EYE, toward(0.5, -0.5, h));
    looks(&camera, [3, 0], EYE, toward(-0.5, 0.5, h));
    looks(&camera, [0, 1], EYE, toward(-0.5, -0.5, -h));
    looks(&camera, [2, 1], EYE, toward(0.5, 0.5, -h));
    looks(&camera, [3, 1], EYE, toward(-0.5, 0.5, -h));
    let narrow = aside("panorama", json!({ "hfov_deg": 80, "vfov_deg": 40 }));
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let (sin_up, cos_up) = 10f64.to_radians().sin_cos();
    looks(&narrow, [3, 0], EYE, toward(cos * cos_up, sin * cos_up, sin_up));
}

#[test]
fn cylinder() {
    let camera = aside("cylinder", json!({ "hfov_deg": 240, "vfov_deg": 90 }));
    for (x, degrees) in [(0, -90.0f64), (1, -30.0), (2, 30.0), (3, 90.0)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        looks(&camera, [x, 0], EYE, toward(cos, sin, 0.5));
        looks(&camera, [x, 1], EYE, toward(cos, sin, -0.5));
    }
}

#[test]
fn an_eye_on_a_face_does_not_see_it() {
    let eye = [1.0, 0.5, 0.5];
    let (a, b, c) = ([2, 0, 0], [0, 2, 0], [0, 0, 2]);
    let on_plane = [
        json!({ "triangle": { "vertices": [a, b, c] } }),
        json!({ "quad": { "vertices": [a, b, [-2, 2, 2], c] } }),
        json!({ "polygon": { "vertices": [a, b, [-2, 2, 2], c] } }),
        json!({ "mesh": { "vertices": [a, b, c, [-2, 2, 2]], "faces": [[0, 1, 2], [2, 1, 3]] } }),
        // From its wall outwards.
        json!({ "cylinder": { "base": [1, -3, -1], "top": [1, 3, -1], "radius": 1.5 } }),
    ];
    let mut random = uniform(7);
    for object in on_plane {
        let outwards = object.get("cylinder").is_some();
        let camera = json!({ "pinhole": { "eye": eye, "look_at": [1.3, 0.6, 2.5], "vfov_deg": if outwards { 60 } else { 120 } } });
        let more = json!({ "camera": camera, "image": { "width": 24, "height": 24 }, "background": 0.25 });
        for World { scene, .. } in &worlds(json!([object]), more) {
            let picture = render(scene, Region::whole(24, 24), &Control::default()).unwrap();
            let seen = picture.film.pixels.iter().filter(|pixel| **pixel != [0.25; 3]).count();
            assert_eq!((seen, picture.rays.camera_hits), (0, 0), "{object}");
            for _ in 0..1_000 {
                let direction =
                    [random() - 0.5, random() - 0.5, if outwards { 1.0 + random() } else { random() - 0.5 }];
                let found = answer(scene, &ray(eye, direction)).at;
                assert!(found.is_none(), "{object} along {direction:?}: {found:?}");
            }
        }
    }
}

#[test]
fn an_eye_on_a_wall_sees_the_wall_around_it() {
    for at in [0.0, 1e3, 1e4] {
        let cylinder = json!({ "cylinder": { "base": [at, -1, 0], "top": [at, 1, 0], "radius": 1, "capped": false } });
        for World { scene, .. } in &bodies(json!([cylinder])) {
            // From the wall at an angle a with its tangent the wall is met again after 2 sin a.
            for a in [1e-3, 3e-3, 1e-2, 3e-2, 0.3, 1.5] {
                let (sin, cos) = f64::sin_cos(a);
                let found = answer(scene, &ray([at - 1.0, 0.0, 0.0], [sin, 0.0, cos])).at;
                let t = found.unwrap_or_else(|| panic!("no wall at {at}, {a}")).t;
                assert!((t / (2.0 * sin) - 1.0).abs() < 0.1, "{t} at {at}, {a}");
            }
        }
    }
}

/// What a ray answers does not depend on the rays beside it.
#[test]
fn rays_from_a_face_are_told_apart_from_rays_that_begin_behind_it() {
    let quad = json!({ "quad": { "vertices": [[2, 0, 0], [0, 2, 0], [-2, 2, 2], [0, 0, 2]] } });
    let behind = json!({ "plane": { "point": [0, 0, -5], "normal": [0, 0, 1] } });
    for World { scene, .. } in &bodies(json!([quad, behind])) {
        let mut random = uniform(3);
        let rays: Vec<RayQuery> = (0..64)
            .map(|i| {
                let along = ray([1.0, 0.5, 0.5], [random() - 0.5, random() - 0.5, -random()]);
                RayQuery { t_min: if i % 3 == 0 { 1e-3 } else { 0.0 }, ..along }
            })
            .collect();
        for (ray, hit) in rays.iter().zip(first_hits(scene, &rays)) {
            let plane = 5.5 / -ray.direction[2];
            assert_near(hit.expect("the plane").t, plane, 1e-4 * plane);
            assert_near(answer(scene, ray).at.expect("the plane").t, plane, 1e-4 * plane);
        }
    }
}
