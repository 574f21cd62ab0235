//! Models of extreme sizes are scaled: scenes have smallest lengths and greatest intensities, and single precision has neither the
//! square of the area of a tiny triangle nor that of a huge one.

use super::origin::bounds;
use super::placed_meshes::box_of;
use crate::models::{LampKind, Model, Projection, Subject, Warning};
use crate::scene::problem::{Code, Problem, Problems};
use glam::{DMat4, DVec3};
use std::ops::RangeInclusive;

/// Sizes of models that stay as they are.
const USUAL: RangeInclusive<f64> = 1e-6..=1e6;
/// Sizes that can be scaled: fourth powers of them are numbers.
const POSSIBLE: RangeInclusive<f64> = 1e-60..=1e60;

/// Scales what is very small or very large to a size between 1 and 2, by a power of two, so that shapes stay as they are to the bit.
pub(super) fn scaled_to_units(model: &mut Model) -> Result<(), Problems> {
    let size = extent(bounds(model));
    if !POSSIBLE.contains(&size) {
        let (least, most) = (POSSIBLE.start(), POSSIBLE.end());
        let detail =
            format!("the model is {size:e} units large: it can be seen if that is between {least:e} and {most:e}");
        return Err(Problems::one(Problem::new("", Code::Degenerate, detail)));
    }
    // Triangles that instances place have a size of their own.
    let own: Vec<f64> = model.geometries.iter().map(|geometry| to_units(extent(box_of(&geometry.positions)))).collect();
    for (geometry, own) in model.geometries.iter_mut().zip(&own).filter(|(_, own)| **own != 1.0) {
        geometry.positions.iter_mut().flatten().for_each(|x| *x *= own);
    }
    let scale = to_units(size);
    for placement in &mut model.placements {
        let own = own[placement.geometry];
        if (scale, own) != (1.0, 1.0) {
            placement.transforms.iter_mut().for_each(|matrix| *matrix = by(scale) * *matrix * by(1.0 / own));
        }
    }
    if scale != 1.0 {
        scale_around(model, scale);
        let detail = format!("the model is {size:.3e} units large: the scene has it {scale:.3e} times as large");
        model.warnings.push(Warning { subject: Subject::Assumed, what: "scale", detail, pointer: String::new() });
    }
    Ok(())
}

/// What brings a size between 1 and 2, if it is an extreme one.
fn to_units(size: f64) -> f64 {
    if USUAL.contains(&size) || !POSSIBLE.contains(&size) {
        return 1.0;
    }
    // The exponent of a number is in the bits below its sign.
    let exponent = (size.to_bits() >> 52) as i32 - 1023;
    2.0_f64.powi(-exponent)
}

fn extent((low, high): (DVec3, DVec3)) -> f64 {
    (high - low).max_element()
}

fn by(scale: f64) -> DMat4 {
    DMat4::from_scale(DVec3::splat(scale))
}

/// Scales lengths beside those of its triangles. Lamps shine on it as before: candela count at a distance of 1.
fn scale_around(model: &mut Model, scale: f64) {
    for camera in &mut model.cameras {
        camera.placed = moved(&camera.placed, scale);
        if let Projection::Orthographic { height } = &mut camera.projection {
            *height *= scale;
        }
    }
    for lamp in &mut model.lamps {
        lamp.placed = moved(&lamp.placed, scale);
        lamp.range = lamp.range.map(|range| range * scale);
        if lamp.kind != LampKind::Directional {
            lamp.intensity *= scale * scale;
        }
    }
    for material in &mut model.materials {
        material.thickness *= scale;
        if let Some(attenuation) = &mut material.attenuation {
            attenuation.distance *= scale;
        }
    }
}

/// The same with its place alone in the scaled model.
fn moved(matrix: &DMat4, scale: f64) -> DMat4 {
    DMat4 { w_axis: (matrix.w_axis.truncate() * scale).extend(1.0), ..*matrix }
}
