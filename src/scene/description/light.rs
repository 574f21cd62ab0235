//! Light sources.

use super::{Color, Vec3, number};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Light sources.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Light {
    /// Shines from a point in all directions.
    Point(PointLight),
    /// Shines from infinitely far away.
    Directional(DirectionalLight),
    /// Shines from a point into a cone.
    Spot(SpotLight),
}

impl Light {
    /// Whether it is more than a point.
    pub fn has_area(&self) -> bool {
        match self {
            Self::Point(light) => light.area.is_some(),
            Self::Directional(light) => light.area.is_some(),
            Self::Spot(light) => light.area.is_some(),
        }
    }

    /// Whether it is more than black.
    pub fn shines(&self) -> bool {
        let (color, intensity) = match self {
            Self::Point(l) => (l.color, l.intensity),
            Self::Directional(l) => (l.color, l.intensity),
            Self::Spot(l) => (l.color, l.intensity),
        };
        color.0.max_element() > 0.0 && intensity > 0.0
    }
}

/// Point light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointLight {
    /// Where it stands.
    pub position: Vec3,
    /// Its color. Default white.
    #[serde(default = "Color::white")]
    pub color: Color,
    /// Factor on the color, at least 0. Default 1.
    #[serde(default = "number::<1>")]
    #[schemars(range(min = 0.0))]
    pub intensity: f64,
    /// How it fades with distance. Default: not at all.
    #[serde(default)]
    pub falloff: Falloff,
    /// The area it shines from, around its position; shadows get soft edges. Default: a point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area: Option<Area>,
}

/// Directional light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DirectionalLight {
    /// The direction its light travels in.
    pub direction: Vec3,
    /// Its color. Default white.
    #[serde(default = "Color::white")]
    pub color: Color,
    /// Factor on the color, at least 0. Default 1.
    #[serde(default = "number::<1>")]
    #[schemars(range(min = 0.0))]
    pub intensity: f64,
    /// How large it is in the sky; shadows get soft edges. Default: a point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area: Option<AngularArea>,
}

/// Spot light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpotLight {
    /// Where it stands.
    pub position: Vec3,
    /// The direction of its axis.
    pub direction: Vec3,
    /// Angle between axis and the edge of the fully lit cone in degrees, 0 to 90. Default 0.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 90.0))]
    pub inner_deg: f64,
    /// Angle between axis and the edge of the light in degrees, above 0, at most 90 and at least `inner_deg`. Default 45.
    #[serde(default = "number::<45>")]
    #[schemars(range(max = 90.0), extend("exclusiveMinimum" = 0))]
    pub outer_deg: f64,
    /// Its color. Default white.
    #[serde(default = "Color::white")]
    pub color: Color,
    /// Factor on the color, at least 0. Default 1.
    #[serde(default = "number::<1>")]
    #[schemars(range(min = 0.0))]
    pub intensity: f64,
    /// How it fades with distance. Default: not at all.
    #[serde(default)]
    pub falloff: Falloff,
    /// The area it shines from, around its position; shadows get soft edges. Default: a point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area: Option<Area>,
}

/// Areas that light comes from, each point of them with the same share of its intensity, with no regard to the angle it
/// leaves at.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Area {
    /// A disc that faces each point it lights, as a far ball does.
    Disc(DiscArea),
    /// A parallelogram.
    Parallelogram(ParallelogramArea),
}

/// A disc around a light's position.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscArea {
    /// Radius in scene units, at least 0.
    #[schemars(range(min = 0.0))]
    pub radius: f64,
}

/// A parallelogram whose middle is a light's position.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParallelogramArea {
    /// One edge.
    pub u: Vec3,
    /// The other edge.
    pub v: Vec3,
}

/// A disc in the sky.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AngularArea {
    /// Its angular diameter in degrees, 0 to 90; the sun's is 0.53.
    #[schemars(range(min = 0.0, max = 90.0))]
    pub angle_deg: f64,
}

/// How a light fades with the distance d.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Falloff {
    /// Not at all.
    #[default]
    None,
    /// 1 - d/reach, never below 0.
    Linear(LinearFalloff),
    /// 1/d^2.
    InverseSquare,
    /// 1/d^2 (1 - (d/range)^4), never below 0, as lights of glTF with a range.
    Windowed(WindowedFalloff),
}

/// Parameters of the windowed falloff.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindowedFalloff {
    /// Distance at which the light is gone, above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub range: f64,
}

/// Parameters of the linear falloff.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinearFalloff {
    /// Distance at which the light is gone, above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub reach: f64,
}
