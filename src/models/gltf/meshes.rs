//! Meshes: the triangles of a primitive, moved by its morph targets.

use super::super::fault::{Fault, Kind};
use super::super::geometry::Geometry;
use super::buffers::Buffers;
use super::json::{Document, Primitive};
use glam::DVec3;
use std::collections::BTreeMap;

/// The points of a primitive with all that belongs to them, and with morph targets by their weights.
pub(super) fn points(
    document: &Document,
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    pointer: &str,
    weights: &[f64],
) -> Result<Geometry, Fault> {
    let of = |attributes: &BTreeMap<String, usize>, name: &str| attributes.get(name).copied();
    let Some(positions) = of(&primitive.attributes, "POSITION") else {
        let detail = "a primitive without positions cannot be drawn";
        return Err(Fault::new(format!("{pointer}/attributes"), Kind::MissingKey, detail));
    };
    let under = |fault: Fault| fault.under(pointer);
    let list = |name: &str| of(&primitive.attributes, name);
    let uvs = |name: &str| list(name).map(|uv| buffers.elements::<2>(document, uv, &["VEC2"])).transpose();
    let mut geometry = Geometry {
        positions: buffers.elements::<3>(document, positions, &["VEC3"]).map_err(under)?,
        normals: list("NORMAL").map(|it| buffers.elements::<3>(document, it, &["VEC3"])).transpose().map_err(under)?,
        // Without normals they are to be ignored (section 3.7.2.1).
        tangents: list("TANGENT")
            .filter(|_| list("NORMAL").is_some())
            .map(|it| buffers.elements::<4>(document, it, &["VEC4"]))
            .transpose()
            .map_err(under)?,
        uvs: [uvs("TEXCOORD_0").map_err(under)?, uvs("TEXCOORD_1").map_err(under)?],
        colors: list("COLOR_0").map(|colors| of_colors(document, buffers, colors)).transpose().map_err(under)?,
        triangles: Vec::new(),
    };
    for (target, &weight) in primitive.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        let shift =
            |name: &str| of(target, name).map(|index| buffers.elements::<3>(document, index, &["VEC3"])).transpose();
        if let Some(shifts) = shift("POSITION")? {
            add(&mut geometry.positions, &shifts, weight);
        }
        if let (Some(normals), Some(shifts)) = (&mut geometry.normals, shift("NORMAL")?) {
            add(normals, &shifts, weight);
        }
        if let (Some(tangents), Some(shifts)) = (&mut geometry.tangents, shift("TANGENT")?) {
            add(tangents, &shifts, weight);
        }
    }
    if !primitive.targets.is_empty() {
        for tangent in geometry.tangents.iter_mut().flatten() {
            let [x, y, z, side] = *tangent;
            let [x, y, z] = DVec3::new(x, y, z).try_normalize().unwrap_or(DVec3::X).to_array();
            *tangent = [x, y, z, side];
        }
    }
    Ok(geometry)
}

fn add<const N: usize>(base: &mut [[f64; N]], shifts: &[[f64; 3]], weight: f64) {
    for (value, shift) in base.iter_mut().zip(shifts) {
        value.iter_mut().zip(shift).for_each(|(value, shift)| *value += weight * shift);
    }
}

/// Colors with opacity 1 where they have none.
fn of_colors(document: &Document, buffers: &Buffers<'_>, index: usize) -> Result<Vec<[f64; 4]>, Fault> {
    let mut colors = buffers.elements::<4>(document, index, &["VEC3", "VEC4"])?;
    if document.accessors[index].kind == "VEC3" {
        colors.iter_mut().for_each(|color| color[3] = 1.0);
    }
    Ok(colors)
}

/// The triangles of a primitive, of which no corner is the same as another; None if it is drawn as points or lines.
pub(super) fn triangles(
    document: &Document,
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    pointer: &str,
    points: usize,
) -> Result<Option<Vec<[u32; 3]>>, Fault> {
    if primitive.mode < 4 {
        return Ok(None);
    }
    let mut triangles = match (primitive.mode, primitive.indices) {
        (4, Some(accessor)) => {
            let triangles = buffers.triples(document, accessor)?;
            check(triangles.as_flattened(), points, pointer)?;
            triangles
        }
        (mode, indices) => {
            let indices = match indices {
                Some(accessor) => buffers.indices(document, accessor)?,
                None => {
                    buffers.budget.take(points as u64, 4)?;
                    (0..u32::try_from(points).unwrap_or(u32::MAX)).collect()
                }
            };
            check(&indices, points, pointer)?;
            let count = indices.len().saturating_sub(2);
            buffers.budget.take(count as u64, 12)?;
            match mode {
                4 => indices.as_chunks::<3>().0.to_vec(),
                5 => (0..count).map(|i| [i, i + 1 + i % 2, i + 2 - i % 2].map(|at| indices[at])).collect(),
                _ => (0..count).map(|i| [i + 1, i + 2, 0].map(|at| indices[at])).collect(),
            }
        }
    };
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    Ok(Some(triangles))
}

fn check(indices: &[u32], points: usize, pointer: &str) -> Result<(), Fault> {
    let Some(at) = indices.iter().position(|index| *index as usize >= points) else { return Ok(()) };
    let detail = format!("element {at} is {}, and there are {points} vertices", indices[at]);
    Err(Fault::new(format!("{pointer}/indices"), Kind::OutOfRange, detail))
}
