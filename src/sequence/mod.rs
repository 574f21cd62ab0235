//! Frames of one scene: its camera goes round it or along a path, its bodies move on, and patches change what they like.
//!
//! A frame is a scene like any other. So its picture has an id and a proof of its own, and is the one that its scene gives
//! alone. Frames are made as variations of the scene, which share its geometry as long as no body moves.

mod bodies;
mod check;
mod ease;
mod motion;
mod path;
mod play;
mod track;
mod turntable;

pub use ease::Ease;
pub use path::Key;
pub use turntable::Turntable;

use crate::scene::compile::Original;
use crate::scene::files::Files;
use crate::scene::limits::Limit;
use crate::scene::problem::Problem;
use crate::scene::variation::vary_with;
use crate::scene::{Accept, Description, Loaded, NotLoaded, Overrides, Problems};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

/// Frames of a sequence: two and a half minutes at 24 a second.
pub const FRAMES: Limit = Limit { name: "frames", max: 3_600 };

/// Frames of a scene, and how they are shown.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sequence {
    /// How many, 1 to 3600. Default: as many as there are `patches`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 3600))]
    pub count: Option<u32>,
    /// Frames a second of animations, 0.1 to 100. Default 24.
    #[serde(default = "default_rate")]
    #[schemars(range(min = 0.1, max = 100.0))]
    pub rate: f64,
    /// How often animations are shown; 0: again and again. Default 0.
    #[serde(default)]
    pub loops: u16,
    /// Takes the camera around the scene. Default: it stays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turntable: Option<Turntable>,
    /// Where the camera is at which time, in the order of time. Between them it takes a smooth path. Default: it stays.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 1000))]
    pub camera: Vec<Key>,
    /// Whether the path of `camera` goes back to where it begins, so that an animation can be shown again and again. Default:
    /// false.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub closed: bool,
    /// For which share of the time between two frames the shutter is open, above 0, at most 1. Then the `motion` of groups and
    /// instances goes on from frame to frame. Default: all frames are of the same moment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1.0))]
    pub shutter: Option<f64>,
    /// How fast the animations of models go on, those that say `animation` or `t`: seconds of theirs in a second of the frames by
    /// `rate`, above 0, at most 1000. After their end they stay as they are then. Default: they stay at their `t`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1000.0))]
    pub play: Option<f64>,
    /// What is different in each frame: merge patches (RFC 7396) on the scene, one for each frame. Then the camera and the
    /// bodies of the patched scene are moved. Default: nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Vec<serde_json::Map<String, serde_json::Value>>")]
    pub patches: Vec<Box<RawValue>>,
}

fn default_rate() -> f64 {
    24.0
}

impl Sequence {
    /// So many frames all around a scene.
    pub fn turntable(count: u32) -> Self {
        Self {
            count: Some(count),
            rate: default_rate(),
            loops: 0,
            turntable: Some(Turntable::default()),
            camera: Vec::new(),
            closed: false,
            shutter: None,
            play: None,
            patches: Vec::new(),
        }
    }

    /// The same of a model, around which the axis is vertical, from wherever it is seen.
    #[must_use]
    pub fn of_model(mut self) -> Self {
        if let Some(turntable) = &mut self.turntable {
            turntable.axis.get_or_insert([0.0, 1.0, 0.0]);
        }
        self
    }

    /// How many frames it has.
    pub fn count(&self) -> u32 {
        self.count.unwrap_or(self.patches.len().min(u32::MAX as usize) as u32)
    }

    /// Checks everything that can be said without a scene; all problems are reported at once.
    pub fn check(&self) -> Result<(), Problems> {
        check::check(self)
    }

    /// A frame, by its number from 0.
    pub fn frame(&self, number: u32) -> Frame<'_> {
        Frame { sequence: self, number }
    }

    /// All frames.
    pub fn frames(&self) -> impl Iterator<Item = Frame<'_>> {
        (0..self.count()).map(|number| self.frame(number))
    }
}

/// A frame of a checked sequence.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    sequence: &'a Sequence,
    /// Its number, from 0.
    pub number: u32,
}

impl<'a> Frame<'a> {
    /// The patch on the scene.
    pub fn patch(&self) -> &'a [u8] {
        self.sequence.patches.get(self.number as usize).map_or(b"{}", |patch| patch.get().as_bytes())
    }

    /// When it is, from 0 to 1 for the last frame; if the path is closed, the frame after the last one would be at 1.
    pub fn time(&self) -> f64 {
        let count = self.sequence.count();
        let last = if self.sequence.closed { count } else { (count - 1).max(1) };
        f64::from(self.number) / f64::from(last)
    }

    /// Moves the camera and the bodies of the patched scene to where they are in this frame.
    pub fn place(&self, scene: &mut Description) -> Result<(), Problem> {
        let Sequence { rate, turntable, camera, closed, shutter, play, .. } = self.sequence;
        path::take(&mut scene.camera, camera, *closed, self.time())?;
        if let Some(turntable) = turntable {
            turntable.turn(&mut scene.camera, self.number, self.sequence.count());
        }
        if let Some(shutter) = shutter {
            motion::go_on(scene, f64::from(self.number) / shutter);
        }
        if let Some(speed) = play {
            play::go_on(scene, f64::from(self.number) / rate * speed)?;
        }
        Ok(())
    }

    /// The scene of this frame, if `accept` wants it. `overrides` are those of `original`, and replace settings of every frame, but
    /// not where the camera is.
    pub fn load_if<E>(
        &self,
        original: Original<'_>,
        overrides: &Overrides,
        files: &dyn Files,
        accept: Accept<'_, E>,
    ) -> Result<Loaded, NotLoaded<E>> {
        let overrides = overrides.again(original.description.image);
        let loaded = vary_with(original, self.patch(), &|scene| self.place(scene), &overrides, files, accept);
        loaded.map_err(|error| match error {
            NotLoaded::Problems(problems) => NotLoaded::Problems(self.named(problems)),
            refused => refused,
        })
    }

    /// Problems that say which frame they are of.
    fn named(&self, Problems(mut problems): Problems) -> Problems {
        for problem in &mut problems {
            problem.detail = format!("in frame {}: {}", self.number, problem.detail);
        }
        Problems(problems)
    }
}
