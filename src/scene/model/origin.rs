//! Models that stand far from the origin, as maps do, are moved there: single precision has 24 bits for where a point is, of which
//! distance leaves few for shape.

use super::placed_meshes::box_of;
use crate::models::{Model, Subject, Warning};
use glam::{DMat4, DVec3};

/// How many of its own sizes from the origin a model stands far: 17 bits are left for its shape, 200 steps a pixel.
const FAR: f64 = 128.0;

/// Moves what is far, in double precision. The scene then has its coordinates from the middle of the model.
pub(super) fn recenter_with_warning(model: &mut Model) {
    let Some(DVec3 { x, y, z }) = recenter(model) else { return };
    let detail = format!(
        "the model stands around ({x}, {y}, {z}), far from the origin for its size: the scene has it at the origin"
    );
    model.warnings.push(Warning { subject: Subject::Assumed, what: "origin", detail, pointer: String::new() });
}

/// The same without a warning. Returns where the middle of the model was, if that was far.
pub(super) fn recenter(model: &mut Model) -> Option<DVec3> {
    // Vertices of instances stay as they are, so they must be near the origin of their own.
    let shifts: Vec<Option<DVec3>> = model.geometries.iter().map(|geometry| far(box_of(&geometry.positions))).collect();
    for (geometry, shift) in model.geometries.iter_mut().zip(&shifts) {
        let Some(shift) = shift else { continue };
        geometry.positions.iter_mut().for_each(|point| *point = (DVec3::from_array(*point) - *shift).to_array());
    }
    for placement in &mut model.placements {
        let Some(shift) = shifts[placement.geometry] else { continue };
        placement.transforms.iter_mut().for_each(|matrix| *matrix *= DMat4::from_translation(shift));
    }
    let middle = far(bounds(model))?;
    let placed = model.placements.iter_mut().flat_map(|placement| &mut placement.transforms);
    let cameras = model.cameras.iter_mut().map(|camera| &mut camera.placed);
    let lamps = model.lamps.iter_mut().map(|lamp| &mut lamp.placed);
    let all = placed.chain(cameras).chain(lamps);
    all.for_each(|matrix| matrix.w_axis -= middle.extend(0.0));
    Some(middle)
}

/// A box around the model, which may be larger than it.
pub(super) fn bounds(model: &Model) -> (DVec3, DVec3) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for placement in &model.placements {
        let (least, most) = box_of(&model.geometries[placement.geometry].positions);
        // The box of a box may be larger, which is enough to know what is far.
        for matrix in &placement.transforms {
            for corner in 0..8_usize {
                let of = |c: usize| if corner >> c & 1 == 0 { least[c] } else { most[c] };
                let placed = matrix.transform_point3(DVec3::new(of(0), of(1), of(2)));
                (low, high) = (low.min(placed), high.max(placed));
            }
        }
    }
    (low, high)
}

/// The middle of a box that is far from the origin.
fn far((low, high): (DVec3, DVec3)) -> Option<DVec3> {
    let (middle, extent) = ((low + high) / 2.0, (high - low).max_element());
    (middle.is_finite() && extent > 0.0 && middle.abs().max_element() > FAR * extent).then_some(middle)
}
