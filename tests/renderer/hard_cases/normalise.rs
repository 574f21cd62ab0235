//! N: unit vectors, bases and cameras.

use super::Case;
use super::evidence::Evidence;
use super::lab::{Lab, ask, ball, description, hit, picture, rows, square, truth, vector};
use super::textbook::cameras;
use crate::common::Random;
use crate::common::naive;
use glam::DVec3;
use serde_json::{Value, json};
use strahl::camera::Basis;
use strahl::lanes::{Lanes, Mask, Real};
use strahl::scene::compile::camera_of;
use strahl::scene::description;

pub const CASES: &[Case] = &[
    ("N01", extremes),
    ("N02", bases),
    ("N03", parallel_up),
    ("N04", angles),
    ("N05", fisheye),
    ("N06", panorama),
    ("N07", symmetry),
];

fn extremes(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "normalize_extreme", &[]);
    for row in rows("normalize_extreme") {
        let v = vector(&row["in"]["v"]);
        // The same lengths for double precision: powers of ten times as far out.
        let v = if lab.is_double() && v.length() > 1e20 {
            v * 1e250
        } else if lab.is_double() {
            v * 1e-200
        } else {
            v
        };
        let unit = naive::normalize(lab, v);
        e.twin(!((unit.length() - 1.0).abs() < 3.0 * lab.u));
    }
    e
}

fn bases(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(8.0, "u of the radius, about axes near -z");
    let mut random = Random::new(40);
    let mut axes =
        vec![DVec3::Z, -DVec3::Z, DVec3::new(0.0, -0.0, -1.0), DVec3::new(1.0, 0.0, -0.0), DVec3::new(1.0, 0.0, 0.0)];
    for k in 1..40 {
        let s = 2f64.powi(-k);
        axes.push(DVec3::new(s, s * 0.5, -1.0));
        axes.push(super::lab::direction(&mut random));
    }
    for axis in axes {
        let axis = axis.normalize();
        let object = json!([{ "cylinder": { "base": (-axis).to_array(), "top": axis.to_array(), "radius": 1, "capped": false } }]);
        let scene = lab.scene(object, json!({}));
        for _ in 0..50 {
            let d = lab.round3(super::lab::direction(&mut random));
            if let Some(found) = hit(&scene, DVec3::ZERO, d) {
                let p = DVec3::from_array(found.point);
                e.measure((p.cross(axis).length() - 1.0).abs() / lab.u);
            }
        }
        // Frisvad's basis, u = (1 - x^2/(1+z), -xy/(1+z), -x), v = (-xy/(1+z), 1 - y^2/(1+z), -y), in the format.
        let [x, y, z] = lab.round3(axis).to_array();
        let a = lab.round(1.0 / lab.round(1.0 + z));
        let b = lab.round(-lab.round(x * y) * a);
        let u = DVec3::new(lab.round(1.0 - lab.round(x * x) * a), b, -x);
        e.twin_measure((u.length() - 1.0).abs() / lab.u);
    }
    e
}

fn parallel_up(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("cameras");
    for look in [DVec3::Y, -DVec3::Y, DVec3::new(0.0, 1e-10, 0.0), DVec3::new(1e-12, 1.0, 0.0)] {
        let camera = json!({ "pinhole": { "eye": [0, 0, 0], "look_at": look.to_array(), "up": [0, 1, 0] } });
        let scene = description(json!([ball([0.0; 3], 1.0, "red")]), json!({ "camera": camera }));
        let refused = lab.load(&scene).err();
        let named = refused.is_some_and(|p| p.0[0].pointer.contains("/camera/pinhole"));
        e.check(named, || format!("looking along {look} is taken"));
        e.twin(naive::normalize(lab, look.cross(DVec3::Y)).is_nan());
    }
    e
}

fn angles(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("angles of view");
    let scene = |camera: Value, image: Value| {
        description(json!([ball([0.0, 0.0, -3.0], 1.0, "red")]), json!({ "camera": camera, "image": image }))
    };
    let pinhole = |degrees: f64| json!({ "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1], "vfov_deg": degrees } });
    for degrees in [0.0, -1.0, 180.0, 360.0] {
        e.check(lab.load(&scene(pinhole(degrees), square(3))).is_err(), || format!("{degrees} is taken"));
        // Whatever the tangent says: all rows look the same way, or the picture stands on its head.
        let [low, high] = [0.25, 0.75].map(|y| cameras::pinhole(lab, degrees, 0.0, y).y);
        e.twin(!(high - low > 4.0 * lab.u));
    }
    for degrees in [1e-6, 0.01, 90.0, 179.0, 179.999_999] {
        for image in [square(5), json!({ "width": 301, "height": 1 }), json!({ "width": 1, "height": 301 })] {
            let film = picture(&lab.load(&scene(pinhole(degrees), image)).unwrap_or_else(|p| panic!("{p}")).scene).film;
            e.check(film.pixels.iter().flatten().all(|c| c.is_finite()), || {
                format!("{degrees}: a pixel is not finite")
            });
            let middle = film.pixels[film.pixels.len() / 2];
            e.check(middle == [1.0, 0.0, 0.0], || format!("{degrees}: the middle shows {middle:?}"));
        }
    }
    e
}

/// Unit direction and visibility at a point of a picture of one pixel's height and width.
fn view(lab: &Lab, camera: &Value, size: (u32, u32), x: f64, y: f64) -> (DVec3, bool) {
    fn at<L: Lanes<Simd = ()>>(camera: &description::Camera, size: (u32, u32), x: f64, y: f64) -> (DVec3, bool) {
        let basis = Basis::new(&camera.view()).unwrap();
        let primary =
            camera_of::<L::Real>(camera, &basis, size.0, size.1).primary::<L>((), L::lit((), x), L::lit((), y));
        (DVec3::from_array(primary.dir.lane(0).map(Real::to_f64)), primary.seen.any())
    }
    let camera: description::Camera = serde_json::from_value(camera.clone()).unwrap();
    if lab.is_double() { at::<f64>(&camera, size, x, y) } else { at::<f32>(&camera, size, x, y) }
}

fn fisheye(lab: &Lab) -> Evidence {
    let mut e = truth();
    ask(lab, &mut e, "fisheye_directions", &[]);
    for kind in ["fisheye", "omnimax"] {
        for degrees in [1.0, 180.0, 360.0] {
            let camera = json!({ kind: { "eye": [0, 0, 0], "look_at": [0, 0, -1], "fov_deg": degrees } });
            let (middle, seen) = view(lab, &camera, (64, 64), 32.0, 32.0);
            e.check(seen && middle == -DVec3::Z, || format!("{kind}: the middle looks along {middle}"));
        }
    }
    for row in rows("fisheye_directions") {
        let [x, y] = ["ndc_x", "ndc_y"].map(|key| row["in"][key].as_f64().unwrap());
        if row["expect"]["inside_image_circle"] == true {
            let expected = vector(&row["expect"]["unit_direction_right_up_forward"]["fov180"]);
            let d = cameras::fisheye(lab, 180.0, x, y) * DVec3::new(1.0, 1.0, -1.0);
            e.twin(!(d.distance(expected) <= 16.0 * lab.u));
        }
    }
    e
}

fn panorama(lab: &Lab) -> Evidence {
    let mut e = Evidence::measuring(16.0, "u between the two ends of the seam, and of the length");
    let camera = json!({ "panorama": { "eye": [0, 0, 0], "look_at": [0, 0, -1] } });
    let size = (64, 32);
    for k in 0..=32 {
        let y = f64::from(k);
        let [(left, a), (right, b)] = [0.0, 64.0].map(|x| view(lab, &camera, size, x, y));
        e.check(a && b, || format!("row {k} is not seen"));
        e.measure(left.distance(right) / lab.u);
        for x in 0..=64 {
            e.measure((view(lab, &camera, size, f64::from(x), y).0.length() - 1.0).abs() / lab.u);
        }
    }
    for (y, up) in [(0.0, DVec3::Y), (32.0, -DVec3::Y)] {
        let pole = view(lab, &camera, size, 20.0, y).0;
        e.measure(pole.distance(up) / lab.u);
    }
    // There and back by the arc functions, near the poles.
    let mut random = Random::new(42);
    for k in 0..400 {
        let lean = 2f64.powi(-(k % 20)) * 0.5;
        let [x, z, _] = random.point(lean);
        let d = lab.round3(DVec3::new(x, if k % 2 == 0 { 1.0 } else { -1.0 }, z).normalize());
        e.twin_measure(cameras::panorama_and_back(lab, d).distance(d) / lab.u);
    }
    e
}

fn symmetry(lab: &Lab) -> Evidence {
    let mut e = Evidence::counting("pixels and their mirror images");
    let (width, height) = (54, 38);
    let mut random = Random::new(41);
    let mut sides = [Vec::new(), Vec::new()];
    for _ in 0..12 {
        let p = random.point(2.0);
        let size = random.between(0.2, 0.7);
        let material = ["red", "glass", "mirror", "matt"][random.below(4)];
        for (objects, sign) in sides.iter_mut().zip([1.0, -1.0]) {
            objects.push(ball([p[0] * sign, p[1], p[2]], size, material));
        }
    }
    let films = sides.map(|objects| {
        let more = json!({
            "image": { "width": width, "height": height }, "background": [0.2, 0.4, 0.6],
            "lights": [{ "point": { "position": [0, 9, 5] } }],
            "camera": { "pinhole": { "eye": [0, 0.5, 7], "look_at": [0, 0.25, 0] } }
        });
        lab.picture(json!(objects), more).film.pixels
    });
    for (i, pixel) in films[0].iter().enumerate() {
        let (x, y) = (i % width, i / width);
        e.check(*pixel == films[1][y * width + width - 1 - x], || format!("pixel {x} {y}"));
        let ndc = |x: usize| lab.round(lab.round(2.0 * lab.round((x as f64 + 0.5) / width as f64)) - 1.0);
        e.twin(ndc(x) != -ndc(width - 1 - x));
    }
    e
}
