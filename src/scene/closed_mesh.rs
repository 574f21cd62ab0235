//! Meshes without a hole.

use super::description::Vec3;
use crate::control;
use rayon::prelude::*;
use std::cmp::Ordering;

/// Whether each edge belongs to two faces that run along it in opposite directions, vertices compared by position.
pub(super) fn is_closed(vertices: &[Vec3], faces: &[[u32; 3]]) -> bool {
    // Adding 0 turns -0 into 0.
    let position = |vertex: &u32| vertices[*vertex as usize].map(|x| (x + 0.0).to_bits());
    let mut sorted: Vec<u32> = (0..vertices.len() as u32).collect();
    sorted.par_sort_unstable_by_key(position);
    // Vertices at one position have one number.
    let mut numbers = vec![0; sorted.len()];
    for pair in sorted.windows(2) {
        let differ = position(&pair[0]) != position(&pair[1]);
        numbers[pair[1] as usize] = numbers[pair[0] as usize] + u64::from(differ);
    }
    drop(sorted);
    // The edges along which faces run upwards, and those along which they run downwards, each as a number.
    let half = faces.len() * 3 / 2 + 3;
    let (mut up, mut down) = (Vec::with_capacity(half), Vec::with_capacity(half));
    for face in faces {
        if control::step(1) {
            return true;
        }
        let corner = face.map(|i| numbers[i as usize]);
        for k in 0..3 {
            let (a, b) = (corner[k], corner[(k + 1) % 3]);
            // Sides without length bound nothing.
            match a.cmp(&b) {
                Ordering::Less => up.push(a << 32 | b),
                Ordering::Greater => down.push(b << 32 | a),
                Ordering::Equal => {}
            }
        }
        if up.len().max(down.len()) > half {
            return false;
        }
    }
    up.par_sort_unstable();
    down.par_sort_unstable();
    up == down
}
