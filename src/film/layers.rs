//! Layers of a picture beside its colors: what stands in each pixel of one file with many channels, or of pictures of their own.

use super::cryptomatte::{Cryptomatte, RANKS, Ranks};
use super::{Codes, FileFormat, Film, Region, png};
use ::png::BitDepth;
use serde_json::json;

/// What is shown of the farthest thing, from black to white.
const DARKEST: f32 = 1.0 / 255.0;
/// The nearest distance that is told from others, as a part of the largest.
const LEAST_DISTANCE: f32 = 1e-3;

/// A layer, row by row.
#[derive(Debug, Clone, PartialEq)]
pub enum Layer {
    /// Distances; infinite where nothing is.
    Distance(Vec<f32>),
    /// Points.
    Position(Vec<[f32; 3]>),
    /// Unit vectors; 0 where nothing is.
    Normal(Vec<[f32; 3]>),
    /// Colors.
    Albedo(Vec<[f32; 3]>),
    /// Names.
    Ids(Cryptomatte),
    /// The share of one object, which is named.
    Share(String, Vec<f32>),
}

/// One channel of a file.
#[derive(Debug)]
pub(super) struct Channel {
    pub(super) name: String,
    pub(super) values: Vec<f32>,
}

impl Layer {
    /// Its channels, by the names that other programs know.
    pub(super) fn channels(self) -> Vec<Channel> {
        let three = |layer: &str, letters: [&str; 3], vectors: &[[f32; 3]]| {
            let channel = |c: usize| Channel {
                name: format!("{layer}.{}", letters[c]),
                values: vectors.iter().map(|v| v[c]).collect(),
            };
            vec![channel(0), channel(1), channel(2)]
        };
        match self {
            Self::Distance(values) => vec![Channel { name: "Z".into(), values }],
            Self::Position(points) => three("P", ["X", "Y", "Z"], &points),
            Self::Normal(normals) => three("N", ["X", "Y", "Z"], &normals),
            Self::Albedo(colors) => three("albedo", ["R", "G", "B"], &colors),
            Self::Ids(ids) => ids.channels().collect(),
            Self::Share(_, values) => vec![Channel { name: "share.Y".into(), values }],
        }
    }

    /// What a file says about it.
    pub(super) fn attributes(&self) -> Vec<(String, String)> {
        match self {
            Self::Ids(ids) => ids.attributes().to_vec(),
            Self::Share(object, _) => vec![("share/object".into(), object.clone())],
            _ => Vec::new(),
        }
    }

    /// The layer as a PNG of 8 or 16 bits. A text in it says what the codes mean.
    pub fn png(&self, region: Region, format: FileFormat) -> Vec<u8> {
        let (codes, note) = self.codes(region, format);
        let depth = if format == FileFormat::Png16 { BitDepth::Sixteen } else { BitDepth::Eight };
        png::file([region.width, region.height], &codes, 3, depth, Some(&note))
    }

    /// Codes of three channels, and what they mean.
    fn codes(&self, region: Region, format: FileFormat) -> (Vec<u8>, String) {
        let linear = |values: &mut dyn Iterator<Item = [f32; 3]>| codes(values, format);
        match self {
            Self::Distance(distances) => {
                let [near, far] = ends(distances.iter().copied());
                // Even steps of 1/distance show near things better than a horizon. Nothing is black, and so the farthest is not.
                let inverse = |d: f32| 1.0 / d.max(far * LEAST_DISTANCE).max(f32::MIN_POSITIVE);
                let ends = [far, near].map(inverse);
                let shown =
                    |d: f32| if d.is_finite() { DARKEST + (1.0 - DARKEST) * part(inverse(d), ends) } else { 0.0 };
                let note = json!({ "layer": "distance", "white": near.max(far * LEAST_DISTANCE), "darkest": far,
                                   "black": "nothing", "steps": "1/distance" });
                (linear(&mut distances.iter().map(|d| [shown(*d); 3])), note.to_string())
            }
            Self::Position(points) => {
                let ends: [[f32; 2]; 3] = std::array::from_fn(|c| ends(points.iter().map(|p| p[c])));
                let shown = |p: &[f32; 3]| std::array::from_fn(|c| part(p[c], ends[c]));
                let note = json!({ "layer": "position", "black": ends.map(|e| e[0]), "white": ends.map(|e| e[1]) });
                (linear(&mut points.iter().map(shown)), note.to_string())
            }
            Self::Normal(normals) => {
                let shown = |n: &[f32; 3]| if *n == [0.0; 3] { *n } else { n.map(|x| 0.5 + 0.5 * x) };
                let note = json!({ "layer": "normal", "black": -1, "white": 1 });
                (linear(&mut normals.iter().map(shown)), note.to_string())
            }
            Self::Albedo(colors) => {
                let film = Film { region, pixels: colors.clone(), ..Film::default() };
                (Codes::new(&film, format).codes, json!({ "layer": "albedo", "codes": "sRGB" }).to_string())
            }
            Self::Ids(ids) => {
                let shown = |ranks: &Ranks| color(if ranks[0].1 > 0.0 { Some(ranks[0].0) } else { None });
                let hex = |id| {
                    let [r, g, b] = color(Some(id));
                    format!("#{r:02x}{g:02x}{b:02x}")
                };
                let colors: serde_json::Value = serde_json::from_str(&ids.listed(hex)).unwrap_or_default();
                let bytes = ids.pixels.iter().flat_map(shown);
                let note = json!({ "layer": ids.name.trim_start_matches("crypto_"), "colors": colors });
                let codes = match format {
                    FileFormat::Png16 => bytes.flat_map(|code| [code, code]).collect(),
                    _ => bytes.collect(),
                };
                (codes, note.to_string())
            }
            Self::Share(object, shares) => {
                let note = json!({ "layer": "share", "object": object, "black": 0, "white": 1 });
                (linear(&mut shares.iter().map(|share| [*share; 3])), note.to_string())
            }
        }
    }
}

/// Codes of numbers from 0 to 1, in equal steps.
fn codes(pixels: &mut dyn Iterator<Item = [f32; 3]>, format: FileFormat) -> Vec<u8> {
    match format {
        FileFormat::Png16 => {
            pixels.flatten().flat_map(|x| ((65535.0 * x.clamp(0.0, 1.0) + 0.5) as u16).to_be_bytes()).collect()
        }
        _ => pixels.flatten().map(|x| (255.0 * x.clamp(0.0, 1.0) + 0.5) as u8).collect(),
    }
}

/// The color of an id: three of its bytes, none of them dark. Nothing is black.
fn color(id: Option<u32>) -> [u8; 3] {
    id.map_or([0; 3], |id| [id >> 16, id >> 8, id].map(|byte| 64 + (byte & 255) as u8 / 4 * 3))
}

/// The least and the largest of finite numbers.
fn ends(values: impl Iterator<Item = f32>) -> [f32; 2] {
    let widest = |[least, most]: [f32; 2], x: f32| [least.min(x), most.max(x)];
    let ends = values.filter(|x| x.is_finite()).fold([f32::INFINITY, f32::NEG_INFINITY], widest);
    if ends[0] <= ends[1] { ends } else { [0.0; 2] }
}

/// Where a number lies between two others: 0 at the first, 1 at the second, and 1 where both are the same.
fn part(x: f32, [from, to]: [f32; 2]) -> f32 {
    if from == to { 1.0 } else { (x - from) / (to - from) }
}

/// Channels of ids in a file.
pub const ID_CHANNELS: u64 = 2 * RANKS as u64;
