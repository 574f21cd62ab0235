//! All limits of scenes. Errors name the constant.

use crate::models;

/// A limit by name, as errors and `GET /v1/limits` quote it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    /// Name in errors.
    pub name: &'static str,
    /// Largest value allowed.
    pub max: u64,
}

impl Limit {
    const fn new(name: &'static str, max: u64) -> Self {
        Self { name, max }
    }
}

/// Bytes of a scene file, after decompression.
pub const SCENE_BYTES: Limit = Limit::new("scene_bytes", 256 << 20);
/// Levels of arrays and objects in the JSON.
pub const JSON_DEPTH: Limit = Limit::new("json_depth", 127);
/// Groups in groups and instances in definitions in instances, counted along the longest chain.
pub const NESTING: Limit = Limit::new("nesting", 32);
/// Objects written in a scene, faces of meshes not counted.
pub const OBJECTS: Limit = Limit::new("objects", 2_000_000);
/// Triangles written in a scene.
pub const TRIANGLES: Limit = Limit::new("triangles", 20_000_000);
/// Bytes of a name: of a scene, a material, a definition or an object, in UTF-8.
pub const NAME_BYTES: Limit = Limit::new("name_bytes", models::NAME_BYTES as u64);
/// Lights.
pub const LIGHTS: Limit = Limit::new("lights", 1_000);
/// Corners of one polygon.
pub const POLYGON_VERTICES: Limit = Limit::new("polygon_vertices", models::polygon::MOST_CORNERS as u64);
/// Sum of the squares of the corners of all polygons, which bounds the time of ear clipping.
pub const POLYGON_WORK: Limit = Limit::new("polygon_work", models::polygon::MOST_WORK);
/// Primitives after all instances are expanded, which never happens in memory: 2^53, so that JSON keeps the count exact.
pub const EXPANDED_PRIMITIVES: Limit = Limit::new("expanded_primitives", 1 << 53);
/// Width or height of the picture.
pub const IMAGE_SIDE: Limit = Limit::new("image_side", 16_384);
/// Pixels of the picture.
pub const PIXELS: Limit = Limit::new("pixels", 100_000_000);
/// Samples per pixel.
pub const SAMPLES: Limit = Limit::new("samples", 1_024);
/// Depth of the ray tree.
pub const MAX_DEPTH: Limit = Limit::new("max_depth", 100_000);
/// Rays followed for one sample; deeper rays are dropped and counted in `cost.rays.dropped`.
pub const RAYS_PER_SAMPLE: Limit = Limit::new("rays_per_sample", 1_000_000);
/// Rays recorded for one ray tree.
pub const TREE_RAYS: Limit = Limit::new("tree_rays", 100_000);
/// Bytes of a picture in a scene, before it is decoded.
pub const PICTURE_BYTES: Limit = Limit::new("picture_bytes", 64 << 20);
/// Width or height of a picture in a scene.
pub const PICTURE_SIDE: Limit = Limit::new("picture_side", 16_384);
/// Bytes of memory that all pictures of a scene take, decoded: 4 for each pixel of 8 bits, 16 for one of 16 bits.
pub const PICTURE_MEMORY: Limit = Limit::new("picture_memory", 256 << 20);
/// Warnings of the file that a scene was made of.
pub const IMPORT_WARNINGS: Limit = Limit::new("import_warnings", 50);
/// Characters of one of them, as JSON Schema counts them: Unicode code points.
pub const IMPORT_WARNING_CHARACTERS: Limit = Limit::new("import_warning_characters", 1_024);
/// Bytes that a model may have once it is decoded.
pub const DECODED_BYTES: Limit = Limit::new("decoded_bytes", models::DECODED_BYTES);
/// Lists and objects in the JSON of a glTF file.
pub const GLTF_ELEMENTS: Limit = Limit::new("gltf_elements", models::gltf::ELEMENTS as u64);
/// Elements of a list in the JSON of a glTF file; fewer of those that take much memory.
pub const GLTF_LIST: Limit = Limit::new("gltf_list", models::gltf::LIST as u64);
/// Nodes of a glTF file.
pub const NODES: Limit = Limit::new("nodes", models::gltf::NODES as u64);
/// Nodes of a glTF file below each other.
pub const NODE_LEVELS: Limit = Limit::new("node_levels", models::gltf::NODE_LEVELS as u64);
/// Problems reported for one scene.
pub const PROBLEMS: Limit = Limit::new("problems", 50);
/// All limits that have a name.
pub const ALL: [Limit; 27] = [
    SCENE_BYTES,
    JSON_DEPTH,
    NESTING,
    OBJECTS,
    TRIANGLES,
    NAME_BYTES,
    LIGHTS,
    POLYGON_VERTICES,
    POLYGON_WORK,
    EXPANDED_PRIMITIVES,
    IMAGE_SIDE,
    PIXELS,
    SAMPLES,
    MAX_DEPTH,
    RAYS_PER_SAMPLE,
    TREE_RAYS,
    PICTURE_BYTES,
    PICTURE_SIDE,
    PICTURE_MEMORY,
    IMPORT_WARNINGS,
    IMPORT_WARNING_CHARACTERS,
    DECODED_BYTES,
    GLTF_ELEMENTS,
    GLTF_LIST,
    NODES,
    NODE_LEVELS,
    PROBLEMS,
];
/// Problems looked for in one scene, so that it can be said how many more there are.
pub(in crate::scene) const PROBLEMS_FOUND: usize = 1_000;
/// Bytes of all problems that are reported; one is reported in any case.
pub(in crate::scene) const PROBLEM_BYTES: usize = 64 << 10;
/// Largest magnitude of a coordinate, length or color, so that squares of lengths stay finite in single precision.
pub const MAGNITUDE: f64 = 1e15;
/// Smallest length, so that squares of lengths do not vanish in single precision.
pub const SMALLEST_LENGTH: f64 = 1e-15;
/// Largest coefficient of a material (k_a, k_d, k_s, r_s, r_t). Nothing real is above 1.
pub const COEFFICIENT: f64 = 1e3;
/// Least share of light that a body may let pass over its attenuation distance.
pub const SMALLEST_SHARE: f64 = 1e-6;
/// Largest angle of a motion while the shutter is open, in degrees: 100 turns.
pub const ROTATION: f64 = 36_000.0;
