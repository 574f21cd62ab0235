//! KHR_draco_mesh_compression: the attributes and triangles of a primitive in one stream, unpacked to what its accessors say.
//!
//! The counts of the accessors are limits for the decoder (`draco-core`), so a stream never gives more than the file says.

use super::super::budget::Budget;
use super::super::fault::{Fault, Faults, Kind};
use super::accessors::{Component, width};
use super::buffers::Buffers;
use super::json::{Document, Draco, Primitive};
use draco_core::{DataType, DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute, PointIndex};
use std::collections::HashMap;

/// Bytes that the decoder takes for a triangle beside what it gives: corners, their opposites, and seams of attributes.
const WORK: usize = 64;
/// Bytes of an element of an attribute, at most.
const ELEMENT: u64 = 32;
/// Attributes that a stream may have beside those that the file names.
const UNNAMED: u64 = 8;

/// The elements of accessors that come out of streams, by the index of the accessor.
pub(super) fn unpack(document: &Document, buffers: &Buffers<'_>, faults: &mut Faults) -> HashMap<usize, Vec<u8>> {
    let mut unpacked = Unpacked::default();
    for (i, mesh) in document.meshes.iter().enumerate() {
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            let Some(draco) = &primitive.extensions.draco else { continue };
            let pointer = format!("/meshes/{i}/primitives/{k}");
            let done = unpacked.primitive(document, buffers, primitive, draco, &pointer);
            if let Err(fault) = done
                && !faults.push(fault.under(format!("{pointer}/extensions/KHR_draco_mesh_compression")))
            {
                return HashMap::new();
            }
        }
    }
    unpacked.elements
}

#[derive(Default)]
struct Unpacked {
    elements: HashMap<usize, Vec<u8>>,
    /// The view and the number in its stream that an accessor is from; indices have no number.
    origins: HashMap<usize, (usize, Option<u32>)>,
}

impl Unpacked {
    fn primitive(
        &mut self,
        document: &Document,
        buffers: &Buffers<'_>,
        primitive: &Primitive,
        draco: &Draco,
        pointer: &str,
    ) -> Result<(), Fault> {
        let named = draco.attributes.iter();
        let attributes: Vec<(&str, usize, u32)> = named
            .filter_map(|(name, number)| Some((name.as_str(), *primitive.attributes.get(name)?, *number)))
            .collect();
        let has_bytes = |accessor: usize| document.accessors[accessor].buffer_view.is_some();
        if primitive.indices.is_none_or(has_bytes) && attributes.iter().all(|(_, accessor, _)| has_bytes(*accessor)) {
            // All is there for readers without the extension, too.
            return Ok(());
        }
        let Some(indices) = primitive.indices else {
            let detail = "the triangles of a Draco stream need an accessor of indices";
            return Err(Fault::new(format!("{pointer}/indices"), Kind::MissingKey, detail));
        };
        if primitive.mode != 4 {
            let detail = "a Draco stream holds triangles: the mode must be 4";
            return Err(Fault::new(format!("{pointer}/mode"), Kind::Unsupported, detail));
        }
        let view = draco.buffer_view;
        let mut origins = vec![(indices, (view, None))];
        origins.extend(attributes.iter().map(|(_, accessor, number)| (*accessor, (view, Some(*number)))));
        let known = |(accessor, origin): &(usize, (usize, Option<u32>))| self.origins.get(accessor) == Some(origin);
        if origins.iter().all(known) {
            return Ok(());
        }
        if let Some((accessor, _)) = origins.iter().find(|it| self.origins.contains_key(&it.0) && !known(it)) {
            let detail = format!("accessor {accessor} would be unpacked from two streams");
            return Err(Fault::new("", Kind::OutOfRange, detail));
        }
        let points = attributes.first().map_or(0, |(_, accessor, _)| document.accessors[*accessor].count);
        let triangles = document.accessors[indices].count / 3;
        let stream = buffers.view(view)?;
        let mesh = decode(stream, points, triangles, attributes.len() as u64, &buffers.budget)?;
        self.elements.insert(indices, corners(document, indices, &mesh)?);
        for (name, accessor, number) in attributes {
            check_count(document, accessor, mesh.num_points(), "vertices")?;
            let Some(attribute) = mesh.attribute_by_unique_id(number) else {
                let pointer = format!("{pointer}/extensions/KHR_draco_mesh_compression/attributes/{name}");
                let detail = format!("the stream has no attribute {number}");
                return Err(Fault::new(pointer, Kind::UnknownReference, detail));
            };
            self.elements.insert(accessor, elements(document, accessor, attribute, mesh.num_points())?);
        }
        self.origins.extend(origins);
        Ok(())
    }
}

fn check_count(document: &Document, accessor: usize, there: usize, what: &str) -> Result<(), Fault> {
    let count = document.accessors[accessor].count;
    if count == there as u64 {
        return Ok(());
    }
    let detail = format!("it is {count}, and the Draco stream has {there} {what}");
    Err(Fault::new(format!("/accessors/{accessor}/count"), Kind::OutOfRange, detail))
}

/// The corners of the triangles in the type of their accessor.
fn corners(document: &Document, index: usize, mesh: &Mesh) -> Result<Vec<u8>, Fault> {
    check_count(document, index, 3 * mesh.num_faces(), "corners of triangles")?;
    let component = Component::of(document.accessors[index].component_type);
    let fitting = component.filter(|component| match component {
        Component::U8 => mesh.num_points() <= 1 << 8,
        Component::U16 => mesh.num_points() <= 1 << 16,
        _ => *component == Component::U32,
    });
    let Some(component) = fitting else {
        let detail = format!("{} vertices have no indices of this type", mesh.num_points());
        return Err(Fault::new(format!("/accessors/{index}/componentType"), Kind::OutOfRange, detail));
    };
    let mut into = Vec::with_capacity(12 * mesh.num_faces());
    mesh.faces().iter().flatten().for_each(|point| component.write(f64::from(point.0), &mut into));
    Ok(into)
}

/// Unpacks a stream, if it has no more than so much.
fn decode(stream: &[u8], points: u64, triangles: u64, attributes: u64, budget: &Budget) -> Result<Mesh, Fault> {
    let bytes = points.saturating_mul((attributes + UNNAMED) * ELEMENT);
    budget.take(stream.len() as u64, 1)?;
    budget.take(points.saturating_mul(attributes), ELEMENT as usize / 2)?;
    budget.take(triangles, WORK)?;
    let limits =
        DecodeLimits::default().with_max_points(points).with_max_faces(triangles).with_max_decoded_bytes(bytes);
    let mut mesh = Mesh::new();
    let decoded = MeshDecoder::new().decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh);
    decoded.map_err(|error| match error.kind() {
        ErrorKind::LimitExceeded => {
            let detail = format!("the Draco stream has more than the accessors say: {triangles} triangles");
            Fault::new("", Kind::OutOfRange, detail)
        }
        _ => {
            let why: String = error.to_string().chars().take(120).collect();
            let detail = format!("the Draco stream cannot be unpacked ({why}): pack it anew, or with gltfpack -cc");
            Fault::new("", Kind::Invalid, detail)
        }
    })?;
    Ok(mesh)
}

/// The elements of an attribute in the types of an accessor.
fn elements(document: &Document, index: usize, attribute: &PointAttribute, points: usize) -> Result<Vec<u8>, Fault> {
    let accessor = &document.accessors[index];
    let typed = Component::of(accessor.component_type).zip(width(&accessor.kind));
    let components = usize::from(attribute.num_components());
    let Some((component, _)) = typed.filter(|(_, width)| *width == components) else {
        let detail = format!("is {}, and the Draco stream has {components} numbers for each vertex", accessor.kind);
        return Err(Fault::new(format!("/accessors/{index}/type"), Kind::WrongType, detail));
    };
    let wrong = |detail: &str| Fault::new(format!("/accessors/{index}"), Kind::Invalid, detail);
    let (size, stride) = (attribute.data_type().byte_length(), attribute.byte_stride() as usize);
    let bytes = attribute.buffer().data();
    let mut into = Vec::with_capacity(points * components * component.size() as usize);
    for point in 0..points {
        let start = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let element = start.checked_mul(stride).and_then(|start| bytes.get(start..)?.get(..size * components));
        let element = element.ok_or_else(|| wrong("the Draco stream has no value for a vertex"))?;
        for number in element.chunks_exact(size) {
            let number = number_of(attribute.data_type(), number);
            component.write(number.ok_or_else(|| wrong("the Draco stream has no numbers"))?, &mut into);
        }
    }
    Ok(into)
}

fn number_of(kind: DataType, bytes: &[u8]) -> Option<f64> {
    Some(match kind {
        DataType::Int8 => f64::from(i8::from_le_bytes(bytes.try_into().ok()?)),
        DataType::Uint8 | DataType::Bool => f64::from(*bytes.first()?),
        DataType::Int16 => f64::from(i16::from_le_bytes(bytes.try_into().ok()?)),
        DataType::Uint16 => f64::from(u16::from_le_bytes(bytes.try_into().ok()?)),
        DataType::Int32 => f64::from(i32::from_le_bytes(bytes.try_into().ok()?)),
        DataType::Uint32 => f64::from(u32::from_le_bytes(bytes.try_into().ok()?)),
        DataType::Float32 => f64::from(f32::from_le_bytes(bytes.try_into().ok()?)),
        DataType::Float64 => f64::from_le_bytes(bytes.try_into().ok()?),
        _ => return None,
    })
}
