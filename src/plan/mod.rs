//! Plans, like EXPLAIN of a database: which effects a scene calls for, how deep its rays go, and estimates of rays and time.

mod block;
mod cells;
pub mod depth;
pub mod estimate;
pub mod explain;
pub mod pilot;
pub mod ray_times;
mod savings;
mod survey;
pub mod table;

use crate::accel::ALLOCATION;
use crate::control::milliseconds;
use crate::lanes::Real;
use crate::scene::compile::Precise;
use crate::scene::description::{Accuracy, Description, Precision};
use crate::scene::effects::Effect;
use crate::scene::world::World;
use crate::scene::{Problem, Scene};
use crate::trace::variants::KernelVariant;
use depth::Depth;
use estimate::Estimate;
use explain::{Explanation, Lookup, explain};
use fearless_simd::Level;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::time::Instant;

/// The plan of a scene.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Plan {
    /// The kernel that traces it.
    #[serde(flatten)]
    pub kernel: Kernel,
    /// Its effects.
    #[serde(flatten)]
    pub explanation: Explanation,
    /// Depth of the recursion.
    pub depth: Depth,
    /// Most primitives that lie around one point. A ray may take as many steps there, which the estimate does not include.
    pub overlap: f64,
    /// Warnings about the scene.
    pub warnings: Vec<Problem>,
    /// What ends the recursion, and may end the picture.
    #[serde(skip)]
    pub accuracy: Accuracy,
    /// Estimate of the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimate: Option<Estimate>,
    /// Milliseconds that the plan took, with its estimates, but without loading the scene.
    pub explain_ms: f64,
}

/// The compiled kernel that traces a scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Kernel {
    /// Features it contains besides camera and shadow rays, as `REFLECTION|TRANSMISSION`. `LOCAL`: none.
    pub kernel: String,
    /// Features that the scene does not need.
    pub superset_of_needed: Vec<&'static str>,
    /// Hash of all that selects machine code: kernel, precision, instruction set, version.
    pub kernel_hash: String,
    /// Floating-point format.
    pub precision: Precision,
}

/// What a plan says of a description. The rest of it follows from the scene, so this is all that has to be kept.
#[derive(Debug, Clone)]
pub struct Outline {
    max_depth: Option<u32>,
    accuracy: Accuracy,
    /// Values of the pointers of effects.
    values: Vec<(Effect, BTreeMap<String, Value>)>,
}

impl Outline {
    /// The outline of a scene and the description it was compiled from.
    pub fn new(description: &mut Description, scene: &Scene) -> Self {
        let lookup = Lookup::new(description);
        let values = scene.effects.iter().map(|entry| (entry.effect, lookup.values(&entry.because)));
        let mut values: Vec<_> = values.filter(|(_, values)| !values.is_empty()).collect();
        values.shrink_to_fit();
        let render = &description.render;
        Self { max_depth: render.max_depth, accuracy: render.accuracy(), values }
    }

    /// The plan of the scene.
    pub fn plan(&self, scene: &Scene) -> Plan {
        let started = Instant::now();
        let mut explanation = explain(scene);
        for (effect, values) in &self.values {
            let row = explanation.effects.iter_mut().find(|row| row.kind == *effect);
            row.into_iter().for_each(|row| row.values.clone_from(values));
        }
        let requested = self.max_depth;
        let (kernel, depth) = match &scene.world {
            Precise::Single(world) => (Kernel::of(world, Precision::Single), Depth::of(requested, world, &explanation)),
            Precise::Double(world) => (Kernel::of(world, Precision::Double), Depth::of(requested, world, &explanation)),
        };
        let warnings = scene.warnings.clone();
        Plan {
            kernel,
            explanation,
            depth,
            overlap: scene.overlap,
            warnings,
            accuracy: self.accuracy,
            estimate: None,
            explain_ms: milliseconds(started),
        }
    }

    /// Bytes of memory it takes, about.
    pub fn bytes(&self) -> usize {
        let pairs = self.values.iter().flat_map(|(_, values)| values);
        size_of_val(&self.values[..]) + pairs.map(|(pointer, _)| 3 * ALLOCATION + pointer.len()).sum::<usize>()
    }
}

impl Plan {
    /// The plan of a scene and the description it was compiled from.
    pub fn new(description: &mut Description, scene: &Scene) -> Self {
        Outline::new(description, scene).plan(scene)
    }
}

impl Kernel {
    fn of<R: Real>(world: &World<R>, precision: Precision) -> Self {
        let axes = KernelVariant::of(world).axes();
        let effects = world.effects;
        let needed = [
            effects.has(Effect::Reflection) || effects.has(Effect::Fresnel),
            effects.has(Effect::Transmission) || effects.has(Effect::Absorption),
            world.has_footprints(),
            effects.has_details(),
            effects.needs_sampling(),
        ];
        let names = ["REFLECTION", "TRANSMISSION", "FOOTPRINTS", "DETAILS", "SAMPLED"];
        let has: Vec<&str> = (0..names.len()).filter(|i| axes[*i]).map(|i| names[i]).collect();
        let kernel = if has.is_empty() { "LOCAL".to_owned() } else { has.join("|") };
        let level = Level::new();
        let code = format!("{} {kernel} {precision:?} {level:?}", env!("CARGO_PKG_VERSION"));
        // FNV-1a.
        let hash = code
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
        Self {
            kernel,
            superset_of_needed: (0..names.len()).filter(|i| axes[*i] && !needed[*i]).map(|i| names[i]).collect(),
            kernel_hash: format!("{hash:016x}"),
            precision,
        }
    }
}
