//! The studio around a model: light from all sides, and a floor that shows nothing but the shadow of the key light.

use crate::math;
use crate::scene::description::{Camera, Environment, EnvironmentLight, Material, Object, Pbr, Quad, Studio};
use glam::DVec3;
use std::f64::consts::PI;

/// How far the floor reaches beyond the model, as a multiple of its extent: further than its shadow.
const FLOOR: f64 = 3.0;
/// How far below the model the floor is, as a part of its extent, so that no face of it lies in the floor.
const GAP: f64 = 1e-4;

/// The surroundings, turned so that their front is where the camera is.
pub(super) fn surroundings(camera: &Camera, intensity: f64) -> Environment {
    let view = camera.view();
    let [x, _, z] = [0, 1, 2].map(|i: usize| view.eye[i] - view.look_at[i]);
    let turn = if x.abs().max(z.abs()) > 1e-9 { math::atan2(x, z) * 180.0 / PI } else { 0.0 };
    // Views of one name stand in the same studio, whatever the model.
    let turn = (turn * 1e6).round() / 1e6;
    Environment {
        image: None,
        sky: None,
        studio: Some(Studio {}),
        rotate_deg: turn,
        intensity,
        light: EnvironmentLight::Fast,
    }
}

/// The material of the floor.
pub(super) fn catcher() -> Material {
    Material { pbr: Some(Box::new(Pbr { shadow_catcher: true, ..Pbr::default() })), ..Material::default() }
}

/// A floor under a model within a box.
pub(super) fn floor((low, high): (DVec3, DVec3), material: String) -> Object {
    let extent = (high - low).max_element();
    let (middle, reach, y) = ((low + high) / 2.0, FLOOR * extent, low.y - GAP * extent);
    let corner = |x: f64, z: f64| [middle.x + x * reach, y, middle.z + z * reach];
    let vertices = [corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
    Object::Quad(Box::new(Quad { vertices, material: Some(material), name: Some("floor".into()) }))
}
