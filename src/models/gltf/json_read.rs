//! Reads the JSON of a glTF 2.0 file.
//!
//! The elements of the lists are read one by one, so that each that is wrong is reported.

use super::super::fault::{Fault, Faults, Kind, Place};
use super::json::Document;
use crate::strict_json;
use serde::Deserialize;
use serde_json::value::RawValue;

/// Most elements of a list, and most bytes that they take: the same few characters are a few bytes of an index, and thousands of a
/// material.
pub(crate) const LIST: usize = 1 << 20;
const ELEMENT_BYTES: usize = 1 << 26;
/// Most lists and objects, at any depth: each is a few bytes of text, and hundreds in memory.
pub(crate) const ELEMENTS: usize = 1 << 21;

/// A file, with its lists unread.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Lists<'a> {
    #[serde(borrow)]
    asset: Option<&'a RawValue>,
    scene: Option<usize>,
    #[serde(default)]
    extensions_required: Vec<String>,
    #[serde(default)]
    extensions_used: Vec<String>,
    #[serde(default, borrow)]
    scenes: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    nodes: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    meshes: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    accessors: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    buffer_views: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    buffers: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    materials: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    textures: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    images: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    samplers: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    cameras: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    skins: Vec<&'a RawValue>,
    #[serde(default, borrow)]
    animations: Vec<&'a RawValue>,
    #[serde(default)]
    extensions: RootExtensions<'a>,
}

#[derive(Deserialize, Default)]
struct RootExtensions<'a> {
    #[serde(rename = "KHR_lights_punctual", borrow)]
    lights: Option<LightList<'a>>,
    #[serde(rename = "KHR_materials_variants", borrow)]
    variants: Option<VariantList<'a>>,
}

#[derive(Deserialize)]
struct LightList<'a> {
    #[serde(default, borrow)]
    lights: Vec<&'a RawValue>,
}

#[derive(Deserialize)]
struct VariantList<'a> {
    #[serde(default, borrow)]
    variants: Vec<&'a RawValue>,
}

#[derive(Debug, Deserialize)]
struct Asset {
    version: String,
    /// The least version that a reader has to know.
    #[serde(rename = "minVersion")]
    least: Option<String>,
}

/// Reads the JSON; all elements that are wrong are reported.
pub(super) fn read(text: &[u8]) -> Result<Document, Faults> {
    let nested = text.iter().filter(|byte| matches!(byte, b'{' | b'[')).count();
    if nested > ELEMENTS {
        let detail = format!("{nested} lists and objects are over the limit of {ELEMENTS} (gltf_elements)");
        return Err(Faults::one(Fault::new("", Kind::Limit, detail)));
    }
    let lists = strict_json::from_slice::<Lists<'_>>(text).map_err(|error| {
        if !error.is_data() {
            let detail = format!("this is not JSON: {error}");
            return Faults::one(Fault::new("", Kind::Invalid, detail).at(Place::Json(offset(text, &error))));
        }
        Faults::one(fault(text, 0, text, String::new(), &error))
    })?;
    let mut faults = Faults::default();
    check_version(text, lists.asset, &mut faults);
    let mut elements = Elements { text, faults: &mut faults };
    let extensions = lists.extensions;
    let document = Document {
        scene: lists.scene,
        extensions_required: lists.extensions_required,
        extensions_used: lists.extensions_used,
        scenes: elements.of("/scenes", lists.scenes),
        nodes: elements.of("/nodes", lists.nodes),
        meshes: elements.of("/meshes", lists.meshes),
        accessors: elements.of("/accessors", lists.accessors),
        views: elements.of("/bufferViews", lists.buffer_views),
        buffers: elements.of("/buffers", lists.buffers),
        materials: elements.of("/materials", lists.materials),
        textures: elements.of("/textures", lists.textures),
        images: elements.of("/images", lists.images),
        samplers: elements.of("/samplers", lists.samplers),
        cameras: elements.of("/cameras", lists.cameras),
        skins: elements.of("/skins", lists.skins),
        animations: elements.of("/animations", lists.animations),
        lights: elements
            .of("/extensions/KHR_lights_punctual/lights", extensions.lights.map_or_else(Vec::new, |list| list.lights)),
        variants: elements.of(
            "/extensions/KHR_materials_variants/variants",
            extensions.variants.map_or_else(Vec::new, |list| list.variants),
        ),
    };
    faults.none_or_err()?;
    Ok(document)
}

fn check_version(text: &[u8], asset: Option<&RawValue>, faults: &mut Faults) {
    let Some(asset) = asset else {
        let detail = "\"asset\" with its \"version\" is missing: this is no glTF 2.0";
        faults.push(Fault::new("/asset", Kind::MissingKey, detail));
        return;
    };
    match strict_json::from_slice(asset.get().as_bytes()) {
        Ok(Asset { version, least }) => {
            let is_known = |version: &str| version.starts_with("2.");
            let (key, says, needed) = match least {
                // Files of 2.1 may say that a reader of 2.0 will do.
                Some(least) if is_known(&version) && least != "2.0" && !least.starts_with("1.") => {
                    ("minVersion", "this is for readers of", least)
                }
                _ if is_known(&version) => return,
                _ => ("version", "this is", version),
            };
            let shown: String = needed.chars().take(20).collect();
            let detail = format!("{says} glTF {shown:?}, and glTF 2.0 is read: convert it");
            faults.push(Fault::new(format!("/asset/{key}"), Kind::Unsupported, detail));
        }
        Err(error) => {
            let start = start_of(text, asset);
            faults.push(fault(asset.get().as_bytes(), start, text, "/asset".into(), &error));
        }
    }
}

/// Reads elements of lists.
struct Elements<'a> {
    text: &'a [u8],
    faults: &'a mut Faults,
}

impl Elements<'_> {
    // The code for each kind of element is large, and inlined it would be one function of 100 kB.
    #[inline(never)]
    fn of<T: for<'de> Deserialize<'de>>(&mut self, list: &str, elements: Vec<&RawValue>) -> Vec<T> {
        let most = LIST.min(ELEMENT_BYTES / size_of::<T>().max(1));
        if elements.len() > most {
            let detail = format!("{} elements are over the limit of {most} for this list (gltf_list)", elements.len());
            self.faults.push(Fault::new(list, Kind::Limit, detail));
            return Vec::new();
        }
        let mut read = Vec::with_capacity(elements.len());
        for (i, element) in elements.into_iter().enumerate() {
            match strict_json::from_slice(element.get().as_bytes()) {
                Ok(element) => read.push(element),
                Err(error) => {
                    let start = start_of(self.text, element);
                    let pointer = format!("{list}/{i}");
                    if !self.faults.push(fault(element.get().as_bytes(), start, self.text, pointer, &error)) {
                        break;
                    }
                }
            }
        }
        read
    }
}

/// Where a part of a text begins.
fn start_of(text: &[u8], part: &RawValue) -> usize {
    part.get().as_ptr() as usize - text.as_ptr() as usize
}

/// The fault that serde found in a part of a text, which begins at `start`.
fn fault(part: &[u8], start: usize, text: &[u8], pointer: String, error: &serde_json::Error) -> Fault {
    let words = error.to_string();
    let words = words.split(" at line ").next().unwrap_or_default();
    let kind = match words {
        words if words.starts_with("missing field") => Kind::MissingKey,
        words if words.contains("out of range") => Kind::OutOfRange,
        _ => Kind::WrongType,
    };
    // serde names types of ours.
    let words = match words.split_once("struct ") {
        Some((before, _)) if before.ends_with("expected ") => format!("{before}an object"),
        _ => words.to_owned(),
    };
    // A key that is missing belongs to the object that ends there.
    let at = (start + offset(part, error)).min(text.len().saturating_sub(1));
    Fault::new(pointer, kind, words).at(Place::Json(at))
}

/// The offset of the last byte that serde has read.
fn offset(text: &[u8], error: &serde_json::Error) -> usize {
    let mut start = 0;
    for _ in 1..error.line() {
        start += text[start..].iter().position(|byte| *byte == b'\n').map_or(text.len() - start, |at| at + 1);
    }
    (start + error.column().saturating_sub(1)).min(text.len())
}
