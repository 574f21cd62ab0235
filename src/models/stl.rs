//! STL: triangles without anything else, binary or text. Faces are flat, and z is up, as in the programs that print them.

use super::budget::{Budget, worked};
use super::fault::{Fault, Faults, Kind, Place, Subject, warn};
use super::geometry::Geometry;
use super::material::ModelMaterial;
use super::model::{Model, Placement, Up};
use super::text::Text;
use glam::DMat4;
use hashbrown::HashMap;

/// Bytes before the triangles of a binary file: a title, and their number.
const HEADER: usize = 84;
/// Bytes of a triangle: its normal, three corners, and two that mean nothing.
const TRIANGLE: usize = 50;

/// Reads a file.
pub(super) fn read(bytes: &[u8]) -> Result<Model, Faults> {
    let mut corners = Corners::default();
    // Binary files may begin with "solid" as those of text do: their length tells.
    match count(bytes) {
        Some(count) if bytes.len() == HEADER + count * TRIANGLE => binary(&bytes[HEADER..], &mut corners)?,
        Some(count) if !bytes.trim_ascii_start().starts_with(b"solid") => {
            let detail =
                format!("{count} triangles need {} bytes, and there are {}", HEADER + count * TRIANGLE, bytes.len());
            let place = Place::Offset(HEADER as u64 - 4);
            return Err(Faults::one(Fault::new("", Kind::OutOfBounds, detail).at(place)));
        }
        _ => text(bytes, &mut corners)?,
    }
    Ok(corners.into_model(Up::Z))
}

fn count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize)
}

fn binary(bytes: &[u8], corners: &mut Corners) -> Result<(), Faults> {
    for (i, triangle) in bytes.chunks_exact(TRIANGLE).enumerate() {
        let number = |at: usize| {
            let at = 12 + 4 * at;
            f64::from(f32::from_le_bytes([triangle[at], triangle[at + 1], triangle[at + 2], triangle[at + 3]]))
        };
        let points = [0, 1, 2].map(|corner| [0, 1, 2].map(|c| number(3 * corner + c)));
        if points.as_flattened().iter().any(|number| !number.is_finite()) {
            let place = Place::Offset((HEADER + i * TRIANGLE) as u64);
            let detail = format!("triangle {i} has a corner that is no finite number");
            return Err(Faults::one(Fault::new("", Kind::OutOfRange, detail).at(place)));
        }
        corners.add(&points)?;
    }
    Ok(())
}

fn text(bytes: &[u8], corners: &mut Corners) -> Result<(), Faults> {
    let mut text = Text::new(bytes);
    let mut faults = Faults::default();
    let mut polygon: Vec<[f64; 3]> = Vec::new();
    loop {
        if let Some(word) = text.word() {
            let word_is = |name: &str| word.text.eq_ignore_ascii_case(name.as_bytes());
            if word_is("vertex") {
                polygon.extend(faults.note(text.numbers::<3>()));
            } else if word_is("endloop") {
                if polygon.len() < 3 {
                    let detail = format!("the loop has {} corners, and needs 3", polygon.len());
                    faults.push(word.fault(Kind::Degenerate, detail));
                }
                for i in 2..polygon.len() {
                    corners.add(&[polygon[0], polygon[i - 1], polygon[i]])?;
                }
                polygon.clear();
            } else if !["solid", "facet", "outer", "endfacet", "endsolid"].iter().any(|name| word_is(name)) {
                let detail = format!("{} is no word of STL", word.quoted());
                if !faults.push(word.fault(Kind::Invalid, detail)) {
                    break;
                }
            }
        }
        if !text.next_line() {
            break;
        }
    }
    faults.none_or_err()
}

/// Triangles by their corners, of which equal ones are one.
#[derive(Default)]
pub(super) struct Corners {
    geometry: Geometry,
    known: HashMap<[u64; 3], u32>,
    budget: Budget,
    degenerate: usize,
}

impl Corners {
    fn add(&mut self, points: &[[f64; 3]; 3]) -> Result<(), Fault> {
        if self.geometry.triangles.len().is_multiple_of(4_096) {
            worked(4_096)?;
            self.budget.take(4_096, 12 + 3 * 48)?;
        }
        let Geometry { positions, triangles, .. } = &mut self.geometry;
        let triangle = points.map(|point| {
            // -0 is 0.
            let key = point.map(|number| (number + 0.0).to_bits());
            *self.known.entry(key).or_insert_with(|| {
                positions.push(point);
                positions.len() as u32 - 1
            })
        });
        let [a, b, c] = triangle;
        if a == b || b == c || c == a {
            self.degenerate += 1;
        } else {
            triangles.push(triangle);
        }
        Ok(())
    }

    fn into_model(self, up: Up) -> Model {
        let mut model = Model { up, materials: vec![ModelMaterial::plain(0.8)], ..Model::default() };
        if !self.geometry.triangles.is_empty() {
            let detail = "the file does not say which axis is up, and in STL it is mostly z: up=y turns it";
            warn(&mut model.warnings, Subject::Assumed, "up-z", String::new(), detail);
            model.geometries.push(self.geometry);
            let transforms = vec![DMat4::IDENTITY];
            model.placements.push(Placement { geometry: 0, material: Some(0), name: None, transforms });
        }
        model
    }
}
