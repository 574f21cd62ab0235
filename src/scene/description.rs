//! What a scene's JSON says, version 1: the serde types behind `api/scene.schema.json`.
//!
//! Nothing here is checked beyond its shape; [`compile`](crate::scene::compile) does the rest. Lengths are in scene
//! units, angles in degrees (the key says so), colours are linear RGB. Right-handed, y up by convention.

use super::named::Named;
use crate::math::Rgb;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use super::color::{Color, Diffuse};

/// A point, direction or extent: three finite numbers.
pub type Vec3 = [f64; 3];

/// A whole scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// Where the schema lies, for editors. Ignored.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Version of this format: 1.
    #[schemars(range(min = 1, max = 1))]
    pub version: u32,
    /// A title, for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Size of the picture.
    #[serde(default)]
    pub image: ImageSize,
    /// The eye and its projection.
    pub camera: Camera,
    /// Radiance of a ray that hits nothing. Default: black.
    #[serde(default)]
    pub background: Color,
    /// Ambient light I_a, multiplied by each material's `ambient`. Default: 0.1 grey.
    #[serde(default = "default_ambient")]
    pub ambient: Color,
    /// Light sources. Default when the key is missing: one directional light from the upper left front. `[]` is darkness.
    #[serde(default = "default_lights")]
    pub lights: Vec<Light>,
    /// Materials by name.
    #[serde(default)]
    pub materials: Named<Material>,
    /// Groups of objects that instances may place, by name. Definitions may use other definitions, but no cycles.
    #[serde(default)]
    pub definitions: Named<Vec<Object>>,
    /// The objects of the scene, at least one.
    #[schemars(length(min = 1))]
    pub objects: Vec<Object>,
    /// How to render.
    #[serde(default)]
    pub render: RenderSettings,
}

fn default_ambient() -> Color {
    Color(Rgb::splat(0.1))
}

fn default_lights() -> Vec<Light> {
    vec![Light::Directional(DirectionalLight { direction: [1.0, -2.0, -1.5], color: Color::WHITE, intensity: 1.0 })]
}

/// Size of the picture in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImageSize {
    /// Pixels across, 1 to 16384. Default 960.
    #[serde(default = "default_width")]
    #[schemars(range(min = 1, max = 16384))]
    pub width: u32,
    /// Pixels down, 1 to 16384. Default 540.
    #[serde(default = "default_height")]
    #[schemars(range(min = 1, max = 16384))]
    pub height: u32,
}

fn default_width() -> u32 {
    960
}

fn default_height() -> u32 {
    540
}

impl Default for ImageSize {
    fn default() -> Self {
        Self { width: default_width(), height: default_height() }
    }
}

/// Projections. All have `eye`, `look_at` and `up`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Camera {
    /// Perspective: all rays start at the eye, straight lines stay straight.
    Pinhole(PinholeCamera),
    /// Parallel rays.
    Orthographic(OrthographicCamera),
    /// Equidistant fisheye: distance from the centre is proportional to the angle. The circle touches the image's
    /// shorter side; outside it is background.
    Fisheye(FisheyeCamera),
    /// Dome picture: equidistant, the circle spans the image's width and touches its upper edge; what lies below the
    /// image is cut off, as on an Omnimax dome.
    Omnimax(FisheyeCamera),
    /// Equirectangular: columns are longitude, rows are latitude.
    Panorama(PanoramaCamera),
    /// Cylindrical: columns are longitude, rows are perspective.
    Cylinder(CylinderCamera),
}

/// Where a camera stands and what it faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Eye point.
    pub eye: Vec3,
    /// Point in the middle of the picture.
    pub look_at: Vec3,
    /// Direction that points up in the picture; need not be perpendicular.
    pub up: Vec3,
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

fn default_up() -> Vec3 {
    [0.0, 1.0, 0.0]
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
    #[serde(default = "default_pinhole_vfov")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub vfov_deg: f64,
}

fn default_pinhole_vfov() -> f64 {
    45.0
}

/// Parallel projection.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OrthographicCamera {
    /// Point in the middle of the plane the rays start on.
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
    #[serde(default = "default_fisheye_fov")]
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0))]
    pub fov_deg: f64,
}

fn default_fisheye_fov() -> f64 {
    180.0
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
    #[serde(default = "default_panorama_hfov")]
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0))]
    pub hfov_deg: f64,
    /// Angle down the picture in degrees, above 0, at most 180. Default 180.
    #[serde(default = "default_panorama_vfov")]
    #[schemars(range(max = 180.0), extend("exclusiveMinimum" = 0))]
    pub vfov_deg: f64,
}

fn default_panorama_hfov() -> f64 {
    360.0
}

fn default_panorama_vfov() -> f64 {
    180.0
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
    #[serde(default = "default_cylinder_hfov")]
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0))]
    pub hfov_deg: f64,
    /// Angle down the picture's middle column in degrees, above 0 and below 180. Default 60.
    #[serde(default = "default_cylinder_vfov")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub vfov_deg: f64,
}

fn default_cylinder_hfov() -> f64 {
    180.0
}

fn default_cylinder_vfov() -> f64 {
    60.0
}

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

fn default_intensity() -> f64 {
    1.0
}

/// Point light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointLight {
    /// Where it stands.
    pub position: Vec3,
    /// Its colour. Default white.
    #[serde(default = "Color::white")]
    pub color: Color,
    /// Factor on the colour, at least 0. Default 1.
    #[serde(default = "default_intensity")]
    #[schemars(range(min = 0.0))]
    pub intensity: f64,
    /// How it fades with distance. Default: not at all.
    #[serde(default)]
    pub falloff: Falloff,
}

/// Directional light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DirectionalLight {
    /// The direction its light travels in.
    pub direction: Vec3,
    /// Its colour. Default white.
    #[serde(default = "Color::white")]
    pub color: Color,
    /// Factor on the colour, at least 0. Default 1.
    #[serde(default = "default_intensity")]
    #[schemars(range(min = 0.0))]
    pub intensity: f64,
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
    #[serde(default = "default_outer")]
    #[schemars(range(max = 90.0), extend("exclusiveMinimum" = 0))]
    pub outer_deg: f64,
    /// Its colour. Default white.
    #[serde(default = "Color::white")]
    pub color: Color,
    /// Factor on the colour, at least 0. Default 1.
    #[serde(default = "default_intensity")]
    #[schemars(range(min = 0.0))]
    pub intensity: f64,
    /// How it fades with distance. Default: not at all.
    #[serde(default)]
    pub falloff: Falloff,
}

fn default_outer() -> f64 {
    45.0
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
}

/// Parameters of the linear falloff.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinearFalloff {
    /// Distance at which the light is gone, above 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub reach: f64,
}

/// How a surface answers light: `L = L_Phong + r_s L_s + r_t L_t` with
/// `L_Phong = k_a I_a + sum over lights (k_d (N.L) + k_s (R.V)^m) I`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// k_a, factor on the scene's ambient light. Default: the diffuse colour.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambient: Option<Diffuse>,
    /// k_d, a colour or a texture. Default 0.8 grey.
    #[serde(default)]
    pub diffuse: Diffuse,
    /// k_s, strength of the Phong highlight. Default 0.
    #[serde(default)]
    pub specular: Color,
    /// m, the Phong exponent, 0 to 1e6. Default 32.
    #[serde(default = "default_shininess")]
    #[schemars(range(min = 0.0, max = 1e6))]
    pub shininess: f64,
    /// r_s, factor on what the reflected ray brings. Default 0.
    #[serde(default)]
    pub reflection: Color,
    /// r_t, factor on what the transmitted ray brings. Default 0.
    #[serde(default)]
    pub transmission: Color,
    /// Index of refraction, 0.01 to 100. Default 1.5.
    #[serde(default = "default_ior")]
    #[schemars(range(min = 0.01, max = 100.0))]
    pub ior: f64,
    /// Whether the surface exists only for rays that come from its front. Default false.
    #[serde(default)]
    pub one_sided: bool,
}

fn default_shininess() -> f64 {
    32.0
}

fn default_ior() -> f64 {
    1.5
}

impl Default for Material {
    fn default() -> Self {
        Self {
            ambient: None,
            diffuse: Diffuse::default(),
            specular: Color::BLACK,
            shininess: default_shininess(),
            reflection: Color::BLACK,
            transmission: Color::BLACK,
            ior: default_ior(),
            one_sided: false,
        }
    }
}

/// Checkerboard: tile `a` where the sum of floor(p / size) over the named axes is even, in object space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Checker {
    /// Colour of the even tiles.
    pub a: Color,
    /// Colour of the odd tiles.
    pub b: Color,
    /// Edge of a tile in scene units, above 0. Default 1.
    #[serde(default = "default_checker_size")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub size: f64,
    /// The axes that count. Default `"xz"`, a floor.
    #[serde(default)]
    pub axes: Axes,
}

fn default_checker_size() -> f64 {
    1.0
}

/// A set of axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum Axes {
    X,
    Y,
    Z,
    Xy,
    #[default]
    Xz,
    Yz,
    Xyz,
}

impl Axes {
    /// Whether x, y and z count.
    pub fn flags(self) -> [bool; 3] {
        match self {
            Self::X => [true, false, false],
            Self::Y => [false, true, false],
            Self::Z => [false, false, true],
            Self::Xy => [true, true, false],
            Self::Xz => [true, false, true],
            Self::Yz => [false, true, true],
            Self::Xyz => [true, true, true],
        }
    }
}

/// Things in a scene.
///
/// `sphere`, `box`, `torus`, `mesh`, capped `cylinder` and `cone` and the half-space of a `plane` are closed bodies:
/// light that passes their surface is refracted. `disc`, `triangle`, `quad`, `polygon` and uncapped `cylinder` and
/// `cone` enclose nothing: they are infinitely thin, and light passes them without bending.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "each variant's type says it")]
pub enum Object {
    Sphere(Sphere),
    Plane(Plane),
    Disc(Disc),
    Triangle(Triangle),
    Quad(Quad),
    Box(AxisBox),
    Cylinder(Cylinder),
    Cone(Cone),
    Torus(Torus),
    Mesh(Mesh),
    Polygon(Polygon),
    Group(Group),
    Instance(Instance),
}

impl Object {
    /// The key of this kind of object in the JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sphere(_) => "sphere",
            Self::Plane(_) => "plane",
            Self::Disc(_) => "disc",
            Self::Triangle(_) => "triangle",
            Self::Quad(_) => "quad",
            Self::Box(_) => "box",
            Self::Cylinder(_) => "cylinder",
            Self::Cone(_) => "cone",
            Self::Torus(_) => "torus",
            Self::Mesh(_) => "mesh",
            Self::Polygon(_) => "polygon",
            Self::Group(_) => "group",
            Self::Instance(_) => "instance",
        }
    }
}

/// What every body may say besides its geometry.
///
/// Not flattened with serde (that would lose error paths), so each body lists the keys itself.
#[derive(Debug, Clone, Copy)]
pub struct Look<'a> {
    /// Name of the material; none is the default material.
    pub material: Option<&'a str>,
    /// Name of the body.
    pub name: Option<&'a str>,
    /// Whether a closed body is turned inside out: its inside is empty space, as an air bubble in glass.
    pub hollow: bool,
}

macro_rules! body {
    (
        $(#[$doc:meta])* $name:ident { $( $(#[$field_doc:meta])* $field:ident : $type:ty ),* $(,)? } $(hollow: $hollow:tt)?
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $( $(#[$field_doc])* pub $field: $type, )*
            /// Name of a material in `materials`. Default: 0.8 grey diffuse.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub material: Option<String>,
            /// A name, for people; answers and ray trees repeat it.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub name: Option<String>,
            $(
                /// Turns the body inside out: its inside is empty space (ior 1), as an air bubble in glass. Default false.
                #[serde(default, skip_serializing_if = "is_false")]
                pub hollow: body!(@bool $hollow),
            )?
        }

        impl $name {
            /// Material, name and hollowness.
            pub fn look(&self) -> Look<'_> {
                Look { material: self.material.as_deref(), name: self.name.as_deref(), hollow: body!(@hollow self $($hollow)?) }
            }
        }
    };
    (@bool $hollow:tt) => { bool };
    (@hollow $self:ident yes) => { $self.hollow };
    (@hollow $self:ident) => { false };
}

fn is_false(value: &bool) -> bool {
    !value
}

fn yes() -> bool {
    true
}

body! {
    /// Ball around `center`.
    Sphere {
        /// Centre.
        center: Vec3,
        /// Radius, above 0.
        #[schemars(extend("exclusiveMinimum" = 0))]
        radius: f64,
    } hollow: yes
}

body! {
    /// Infinite plane; it bounds the half-space behind it.
    Plane {
        /// Any point of the plane.
        point: Vec3,
        /// Direction of its front, any length but 0.
        normal: Vec3,
    } hollow: yes
}

body! {
    /// Flat disc.
    Disc {
        /// Centre.
        center: Vec3,
        /// Direction of its front, any length but 0.
        normal: Vec3,
        /// Radius, above 0.
        #[schemars(extend("exclusiveMinimum" = 0))]
        radius: f64,
    }
}

body! {
    /// Triangle; its front sees the vertices counter-clockwise.
    Triangle {
        /// The corners.
        vertices: [Vec3; 3],
    }
}

body! {
    /// Two triangles 0 1 2 and 0 2 3; planar for most uses, but it need not be.
    Quad {
        /// The corners, in order around it.
        vertices: [Vec3; 4],
    }
}

body! {
    /// Box with sides parallel to the axes. It may be flat in one direction.
    AxisBox {
        /// Lower corner.
        min: Vec3,
        /// Upper corner, in no coordinate below `min`.
        max: Vec3,
    } hollow: yes
}

body! {
    /// Circular cylinder from `base` to `top`.
    Cylinder {
        /// Centre of one end.
        base: Vec3,
        /// Centre of the other end.
        top: Vec3,
        /// Radius, above 0.
        #[schemars(extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Whether discs close its ends. Default true.
        #[serde(default = "yes")]
        capped: bool,
    } hollow: yes
}

body! {
    /// Circular cone or its frustum from `base` to `top`.
    Cone {
        /// Centre of one end.
        base: Vec3,
        /// Radius at the base, at least 0.
        #[schemars(range(min = 0.0))]
        base_radius: f64,
        /// Centre of the other end.
        top: Vec3,
        /// Radius at the top, at least 0; not both 0. Default 0.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        top_radius: f64,
        /// Whether discs close its ends. Default true.
        #[serde(default = "yes")]
        capped: bool,
    } hollow: yes
}

body! {
    /// Ring: all points at `minor_radius` from a circle of `major_radius`.
    Torus {
        /// Centre.
        center: Vec3,
        /// Axis of rotation, any length but 0. Default +y.
        #[serde(default = "default_up")]
        axis: Vec3,
        /// Radius of the circle, above 0.
        #[schemars(extend("exclusiveMinimum" = 0))]
        major_radius: f64,
        /// Radius of the tube, above 0 and below `major_radius`.
        #[schemars(extend("exclusiveMinimum" = 0))]
        minor_radius: f64,
    } hollow: yes
}

body! {
    /// Triangles over shared vertices; fronts see their corners counter-clockwise. The fronts bound one body.
    Mesh {
        /// The points.
        #[schemars(length(min = 3))]
        vertices: Vec<Vec3>,
        /// Three indices of vertices each, from 0.
        #[schemars(length(min = 1))]
        faces: Vec<[u32; 3]>,
        /// Shading normals, one for each vertex; without them faces are flat.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        normals: Option<Vec<Vec3>>,
        /// Texture coordinates, one pair for each vertex.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        uvs: Option<Vec<[f64; 2]>>,
    } hollow: yes
}

body! {
    /// Planar polygon, which may be concave; its front sees the vertices counter-clockwise.
    Polygon {
        /// The corners, in order around it; edges must not cross.
        #[schemars(length(min = 3))]
        vertices: Vec<Vec3>,
    }
}

/// Objects moved together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// What is in the group.
    pub objects: Vec<Object>,
    /// Where the group goes. Default: where it is.
    #[serde(default)]
    pub transform: Transform,
    /// A name, for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

/// One placed copy of a definition. It costs no memory beyond itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Instance {
    /// Name in `definitions`.
    pub of: String,
    /// Where the copy goes. Default: where the definition is.
    #[serde(default)]
    pub transform: Transform,
    /// A name, for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

/// Either `matrix`, or any of `scale`, `rotate_deg` and `translate`, applied in this order.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Transform {
    /// 4 x 4, column-major, last row 0 0 0 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix: Option<[f64; 16]>,
    /// Moved by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub translate: Option<Vec3>,
    /// Turned around an axis through the origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate_deg: Option<Rotation>,
    /// Enlarged around the origin: one factor, or one for each axis. Not 0; negative mirrors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<Scale>,
}

/// Rotation around an axis, counter-clockwise when the axis points at the viewer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// The axis, any length but 0.
    pub axis: Vec3,
    /// The angle in degrees.
    pub angle: f64,
}

/// Factors for each axis, written as one number when they are equal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Scale {
    /// The same for all.
    Uniform(f64),
    /// For x, y and z.
    PerAxis(Vec3),
}

/// How shadow rays treat bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shadows {
    /// Any body blocks.
    #[default]
    Opaque,
    /// Each surface crossed attenuates by its transmission, without bending the ray.
    Transmissive,
    /// No shadow rays at all.
    None,
}

/// Floating-point format of the whole trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// 32 bits.
    #[default]
    Single,
    /// 64 bits.
    Double,
}

/// What ends the recursion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// `max_depth` and `min_weight`.
    Fixed(FixedAccuracy),
}

/// Parameters of the fixed mode: none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedAccuracy {}

impl Default for Accuracy {
    fn default() -> Self {
        Self::Fixed(FixedAccuracy {})
    }
}

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSettings {
    /// Longest chain of rays, 1 to 100000; the primary ray counts 1. Default 10.
    #[schemars(range(min = 1, max = 100_000))]
    pub max_depth: u32,
    /// A ray whose weight is below this in every channel is not followed, nor is a light asked for that could add less
    /// than a quarter of this share of itself, 0 to 1. Default 0.001.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_weight: f64,
    /// Rays for each pixel, 1 to 1024, spread evenly over it. Default 1.
    #[schemars(range(min = 1, max = 1024))]
    pub samples: u32,
    /// Whether pixels that differ from a neighbour get 16 samples. Default true.
    pub antialias: bool,
    /// What casts shadows. Default `"opaque"`.
    pub shadows: Shadows,
    /// Floating-point format. Default `"single"`.
    pub precision: Precision,
    /// What ends the recursion. Default `{"fixed": {}}`.
    pub accuracy: Accuracy,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            max_depth: 10,
            min_weight: 0.001,
            samples: 1,
            antialias: true,
            shadows: Shadows::default(),
            precision: Precision::default(),
            accuracy: Accuracy::default(),
        }
    }
}
