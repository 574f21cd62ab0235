//! Cameras as textbooks write them.

use crate::common::naive;
use crate::hard_cases::lab::Lab;
use glam::DVec3;
use std::f64::consts::PI;
use strahl::math::{acos, atan2, sin_cos, tan};

/// The pinhole camera at a point of [-1, 1]^2, whatever its angle of view.
pub fn pinhole(lab: &Lab, degrees: f64, x: f64, y: f64) -> DVec3 {
    let half = lab.round(tan(lab.round(degrees.to_radians() / 2.0)));
    naive::normalize(lab, DVec3::new(lab.round(x * half), lab.round(y * half), -1.0))
}

/// The equidistant fisheye: sin(theta) x / r, sin(theta) y / r, cos(theta).
pub fn fisheye(lab: &Lab, degrees: f64, x: f64, y: f64) -> DVec3 {
    let r = lab.round(lab.round(lab.round(x * x) + lab.round(y * y)).sqrt());
    let (sin, cos) = sin_cos(lab.round(r * lab.round(degrees.to_radians() / 2.0)));
    DVec3::new(lab.round(lab.round(sin) * x) / r, lab.round(lab.round(sin) * y) / r, -cos)
}

/// From a unit direction to longitude and latitude by the arc functions, and back.
pub fn panorama_and_back(lab: &Lab, direction: DVec3) -> DVec3 {
    let d = naive::normalize(lab, direction);
    let theta = lab.round(acos(d.y));
    let phi = lab.round(atan2(d.x, -d.z));
    let ((sin_theta, cos_theta), (sin_phi, cos_phi)) = (sin_cos(theta), sin_cos(phi.clamp(-PI, PI)));
    DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
}
