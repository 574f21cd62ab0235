//! The media types of scenes and models: what `Content-Type` may name, what the contract lists, and what a refusal advises.

use super::variation;
use strahl::scene::Format;
use strahl::scene::recognise::is_gzip;

/// One of them.
#[derive(Debug)]
pub(crate) struct SceneType {
    /// As in `Content-Type`, in lower case.
    pub(crate) name: &'static str,
    /// How such a body is read.
    pub(crate) format: Format,
    /// Whether it is text.
    pub(crate) is_text: bool,
    /// What a refusal says behind its name.
    meant_for: &'static str,
}

const fn text(name: &'static str, format: Format) -> SceneType {
    SceneType { name, format, is_text: true, meant_for: "" }
}

const fn binary(name: &'static str, format: Format) -> SceneType {
    SceneType { name, format, is_text: false, meant_for: "" }
}

/// Those that the contract lists.
pub(crate) const SCENE_TYPES: [SceneType; 10] = [
    text("application/json", Format::Json),
    text(variation::MEDIA_TYPE, Format::Json),
    binary("model/gltf-binary", Format::Gltf),
    text("model/gltf+json", Format::Gltf),
    text("model/obj", Format::Obj),
    binary("model/stl", Format::Stl),
    binary("model/ply", Format::Ply),
    SceneType { meant_for: " for a model with parts", ..binary("multipart/form-data", Format::Parts) },
    text("text/x-nff", Format::Nff),
    SceneType { meant_for: " for compressed NFF", ..binary("application/gzip", Format::Nff) },
];

/// Other names of some of them.
const ALIASES: [(&str, Format); 3] =
    [("application/x-gzip", Format::Nff), ("model/x.stl-binary", Format::Stl), ("model/x.stl-ascii", Format::Stl)];

/// The format that a name in lower case stands for.
pub(super) fn format_of(name: &str) -> Option<Format> {
    let listed = SCENE_TYPES.iter().map(|it| (it.name, it.format));
    listed.chain(ALIASES).find(|(known, _)| *known == name).map(|(_, format)| format)
}

/// The name for a body in a format. Of two, binary glTF and compressed NFF are known by how they begin.
pub(crate) fn name_of(format: Format, body: &[u8]) -> &'static str {
    let is_text = !(is_gzip(body) || body.starts_with(b"glTF"));
    let mut names = SCENE_TYPES.iter().filter(|it| it.format == format);
    let first = names.clone().next().map_or("application/octet-stream", |it| it.name);
    names.find(|it| it.is_text == is_text).map_or(first, |it| it.name)
}

/// Their names, as `Accept-Query` has them.
pub(crate) fn names() -> String {
    SCENE_TYPES.each_ref().map(|it| it.name).join(", ")
}

/// What to send, as a refusal says it.
pub(super) fn advice() -> String {
    let of_scenes = SCENE_TYPES.iter().filter(|it| it.name != variation::MEDIA_TYPE);
    let mut words: Vec<String> = of_scenes.map(|it| format!("{}{}", it.name, it.meant_for)).collect();
    let last = words.pop().unwrap_or_default();
    format!("send {}, or {last}", words.join(", "))
}
