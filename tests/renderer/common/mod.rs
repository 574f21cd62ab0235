//! What several tests need: the scenes of the repository, and rendering them as a user would.
#![allow(clippy::neg_cmp_op_on_partial_ord, reason = "NaN must count as wrong")]

pub mod bodies;
pub mod distances;
pub mod floors;
pub mod leaving;
pub mod meshes;
pub mod naive;
pub mod numbers;
pub mod questions;
pub mod watertight;
pub mod wide;

use std::path::{Path, PathBuf};
use strahl::film::{Film, Region};
use strahl::render::{Control, RenderOptions, render_with};
use strahl::scene::{Description, Format, Loaded, Overrides, load};

/// All scenes under `scenes/`, as "folder/name", sorted.
pub fn scene_names() -> Vec<String> {
    let mut names = Vec::new();
    for folder in std::fs::read_dir(root().join("scenes")).unwrap() {
        let folder = folder.unwrap().path();
        if !folder.is_dir() {
            continue;
        }
        for file in std::fs::read_dir(&folder).unwrap() {
            let path = file.unwrap().path();
            if path.extension().is_some_and(|e| e == "json") {
                let part = |p: &Path| p.file_stem().unwrap().to_str().unwrap().to_owned();
                names.push(format!("{}/{}", part(&folder), part(&path)));
            }
        }
    }
    names.sort();
    assert!(names.len() >= 15, "the scenes have gone: {names:?}");
    names
}

/// The repository.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Reads a file of the repository.
pub fn read(path: &str) -> Vec<u8> {
    std::fs::read(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Loads a scene of the repository at a width, its shape kept.
pub fn load_scene(name: &str, width: u32, mut overrides: Overrides) -> Loaded {
    let text = read(&format!("scenes/{name}.json"));
    let description: Description = serde_json::from_slice(&text).unwrap();
    let image = description.image;
    overrides.width = Some(width);
    overrides.height = Some((image.height * width).div_ceil(image.width));
    load(&text, Format::Json, &overrides).unwrap_or_else(|problems| panic!("{name}: {problems}"))
}

/// Renders the whole picture.
pub fn render_whole(loaded: &Loaded) -> Film {
    render_as(loaded, RenderOptions::default())
}

/// Renders the whole picture, cut in a given way.
pub fn render_as(loaded: &Loaded, cut: RenderOptions) -> Film {
    let region = Region::whole(loaded.scene.width, loaded.scene.height);
    render_with(&loaded.scene, region, &Control::default(), cut).unwrap().film
}

/// Works through many cases on threads of its own.
///
/// Tests share a process and with it rayon's threads. A thread that waits for its picture takes up any work that is queued:
/// another test's would count into the time that this case may take, and on the stack that this case has left.
pub fn on_own_threads<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().build().unwrap().install(work)
}

/// A small generator of reproducible random numbers (Marsaglia's xorshift64*).
pub struct Random(u64);

impl Random {
    /// A generator; equal seeds give equal sequences.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in 0..n.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// A point in a cube around the origin.
    pub fn point(&mut self, half: f64) -> [f64; 3] {
        std::array::from_fn(|_| self.between(-half, half))
    }
}
