//! Skins: vertices that follow joints (glTF 2.0, section 3.7.3).

use super::super::fault::{Fault, Faults, Kind, Subject, Warning, warn};
use super::super::geometry::Geometry;
use super::buffers::Buffers;
use super::json::{Document, Primitive};
use super::nodes;
use glam::DMat4;

/// From the pose of binding to where each joint is.
pub(super) fn matrices(
    document: &Document,
    buffers: &Buffers<'_>,
    index: usize,
    worlds: &[DMat4],
) -> Result<Vec<DMat4>, Fault> {
    let skin = &document.skins[index];
    // Each node with the skin has its own.
    buffers.budget.take(skin.joints.len() as u64, 2 * size_of::<DMat4>())?;
    let unbound = match skin.inverse_bind_matrices {
        Some(accessor) => buffers.elements::<16>(document, accessor, &["MAT4"])?,
        None => vec![DMat4::IDENTITY.to_cols_array(); skin.joints.len()],
    };
    if let Some(at) = unbound.iter().position(|matrix| !is_affine(matrix)) {
        return Err(not_affine(index, at));
    }
    Ok(skin
        .joints
        .iter()
        .zip(unbound)
        .map(|(&joint, unbind)| worlds[joint] * DMat4::from_cols_array(&unbind))
        .collect())
}

fn is_affine(matrix: &[f64; 16]) -> bool {
    [3, 7, 11].iter().all(|&i| matrix[i].abs() < 1e-3) && (matrix[15] - 1.0).abs() < 1e-3
}

fn not_affine(skin: usize, at: usize) -> Fault {
    let detail = format!("the last row of matrix {at} is not 0 0 0 1");
    Fault::new(format!("/skins/{skin}/inverseBindMatrices"), Kind::OutOfRange, detail)
}

/// Notes what would be wrong with skins.
pub(super) fn check(document: &Document, buffers: &Buffers<'_>, faults: &mut Faults) {
    let roots = nodes::roots(document);
    let identity = vec![DMat4::IDENTITY; document.nodes.len()];
    for (index, skin) in document.skins.iter().enumerate() {
        if skin.joints.windows(2).any(|pair| roots[pair[0]] != roots[pair[1]]) {
            let detail = "the joints have no common root";
            faults.push(Fault::new(format!("/skins/{index}/joints"), Kind::Degenerate, detail));
        }
        if let Err(fault) = matrices(document, buffers, index, &identity)
            && !faults.push(fault)
        {
            return;
        }
    }
}

/// How far the weights of a vertex may be from 1 in all: four of 8 bits are rounded.
const ROUNDING: f64 = 0.02;

/// Geometry with its vertices where joints have them.
pub(super) fn skinned(
    document: &Document,
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    pointer: &str,
    geometry: Geometry,
    joints: &[DMat4],
    warnings: &mut Vec<Warning>,
) -> Result<Geometry, Fault> {
    let count = geometry.positions.len();
    buffers.budget.take(count as u64, size_of::<DMat4>() + 128)?;
    let mut mixed = vec![DMat4::ZERO; count];
    let mut sums = vec![0.0; count];
    for set in 0.. {
        let of = |name: &str| primitive.attributes.get(&format!("{name}_{set}")).copied();
        let (Some(indices), Some(weights)) = (of("JOINTS"), of("WEIGHTS")) else { break };
        let indices = buffers.elements::<4>(document, indices, &["VEC4"])?;
        let weights = buffers.elements::<4>(document, weights, &["VEC4"])?;
        for (vertex, (indices, weights)) in indices.into_iter().zip(weights).enumerate().take(count) {
            for (index, weight) in indices.into_iter().zip(weights).filter(|(_, weight)| *weight != 0.0) {
                let is_index = index >= 0.0 && index % 1.0 == 0.0;
                let Some(joint) = joints.get(index as usize).filter(|_| is_index) else {
                    let why = if is_index {
                        format!("and the skin has {} joints", joints.len())
                    } else {
                        "which is no index: unsigned integers that are not normalized are".to_owned()
                    };
                    let detail = format!("vertex {vertex} follows joint {index}, {why}");
                    let pointer = format!("{pointer}/attributes/JOINTS_{set}");
                    return Err(Fault::new(pointer, Kind::OutOfRange, detail));
                };
                mixed[vertex] += *joint * weight;
                sums[vertex] += weight;
            }
        }
    }
    if sums.iter().any(|sum| (sum - 1.0).abs() > ROUNDING) {
        let detail = "weights of joints that do not add up to 1 are scaled, and vertices without any follow none";
        warn(warnings, Subject::Assumed, "joint-weights", format!("{pointer}/attributes/WEIGHTS_0"), detail);
    }
    // Quantised weights do not add up to 1.
    for (matrix, sum) in mixed.iter_mut().zip(sums) {
        *matrix = if sum > 1e-9 { *matrix * (1.0 / sum) } else { DMat4::IDENTITY };
    }
    Ok(geometry.moved(|vertex| mixed[vertex]))
}
