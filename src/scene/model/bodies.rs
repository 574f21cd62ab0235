//! Placed triangles as objects: what stands in one place is a mesh of the scene itself, and what stands in several is an instance. A
//! large mesh in several materials is an instance for each of them.

use super::flat::is_flat;
use crate::models::{Geometry, Model, NAME_BYTES, shortened};
use crate::scene::description::{Instance, Mesh, Object, Transform};
use crate::scene::limits::MAGNITUDE;
use crate::scene::named::Named;
use glam::DMat4;
use std::sync::Arc;

/// Triangles of a mesh that is worth an instance. Rays enter it by a level more, and smaller ones are sorted as soon.
const LARGE: usize = 4_096;
/// Triangles that instances must save in all.
const WORTH: usize = 100_000;

/// Definitions, whose names begin with a prefix, and objects. `names` are those of the materials in the scene.
pub(super) fn objects(model: &mut Model, names: &[String], prefix: &str) -> (Named<Vec<Object>>, Vec<Object>) {
    let (mut definitions, mut objects) = (Named::default(), Vec::new());
    let is_shared = shared(model);
    let mut faces: Vec<Option<Arc<Vec<[u32; 3]>>>> = vec![None; model.geometries.len()];
    let mut uses = vec![0_usize; model.geometries.len()];
    model.placements.iter().for_each(|placement| uses[placement.geometry] += 1);
    for placement in std::mem::take(&mut model.placements) {
        uses[placement.geometry] -= 1;
        let geometry = &mut model.geometries[placement.geometry];
        // The last that needs it takes it.
        let own = if uses[placement.geometry] == 0 { std::mem::take(geometry) } else { geometry.clone() };
        let material = placement.material.map(|index| names[index].clone());
        let name = placement.name.as_deref().map(|name| shortened(name, NAME_BYTES));
        if let [only] = placement.transforms.as_slice()
            && (!is_shared[placement.geometry] || is_flat(only))
        {
            // Its triangles are in the hierarchy of the scene: one level less for every ray.
            let moved = if *only == DMat4::IDENTITY { own } else { own.moved(|_| *only) };
            objects.push(Object::Mesh(Box::new(mesh(moved, None, material, name))));
            continue;
        }
        // Meshes of one list of faces share a hierarchy.
        let of_all = faces[placement.geometry].get_or_insert_with(|| Arc::new(own.triangles.clone()));
        let own = mesh(own, Some(Arc::clone(of_all)), material, name);
        let definition = format!("{prefix}mesh {}", definitions.len());
        definitions.insert(definition.clone(), vec![Object::Mesh(Box::new(own))]);
        objects.extend(placement.transforms.iter().map(|matrix| {
            let transform = Transform { matrix: Some(matrix.to_cols_array()), ..Transform::default() };
            Object::Instance(Box::new(Instance { of: definition.clone(), transform, motion: None, name: None }))
        }));
    }
    (definitions, objects)
}

/// Which geometries are instances in all places: large ones that stand in several, if that saves enough.
fn shared(model: &Model) -> Vec<bool> {
    let mut places = vec![0_usize; model.geometries.len()];
    model.placements.iter().for_each(|placement| places[placement.geometry] += placement.transforms.len());
    let large = |geometry: &Geometry| geometry.triangles.len() >= LARGE;
    let saved = |(geometry, places): (&Geometry, &usize)| match large(geometry) {
        true => geometry.triangles.len() * places.saturating_sub(1),
        false => 0,
    };
    let is_worth_it = model.geometries.iter().zip(&places).map(saved).sum::<usize>() >= WORTH;
    model.geometries.iter().zip(places).map(|(geometry, places)| is_worth_it && places > 1 && large(geometry)).collect()
}

fn mesh(geometry: Geometry, faces: Option<Arc<Vec<[u32; 3]>>>, material: Option<String>, name: Option<String>) -> Mesh {
    // The origin of a scene's coordinates is the lower left corner of the picture.
    let flipped = |uvs: Option<Vec<[f64; 2]>>| {
        uvs.map(|mut uvs| {
            uvs.iter_mut().for_each(|uv| *uv = [uv[0], 1.0 - uv[1]].map(|x| x.clamp(-MAGNITUDE, MAGNITUDE)));
            uvs
        })
    };
    let within = |list: Option<Vec<[f64; 4]>>, least: f64| {
        list.map(|mut list| {
            list.iter_mut().flatten().for_each(|number| *number = number.clamp(least, 1.0));
            list
        })
    };
    let Geometry { positions, mut triangles, normals, tangents, uvs: [uvs, uvs1], colors } = geometry;
    let own = || {
        // The compiled scene may keep the list.
        triangles.shrink_to_fit();
        triangles.into()
    };
    Mesh {
        vertices: positions,
        faces: faces.unwrap_or_else(own),
        normals,
        uvs: flipped(uvs),
        uvs1: flipped(uvs1),
        tangents: within(tangents, -1.0),
        colors: within(colors, 0.0),
        material,
        name,
        hollow: false,
    }
}
