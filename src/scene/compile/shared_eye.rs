//! Whether all camera rays start in the same media. Then these are searched once for all rays.

use super::contact;
use crate::accel::{Bounds, Extent, Item, Shape};
use crate::camera::Camera;
use crate::lanes::Real;
use crate::scene::description::{Camera as Described, Description};
use glam::DVec3;

/// Whether no transmitting body comes so near to the eye that some rays may start inside of it and others outside. `items`
/// are those of the scene itself.
pub(super) fn is_shared<R: Real>(
    description: &Description,
    camera: &Camera<R>,
    moves: bool,
    items: &[Item<R>],
    extents: &[Option<Extent>],
) -> bool {
    if matches!(description.camera, Described::Orthographic(_)) {
        return false;
    }
    let lens = match &description.camera {
        Described::Pinhole(pinhole) if camera.lens().is_some() => 0.5 * pinhole.aperture,
        _ => 0.0,
    };
    if lens == 0.0 && !moves {
        return true;
    }
    let eye = DVec3::from_array(description.camera.view().eye);
    let far = |bounds: Bounds| {
        let outside = (bounds.min - eye).max(eye - bounds.max).max(DVec3::ZERO);
        outside.length() > lens * (1.0 + 1e-6) + 64.0 * R::ROUNDOFF * eye.length()
    };
    items.iter().zip(extents).all(|(item, extent)| {
        // A body at rest contains all rays that start in one point, or none.
        let matters = matches!(item.shape, Shape::Instance(_)) || (lens > 0.0 && item.lets_light_through());
        !matters || contact::bounds(item, extent).is_some_and(far)
    })
}
