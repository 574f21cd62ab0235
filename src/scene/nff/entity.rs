//! The entities of an NFF file and their grammar (NFF.TXT 3.9, "Neutral File Format").

use crate::scene::description::Vec3;

/// Kinds of entities, by their first token.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    View,
    Background,
    Light,
    Fill,
    Cone,
    Sphere,
    Polygon,
    Patch,
}

/// Each kind with its keyword, and its form for messages.
const KINDS: [(Kind, &str, &str); 8] = [
    (
        Kind::View,
        "v",
        "the view \"v from x y z at x y z up x y z angle degrees [hither distance] [resolution width height]\"",
    ),
    (Kind::Background, "b", "the background \"b r g b\""),
    (Kind::Light, "l", "a light \"l x y z [r g b]\""),
    (Kind::Fill, "f", "a fill \"f r g b Kd Ks Shine T ior\""),
    (Kind::Cone, "c", "a cone \"c base(x y z) base_radius apex(x y z) apex_radius\""),
    (Kind::Sphere, "s", "a sphere \"s x y z radius\""),
    (Kind::Polygon, "p", "a polygon \"p n\" and n times \"x y z\""),
    (Kind::Patch, "pp", "a patch \"pp n\" and n times \"x y z nx ny nz\""),
];

impl Kind {
    /// For messages.
    pub(super) const KEYWORDS: &'static str = "v, b, l, f, c, s, p and pp";

    pub(super) fn of_keyword(keyword: &[u8]) -> Option<Self> {
        KINDS.iter().find(|(_, known, _)| known.as_bytes() == keyword).map(|(kind, ..)| *kind)
    }

    /// Its name, and its keyword.
    pub(super) fn form(self) -> &'static str {
        KINDS[self as usize].2
    }
}

/// One entity with its values, each of them finite and in its range.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Entity {
    View(View),
    Background(Vec3),
    Light(Light),
    Fill(Fill),
    Cone(Cone),
    Sphere(Sphere),
    Polygon(Vec<Vec3>),
    Patch(Patch),
}

/// The eye, and the size of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    pub(super) from: Vec3,
    pub(super) at: Vec3,
    pub(super) up: Vec3,
    /// Degrees, above 0 and below 180.
    pub(super) angle: f64,
    /// Width and height in pixels. The "hither" plane is for hidden-surface algorithms; rays ignore it.
    pub(super) resolution: [u32; 2],
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Light {
    pub(super) position: Vec3,
    pub(super) color: Option<Vec3>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fill {
    pub(super) color: Vec3,
    pub(super) kd: f64,
    pub(super) ks: f64,
    /// Phong's exponent, for highlights.
    pub(super) shine: f64,
    /// 0 to 1; above 0 the object transmits and has two sides.
    pub(super) transmittance: f64,
    pub(super) ior: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cone {
    pub(super) base: Vec3,
    pub(super) base_radius: f64,
    pub(super) apex: Vec3,
    pub(super) apex_radius: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sphere {
    pub(super) center: Vec3,
    pub(super) radius: f64,
}

/// A polygon with a shading normal for each vertex.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Patch {
    pub(super) vertices: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
}
