//! The JSON of a glTF 2.0 file as serde reads it. Keys that are not listed are ignored, as the specification asks.
//!
//! The elements of the lists are read one by one, so that each that is wrong is reported.

use super::super::fault::{Fault, Faults, Kind, Place};
use serde::Deserialize;
use serde_json::value::RawValue;
use std::collections::BTreeMap;

/// Most elements of a list.
const ELEMENTS: usize = 1 << 20;

/// A file, with its lists unread.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Lists<'a> {
    #[serde(borrow)]
    asset: Option<&'a RawValue>,
    scene: Option<usize>,
    #[serde(default)]
    extensions_required: Vec<String>,
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

/// A file.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub(super) scene: Option<usize>,
    pub(super) extensions_required: Vec<String>,
    pub(super) scenes: Vec<Scene>,
    pub(super) nodes: Vec<Node>,
    pub(super) meshes: Vec<Mesh>,
    pub(super) accessors: Vec<Accessor>,
    pub(super) views: Vec<BufferView>,
    pub(super) buffers: Vec<Buffer>,
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    pub(super) images: Vec<Image>,
    pub(super) samplers: Vec<Sampler>,
    pub(super) cameras: Vec<Camera>,
    pub(super) skins: Vec<Skin>,
    pub(super) animations: Vec<Animation>,
    pub(super) lights: Vec<Light>,
    pub(super) variants: Vec<Variant>,
}

#[derive(Debug, Deserialize)]
struct Asset {
    version: String,
}

#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct Node {
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) children: Vec<usize>,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) camera: Option<usize>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    pub(super) weights: Option<Vec<f64>>,
    #[serde(default)]
    pub(super) extensions: NodeExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(super) light: Option<NodeLight>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(super) instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    pub(super) visibility: Option<Visibility>,
}

#[derive(Debug, Deserialize)]
pub(super) struct NodeLight {
    pub(super) light: usize,
}

#[derive(Debug, Deserialize)]
pub(super) struct Instancing {
    #[serde(default)]
    pub(super) attributes: BTreeMap<String, usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Visibility {
    #[serde(default = "yes")]
    pub(super) visible: bool,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    pub(super) name: Option<String>,
    pub(super) primitives: Vec<Primitive>,
    pub(super) weights: Option<Vec<f64>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: BTreeMap<String, usize>,
    pub(super) indices: Option<usize>,
    pub(super) material: Option<usize>,
    #[serde(default = "triangles")]
    pub(super) mode: u32,
    #[serde(default)]
    pub(super) targets: Vec<BTreeMap<String, usize>>,
    #[serde(default)]
    pub(super) extensions: PrimitiveExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_materials_variants")]
    pub(super) variants: Option<Mappings>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mappings {
    #[serde(default)]
    pub(super) mappings: Vec<Mapping>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mapping {
    pub(super) material: usize,
    #[serde(default)]
    pub(super) variants: Vec<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: u64,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
    #[serde(default)]
    pub(super) extensions: ViewExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub(super) meshopt: Option<Meshopt>,
}

/// A view whose bytes are compressed.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Meshopt {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: u64,
    pub(super) count: u64,
    pub(super) mode: String,
    #[serde(default = "no_filter")]
    pub(super) filter: String,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: u64,
    #[serde(default)]
    pub(super) extensions: BufferExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct BufferExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub(super) meshopt: Option<Fallback>,
}

/// A buffer that is only there for readers without the extension.
#[derive(Debug, Deserialize)]
pub(super) struct Fallback {
    #[serde(default)]
    pub(super) fallback: bool,
}

#[derive(Debug, Deserialize)]
pub(super) struct Texture {
    pub(super) sampler: Option<usize>,
    pub(super) source: Option<usize>,
    #[serde(default)]
    pub(super) extensions: TextureExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    pub(super) webp: Option<Source>,
    #[serde(rename = "KHR_texture_basisu")]
    pub(super) basisu: Option<Source>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Source {
    pub(super) source: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    pub(super) uri: Option<String>,
    pub(super) buffer_view: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Sampler {
    pub(super) mag_filter: Option<u32>,
    #[serde(default = "repeat")]
    pub(super) wrap_s: u32,
    #[serde(default = "repeat")]
    pub(super) wrap_t: u32,
}

#[derive(Debug, Deserialize)]
pub(super) struct Camera {
    pub(super) name: Option<String>,
    pub(super) perspective: Option<Perspective>,
    pub(super) orthographic: Option<Orthographic>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Perspective {
    pub(super) yfov: f64,
}

#[derive(Debug, Deserialize)]
pub(super) struct Orthographic {
    pub(super) ymag: f64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub(super) joints: Vec<usize>,
    pub(super) skeleton: Option<usize>,
    pub(super) inverse_bind_matrices: Option<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Animation {
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) channels: Vec<Channel>,
    #[serde(default)]
    pub(super) samplers: Vec<AnimationSampler>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Channel {
    pub(super) sampler: usize,
    pub(super) target: Target,
}

#[derive(Debug, Deserialize)]
pub(super) struct Target {
    pub(super) node: Option<usize>,
    pub(super) path: String,
}

#[derive(Debug, Deserialize)]
pub(super) struct AnimationSampler {
    pub(super) input: usize,
    pub(super) output: usize,
    #[serde(default = "linear")]
    pub(super) interpolation: String,
}

#[derive(Debug, Deserialize)]
pub(super) struct Light {
    #[serde(rename = "type")]
    pub(super) kind: String,
    #[serde(default = "white")]
    pub(super) color: [f64; 3],
    #[serde(default = "one")]
    pub(super) intensity: f64,
    pub(super) range: Option<f64>,
    #[serde(default)]
    pub(super) spot: Spot,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Spot {
    #[serde(default)]
    pub(super) inner_cone_angle: f64,
    pub(super) outer_cone_angle: Option<f64>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Variant {
    pub(super) name: Option<String>,
}

pub(super) use super::json_materials::Material;

fn yes() -> bool {
    true
}

fn triangles() -> u32 {
    4
}

fn repeat() -> u32 {
    10_497
}

fn no_filter() -> String {
    "NONE".into()
}

fn linear() -> String {
    "LINEAR".into()
}

fn one() -> f64 {
    1.0
}

fn white() -> [f64; 3] {
    [1.0; 3]
}

/// Reads the JSON; all elements that are wrong are reported.
pub(super) fn read(text: &[u8]) -> Result<Document, Faults> {
    let lists: Lists<'_> = serde_json::from_slice(text).map_err(|error| {
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
    match serde_json::from_str::<Asset>(asset.get()) {
        Ok(asset) if asset.version.starts_with("2.") => {}
        Ok(asset) => {
            let shown: String = asset.version.chars().take(20).collect();
            let detail = format!("this is glTF {shown:?}, and glTF 2.0 is read: convert it");
            faults.push(Fault::new("/asset/version", Kind::Unsupported, detail));
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
    fn of<T: for<'de> Deserialize<'de>>(&mut self, list: &str, elements: Vec<&RawValue>) -> Vec<T> {
        if elements.len() > ELEMENTS {
            let detail = format!("{} elements are over the limit of {ELEMENTS} (gltf_elements)", elements.len());
            self.faults.push(Fault::new(list, Kind::Limit, detail));
            return Vec::new();
        }
        let mut read = Vec::with_capacity(elements.len());
        for (i, element) in elements.into_iter().enumerate() {
            match serde_json::from_str(element.get()) {
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
    // A key that is missing belongs to the object that ends there.
    let at = (start + offset(part, error)).min(text.len().saturating_sub(1));
    Fault::new(pointer, kind, words.to_owned()).at(Place::Json(at))
}

/// The offset of the last byte that serde has read.
fn offset(text: &[u8], error: &serde_json::Error) -> usize {
    let mut start = 0;
    for _ in 1..error.line() {
        start += text[start..].iter().position(|byte| *byte == b'\n').map_or(text.len() - start, |at| at + 1);
    }
    (start + error.column().saturating_sub(1)).min(text.len())
}
