//! Known scenes and the descriptions of their tiles, for the contract.
#![allow(dead_code, reason = "only their descriptions are used")]

use super::generated::{Estimate, SceneProblem};
use utoipa::ToSchema;

/// A scene that is remembered.
#[derive(Debug, ToSchema)]
pub(crate) struct KnownScene {
    /// Its name: a hash of its canonical text.
    scene_id: String,
    /// The name of its picture, opened as 2^zoom times its size.
    image_id: String,
    /// As how many times its size it was opened.
    zoom: u32,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// What the author should know.
    warnings: Vec<SceneProblem>,
    /// Rays and milliseconds that its own picture should take.
    estimate: Estimate,
    /// Addresses of the scene, its picture, and its tiles by each convention.
    links: SceneLinks,
}

/// Addresses of a scene, its picture, and its tiles by each convention.
#[derive(Debug, ToSchema)]
pub(crate) struct SceneLinks {
    /// The scene's canonical text.
    #[schema(rename = "self")]
    this: String,
    /// The picture as a PNG.
    image: String,
    /// The description of the image for IIIF.
    iiif: String,
    /// The description of the image for DZI.
    dzi: String,
    /// The description of the image's tiles for XYZ.
    xyz: String,
}

/// The description of an image by the IIIF Image API 3.0.
#[derive(Debug, ToSchema)]
pub(crate) struct ImageInfo {
    /// Where the words are defined.
    #[schema(rename = "@context")]
    context: String,
    /// The image's address.
    id: String,
    /// `ImageService3`.
    r#type: String,
    /// Address of the protocol.
    protocol: String,
    /// `level2`.
    profile: String,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// Most pixels of one answer.
    #[schema(rename = "maxArea")]
    max_area: u64,
    /// Sizes that the whole image comes in.
    sizes: Vec<InfoSize>,
    /// Tiles and how much smaller than the image they may be.
    tiles: Vec<InfoTile>,
    /// Formats, the best first.
    #[schema(rename = "preferredFormats")]
    preferred_formats: Vec<String>,
    /// Formats beyond those of level 2.
    #[schema(rename = "extraFormats")]
    extra_formats: Vec<String>,
    /// Qualities beyond `default`.
    #[schema(rename = "extraQualities")]
    extra_qualities: Vec<String>,
    /// Features beyond those of level 2.
    #[schema(rename = "extraFeatures")]
    extra_features: Vec<String>,
}

/// A size of an image.
#[derive(Debug, ToSchema)]
pub(crate) struct InfoSize {
    /// `Size`.
    r#type: String,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
}

/// Tiles of an image.
#[derive(Debug, ToSchema)]
pub(crate) struct InfoTile {
    /// `Tile`.
    r#type: String,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// How many pixels of the image one of the tile's may stand for, across and down.
    #[schema(rename = "scaleFactors")]
    scale_factors: Vec<u64>,
}

/// The description of an image's tiles: TileJSON, with pixels for coordinates.
#[derive(Debug, ToSchema)]
pub(crate) struct TileJson {
    /// `3.0.0`.
    tilejson: String,
    /// `simple`.
    crs: String,
    /// Addresses with `{z}`, `{x}` and `{y}` in them.
    tiles: Vec<String>,
    /// Edge of a tile in pixels.
    #[schema(rename = "tileSize")]
    tile_size: u32,
    /// Pixels across.
    width: u32,
    /// Pixels down.
    height: u32,
    /// 0: the whole image in one tile.
    minzoom: u32,
    /// The deepest zoom there is.
    maxzoom: u32,
    /// The zoom at which the image has its own size.
    nativezoom: u32,
}
