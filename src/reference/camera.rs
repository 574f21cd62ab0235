//! Projections: pixel to primary ray. Pixel (x, y) has its centre at (x + 0.5, y + 0.5), y counts downwards.

use super::ray::Ray;
use crate::math;
use crate::scene::description::{Camera as Projection, Description, FisheyeCamera};
use glam::DVec3;

/// An eye with its picture's size.
#[derive(Debug)]
pub(super) struct Camera {
    projection: Projection,
    width: f64,
    height: f64,
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Camera {
    pub(super) fn new(description: &Description) -> Self {
        let view = description.camera.view();
        let eye = DVec3::from(view.eye);
        let forward = (DVec3::from(view.look_at) - eye).normalize();
        let right = forward.cross(DVec3::from(view.up)).normalize();
        Self {
            projection: description.camera.clone(),
            width: f64::from(description.image.width),
            height: f64::from(description.image.height),
            eye,
            forward,
            right,
            up: right.cross(forward),
        }
    }

    /// The ray through a point of the picture, with unit direction; none outside the circle of a fisheye or dome.
    pub(super) fn primary_ray(&self, x: f64, y: f64) -> Option<Ray> {
        let (w, h) = (self.width, self.height);
        let (sx, sy) = (2.0 * x / w - 1.0, 1.0 - 2.0 * y / h);
        let longitude = |hfov_deg: f64| (x / w - 0.5) * hfov_deg.to_radians();
        let dir = match &self.projection {
            Projection::Pinhole(pinhole) => {
                let half_height = math::tan(pinhole.vfov_deg.to_radians() / 2.0);
                self.forward + self.right * (sx * half_height * w / h) + self.up * (sy * half_height)
            }
            Projection::Orthographic(orthographic) => {
                let half_height = orthographic.height / 2.0;
                let origin = self.eye + self.right * (sx * half_height * w / h) + self.up * (sy * half_height);
                return Some(Ray { origin, dir: self.forward });
            }
            Projection::Fisheye(fisheye) => {
                let side = w.min(h);
                self.equidistant(fisheye, (2.0 * x - w) / side, (h - 2.0 * y) / side)?
            }
            Projection::Omnimax(dome) => self.equidistant(dome, sx, 1.0 - 2.0 * y / w)?,
            Projection::Panorama(panorama) => {
                let (sin_lat, cos_lat) = math::sin_cos((0.5 - y / h) * panorama.vfov_deg.to_radians());
                self.up * sin_lat + self.horizontal(longitude(panorama.hfov_deg)) * cos_lat
            }
            Projection::Cylinder(cylinder) => {
                let half_height = math::tan(cylinder.vfov_deg.to_radians() / 2.0);
                self.horizontal(longitude(cylinder.hfov_deg)) + self.up * (sy * half_height)
            }
        };
        Some(Ray { origin: self.eye, dir: dir.normalize() })
    }

    fn horizontal(&self, longitude: f64) -> DVec3 {
        let (sin, cos) = math::sin_cos(longitude);
        self.forward * cos + self.right * sin
    }

    /// Equidistant projection of a point of the unit disc.
    fn equidistant(&self, fisheye: &FisheyeCamera, px: f64, py: f64) -> Option<DVec3> {
        let r = math::hypot(px, py);
        if r > 1.0 {
            return None;
        }
        if r == 0.0 {
            return Some(self.forward);
        }
        let (sin, cos) = math::sin_cos(r * fisheye.fov_deg.to_radians() / 2.0);
        Some(self.forward * cos + (self.right * px + self.up * py) / r * sin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: &str, width: u32, height: u32) -> Camera {
        let json = format!(
            r#"{{ "version": 1, "image": {{ "width": {width}, "height": {height} }}, "camera": {projection},
                 "objects": [] }}"#
        );
        Camera::new(&serde_json::from_str(&json).unwrap())
    }

    fn assert_dir(camera: &Camera, x: f64, y: f64, expected: [f64; 3]) {
        let dir = camera.primary_ray(x, y).unwrap().dir;
        assert!(dir.abs_diff_eq(DVec3::from(expected).normalize(), 1e-14), "({x}, {y}): {dir}");
    }

    // Looking along -z with y up, right is +x.
    const VIEW: &str = r#""eye": [0, 0, 0], "look_at": [0, 0, -5]"#;

    #[test]
    fn pinhole_spans_its_angle_vertically() {
        let camera = camera(&format!(r#"{{ "pinhole": {{ {VIEW}, "vfov_deg": 90 }} }}"#), 200, 100);
        assert_dir(&camera, 100.0, 50.0, [0.0, 0.0, -1.0]);
        assert_dir(&camera, 100.0, 0.0, [0.0, 1.0, -1.0]);
        assert_dir(&camera, 0.0, 100.0, [-2.0, -1.0, -1.0]);
    }

    #[test]
    fn orthographic_rays_are_parallel() {
        let camera = camera(&format!(r#"{{ "orthographic": {{ {VIEW}, "height": 4 }} }}"#), 200, 100);
        let corner = camera.primary_ray(200.0, 0.0).unwrap();
        assert!(corner.origin.abs_diff_eq(DVec3::new(4.0, 2.0, 0.0), 1e-14));
        assert_eq!(corner.dir, DVec3::NEG_Z);
    }

    #[test]
    fn fisheye_touches_the_shorter_side() {
        let camera = camera(&format!(r#"{{ "fisheye": {{ {VIEW} }} }}"#), 200, 100);
        assert_dir(&camera, 100.0, 50.0, [0.0, 0.0, -1.0]);
        assert_dir(&camera, 100.0, 0.0, [0.0, 1.0, 0.0]);
        assert_dir(&camera, 125.0, 50.0, [1.0, 0.0, -1.0]);
        assert!(camera.primary_ray(49.0, 50.0).is_none());
    }

    #[test]
    fn omnimax_spans_the_width_and_touches_the_top() {
        let camera = camera(&format!(r#"{{ "omnimax": {{ {VIEW} }} }}"#), 200, 150);
        assert_dir(&camera, 0.0, 100.0, [-1.0, 0.0, 0.0]);
        assert_dir(&camera, 100.0, 0.0, [0.0, 1.0, 0.0]);
        assert_dir(&camera, 100.0, 150.0, [0.0, -1.0, -1.0]);
        assert!(camera.primary_ray(1.0, 1.0).is_none());
    }

    #[test]
    fn panorama_maps_columns_to_longitude_and_rows_to_latitude() {
        let camera = camera(&format!(r#"{{ "panorama": {{ {VIEW} }} }}"#), 400, 200);
        assert_dir(&camera, 300.0, 100.0, [1.0, 0.0, 0.0]);
        assert_dir(&camera, 0.0, 100.0, [0.0, 0.0, 1.0]);
        assert_dir(&camera, 123.0, 0.0, [0.0, 1.0, 0.0]);
        assert_dir(&camera, 200.0, 150.0, [0.0, -1.0, -1.0]);
    }

    #[test]
    fn cylinder_is_perspective_in_its_columns() {
        let camera = camera(&format!(r#"{{ "cylinder": {{ {VIEW}, "vfov_deg": 90 }} }}"#), 400, 200);
        assert_dir(&camera, 400.0, 100.0, [1.0, 0.0, 0.0]);
        assert_dir(&camera, 400.0, 0.0, [1.0, 1.0, 0.0]);
        assert_dir(&camera, 200.0, 200.0, [0.0, -1.0, -1.0]);
    }
}
