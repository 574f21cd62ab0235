//! The pinhole camera of an NFF view.
//!
//! NFF's angle runs from the centre of the top pixel row to the centre of the bottom row, half a pixel short of the
//! picture's edges: over N rows the edge lies at tan(angle/2) N/(N-1).

use super::entity::View;
use super::tokens::Place;
use crate::math;
use crate::scene::description::{Camera, ImageSize, PinholeCamera};
use crate::scene::limits::PIXELS;
use crate::scene::problem::{Code, Problem};
use glam::DVec3;

/// The camera and size that the file asks for.
pub(super) fn camera(place: Place, view: &View) -> Result<(Camera, ImageSize), Problem> {
    let [width, height] = view.resolution;
    if u64::from(width) * u64::from(height) > PIXELS.max {
        let detail = format!("{width} x {height} pixels are more than the limit {} of {}", PIXELS.name, PIXELS.max);
        return Err(place.problem(Code::Limit, detail));
    }
    let rows = f64::from(height);
    // a single row has one centre, so there is no angle to measure
    let edge = if height == 1 { 1.0 } else { rows / (rows - 1.0) };
    Ok((pinhole(place, view, edge)?, ImageSize { width, height }))
}

/// The picture by which the SPD counts rays: those through the 513 x 513 corners of 512 x 512 pixels, which are here the
/// centres of 513 x 513 pixels.
pub(super) fn counting_camera(place: Place, view: &View) -> Result<(Camera, ImageSize), Problem> {
    let corners = 512.0 / 511.0;
    let edge = corners * 513.0 / 512.0;
    Ok((pinhole(place, view, edge)?, ImageSize { width: 513, height: 513 }))
}

/// `edge` is how far the upper edge lies from the middle, where tan(angle/2) is 1.
fn pinhole(place: Place, view: &View, edge: f64) -> Result<Camera, Problem> {
    let degenerate = |detail: &str| Err(place.problem(Code::Degenerate, detail));
    let direction = DVec3::from_array(view.at) - DVec3::from_array(view.from);
    let up = DVec3::from_array(view.up);
    if direction == DVec3::ZERO {
        return degenerate("\"from\" and \"at\" of the view are the same point");
    }
    if up == DVec3::ZERO {
        return degenerate("\"up\" of the view is 0 0 0");
    }
    if direction.normalize_or_zero().cross(up.normalize_or_zero()).length() < 1e-9 {
        return degenerate("\"up\" of the view is parallel to the direction of view");
    }
    let half_height = math::tan(0.5 * view.angle.to_radians()) * edge;
    let vfov_deg = (2.0 * math::atan(half_height)).to_degrees();
    if vfov_deg <= 0.0 || vfov_deg >= 180.0 {
        return Err(place.problem(Code::OutOfRange, format!("an angle of {} degrees cannot be drawn", view.angle)));
    }
    Ok(Camera::Pinhole(PinholeCamera {
        eye: view.from,
        look_at: view.at,
        up: view.up,
        vfov_deg,
        aperture: 0.0,
        focus_distance: None,
    }))
}
