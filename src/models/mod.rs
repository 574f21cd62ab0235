//! Models that other programs write: glTF 2.0, OBJ, STL and PLY, read into one neutral [`Model`].
//!
//! A reader is a pure function of bytes and of named parts. What a file claims is checked in 64 bits before anything is
//! allocated by it, and all that is decoded counts against a [`Budget`]. What is wrong is a [`Fault`] with its place; what is
//! left out or approximated is a [`Warning`], never silent.

mod budget;
mod crease;
pub mod data_uri;
mod fault;
mod geometry;
pub mod gltf;
pub(crate) mod jpeg;
pub mod ktx2;
mod material;
mod meshopt;
mod model;
mod mtl;
mod mtl_map;
mod name;
mod name_or_index;
mod obj;
pub mod parts;
mod ply;
pub(crate) mod polygon;
pub(crate) mod stl;
pub(crate) mod text;
mod weld;

pub use budget::Budget;
pub(crate) use budget::DECODED_BYTES;
pub use fault::{Fault, Faults, Kind, Place, Subject, Warning};
pub use geometry::Geometry;
pub use material::{Alpha, Attenuation, Channel, Clearcoat, ModelMaterial, Texture, UvTransform, Wrap};
pub use model::{Lamp, LampKind, Model, ModelCamera, Picture, Placement, Projection, Up};
pub(crate) use name::{NAME_BYTES, shortened};
pub use name_or_index::{NameOrIndex, counted};

use std::fmt;

/// Gives the part of a model that has a name; an error is the end of a sentence that begins with the name.
pub type Parts<'a> = dyn Fn(&str) -> Result<Vec<u8>, String> + 'a;

/// Formats of models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelFormat {
    /// glTF 2.0, binary or JSON.
    Gltf,
    /// Wavefront OBJ with MTL.
    Obj,
    /// Stereolithography, binary or text.
    Stl,
    /// Polygon File Format, binary or text.
    Ply,
}

/// What of a model is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Choice {
    /// Which scene of the file. Default: the one that it names, else the first.
    pub scene: Option<u32>,
    /// Which animation is played. Default: none, the pose at rest.
    pub animation: Option<NameOrIndex>,
    /// Seconds since the start of the animation.
    pub seconds: f64,
    /// Which variant of the materials. Default: none.
    pub variant: Option<NameOrIndex>,
    /// Whether what only changes the look is refused too, as the glTF specification asks of `extensionsRequired`.
    pub strict: bool,
}

impl Choice {
    /// Fails if something is chosen of which only glTF has any.
    fn check_lacking(&self) -> Result<(), Faults> {
        let lacking = |what: &str, wanted: &dyn fmt::Display| {
            let detail = format!("there is no {what} {wanted}: only glTF has any");
            Faults::one(Fault::new("", Kind::UnknownReference, detail))
        };
        match (&self.scene, &self.animation, &self.variant) {
            (Some(scene), ..) => Err(lacking("scene", scene)),
            (_, Some(animation), _) => Err(lacking("animation", animation)),
            (.., Some(variant)) => Err(lacking("variant", variant)),
            (None, None, None) => Ok(()),
        }
    }
}

/// Reads a model.
pub fn read(format: ModelFormat, bytes: &[u8], parts: &Parts<'_>, choice: Choice) -> Result<Model, Faults> {
    if format != ModelFormat::Gltf {
        choice.check_lacking()?;
    }
    let mut model = match format {
        ModelFormat::Gltf => gltf::read(bytes, parts, choice)?,
        ModelFormat::Obj => obj::read(bytes, parts)?,
        ModelFormat::Stl => stl::read(bytes)?,
        ModelFormat::Ply => ply::read(bytes)?,
    };
    model.drop_repeated();
    model.drop_unseen();
    if model.triangles() == 0 {
        return Err(Faults::one(model.nothing_to_see()));
    }
    Ok(model)
}
