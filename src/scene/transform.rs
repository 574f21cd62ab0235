//! A scene's `transform` as an affine map.

use super::description::{Scale, Transform};
use super::limits;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Whether it leaves everything where it is.
pub(crate) fn is_identity(transform: &Transform) -> bool {
    affine(transform).is_ok_and(|map| map == DAffine3::IDENTITY)
}

/// The map, or what is wrong with it.
pub(crate) fn affine(transform: &Transform) -> Result<DAffine3, String> {
    let map = match transform.matrix {
        Some(m) => {
            if transform.translate.is_some() || transform.rotate_deg.is_some() || transform.scale.is_some() {
                return Err("has a matrix, so it must not have translate, rotate_deg or scale".into());
            }
            if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
                return Err("the matrix must have the last row 0 0 0 1; it is written column by column".into());
            }
            let column = |i: usize| DVec3::new(m[i], m[i + 1], m[i + 2]);
            DAffine3 { matrix3: DMat3::from_cols(column(0), column(4), column(8)), translation: column(12) }
        }
        None => {
            let scale = match transform.scale {
                Some(Scale::Uniform(factor)) => DVec3::splat(factor),
                Some(Scale::PerAxis(factors)) => DVec3::from_array(factors),
                None => DVec3::ONE,
            };
            let rotation = match transform.rotate_deg {
                Some(rotation) => {
                    let axis = DVec3::from_array(rotation.axis).try_normalize();
                    let axis = axis.ok_or("rotate_deg.axis must not be the zero vector")?;
                    rotate(axis, rotation.angle)
                }
                None => DQuat::IDENTITY,
            };
            let translation = transform.translate.map_or(DVec3::ZERO, DVec3::from_array);
            DAffine3::from_scale_rotation_translation(scale, rotation, translation)
        }
    };
    let columns = map.matrix3.to_cols_array();
    if columns.iter().chain(&map.translation.to_array()).any(|x| x.is_nan() || x.abs() > limits::MAGNITUDE) {
        return Err(format!("must have numbers between -{0:e} and {0:e}", limits::MAGNITUDE));
    }
    // The volume relative to the lengths of the columns says how flat the map is, at any scale.
    let m = map.matrix3;
    let lengths = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    if m.determinant().abs() <= 1e-12 * lengths || lengths == 0.0 {
        return Err("is singular: it flattens space, so nothing can be seen of it".into());
    }
    Ok(map)
}

/// Rotation around a unit axis, with the sine of `math`, which is the same on every machine.
fn rotate(axis: DVec3, degrees: f64) -> DQuat {
    let (sin, cos) = crate::math::sin_cos((degrees % 720.0).to_radians() * 0.5);
    DQuat::from_xyzw(axis.x * sin, axis.y * sin, axis.z * sin, cos)
}
