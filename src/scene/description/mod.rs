//! What a scene's JSON says, version 1: the serde types behind `api/scene.schema.json`.
//!
//! Nothing here is checked beyond its shape; [`compile`](crate::scene::compile) does the rest. Lengths are in scene
//! units, angles in degrees (the key says so), colors are linear RGB. Right-handed, y up by convention.

mod camera;
mod channel;
mod color;
mod diffuse;
mod film;
mod fog;
mod import_warning;
mod light;
mod material;
mod models;
mod object;
mod pbr;
mod picture_names;
mod render;
mod sameness;
mod texture;
mod written;

pub use camera::{Camera, CylinderCamera, FisheyeCamera, OrthographicCamera, PanoramaCamera, PinholeCamera};
pub use channel::{Channel, Enlarged, Factor, TexelChannel, Textured, UvTransform, Wraps};
pub use color::Color;
pub(in crate::scene) use color::HEX;
pub use diffuse::Diffuse;
pub use film::{Film, FilmBackground};
pub use fog::{Fog, FogHeight};
pub use import_warning::ImportWarning;
pub use light::{
    AngularArea, Area, DirectionalLight, DiscArea, Falloff, Light, LinearFalloff, ParallelogramArea, PointLight,
    SpotLight, WindowedFalloff,
};
pub use material::{Axes, Checker, Fresnel, Material};
pub(in crate::scene) use models::{ModelBodies, ModelPlace};
pub use models::{PlacedModel, ReadModels, UpAxis};
pub use object::{
    Appearance, AxisBox, Cone, Cylinder, Disc, Group, Instance, Mesh, Motion, Object, Plane, Polygon, Quad, Rotation,
    Scale, Sphere, Torus, Transform, Triangle,
};
pub use pbr::{AlphaMode, Attenuation, Opacity, Pbr};
pub(in crate::scene) use picture_names::PictureNames;
pub use render::{
    Accuracy, DEFAULT_MAX_DEPTH, Fidelity, Fixed, Precision, Proved, Rays, RenderSettings, Shadows, Statistical, Time,
};
pub use texture::{
    Bump, Environment, EnvironmentLight, Gradient, Grain, ImageMap, Mapping, Noise, NormalMap, Planar, PlanarAxes,
    Relief, Sky, Spherical, Studio, Wrap,
};

use super::named::{self, Named};
use crate::math::Rgb;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::mem::take;
use std::sync::Arc;

/// A point, direction or extent: three finite numbers.
pub type Vec3 = [f64; 3];

/// A whole scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// URL of the schema, for editors. Ignored.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Version of this format: 1.
    #[schemars(range(min = 1, max = 1))]
    pub version: u32,
    /// A title, for people. At most 256 bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(max = 256))]
    pub name: Option<String>,
    /// Size of the picture.
    #[serde(default)]
    pub image: ImageSize,
    /// The eye and its projection.
    pub camera: Camera,
    /// Radiance of a ray that hits nothing. Default: black.
    #[serde(default)]
    pub background: Color,
    /// A picture of the surroundings or a sky, in place of `background`. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<Environment>,
    /// Ambient light I_a, multiplied by each material's `ambient`. Default: 0.1 grey.
    #[serde(default = "default_ambient")]
    pub ambient: Color,
    /// Fog. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fog: Option<Fog>,
    /// Light sources. Default: one directional light from the upper left front. `[]` means no lights.
    #[serde(default = "default_lights")]
    pub lights: Vec<Light>,
    /// Materials by name, each of at most 256 bytes.
    #[serde(default, deserialize_with = "named::deserialize")]
    #[schemars(schema_with = "named::schema::<Material>")]
    pub materials: Named<Material>,
    /// Groups of objects that instances may place, by name of at most 256 bytes. Definitions may use other definitions, but no cycles.
    #[serde(default, deserialize_with = "named::shared")]
    #[schemars(schema_with = "named::schema::<Vec<Object>>")]
    pub definitions: Arc<Named<Vec<Object>>>,
    /// The objects of the scene, at least one.
    #[schemars(length(min = 1))]
    pub objects: Arc<Vec<Object>>,
    /// How to render.
    #[serde(default)]
    pub render: RenderSettings,
    /// How light becomes colors.
    #[serde(default, skip_serializing_if = "Film::is_default")]
    pub film: Film,
    /// What the file of a model said and the scene does not, repeated as warnings of its pictures: at most 50.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 50))]
    pub import_warnings: Vec<ImportWarning>,
    /// What the models among its objects are, once they have been read.
    #[serde(skip)]
    pub models: ReadModels,
}

impl Description {
    /// Objects as a camera sees them, and all else as it is where a scene says nothing.
    pub fn new(camera: Camera, objects: Vec<Object>) -> Self {
        Self {
            schema: None,
            version: 1,
            name: None,
            image: ImageSize::default(),
            camera,
            background: Color::default(),
            environment: None,
            ambient: default_ambient(),
            fog: None,
            lights: default_lights(),
            materials: Named::default(),
            definitions: Arc::default(),
            objects: objects.into(),
            render: RenderSettings::default(),
            film: Film::default(),
            import_warnings: Vec::new(),
            models: ReadModels::default(),
        }
    }

    /// All settings as JSON, without materials, definitions and objects, which may be large.
    pub fn settings(&mut self) -> Value {
        let large = (take(&mut self.materials), take(&mut self.definitions), take(&mut self.objects));
        let settings = serde_json::to_value(&*self).unwrap_or_default();
        (self.materials, self.definitions, self.objects) = large;
        settings
    }
}

fn default_ambient() -> Color {
    Color(Rgb::splat(0.1))
}

fn default_lights() -> Vec<Light> {
    vec![Light::Directional(DirectionalLight {
        direction: [1.0, -2.0, -1.5],
        color: Color::WHITE,
        intensity: 1.0,
        area: None,
    })]
}

/// Size of the picture in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ImageSize {
    /// Pixels across, 1 to 16384. Default 960.
    #[schemars(range(min = 1, max = 16384))]
    pub width: u32,
    /// Pixels down, 1 to 16384. Default 540.
    #[schemars(range(min = 1, max = 16384))]
    pub height: u32,
}

impl Default for ImageSize {
    fn default() -> Self {
        Self { width: 960, height: 540 }
    }
}

/// Whether a key that is off at 0 need not be written.
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Whether a key has its default and need not be written.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// A default that is a whole number.
fn number<const N: u32>() -> f64 {
    f64::from(N)
}

fn default_up() -> Vec3 {
    [0.0, 1.0, 0.0]
}
