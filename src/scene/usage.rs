//! What the bodies of a scene use. Definitions that nothing places are not built and do not count.

use super::effects::MAX_POINTERS;

/// How far from the origin bodies are that single precision rounds too much: at 1000 times their size one pixel in a hundred is
/// some codes off.
pub(super) const FAR_AWAY: f64 = 500.0;

/// How large all bodies together have to be in single precision: products of the edges of smaller triangles underflow. Pictures of meshes
/// of 34,000 triangles did not depend on the hierarchy at 1e-19, and did at 1e-20.
pub(super) const TINY: f64 = 1e-17;

/// What bodies have.
#[derive(Debug, Clone, Default)]
pub struct Usage {
    /// Of each material, the default material last.
    pub materials: Vec<Used>,
    /// Whether anything moves while the shutter is open.
    pub moves: bool,
    /// Whether any body is turned inside out.
    pub hollow: bool,
    /// Whether any body is of triangles or a frustum: rounding may let an eye see such a surface that it is on.
    pub rounded: bool,
    /// Whether any mesh has normals of its own.
    pub smooth: bool,
    /// Whether anything is placed by a transform.
    pub placed: bool,
    /// Whether all bodies are far from the origin, hundreds of times as far as they are large.
    pub far_away: bool,
    /// Whether all bodies together are so small that products of their edges underflow in single precision.
    pub tiny: bool,
    /// Whether the eye is in a closed room, so that no ray leaves the scene.
    pub enclosed: bool,
}

/// How a material is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Used {
    /// By any body.
    pub anywhere: bool,
    /// By a body that light may be inside of: it is closed, and not hollow.
    pub filled: bool,
    /// By a body that the eye may be inside of.
    pub around_eye: bool,
}

/// JSON pointers of the first objects that use something.
#[derive(Debug, Default)]
pub(super) struct Pointers {
    /// Those that move.
    pub(super) moving: Vec<String>,
    /// Those that are turned inside out.
    pub(super) hollow: Vec<String>,
    /// Meshes with normals.
    pub(super) smooth: Vec<String>,
    /// Those that are placed by a transform.
    pub(super) placed: Vec<String>,
}

/// Keeps a pointer, if there are not many yet.
pub(super) fn note(list: &mut Vec<String>, pointer: impl FnOnce() -> String) {
    if list.len() < MAX_POINTERS {
        list.push(pointer());
    }
}
