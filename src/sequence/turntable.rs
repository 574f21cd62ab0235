//! A camera that goes around a scene.

use crate::math::sin_cos;
use crate::scene::description::{
    Camera, CylinderCamera, FisheyeCamera, OrthographicCamera, PanoramaCamera, PinholeCamera, Vec3,
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The camera goes around an axis, in equal steps from frame to frame. The frame after the last one would be at the whole angle,
/// so 360 degrees can be shown again and again. Lights stay with the scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Turntable {
    /// The whole angle, -36000 to 36000; above 0 counter-clockwise when the axis points at the viewer. Default 360.
    #[schemars(range(min = -36000.0, max = 36000.0))]
    pub degrees: f64,
    /// Direction of the axis. Default: the camera's `up`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<Vec3>,
    /// A point of the axis. Default: the camera's `look_at`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub center: Option<Vec3>,
}

impl Default for Turntable {
    fn default() -> Self {
        Self { degrees: 360.0, axis: None, center: None }
    }
}

impl Turntable {
    /// Turns a camera to where it is in a frame of so many.
    pub(super) fn turn(&self, camera: &mut Camera, number: u32, count: u32) {
        let view = camera.view();
        let degrees = self.degrees * f64::from(number) / f64::from(count) % 360.0;
        // The axis of a camera without an up direction is none; the check of the scene says so.
        let Some(axis) = DVec3::from_array(self.axis.unwrap_or(view.up)).try_normalize() else { return };
        if degrees == 0.0 {
            return;
        }
        let center = DVec3::from_array(self.center.unwrap_or(view.look_at));
        let (sin, cos) = sin_cos_of_degrees(degrees);
        let turned = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
        let (own_eye, own_look_at, own_up) = parts(camera);
        *own_eye = (center + turned(DVec3::from_array(view.eye) - center)).to_array();
        if self.center.is_some() {
            *own_look_at = (center + turned(DVec3::from_array(view.look_at) - center)).to_array();
        }
        // Around an axis that is the camera's own, up stays as it is to the bit.
        let up = DVec3::from_array(view.up);
        if self.axis.is_some() && axis.cross(up) != DVec3::ZERO {
            *own_up = turned(up).to_array();
        }
    }
}

/// Eye, target and up vector of any projection.
fn parts(camera: &mut Camera) -> (&mut Vec3, &mut Vec3, &mut Vec3) {
    match camera {
        Camera::Pinhole(PinholeCamera { eye, look_at, up, .. })
        | Camera::Orthographic(OrthographicCamera { eye, look_at, up, .. })
        | Camera::Fisheye(FisheyeCamera { eye, look_at, up, .. })
        | Camera::Omnimax(FisheyeCamera { eye, look_at, up, .. })
        | Camera::Panorama(PanoramaCamera { eye, look_at, up, .. })
        | Camera::Cylinder(CylinderCamera { eye, look_at, up, .. }) => (eye, look_at, up),
    }
}

/// Sine and cosine of an angle between -360 and 360 degrees, exact where it is a multiple of 90.
pub(super) fn sin_cos_of_degrees(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        between => sin_cos(between.to_radians()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hypot;

    fn camera() -> Camera {
        Camera::Pinhole(PinholeCamera::looking([3.3, 1.7, 5.1], [0.1, 0.7, -0.3]))
    }

    fn turned(turntable: Turntable, number: u32, count: u32) -> Camera {
        let mut camera = camera();
        turntable.turn(&mut camera, number, count);
        camera
    }

    #[test]
    fn a_whole_turn_closes_to_the_last_bit() {
        for degrees in [360.0, -360.0, 720.0] {
            let turntable = Turntable { degrees, ..Turntable::default() };
            assert_eq!((turned(turntable, 0, 36), turned(turntable, 36, 36)), (camera(), camera()));
        }
    }

    #[test]
    fn the_eye_keeps_its_distance_and_its_height() {
        let away = |camera: &Camera| {
            let view = camera.view();
            let [x, y, z] = [0, 1, 2].map(|i| view.eye[i] - view.look_at[i]);
            (hypot(x, z), y)
        };
        let (radius, height) = away(&camera());
        for number in 0..36 {
            let (r, y) = away(&turned(Turntable::default(), number, 36));
            assert!((r - radius).abs() < 1e-14 && (y - height).abs() < 1e-14, "{number}: {r} {y}");
        }
    }

    #[test]
    fn a_quarter_is_exact_and_counter_clockwise() {
        let turntable = Turntable { axis: Some([0.0, 2.0, 0.0]), center: Some([0.0; 3]), ..Turntable::default() };
        let view = turned(turntable, 9, 36).view();
        assert_eq!((view.eye, view.look_at, view.up), ([5.1, 1.7, -3.3], [-0.3, 0.7, -0.1], [0.0, 1.0, 0.0]));
    }
}
