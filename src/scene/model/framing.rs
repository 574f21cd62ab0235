//! Where the camera stands: as near as possible with every vertex inside of the picture and air around it.
//!
//! A vertex is inside if it is on the inner side of four planes through the eye. Each plane only shifts as the eye moves along
//! the view, so the extreme vertex in the direction of each decides, and one pass over the vertices finds the place exactly, for
//! any shape of the picture.

use super::placed_meshes::{Extremes, Placed};
use super::view::View;
use crate::math;
use crate::models::{ModelCamera, Projection};
use crate::scene::description::{Camera, OrthographicCamera, PinholeCamera};
use glam::DVec3;
use std::f64::consts::PI;

/// Full vertical angle of view in degrees, as model-viewer has it.
const VERTICAL: f64 = 30.0;
/// The part of the picture that the model may fill: 5 % are left at each edge.
const FILLED: f64 = 0.9;
/// Sides from which a model is looked at that the camera goes around.
const SIDES: u32 = 72;

/// What is to the right, up and back of a camera.
struct Axes {
    right: DVec3,
    up: DVec3,
    back: DVec3,
}

impl Axes {
    fn of(view: View) -> Self {
        let ((sin_theta, cos_theta), (sin_phi, cos_phi)) = (turned(view.theta), turned(view.phi));
        let back = DVec3::new(sin_phi * sin_theta, cos_phi, sin_phi * cos_theta);
        let right = DVec3::new(cos_theta, 0.0, -sin_theta);
        Self { right, up: back.cross(right), back }
    }
}

/// Sine and cosine of an angle in degrees; those of right angles are exact.
fn turned(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => math::sin_cos(degrees * PI / 180.0),
    }
}

/// A camera that sees all of the model around a point, and the middle of it `aside` of the middle of the picture, in halves of its
/// width: by half a pixel in even widths. There the middle lies between two columns, and what is thin and upright, as the pole of a
/// lamp is, would pass between all of their samples.
pub(super) fn framed(model: &Placed<'_>, origin: DVec3, view: View, aspect: f64, aside: f64) -> Camera {
    let Axes { right, up, back } = Axes::of(view);
    let tall = math::tan(VERTICAL / 2.0 * PI / 180.0) * FILLED;
    let wide = tall * aspect;
    // A vertex (x, y, z) is seen from (ex, ey, ez) if x - ex <= wide (ez - z), and so on.
    let Extremes { most, .. } = Extremes::of(
        model,
        origin,
        [right + back * wide, back * wide - right, up + back * tall, back * tall - up, back, -back, right, -right],
        1,
    );
    let [east, west, north, south, near, far, rightmost, leftmost] = most;
    let (x, y) = ((east - west) / 2.0, (north - south) / 2.0);
    let least = ((east + west) / (2.0 * wide)).max((north + south) / (2.0 * tall));
    // A flat model that is seen from its edge has no extent across.
    let extent = (near + far).max(east + west).max(north + south).max(1e-6);
    let distance = least.max(near + 1e-3 * extent);
    // What is seen from its edge stays so.
    let aside = if rightmost + leftmost > 1e-6 * extent { aside } else { 0.0 };
    let axis = origin + right * (x - aside * distance * wide / FILLED) + up * y;
    let (eye, look_at) = (axis + back * distance, axis + back * ((near - far) / 2.0));
    Camera::Pinhole(PinholeCamera {
        up: upright(view, up).to_array(),
        vfov_deg: VERTICAL,
        ..PinholeCamera::looking(eye.to_array(), look_at.to_array())
    })
}

/// A camera that looks at the middle of the model, and sees all of it from each side that a turn around the vertical axis leads to.
pub(super) fn framed_around(model: &Placed<'_>, (low, high): (DVec3, DVec3), view: View, aspect: f64) -> Camera {
    let (middle, extent) = ((low + high) / 2.0, (high - low).max_element());
    let tall = math::tan(VERTICAL / 2.0 * PI / 180.0) * FILLED;
    let wide = tall * aspect;
    let mut distance = 0.0_f64;
    for side in 0..SIDES {
        let theta = view.theta + 360.0 * f64::from(side) / f64::from(SIDES);
        let Axes { right, up, back } = Axes::of(View { theta, ..view });
        let planes = [right / wide + back, back - right / wide, up / tall + back, back - up / tall, back];
        let Extremes { most, .. } = Extremes::of(model, middle, planes, u64::from(SIDES));
        let [sides @ .., near] = most;
        distance = sides.into_iter().fold(distance, f64::max).max(near + 1e-3 * extent);
    }
    let Axes { up, back, .. } = Axes::of(view);
    Camera::Pinhole(PinholeCamera {
        up: upright(view, up).to_array(),
        vfov_deg: VERTICAL,
        ..PinholeCamera::looking((middle + back * distance).to_array(), middle.to_array())
    })
}

/// +y, but where the camera looks along it.
fn upright(view: View, up: DVec3) -> DVec3 {
    if view.phi > 0.01 && view.phi < 179.99 { DVec3::Y } else { up }
}

/// The angle of view of a camera in degrees, as near as scenes take it.
pub(super) fn degrees(vertical: f64) -> f64 {
    (vertical * 180.0 / PI).clamp(0.1, 179.0)
}

/// A camera of the file, for a model around a point.
pub(super) fn of_file(camera: &ModelCamera, model: &Placed<'_>, origin: DVec3) -> Camera {
    let matrix = camera.placed;
    let eye = matrix.w_axis.truncate();
    let back = matrix.transform_vector3(DVec3::Z).try_normalize().unwrap_or(DVec3::Z);
    let up = matrix.transform_vector3(DVec3::Y).try_normalize().unwrap_or(DVec3::Y);
    // What is in focus is as far as the middle of the model.
    let Extremes { most: [near, far], .. } = Extremes::of(model, origin, [back, -back], 1);
    let distance = (back.dot(eye - origin) - (near - far) / 2.0).max(1e-3 * (near + far).max(1e-6));
    let look_at = (eye - back * distance).to_array();
    match camera.projection {
        Projection::Perspective { vertical } => Camera::Pinhole(PinholeCamera {
            up: up.to_array(),
            vfov_deg: degrees(vertical),
            ..PinholeCamera::looking(eye.to_array(), look_at)
        }),
        Projection::Orthographic { height } => {
            Camera::Orthographic(OrthographicCamera { eye: eye.to_array(), look_at, up: up.to_array(), height })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat4;

    fn model(points: &[[f64; 3]]) -> Placed<'_> {
        Placed::points(points)
    }

    fn middle(model: &Placed<'_>) -> DVec3 {
        let (low, high) = model.bounds().unwrap();
        (low + high) / 2.0
    }

    /// Where points are in the picture, from -1 to 1.
    fn seen(camera: &PinholeCamera, aspect: f64, points: &[[f64; 3]]) -> Vec<[f64; 2]> {
        let [eye, look_at, up] = [camera.eye, camera.look_at, camera.up].map(DVec3::from_array);
        let back = (eye - look_at).normalize();
        let right = up.cross(back).normalize();
        let tall = math::tan(camera.vfov_deg / 2.0 * PI / 180.0);
        let place = |point: &[f64; 3]| {
            let way = DVec3::from_array(*point) - eye;
            let depth = -way.dot(back);
            [way.dot(right) / (depth * tall * aspect), way.dot(back.cross(right)) / (depth * tall)]
        };
        points.iter().map(place).collect()
    }

    #[test]
    fn every_vertex_is_inside_and_some_touch_the_margin() {
        let points: Vec<_> =
            (0..40).map(|i| [f64::from(i * 7 % 11), f64::from(i * 5 % 13) * 3.0, f64::from(i % 4)]).collect();
        let model = model(&points);
        let middle = middle(&model);
        for (view, aspect) in
            [("three_quarter", 1.0), ("top", 2.0), ("left", 0.25), ("-77,120", 16.0 / 9.0), ("bottom", 1.0)]
        {
            let Camera::Pinhole(camera) = framed(&model, middle, view.parse().unwrap(), aspect, 0.0) else {
                panic!("a pinhole")
            };
            let seen = seen(&camera, aspect, &points);
            let most = seen.iter().flatten().fold(0.0_f64, |most, at| most.max(at.abs()));
            assert!((most - FILLED).abs() < 1e-9, "{view}: {most}");
            // It cannot be nearer: both edges of one direction are touched.
            let touched = |c: usize| {
                let ends =
                    seen.iter().map(|at| at[c]).fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
                (ends.0 + FILLED).abs() < 1e-9 && (ends.1 - FILLED).abs() < 1e-9
            };
            assert!(touched(0) || touched(1), "{view}");
        }
    }

    #[test]
    fn a_model_stays_inside_while_the_camera_goes_around_it() {
        let points: Vec<_> = (0..30).map(|i| [f64::from(i % 3) * 5.0, f64::from(i), f64::from(i % 7) - 20.0]).collect();
        let model = model(&points);
        let bounds = model.bounds().unwrap();
        let Camera::Pinhole(camera) = framed_around(&model, bounds, View { theta: 10.0, phi: 60.0 }, 1.5) else {
            panic!("a pinhole")
        };
        let middle = DVec3::from_array(camera.look_at);
        let mut most = 0.0_f64;
        for side in 0..36 {
            let turned = DMat4::from_rotation_y(f64::from(side) * PI / 18.0);
            let eye = middle + turned.transform_vector3(DVec3::from_array(camera.eye) - middle);
            let camera = PinholeCamera { eye: eye.to_array(), ..camera };
            most = seen(&camera, 1.5, &points).iter().flatten().fold(most, |most, at| most.max(at.abs()));
        }
        assert!((FILLED - 0.01..FILLED + 1e-9).contains(&most), "{most}");
    }

    #[test]
    fn distance_to_the_origin_does_not_matter() {
        let at = |shift: f64| {
            let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25]];
            let points = points.map(|[x, y, z]| [x + shift, y, z - 3.0 * shift]);
            let model = model(&points);
            let Camera::Pinhole(camera) = framed(&model, middle(&model), View::default(), 1.0, 0.0) else {
                panic!("a pinhole")
            };
            let moved = |[x, y, z]: [f64; 3]| DVec3::new(x - shift, y, z + 3.0 * shift);
            [moved(camera.eye), moved(camera.look_at)]
        };
        let [near, far] = [at(0.0), at(1e6)];
        assert!((0..2).all(|i| near[i].abs_diff_eq(far[i], 1e-8)), "{near:?} {far:?}");
    }

    #[test]
    fn a_flat_model_seen_from_its_edge_is_in_front_of_the_camera() {
        let points = [[0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0]];
        let model = model(&points);
        let Camera::Pinhole(camera) = framed(&model, middle(&model), "front".parse().unwrap(), 1.0, 0.0) else {
            panic!("a pinhole")
        };
        assert!(camera.eye[2] > 2.0 && camera.look_at[2] == 1.0, "{camera:?}");
    }
}
