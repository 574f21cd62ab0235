//! The camera of a description.

use crate::camera::{Angular, Basis, Camera, Flat, Lens, PictureEdges};
use crate::lanes::Real;
use crate::math;
use crate::scene::description as d;
use glam::{DVec2, DVec3};

/// How far from the eye camera rays may start: half the diagonal of what an orthographic camera sees, the radius of a lens, else 0.
pub(super) fn eye_radius(description: &d::Description) -> f64 {
    match &description.camera {
        d::Camera::Orthographic(camera) => {
            let size = DVec2::new(f64::from(description.image.width), f64::from(description.image.height));
            0.5 * camera.height * size.length() / size.y
        }
        d::Camera::Pinhole(pinhole) => 0.5 * pinhole.aperture,
        _ => 0.0,
    }
}

/// The camera of a description for a picture of this size.
pub fn camera_of<R: Real>(camera: &d::Camera, basis: &Basis, width: u32, height: u32) -> Camera<R> {
    let size = (f64::from(width), f64::from(height));
    let half_tan = |degrees: f64| math::tan(degrees.to_radians() * 0.5);
    match *camera {
        d::Camera::Pinhole(c) => {
            let flat = Flat::pinhole(basis, half_tan(c.vfov_deg), size);
            if c.aperture == 0.0 {
                return Camera::Flat(flat);
            }
            let distance = DVec3::from_array(c.look_at).distance(basis.eye);
            Camera::Lens(flat, Lens::new(basis, 0.5 * c.aperture, c.focus_distance.unwrap_or(distance)))
        }
        d::Camera::Orthographic(c) => Camera::Flat(Flat::orthographic(basis, c.height, size)),
        d::Camera::Fisheye(c) => Camera::Angular(Angular::fisheye(basis, c.fov_deg.to_radians(), size)),
        d::Camera::Omnimax(c) => Camera::Angular(Angular::omnimax(basis, c.fov_deg.to_radians(), size)),
        d::Camera::Panorama(c) => {
            Camera::Angular(Angular::panorama(basis, c.hfov_deg.to_radians(), c.vfov_deg.to_radians(), size))
        }
        d::Camera::Cylinder(c) => {
            Camera::Angular(Angular::cylinder(basis, c.hfov_deg.to_radians(), half_tan(c.vfov_deg), size))
        }
    }
}

/// The edges of such a picture, if it is flat.
pub(super) fn edges_of<R: Real>(camera: &d::Camera, width: u32, height: u32) -> Option<PictureEdges<R>> {
    let (tall, parallel) = match camera {
        d::Camera::Pinhole(c) => (math::tan(c.vfov_deg.to_radians() * 0.5), false),
        d::Camera::Orthographic(c) => (0.5 * c.height, true),
        _ => return None,
    };
    let half = [tall * f64::from(width) / f64::from(height), tall];
    PictureEdges::new(&camera.view(), half, parallel)
}
