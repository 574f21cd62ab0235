//! STL: triangles without anything else, binary or text. Faces are flat, and z is up, as in the programs that print them.

use super::budget::{Budget, LINES, worked};
use super::fault::{Fault, Faults, Kind, Place, Subject, warn};
use super::geometry::Geometry;
use super::material::ModelMaterial;
use super::model::{Model, Placement, Up};
use super::polygon::{MOST_CORNERS, too_many_corners};
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
    // Binary files may begin with "solid" as those of text do: their length tells, else a byte that no text has. The highest one of
    // the count is 0 up to 16 million triangles.
    match count(bytes) {
        Some(_) if is_binary(bytes) => {
            corners.is_colored = bytes[..HEADER].windows(6).any(|word| word == b"COLOR=");
            binary(&bytes[HEADER..], &mut corners)?;
        }
        Some(count) if !begins_as_text(bytes) || bytes[..HEADER].contains(&0) => {
            let (needed, given) = (HEADER + count * TRIANGLE, bytes.len());
            let why = if given < needed { "it is cut off" } else { "more is behind them" };
            let detail = format!(
                "as binary STL the file has {count} triangles by its count, which need {needed} bytes, and it has {given}: {why}"
            );
            let place = Place::Offset(HEADER as u64 - 4);
            return Err(Faults::one(Fault::new("", Kind::OutOfBounds, detail).at(place)));
        }
        _ => text(bytes, &mut corners)?,
    }
    Ok(corners.into_model(Up::Z))
}

/// Whether a file begins as those of text do.
pub(crate) fn begins_as_text(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

/// Whether the length is that of a binary file with as many triangles as it says.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|count| bytes.len() == HEADER + count * TRIANGLE)
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
        corners.is_colored |= triangle[TRIANGLE - 1] & 0x80 != 0;
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

/// Words that stand before others, or say nothing.
const OTHERS: [&str; 2] = ["normal", "outer"];

fn text(bytes: &[u8], corners: &mut Corners) -> Result<(), Faults> {
    let is_one_line = !bytes.trim_ascii().iter().any(|byte| matches!(byte, b'\n' | b'\r'));
    let mut text = Text::new(bytes);
    let mut faults = Faults::default();
    let mut polygon: Vec<[f64; 3]> = Vec::new();
    let mut is_open = false;
    // Whether the words are a title: up to the end of its line, or where all is one line, up to the first facet.
    let mut is_title = false;
    for line in 0_u64.. {
        if line % LINES == 0 {
            worked(LINES * 64)?;
        }
        // What follows the first word of a line is no error: normals are whatever programs write.
        let mut is_first = true;
        while let Some(word) = text.word() {
            let word_is = |name: &str| word.text.eq_ignore_ascii_case(name.as_bytes());
            is_title &= !(is_one_line && word_is("facet"));
            if is_title {
                continue;
            }
            let ends = ["solid", "endsolid", "facet", "endfacet", "loop"].iter().any(|name| word_is(name));
            if ends && is_open && !faults.push(unended(word.place)) {
                return Err(faults);
            }
            if ends {
                polygon.clear();
                is_open = word_is("loop");
                is_title = word_is("solid") || word_is("endsolid");
            } else if word_is("vertex") {
                if !is_open {
                    let detail = format!("{} stands outside of a loop", word.quoted());
                    if !faults.push(word.fault(Kind::Invalid, detail)) {
                        return Err(faults);
                    }
                }
                if polygon.len() == MOST_CORNERS {
                    faults.push(too_many_corners().at(word.place));
                    return Err(faults);
                }
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
                is_open = false;
            } else if is_first && !OTHERS.iter().any(|name| word_is(name)) {
                let detail = format!("{} is no word of STL", word.quoted());
                if !faults.push(word.fault(Kind::Invalid, detail)) {
                    return Err(faults);
                }
            }
            is_first = false;
        }
        is_title = false;
        if !text.next_line() {
            break;
        }
    }
    if is_open {
        faults.push(unended(text.place()));
    }
    faults.none_or_err()
}

/// That a loop is not ended where something else begins.
fn unended(place: Place) -> Fault {
    Fault::new("", Kind::Invalid, "the loop before is not ended: endloop is missing").at(place)
}

/// Triangles by their corners, of which equal ones are one.
#[derive(Default)]
pub(super) struct Corners {
    geometry: Geometry,
    known: HashMap<[u64; 3], u32>,
    budget: Budget,
    /// Those that were added, also degenerate ones, which leave corners behind.
    count: usize,
    /// Whether the file has colors in one of two ways that programs know: a word in the title, or bits behind each triangle.
    is_colored: bool,
}

impl Corners {
    fn add(&mut self, points: &[[f64; 3]; 3]) -> Result<(), Fault> {
        if self.count.is_multiple_of(4_096) {
            worked(4_096)?;
            self.budget.take(4_096, 12 + 3 * 48)?;
        }
        self.count += 1;
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
        if a != b && b != c && c != a {
            triangles.push(triangle);
        }
        Ok(())
    }

    fn into_model(self, up: Up) -> Model {
        let mut model = Model { up, materials: vec![ModelMaterial::plain(0.8)], ..Model::default() };
        if !self.geometry.triangles.is_empty() {
            if self.is_colored {
                let detail = "colors of facets are left out: STL has no standard for them";
                warn(&mut model.warnings, Subject::Skipped, "colors", String::new(), detail);
            }
            let detail = "the file does not say which axis is up, and in STL it is mostly z: up=y turns it";
            warn(&mut model.warnings, Subject::Assumed, "up-z", String::new(), detail);
            model.geometries.push(self.geometry);
            let transforms = vec![DMat4::IDENTITY];
            model.placements.push(Placement { geometry: 0, material: Some(0), name: None, transforms });
        }
        model
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACET: &str = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

    fn triangles(text: &str) -> u64 {
        read(text.as_bytes()).unwrap_or_else(|faults| panic!("{text}: {faults:?}")).triangles()
    }

    #[test]
    fn text_is_as_programs_write_it() {
        let file = format!("solid a facet of my solid\n{FACET}endsolid a facet normal 1 2 3\nsolid\n{FACET}endsolid\n");
        let one_line = file.replace('\n', " ");
        for text in [&file, &file.to_uppercase(), &file.replace('\n', "\r\n"), &file.replace('\n', "\r"), &one_line] {
            assert_eq!(triangles(text), 2, "{text}");
            assert_eq!(triangles(&format!("\u{feff}{text}\n")), 2, "{text}");
        }
        assert_eq!(triangles(&file.replace("normal 0 0 1", "normal nan -nan(ind) 1")), 2);
        assert_eq!(triangles(&format!("solid a\n{}\nendsolid a", FACET.replace('\n', " "))), 1);
        let faults = read(format!("solid\n{}", FACET.replace("vertex 1", "vertx 1")).as_bytes()).unwrap_err();
        assert_eq!((faults.0[0].place, faults.0.len()), (Place::Line(5, 1), 2), "{faults:?}");
    }

    #[test]
    fn facets_without_area_and_endless_loops_take_no_more_than_others() {
        // They leave corners behind, so they count, but no more than others.
        let flat = FACET.replace("1 0 0", "0 0 0");
        assert_eq!(triangles(&format!("solid\n{}{FACET}endsolid\n", flat.repeat(5_000))), 1);
        let endless = format!("solid\nouter loop\n{}", "vertex 0 0 0\n".repeat(MOST_CORNERS + 1));
        let faults = read(endless.as_bytes()).unwrap_err();
        let fault = &faults.0[0];
        assert_eq!((fault.kind, fault.place), (Kind::Limit, Place::Line(MOST_CORNERS as u32 + 3, 1)), "{faults:?}");
    }

    #[test]
    fn binary_files_that_begin_with_solid_are_told_by_their_length() {
        let mut file = vec![b' '; HEADER - 4];
        file[..5].copy_from_slice(b"solid");
        file.extend(1_u32.to_le_bytes());
        file.extend(
            [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()),
        );
        file.extend([0, 0]);
        assert_eq!(read(&file).unwrap().triangles(), 1);
        for wrong in [&file[..HEADER + 49], &[&file[..], b"more"].concat()] {
            let faults = read(wrong).unwrap_err();
            let detail = &faults.0[0].detail;
            let expected = format!("1 triangles by its count, which need 134 bytes, and it has {}", wrong.len());
            assert!(detail.contains(&expected) && faults.0.len() == 1, "{detail}");
        }
    }
}
