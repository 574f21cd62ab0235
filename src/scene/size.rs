//! Memory that a scene will take, from above: estimated before it is read and before it is built, so that what has no room
//! is refused before it is made.
//!
//! The numbers are bytes of resident memory at its peak, measured for 200,000 objects of each kind, rounded upwards.

use super::Format;
use super::compile::Original;
use super::description::{Description, Object, Precision};
use super::pictures::source_bytes;

/// Bytes that reading a text takes beside the text.
pub fn reading_bytes(text: &[u8], format: Format) -> u64 {
    match format {
        // A broken text of up to 8 MiB is read into a tree of values, which takes up to 16 times as much.
        Format::Json => of_json(text).max(16 * text.len().min(8 << 20) as u64),
        Format::Nff => of_nff(text),
        // Numbers of four bytes become such of eight; pictures are written in base64. Of a million triangles of a .glb it is 3.1.
        Format::Gltf | Format::Stl => 5 * text.len() as u64,
        // Text is as long as its numbers, but vertices are known by their indices while it is read.
        Format::Obj | Format::Ply | Format::Parts => 8 * text.len() as u64,
    }
}

fn of_json(text: &[u8]) -> u64 {
    let (mut bytes, mut depth, mut names) = (0, 0_u32, false);
    let (mut at, mut last) = (0, b' ');
    while let Some(&byte) = text.get(at) {
        at += 1;
        match byte {
            b'"' => {
                // Among the keys of the scene only `materials` and `definitions` lead to named values.
                names = if depth == 1 { matches!(text.get(at), Some(b'm' | b'd')) } else { names };
                let start = at;
                while text.get(at).is_some_and(|byte| *byte != b'"') {
                    at += if text[at] == b'\\' { 2 } else { 1 };
                }
                bytes += 24 + at.min(text.len()).saturating_sub(start) as u64;
                at += 1;
            }
            b'{' | b'[' => {
                depth += 1;
                bytes += match byte {
                    _ if names && depth == 3 => 700,
                    // The first object of a list makes room for four.
                    b'{' if last == b'[' => 1_600,
                    b'{' => 200,
                    _ => 0,
                };
                last = byte;
            }
            b'}' | b']' => {
                depth = depth.saturating_sub(1);
                last = byte;
            }
            // Mostly of lists of numbers.
            b',' => {
                bytes += 13;
                last = byte;
            }
            _ => {}
        }
    }
    bytes
}

fn of_nff(text: &[u8]) -> u64 {
    let begins = |at: usize| at == 0 || text[at - 1].is_ascii_whitespace();
    let token = |(at, byte): (usize, &u8)| match byte {
        b's' | b'c' | b'p' if begins(at) => 500,
        b'f' if begins(at) => 1_000,
        b'0'..=b'9' | b'-' | b'.' if begins(at) => 16,
        _ => 0,
    };
    text.iter().enumerate().map(token).sum()
}

/// Bytes that building a scene takes beside its description, without its pictures.
pub fn building_bytes(description: &Description) -> u64 {
    Sizes::new(description.render.precision).of_scene(description)
}

impl Original<'_> {
    /// The same for a variation, whose meshes may be there already.
    pub fn building_bytes(&self, description: &Description) -> u64 {
        let sizes = Sizes::new(description.render.precision);
        let is_known =
            self.has_objects_of(description) && self.description.render.precision == description.render.precision;
        if is_known { Sizes { face: 0, vertex: 0, ..sizes }.of_scene(description) } else { sizes.of_scene(description) }
    }
}

/// Bytes that a description takes.
pub fn description_bytes(description: &Description) -> u64 {
    let sizes = Sizes { object: 200, boxed: 200, geometry: 200, face: 12, vertex: 24 };
    sizes.of_scene(description) + source_bytes(description)
}

/// Bytes of each.
struct Sizes {
    object: u64,
    /// Of those whose shape is large.
    boxed: u64,
    geometry: u64,
    face: u64,
    vertex: u64,
}

impl Sizes {
    fn new(precision: Precision) -> Self {
        match precision {
            Precision::Single => Self { object: 430, boxed: 200, geometry: 2_800, face: 95, vertex: 40 },
            Precision::Double => Self { object: 580, boxed: 300, geometry: 3_800, face: 180, vertex: 60 },
        }
    }

    fn of_scene(&self, description: &Description) -> u64 {
        let named = |name: &str, bytes: u64| bytes + 2 * name.len() as u64;
        let materials: u64 = description.materials.keys().map(|name| named(name, 400)).sum();
        let definitions =
            description.definitions.iter().map(|(name, objects)| named(name, self.geometry) + self.of(objects));
        self.geometry + self.of(&description.objects) + materials + definitions.sum::<u64>()
    }

    fn of(&self, objects: &[Object]) -> u64 {
        objects.iter().map(|object| self.of_one(object)).sum()
    }

    fn of_one(&self, object: &Object) -> u64 {
        let mesh = |faces: usize, vertices: usize| self.face * faces as u64 + self.vertex * vertices as u64;
        let name = object.appearance().and_then(|appearance| appearance.name).map_or(0, |name| 32 + name.len() as u64);
        let more = match object {
            Object::Sphere(_) | Object::Plane(_) | Object::Disc(_) | Object::Box(_) => 0,
            Object::Cylinder(_) | Object::Cone(_) | Object::Torus(_) => self.boxed,
            Object::Instance(instance) => {
                let motion = if instance.motion.is_some() { self.boxed } else { 0 };
                self.boxed + motion + instance.name.as_ref().map_or(0, |name| 32 + name.len() as u64)
            }
            Object::Triangle(_) => mesh(1, 3),
            Object::Quad(_) => mesh(2, 4),
            Object::Polygon(polygon) => mesh(polygon.vertices.len(), polygon.vertices.len()),
            Object::Mesh(m) => {
                let pairs = [&m.uvs, &m.uvs1].into_iter().flatten().map(Vec::len).sum::<usize>();
                let fours = [&m.colors, &m.tangents].into_iter().flatten().map(Vec::len).sum::<usize>();
                let further = m.normals.as_ref().map_or(0, Vec::len) + pairs + 2 * fours;
                mesh(m.faces.len(), m.vertices.len() + further)
            }
            // What is in its file is not known yet.
            Object::Model(model) => {
                let name = model.name.as_ref().map_or(0, |name| 32 + name.len() as u64);
                self.boxed + name + 400 * model.materials.len() as u64
            }
            // Its pointer repeats those of the groups around it.
            Object::Group(group) => {
                let name = group.name.as_ref().map_or(0, |name| 32 + name.len() as u64);
                self.geometry + self.boxed + 700 + name + self.of(&group.objects)
            }
        };
        self.object + name + more
    }
}
