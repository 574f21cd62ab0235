//! The studio around a model: light from all sides, and a floor that shows nothing but the shadow of the key light.

use crate::math;
use crate::scene::description::{Camera, Environment, EnvironmentLight, Material, Mesh, Object, Pbr, Studio};
use glam::DVec3;
use std::f64::consts::PI;

/// Radius of the floor, as a part of the height or the diagonal of the model: about as far as pictures reach.
const REACH: f64 = 0.58;
/// Circles on the floor, as parts of its radius, and how much of a shadow is seen there.
const FADE: [(f64, f64); 4] = [(0.5, 1.0), (0.67, 0.75), (0.83, 0.25), (1.0, 0.0)];
/// Sides of the circles.
const SIDES: u32 = 32;
/// The border of the picture in which shadows fade: a little more than framing leaves free around a model.
const EDGE_FADE: f64 = 0.08;
/// How far below the model the floor is, as a part of its extent, so that no face of it lies in the floor.
const GAP: f64 = 1e-4;
/// Least height of a model's top over the floor, as a part of its extent.
const LIFT: f64 = 0.03;

/// The surroundings, turned so that their front is where the camera is.
pub(super) fn surroundings(camera: &Camera, intensity: f64) -> Environment {
    let view = camera.view();
    let back = DVec3::from_array(view.eye) - DVec3::from_array(view.look_at);
    let DVec3 { x, z, .. } = back;
    let turn = if x.abs().max(z.abs()) > 1e-9 * back.length() { math::atan2(x, z) * 180.0 / PI } else { 0.0 };
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
    let pbr = Pbr { shadow_catcher: true, edge_fade: EDGE_FADE, ..Pbr::default() };
    Material { pbr: Some(Box::new(pbr)), ..Material::default() }
}

/// A floor under a model within a box, of which shadows fade before its edge: pictures end soon behind the model, and a shadow
/// that ends there looks cut off.
pub(super) fn floor((low, high): (DVec3, DVec3), material: String) -> Object {
    let size = high - low;
    let extent = size.max_element();
    // What lies on the floor would hide its own shadow.
    let gap = (GAP * extent).max(LIFT * extent - size.y);
    let middle = ((low + high) / 2.0).with_y(low.y - gap);
    let reach = REACH * size.y.max(math::hypot(size.x, size.z));
    let (mut vertices, mut colors, mut faces) = (vec![middle.to_array()], vec![[1.0; 4]], Vec::new());
    for (ring, (radius, shown)) in (0_u32..).zip(FADE) {
        for side in 0..SIDES {
            let (sin, cos) = math::sin_cos(f64::from(side) / f64::from(SIDES) * 2.0 * PI);
            vertices.push((middle + DVec3::new(cos, 0.0, -sin) * (radius * reach)).to_array());
            colors.push([1.0, 1.0, 1.0, shown]);
            let at = |ring: u32, side: u32| 1 + ring * SIDES + side % SIDES;
            let [from, to] = [at(ring, side), at(ring, side + 1)];
            match ring.checked_sub(1) {
                None => faces.push([0, from, to]),
                Some(inner) => {
                    let [inner_from, inner_to] = [at(inner, side), at(inner, side + 1)];
                    faces.extend([[inner_from, from, to], [inner_from, to, inner_to]]);
                }
            }
        }
    }
    Object::Mesh(Box::new(Mesh {
        vertices,
        faces: faces.into(),
        normals: None,
        tangents: None,
        uvs: None,
        uvs1: None,
        colors: Some(colors),
        material: Some(material),
        name: Some("floor".into()),
        hollow: false,
    }))
}
