//! Where groups and instances go.

use crate::math;
use crate::scene::description::{Rotation, Scale, Transform};
use glam::{DAffine3, DMat3, DMat4, DVec3};

/// Object to parent coordinates.
pub(super) fn to_parent(transform: &Transform) -> DAffine3 {
    if let Some(columns) = &transform.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(columns));
    }
    let scale = match transform.scale {
        None => DVec3::ONE,
        Some(Scale::Uniform(factor)) => DVec3::splat(factor),
        Some(Scale::PerAxis(factors)) => factors.into(),
    };
    let rotation = transform.rotate_deg.map_or(DMat3::IDENTITY, |rotation| rotation_matrix(&rotation));
    DAffine3 {
        matrix3: rotation * DMat3::from_diagonal(scale),
        translation: transform.translate.map_or(DVec3::ZERO, DVec3::from),
    }
}

/// Rodrigues: cos(a) I + sin(a) \[k\]x + (1 - cos(a)) k k^T.
fn rotation_matrix(rotation: &Rotation) -> DMat3 {
    let k = DVec3::from(rotation.axis).normalize();
    let (sin, cos) = math::sin_cos(rotation.angle.to_radians());
    let column = |e: DVec3| e * cos + k.cross(e) * sin + k * (k.dot(e) * (1.0 - cos));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transform(json: &str) -> DAffine3 {
        to_parent(&serde_json::from_str(json).unwrap())
    }

    #[test]
    fn scale_comes_first_then_rotation_then_translation() {
        let quarter_turn = r#"{ "scale": [2, 1, 1], "rotate_deg": { "axis": [0, 0, 3], "angle": 90 },
                                "translate": [10, 0, 0] }"#;
        let moved = transform(quarter_turn).transform_point3(DVec3::X);
        assert!(moved.abs_diff_eq(DVec3::new(10.0, 2.0, 0.0), 1e-14), "{moved}");
    }

    #[test]
    fn a_matrix_is_read_by_columns() {
        let shift = transform(r#"{ "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1] }"#);
        assert_eq!(shift.transform_point3(DVec3::ZERO), DVec3::new(5.0, 6.0, 7.0));
    }
}
