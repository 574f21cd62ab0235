//! Layers of a picture beside its colors: which there are, and rendering them.
//!
//! A pass of its own finds what camera rays meet first, so that pictures without layers cost nothing for them. The share of an
//! object in all mirrors and bodies is the picture of a scene in which only the object shines.

use super::first_hits::{FirstHits, Middle, SAMPLES, Sampled, Wanted, first_hits};
use super::packets::{KernelFormat, TraceJob};
use super::renderer::Renderer;
use super::tiles::BLOCK;
use super::{Picture, RenderOptions, render_window_with};
use crate::camera::Window;
use crate::control::{Cancelled, Control};
use crate::enum_names::{choice, list, words};
use crate::film::cryptomatte::{Cryptomatte, Ranks, id};
use crate::film::{ID_CHANNELS, Layer, Region};
use crate::lanes::dispatch;
use crate::scene::Scene;
use crate::scene::compile::Precise;
use crate::scene::problem::{did_you_mean, quoted};
use crate::trace::counts::RayCounts;
use fearless_simd::{Level, f32x16, f64x8};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// Kinds of layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LayerKind {
    /// Distance from the eye to what the middle of each pixel shows.
    Distance,
    /// The point of the scene that the middle of each pixel shows.
    Position,
    /// The normal there as lights see it, on the side of the eye.
    Normal,
    /// Diffuse color, averaged over each pixel.
    Albedo,
    /// Which objects each pixel shows, and how much of them.
    Object,
    /// Which materials each pixel shows, and how much of them.
    Material,
    /// share:/objects/3 is the share of that object in each pixel, also in mirrors and through glass.
    Share,
}

/// The layers that are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Layers {
    /// One bit for each kind.
    kinds: u8,
    /// The index of the object whose share is asked for.
    share: u32,
}

/// Bytes of memory for each pixel of a channel.
const CHANNEL_BYTES: u64 = 12;
/// Likewise of the picture that a share is.
const SHARE_BYTES: u64 = 32;

const KINDS: [LayerKind; 7] = [
    LayerKind::Distance,
    LayerKind::Position,
    LayerKind::Normal,
    LayerKind::Albedo,
    LayerKind::Object,
    LayerKind::Material,
    LayerKind::Share,
];

impl LayerKind {
    /// Its name.
    pub fn name(self) -> String {
        words::<Self>().swap_remove(self as usize).name
    }

    /// Channels in a file.
    fn channels(self) -> u64 {
        match self {
            Self::Distance => 1,
            Self::Position | Self::Normal | Self::Albedo => 3,
            Self::Object | Self::Material => ID_CHANNELS,
            Self::Share => 1,
        }
    }
}

impl Layers {
    /// Whether a kind is asked for.
    pub fn has(self, kind: LayerKind) -> bool {
        self.kinds & 1 << kind as u8 != 0
    }

    /// Whether none is.
    pub fn is_empty(self) -> bool {
        self.kinds == 0
    }

    /// The object whose share is asked for.
    pub fn share(self) -> Option<u32> {
        self.has(LayerKind::Share).then_some(self.share)
    }

    /// Bytes of memory for each pixel while they are made and written into one file with the colors.
    pub fn pixel_bytes(self) -> u64 {
        let Wanted { middle, samples, .. } = self.wanted();
        let hits = if middle { size_of::<Middle>() } else { 0 } + if samples { size_of::<Sampled>() } else { 0 };
        let channels: u64 = self.kinds().map(LayerKind::channels).sum();
        let share = if self.has(LayerKind::Share) { SHARE_BYTES } else { 0 };
        // Hits are put together from parts; a layer, a channel of it, and its bytes in the file; four channels of colors.
        if self.is_empty() { 0 } else { 2 * hits as u64 + CHANNEL_BYTES * (channels + 4) + share }
    }

    /// What the pass of first hits looks for.
    fn wanted(self) -> Wanted {
        let [middle, samples] = [
            [LayerKind::Distance, LayerKind::Position, LayerKind::Normal],
            [LayerKind::Albedo, LayerKind::Object, LayerKind::Material],
        ]
        .map(|kinds| kinds.into_iter().any(|kind| self.has(kind)));
        Wanted { middle, samples, albedo: self.has(LayerKind::Albedo), sources: false }
    }

    /// Those that are asked for.
    pub fn kinds(self) -> impl Iterator<Item = LayerKind> {
        KINDS.into_iter().filter(move |kind| self.has(*kind))
    }

    /// What is wrong with them for a scene.
    pub fn check(self, scene: &Scene) -> Result<(), String> {
        let objects = scene.sources.objects();
        match self.share() {
            Some(object) if object >= objects => {
                Err(format!("share:/objects/{object}: the scene has {objects} objects, and the first is /objects/0"))
            }
            _ => Ok(()),
        }
    }
}

/// From names with commas between; the error is a sentence.
impl FromStr for Layers {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut layers = Self::default();
        for name in text.split(',').map(str::trim) {
            let (kind, of) = name.split_once(':').map_or((name, None), |(kind, of)| (kind, Some(of)));
            let names = || words::<LayerKind>().into_iter().map(|word| word.name);
            let Some(kind) = choice::<LayerKind>(kind) else {
                let names: Vec<String> = names().collect();
                let suggestion = did_you_mean(kind, names.iter().map(String::as_str));
                let all = list(names.into_iter(), "and");
                let end = if suggestion.is_empty() { "." } else { &suggestion };
                return Err(format!("there is no layer {}{end} The layers are {all}", quoted(name)));
            };
            layers.share = match (kind, of) {
                (LayerKind::Share, of) => {
                    let object = of.and_then(|of| of.strip_prefix("/objects/")?.parse().ok());
                    let is_second = layers.has(kind);
                    object.filter(|_| !is_second).ok_or_else(|| {
                        let wrong = if is_second { "a render has one of it" } else { "it needs an object" };
                        format!("share: {wrong}; write share:/objects/3 for the fourth of the scene's objects")
                    })?
                }
                (_, Some(_)) => return Err(format!("{}: only share is of an object", quoted(name))),
                (_, None) => layers.share,
            };
            layers.kinds |= 1 << kind as u8;
        }
        Ok(layers)
    }
}

/// The names with dashes between, for names of files.
impl fmt::Display for Layers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |kind: LayerKind| match kind {
            LayerKind::Share => format!("share{}", self.share),
            kind => kind.name(),
        };
        f.write_str(&self.kinds().map(name).collect::<Vec<_>>().join("-"))
    }
}

/// Renders layers of a region of a window of the scene's picture, with the names of their kinds, and counts their rays. They are
/// those of the same part of the whole.
pub fn render_layers(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
    layers: Layers,
) -> Result<(Vec<(LayerKind, Layer)>, RayCounts), Cancelled> {
    let wanted = layers.wanted();
    let hits = if wanted.middle || wanted.samples {
        hits(scene, window, region, control, wanted)?
    } else {
        FirstHits::default()
    };
    let mut rays = hits.rays;
    let mut made = Vec::new();
    for kind in layers.kinds() {
        let layer = match kind {
            LayerKind::Distance => Layer::Distance(hits.middles.iter().map(|hit| hit.distance).collect()),
            LayerKind::Position => Layer::Position(hits.middles.iter().map(|hit| hit.position).collect()),
            LayerKind::Normal => Layer::Normal(hits.middles.iter().map(|hit| hit.normal).collect()),
            LayerKind::Albedo => Layer::Albedo(hits.sampled.iter().map(|hit| hit.albedo).collect()),
            LayerKind::Object => {
                let pixels = hits.sampled.iter().map(|hit| hit.objects);
                ids("crypto_object", pixels, |object| format!("/objects/{object}"))
            }
            LayerKind::Material => {
                let pixels = hits.sampled.iter().map(|hit| hit.materials);
                ids("crypto_material", pixels, |material| scene.sources.material(material).to_owned())
            }
            LayerKind::Share => {
                let (shares, more) = share(scene, window, region, control, layers.share)?;
                rays = rays + more;
                Layer::Share(format!("/objects/{}", layers.share), shares)
            }
        };
        made.push((kind, layer));
    }
    Ok((made, rays))
}

/// Whose surface is seen through the middle of each pixel of a region, row by row: the number of its
/// [source](crate::scene::compile::Sources), none where nothing is. Bodies that are placed together have that of what places
/// them.
pub fn render_sources(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
) -> Result<Vec<Option<u32>>, Cancelled> {
    let wanted = Wanted { middle: true, samples: false, albedo: false, sources: true };
    let hits = hits(scene, window, region, control, wanted)?;
    Ok(hits.middles.iter().map(|hit| hit.source).collect())
}

/// What is asked for of the rays of a region.
fn hits(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
    wanted: Wanted,
) -> Result<FirstHits, Cancelled> {
    let level = Level::new();
    match &scene.world {
        Precise::Single(world) => {
            let job = Renderer::new(scene, world, control, RenderOptions::default()).through(window).job;
            of_region(&job, region, |at, out| {
                dispatch!(level, first_hits::<f32x16, f32>(scene, &job, at, wanted, out));
            })
        }
        Precise::Double(world) => {
            let job = Renderer::new(scene, world, control, RenderOptions::default()).through(window).job;
            of_region(&job, region, |at, out| {
                dispatch!(level, first_hits::<f64x8, f64>(scene, &job, at, wanted, out));
            })
        }
    }
}

/// What the rays of a region meet, row by row.
fn of_region<R: KernelFormat>(
    job: &TraceJob<'_, R>,
    region: Region,
    trace: impl Fn(&[[u32; 2]], &mut FirstHits) + Sync,
) -> Result<FirstHits, Cancelled> {
    // Rows of blocks are whole rows of pixels.
    let rows: Vec<Region> = (0..region.height.div_ceil(BLOCK))
        .map(|row| Region { y: region.y + row * BLOCK, height: BLOCK.min(region.height - row * BLOCK), ..region })
        .collect();
    let of_rows = |rows: &Region| {
        let at: Vec<[u32; 2]> = rows.tiles(BLOCK).flat_map(Region::iter).collect();
        let mut traced = FirstHits::default();
        job.control.add_total(rows.pixels());
        trace(&at, &mut traced);
        job.control.add_rays(traced.rays.total());
        if job.control.stops() {
            return Err(Cancelled);
        }
        job.control.add_done(rows.pixels());
        Ok(FirstHits {
            middles: by_rows(*rows, &at, &traced.middles),
            sampled: by_rows(*rows, &at, &traced.sampled),
            rays: traced.rays,
        })
    };
    let parts: Result<Vec<FirstHits>, Cancelled> = rows.par_iter().with_max_len(1).map(of_rows).collect();
    let mut all = FirstHits::default();
    for part in parts? {
        all.middles.extend(part.middles);
        all.sampled.extend(part.sampled);
        all.rays = all.rays + part.rays;
    }
    Ok(all)
}

/// Values in the order of the pixels at `at`, row by row.
fn by_rows<T: Copy + Default>(region: Region, at: &[[u32; 2]], values: &[T]) -> Vec<T> {
    let mut rows = vec![T::default(); values.len()];
    for (at, value) in at.iter().zip(values) {
        rows[region.index(*at)] = *value;
    }
    rows
}

/// The ids of things that have names.
fn ids(name: &'static str, pixels: impl Iterator<Item = Ranks>, name_of: impl Fn(u32) -> String) -> Layer {
    let mut known = BTreeMap::new();
    let mut manifest = BTreeMap::new();
    let mut ids_of = |mut ranks: Ranks| {
        for (thing, share) in &mut ranks {
            if *share > 0.0 {
                *thing = *known.entry(*thing).or_insert_with(|| {
                    let name = name_of(*thing);
                    let id = id(&name);
                    manifest.insert(name, id);
                    id
                });
            }
        }
        ranks
    };
    let pixels = pixels.map(&mut ids_of).collect();
    Layer::Ids(Cryptomatte { name, pixels, manifest })
}

/// The share of an object in each pixel, and the rays of that; 0 everywhere if there is no such object.
fn share(
    scene: &Scene,
    window: &Window,
    region: Region,
    control: &Control,
    object: u32,
) -> Result<(Vec<f32>, RayCounts), Cancelled> {
    let Some(glowing) = scene.glowing(object, SAMPLES) else {
        return Ok((vec![0.0; region.pixels() as usize], RayCounts::default()));
    };
    let Picture { film, rays, .. } = render_window_with(&glowing, window, region, control, RenderOptions::default())?;
    let mean = |light: &[f32; 3]| (light.iter().sum::<f32>() / 3.0).clamp(0.0, 1.0);
    Ok((film.pixels.iter().map(mean).collect(), rays))
}
