//! What is given any bytes, and panics if something is wrong. `cargo fuzz run NAME` and the tests call the same functions.

mod data;
mod keys;
mod requests;
mod scenes;
mod sequences;
#[cfg(test)]
mod tests;

/// Takes any bytes; it fails by a panic.
pub(crate) type Target = fn(&[u8]);

/// The targets by name, which is also that of the folder of their seeds.
pub(crate) const TARGETS: [(&str, Target); 13] = [
    ("scene", scenes::json),
    ("nff", scenes::nff),
    ("sequence", sequences::json),
    ("gltf", scenes::gltf),
    ("obj", scenes::obj),
    ("stl", scenes::stl),
    ("ply", scenes::ply),
    ("parts", scenes::parts),
    ("accept", requests::accept),
    ("iiif", requests::iiif),
    ("events", requests::events),
    ("keys", keys::file),
    ("data", data::folder),
];
