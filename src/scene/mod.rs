//! From a scene's text to the [`Scene`] that a render needs: read, check, compile.

pub mod assets;
pub mod check;
mod closed_mesh;
pub mod compile;
pub mod description;
pub mod effects;
pub mod files;
pub mod hashes;
pub mod light_cells;
pub mod limits;
pub mod load;
pub mod locate;
pub mod model;
pub mod named;
pub mod nff;
pub mod overrides;
mod picture_decoding;
pub mod pictures;
pub mod problem;
pub mod read;
pub mod recognise;
pub mod schema;
pub mod size;
pub(crate) mod transform;
pub mod usage;
pub mod variation;
mod view;
pub mod world;

pub use compile::Scene;
pub use description::Description;
pub use files::{Files, KnownScene, NoFiles};
pub use load::{Accept, Format, Loaded, NotLoaded, load, load_if, load_with};
pub use overrides::Overrides;
pub use problem::{Problem, Problems, printable};
