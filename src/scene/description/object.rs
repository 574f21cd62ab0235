//! Objects, and where they are put.

use super::{PlacedModel, Vec3, default_up};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use std::sync::Arc;

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
    Quad(Box<Quad>),
    Box(AxisBox),
    Cylinder(Cylinder),
    Cone(Cone),
    Torus(Torus),
    Mesh(Box<Mesh>),
    Polygon(Polygon),
    Group(Box<Group>),
    Instance(Box<Instance>),
    Model(Box<PlacedModel>),
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
            Self::Model(_) => "model",
        }
    }

    /// Material, name and hollowness of a body; `None` for groups, instances and models.
    pub fn appearance(&self) -> Option<Appearance<'_>> {
        Some(match self {
            Self::Sphere(o) => o.appearance(),
            Self::Plane(o) => o.appearance(),
            Self::Disc(o) => o.appearance(),
            Self::Triangle(o) => o.appearance(),
            Self::Quad(o) => o.appearance(),
            Self::Box(o) => o.appearance(),
            Self::Cylinder(o) => o.appearance(),
            Self::Cone(o) => o.appearance(),
            Self::Torus(o) => o.appearance(),
            Self::Mesh(o) => o.appearance(),
            Self::Polygon(o) => o.appearance(),
            Self::Group(_) | Self::Instance(_) | Self::Model(_) => return None,
        })
    }
}

/// What every body may say besides its geometry.
///
/// Not flattened with serde (that would lose error paths), so each body lists the keys itself.
#[derive(Debug, Clone, Copy)]
pub struct Appearance<'a> {
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
            #[schemars(length(max = 256))]
            pub material: Option<String>,
            /// A name, for people; answers and ray trees repeat it. At most 256 bytes.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schemars(length(max = 256))]
            pub name: Option<String>,
            $(
                /// Turns the body inside out: its inside is empty space (ior 1), like an air bubble in glass. Default false.
                #[serde(default, skip_serializing_if = "is_false")]
                pub hollow: body!(@bool $hollow),
            )?
        }

        impl $name {
            /// Material, name and hollowness.
            pub fn appearance(&self) -> Appearance<'_> {
                Appearance { material: self.material.as_deref(), name: self.name.as_deref(), hollow: body!(@hollow self $($hollow)?) }
            }
        }
    };
    (@bool $hollow:tt) => { bool };
    (@hollow $self:ident yes) => { $self.hollow };
    (@hollow $self:ident) => { false };
}

/// A list that the compiled scene may share, so nothing is kept beside its elements.
fn shared<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<Vec<[u32; 3]>>, D::Error> {
    let mut list = Vec::deserialize(deserializer)?;
    list.shrink_to_fit();
    Ok(Arc::new(list))
}

pub(super) fn is_false(value: &bool) -> bool {
    !value
}

/// Whether a key that is on by default need not be written.
pub(super) fn is_true(value: &bool) -> bool {
    *value
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
    /// Infinite plane, which bounds the half-space behind it.
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
        #[serde(deserialize_with = "shared")]
        faces: Arc<Vec<[u32; 3]>>,
        /// Shading normals, one for each vertex; without them faces are flat.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        normals: Option<Vec<Vec3>>,
        /// Texture coordinates, one pair for each vertex.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        uvs: Option<Vec<[f64; 2]>>,
        /// Other texture coordinates, one pair for each vertex.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        uvs1: Option<Vec<[f64; 2]>>,
        /// For the normal map of a `pbr` material, one for each vertex: the direction in which the first texture coordinate
        /// grows, and 1 or -1, which turns the direction of the second. Default: as the texture coordinates say.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        tangents: Option<Vec<[f64; 4]>>,
        /// Colors, linear red, green, blue and alpha for each vertex, 0 to 1. They multiply `base_color` and `opacity` of a
        /// `pbr` material; others ignore them.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        colors: Option<Vec<[f64; 4]>>,
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

/// Objects that are transformed together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// The objects of the group.
    pub objects: Vec<Object>,
    /// Transform of the group. Default: none.
    #[serde(default)]
    pub transform: Transform,
    /// How it moves while the shutter is open, which blurs it. Default: not at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
    /// A name, for people. At most 256 bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(max = 256))]
    pub name: Option<String>,
}

/// One placed copy of a definition. Copies share the memory of the definition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Instance {
    /// Name in `definitions`.
    #[schemars(length(max = 256))]
    pub of: String,
    /// Transform of the copy. Default: none.
    #[serde(default)]
    pub transform: Transform,
    /// How it moves while the shutter is open, which blurs it. Default: not at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
    /// A name, for people. At most 256 bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(max = 256))]
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
    /// Rotated around an axis through the origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate_deg: Option<Rotation>,
    /// Scaled around the origin: one factor, or one for each axis. Not 0. Negative factors mirror.
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

/// A steady motion while the shutter is open, from the position that `transform` gives. Rotation comes before translation.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Moved by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub translate: Option<Vec3>,
    /// Rotated around an axis through `center`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate_deg: Option<Rotation>,
    /// A point of the axis of rotation. Default: the origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<Vec3>,
}

impl Motion {
    /// Whether it goes anywhere.
    pub fn moves(&self) -> bool {
        let shifts = self.translate.is_some_and(|by| by.iter().any(|x| *x != 0.0));
        shifts || self.rotate_deg.is_some_and(|rotation| rotation.angle != 0.0)
    }
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
