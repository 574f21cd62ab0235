//! Cameras.

use super::{Vec3, default_up, is_zero, number};
use crate::camera::View;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Projections. All have `eye`, `look_at` and `up`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Camera {
    /// Perspective: all rays start at the eye, straight lines stay straight.
    Pinhole(PinholeCamera),
    /// Parallel rays.
    Orthographic(OrthographicCamera),
    /// Equidistant fisheye: the distance from the centre is proportional to the angle. The circle touches the image's
    /// shorter sides. Outside of it the picture is black, or transparent if `film` says so.
    Fisheye(FisheyeCamera),
    /// Dome picture, as for an Omnimax dome: equidistant. The circle spans the image's width and touches its upper edge, and
    /// the part below the image is cut off.
    Omnimax(FisheyeCamera),
    /// Equirectangular: columns are longitude, rows are latitude.
    Panorama(PanoramaCamera),
    /// Cylindrical: columns are longitude, rows are perspective.
    Cylinder(CylinderCamera),
}

impl Camera {
    /// Eye, target and up vector, whatever the projection.
    pub fn view(&self) -> View {
        match *self {
            Self::Pinhole(PinholeCamera { eye, look_at, up, .. })
            | Self::Orthographic(OrthographicCamera { eye, look_at, up, .. })
            | Self::Fisheye(FisheyeCamera { eye, look_at, up, .. })
            | Self::Omnimax(FisheyeCamera { eye, look_at, up, .. })
            | Self::Panorama(PanoramaCamera { eye, look_at, up, .. })
            | Self::Cylinder(CylinderCamera { eye, look_at, up, .. }) => View { eye, look_at, up },
        }
    }

    /// The projection's key in the JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Pinhole(_) => "pinhole",
            Self::Orthographic(_) => "orthographic",
            Self::Fisheye(_) => "fisheye",
            Self::Omnimax(_) => "omnimax",
            Self::Panorama(_) => "panorama",
            Self::Cylinder(_) => "cylinder",
        }
    }
}

/// Perspective camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PinholeCamera {
    /// Eye point.
    pub eye: Vec3,
    /// Point in the middle of the picture.
    pub look_at: Vec3,
    /// Up direction. Default +y.
    #[serde(default = "default_up")]
    pub up: Vec3,
    /// Full vertical angle of view in degrees, edge to edge, above 0 and below 180. Default 45.
    #[serde(default = "number::<45>")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub vfov_deg: f64,
    /// Diameter of the lens in scene units, at least 0. Objects away from the focus distance are blurred. Default 0: a pinhole,
    /// for which everything is sharp.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0))]
    pub aperture: f64,
    /// Distance of the plane in focus, along the view direction, above 0. Default: the distance of `look_at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub focus_distance: Option<f64>,
}

impl PinholeCamera {
    /// A camera with the defaults of all that is not said. It is turned so that +y is up, or -z if it looks along y.
    pub fn looking(eye: [f64; 3], look_at: [f64; 3]) -> Self {
        let is_upright = (eye[0], eye[2]) == (look_at[0], look_at[2]);
        let up = if is_upright { [0.0, 0.0, -1.0] } else { default_up() };
        Self { eye, look_at, up, vfov_deg: number::<45>(), aperture: 0.0, focus_distance: None }
    }
}

/// Parallel projection.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OrthographicCamera {
    /// Point in the middle of the plane on which the rays start.
    pub eye: Vec3,
    /// Point in the middle of the picture.
    pub look_at: Vec3,
    /// Up direction. Default +y.
    #[serde(default = "default_up")]
    pub up: Vec3,
    /// Height of the picture in scene units, above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub height: f64,
}

/// Fisheye and dome.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FisheyeCamera {
    /// Eye point.
    pub eye: Vec3,
    /// Point in the middle of the circle.
    pub look_at: Vec3,
    /// Up direction. Default +y.
    #[serde(default = "default_up")]
    pub up: Vec3,
    /// Full angle across the circle in degrees, above 0, at most 360. Default 180.
    #[serde(default = "number::<180>")]
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0))]
    pub fov_deg: f64,
}

/// Equirectangular panorama.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PanoramaCamera {
    /// Eye point.
    pub eye: Vec3,
    /// Point in the middle of the picture.
    pub look_at: Vec3,
    /// Up direction. Default +y.
    #[serde(default = "default_up")]
    pub up: Vec3,
    /// Angle across the picture in degrees, above 0, at most 360. Default 360.
    #[serde(default = "number::<360>")]
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0))]
    pub hfov_deg: f64,
    /// Angle down the picture in degrees, above 0, at most 180. Default 180.
    #[serde(default = "number::<180>")]
    #[schemars(range(max = 180.0), extend("exclusiveMinimum" = 0))]
    pub vfov_deg: f64,
}

/// Cylindrical panorama.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderCamera {
    /// Eye point.
    pub eye: Vec3,
    /// Point in the middle of the picture.
    pub look_at: Vec3,
    /// Up direction, the cylinder's axis. Default +y.
    #[serde(default = "default_up")]
    pub up: Vec3,
    /// Angle across the picture in degrees, above 0, at most 360. Default 180.
    #[serde(default = "number::<180>")]
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0))]
    pub hfov_deg: f64,
    /// Angle down the picture's middle column in degrees, above 0 and below 180. Default 60.
    #[serde(default = "number::<60>")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub vfov_deg: f64,
}
