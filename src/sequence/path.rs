//! The path of a camera through keys.

use super::ease::Ease;
use super::track::{self, Knot};
use crate::scene::description::{Camera, Vec3};
use crate::scene::problem::{Code, Problem};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

/// What a camera is at a time. What a key does not say is between the keys before and after it that do, and what no key says is
/// as the scene says.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "CameraKey")]
pub struct Key {
    /// When, from 0, the first frame, to 1, the last one. On a closed path, below 1, where the path begins again.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub t: f64,
    /// How fast it goes from here to the next key. Default: steady.
    #[serde(default)]
    pub ease: Ease,
    /// Eye point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<Vec3>,
    /// Point in the middle of the picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_at: Option<Vec3>,
    /// Up direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<Vec3>,
    /// Vertical angle of view of cameras that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vfov_deg: Option<f64>,
    /// Horizontal angle of view of cameras that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hfov_deg: Option<f64>,
    /// Angle across the circle of a fisheye or an omnimax.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov_deg: Option<f64>,
    /// Height of the picture of an orthographic camera, in scene units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Diameter of the lens of a pinhole camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aperture: Option<f64>,
    /// Distance of the plane in focus of a pinhole camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focus_distance: Option<f64>,
}

type Vector = (&'static str, fn(&Key) -> Option<Vec3>);
type Number = (&'static str, fn(&Key) -> Option<f64>);

/// Points and directions of a key.
pub(super) const VECTORS: [Vector; 3] = [("eye", |key| key.eye), ("look_at", |key| key.look_at), ("up", |key| key.up)];

/// Single numbers of a key.
pub(super) const NUMBERS: [Number; 6] = [
    ("vfov_deg", |key| key.vfov_deg),
    ("hfov_deg", |key| key.hfov_deg),
    ("fov_deg", |key| key.fov_deg),
    ("height", |key| key.height),
    ("aperture", |key| key.aperture),
    ("focus_distance", |key| key.focus_distance),
];

/// Sets a camera to where its path is at a time.
pub(super) fn take(camera: &mut Camera, keys: &[Key], closed: bool, t: f64) -> Result<(), Problem> {
    let mut changes = Map::new();
    for (name, get) in VECTORS {
        let point = |key: &Key| Some(Knot { t: key.t, ease: key.ease, value: get(key)? });
        let knots: Vec<_> = keys.iter().filter_map(point).collect();
        changes.extend(track::at(&knots, closed, t).map(|value| (name.to_owned(), json!(value))));
    }
    for (name, get) in NUMBERS {
        let number = |key: &Key| Some(Knot { t: key.t, ease: key.ease, value: [get(key)?] });
        let knots: Vec<_> = keys.iter().filter_map(number).collect();
        changes.extend(track::at(&knots, closed, t).map(|[value]| (name.to_owned(), json!(value))));
    }
    if changes.is_empty() {
        return Ok(());
    }
    *camera = changed(camera, changes).map_err(|error| {
        let kind = camera.kind();
        let detail = format!("a key of frames.camera does not fit the camera of the scene: {error}");
        Problem::new(format!("/camera/{kind}"), Code::UnknownKey, detail)
    })?;
    Ok(())
}

/// A camera with other values. They go through its JSON, which has the same keys for all projections and keeps every bit.
fn changed(camera: &Camera, changes: Map<String, Value>) -> serde_json::Result<Camera> {
    let mut value = serde_json::to_value(camera)?;
    if let Some(Value::Object(projection)) = value.get_mut(camera.kind()) {
        projection.extend(changes);
    }
    serde_json::from_value(value)
}
