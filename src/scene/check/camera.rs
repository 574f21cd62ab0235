//! Checks of the camera.

use super::findings::Findings;
use super::path::Path;
use crate::camera::Basis;
use crate::scene::description::Camera;
use crate::scene::limits;
use crate::scene::problem::Code;

pub(super) fn check_camera(findings: &mut Findings, camera: &Camera) {
    let root = Path::ROOT;
    let at = root.key("camera");
    let at = at.key(camera.kind());
    let view = camera.view();
    let sound = findings.point(at.key("eye"), &view.eye) & findings.point(at.key("look_at"), &view.look_at);
    findings.direction(at.key("up"), &view.up);
    if sound && view.eye == view.look_at {
        findings.add(
            at.key("look_at"),
            Code::Degenerate,
            "must not be the eye point: there is no direction to look in",
        );
    } else if sound && Basis::new(&view).is_none() && view.up.iter().any(|x| x.abs() >= limits::SMALLEST_LENGTH) {
        findings.add(at.key("up"), Code::Degenerate, "must not be parallel to the view: choose another up direction");
    }
    let mut angle = |key: &str, x: f64, open: bool, max: f64| {
        let (words, ok) = if open {
            (format!("above 0 and below {max}"), x > 0.0 && x < max)
        } else {
            (format!("above 0, at most {max}"), x > 0.0 && x <= max)
        };
        findings.number(at.key(key), x, &words, ok);
    };
    match camera {
        Camera::Pinhole(c) => {
            angle("vfov_deg", c.vfov_deg, true, 180.0);
            if c.aperture != 0.0 {
                findings.length(at.key("aperture"), c.aperture);
            }
            if let Some(distance) = c.focus_distance {
                findings.length(at.key("focus_distance"), distance);
            }
        }
        Camera::Orthographic(c) => findings.length(at.key("height"), c.height),
        Camera::Fisheye(c) | Camera::Omnimax(c) => angle("fov_deg", c.fov_deg, false, 360.0),
        Camera::Panorama(c) => {
            angle("hfov_deg", c.hfov_deg, false, 360.0);
            angle("vfov_deg", c.vfov_deg, false, 180.0);
        }
        Camera::Cylinder(c) => {
            angle("hfov_deg", c.hfov_deg, false, 360.0);
            angle("vfov_deg", c.vfov_deg, true, 180.0);
        }
    }
}
