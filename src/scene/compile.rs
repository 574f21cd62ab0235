//! Description to [`Scene`].
use super::{Description, Problems};

/// A scene that can be rendered.
#[derive(Debug)]
pub struct Scene {
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// What the author should know, though the scene renders.
    pub warnings: Vec<super::Problem>,
    /// Milliseconds spent building bounding volume hierarchies.
    pub bvh_ms: f64,
}

/// Checks a description completely and builds the scene.
pub fn compile(description: &Description) -> Result<Scene, Problems> {
    Ok(Scene { width: description.image.width, height: description.image.height, warnings: Vec::new(), bvh_ms: 0.0 })
}
