//! Bodies that move on from frame to frame.
//!
//! A body with a `motion` stands at `transform` when the shutter opens, and has gone all of `motion` when it closes. A sequence
//! lets it go on at that speed: after s shutters it stands where the motion has taken it, and goes on around an axis that has
//! come along.

use super::bodies::change;
use super::turntable::sin_cos_of_degrees;
use crate::scene::description::{Description, Motion, Object, Transform};
use crate::scene::transform::affine;
use glam::{DAffine3, DMat3, DVec3};

/// Moves all bodies of a scene to where they are after so many shutters.
pub(super) fn go_on(scene: &mut Description, shutters: f64) {
    if shutters != 0.0 {
        change(scene, moves, |object| advance(object, shutters));
    }
}

fn moves(object: &Object) -> bool {
    let motion = match object {
        Object::Group(group) => group.motion,
        Object::Instance(instance) => instance.motion,
        Object::Model(model) => model.motion,
        _ => None,
    };
    motion.is_some_and(|motion| motion.moves())
}

fn advance(object: &mut Object, shutters: f64) {
    match object {
        Object::Group(group) => carry(&mut group.transform, &mut group.motion, shutters),
        Object::Instance(instance) => carry(&mut instance.transform, &mut instance.motion, shutters),
        Object::Model(model) => carry(&mut model.transform, &mut model.motion, shutters),
        _ => {}
    }
}

fn carry(transform: &mut Transform, motion: &mut Option<Motion>, shutters: f64) {
    let Some(motion) = motion.as_mut().filter(|motion| motion.moves()) else { return };
    // The check of the scene says what is wrong with a transform.
    let Ok(placed) = affine(transform) else { return };
    let center = DVec3::from_array(motion.center.unwrap_or_default());
    let by = DVec3::from_array(motion.translate.unwrap_or_default()) * shutters;
    let turn = motion.rotate_deg.and_then(|rotation| {
        let axis = DVec3::from_array(rotation.axis).try_normalize()?;
        let (sin, cos) = sin_cos_of_degrees(rotation.angle * shutters % 360.0);
        let column = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
        Some(DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z)))
    });
    let turn = turn.unwrap_or(DMat3::IDENTITY);
    let moved =
        DAffine3 { matrix3: turn * placed.matrix3, translation: turn * (placed.translation - center) + center + by };
    let [x, y, z] = [moved.matrix3.x_axis, moved.matrix3.y_axis, moved.matrix3.z_axis].map(|axis| axis.extend(0.0));
    let columns = [x, y, z, moved.translation.extend(1.0)].map(|column| column.to_array());
    let mut matrix = [0.0; 16];
    matrix.copy_from_slice(columns.as_flattened());
    *transform = Transform { matrix: Some(matrix), ..Transform::default() };
    motion.center = motion.rotate_deg.map(|_| (center + by).to_array());
}
