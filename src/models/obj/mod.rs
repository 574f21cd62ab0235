//! Wavefront OBJ: polygons over points, texture coordinates and normals with indices of their own, and materials by name.

use super::Parts;
use super::budget::{Budget, LINES, worked};
use super::crease::{NOT_SMOOTH, Part, complete_normals};
use super::fault::{Fault, Faults, Kind, Subject, warn, warn_of_gaps};
use super::material::ModelMaterial;
use super::model::{Model, Placement};
use super::mtl;
use super::polygon::{MOST_CORNERS, PolygonCutter, too_many_corners};
use super::text::{Text, Word};
use crate::math;
use glam::DMat4;
use hashbrown::{HashMap, HashSet};

/// Most material libraries that a file may name.
const LIBRARIES: usize = 1_000;

/// Reads a file and the materials that it names.
pub(super) fn read(bytes: &[u8], parts: &Parts<'_>) -> Result<Model, Faults> {
    let mut reader = Reader::default();
    let mut text = Text::new(bytes);
    let mut faults = Faults::default();
    for line in 0_u64.. {
        if line % LINES == 0 {
            worked(LINES * 64)?;
        }
        if let Some(word) = text.word()
            && let Err(fault) = reader.statement(word, &mut text, parts)
            && !faults.push(fault)
        {
            break;
        }
        if !text.next_line() {
            break;
        }
    }
    faults.none_or_err()?;
    Ok(reader.into_model()?)
}

/// The names of several material libraries in one line: each ends with `.mtl` and may have spaces. Behind the last end are words.
fn libraries(line: &str) -> impl Iterator<Item = &str> {
    let ends_here = |word: &str| word.trim_end().to_ascii_lowercase().ends_with(".mtl");
    let mut rest = line;
    let with_spaces = std::iter::from_fn(move || {
        let mut end = 0;
        let found = rest.split_inclusive(char::is_whitespace).find(|word| {
            end += word.len();
            ends_here(word)
        });
        found?;
        let (name, behind) = rest.split_at(end);
        rest = behind;
        Some(name.trim())
    });
    let last = line.split_inclusive(char::is_whitespace).rev().skip_while(move |word| !ends_here(word));
    let behind: usize = last.map(str::len).sum();
    with_spaces.chain(line[behind..].split_whitespace())
}

/// Indices of what meets at a corner of a face, from 0.
type Corner = (u32, Option<u32>, Option<u32>);

/// Faces of one material.
#[derive(Default)]
struct Group {
    part: Part,
    normals: Vec<[f64; 3]>,
    uvs: Vec<[f64; 2]>,
    colors: Vec<[f64; 4]>,
    has_normals: bool,
    has_uvs: bool,
    known: HashMap<Corner, u32>,
}

#[derive(Default)]
struct Reader {
    points: Vec<[f64; 3]>,
    /// One for each point, once any has one.
    colors: Vec<[f64; 3]>,
    uvs: Vec<[f64; 2]>,
    normals: Vec<[f64; 3]>,
    groups: Vec<Group>,
    /// Groups by the index of their material; the last is for faces without one.
    of_material: HashMap<Option<usize>, usize>,
    material: Option<usize>,
    materials: mtl::Library,
    /// Names of files of materials so far.
    libraries: HashSet<String>,
    /// The smoothing group of faces from here on; none as long as the file says nothing of it.
    smoothing: Option<u32>,
    model: Model,
    budget: Budget,
    polygons: PolygonCutter,
    corners: Vec<Corner>,
}

impl Reader {
    fn statement(&mut self, word: Word<'_>, text: &mut Text<'_>, parts: &Parts<'_>) -> Result<(), Fault> {
        match word.text {
            b"v" => {
                self.budget.take(1, 48)?;
                let point = text.numbers::<3>()?;
                self.point_color(text)?;
                self.points.push(point);
            }
            b"vt" => {
                self.budget.take(1, 16)?;
                let u = self.number_or_zero(text.expected("a number")?)?;
                let v = text.word().map_or(Ok(0.0), |word| self.number_or_zero(word))?;
                self.uvs.push([u, 1.0 - v]);
            }
            b"vn" => {
                self.budget.take(1, 24)?;
                let mut normal = [0.0; 3];
                for number in &mut normal {
                    *number = self.number_or_zero(text.expected("a number")?)?;
                }
                self.normals.push(normal);
            }
            b"f" => self.face(word, text)?,
            b"usemtl" => {
                let name = text.name();
                // Names may have "#", and comments may stand behind them.
                let plain = || name.split_once(" #").map(|(name, _)| name.trim_end());
                self.material = self.materials.find(&name).or_else(|| self.materials.find(plain()?));
                if self.material.is_none() {
                    let detail = "a material that no MTL file describes is grey";
                    warn(&mut self.model.warnings, Subject::Assumed, "materials", String::new(), detail);
                }
            }
            b"mtllib" => self.library(text, parts)?,
            b"o" if self.model.name.is_none() => self.model.name = Some(text.name()),
            b"p" => self.skip("points", "they have no surface and are left out"),
            b"l" => self.skip("lines", "they have no surface and are left out"),
            b"curv" | b"curv2" | b"surf" | b"cstype" => {
                self.skip("curves", "free-form curves and surfaces are left out")
            }
            b"call" | b"csh" => self.skip("files", "what call and csh bring from elsewhere is left out"),
            b"s" => {
                let group = text.word().filter(|word| word.text != b"off");
                let number = group.map(|word| std::str::from_utf8(word.text).ok()?.parse().ok());
                self.smoothing = Some(number.map_or(NOT_SMOOTH, |number| number.unwrap_or(1)));
            }
            b"o" | b"g" | b"vp" | b"mg" | b"deg" | b"bmat" | b"step" | b"parm" | b"trim" | b"hole" | b"scrv"
            | b"sp" | b"end" | b"con" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"maplib" | b"usemap"
            | b"shadow_obj" | b"trace_obj" | b"ctech" | b"stech" => {}
            _ => return Err(word.fault(Kind::Invalid, format!("{} is no statement of OBJ", word.quoted()))),
        }
        Ok(())
    }

    fn skip(&mut self, what: &'static str, detail: &str) {
        warn(&mut self.model.warnings, Subject::Skipped, what, String::new(), detail);
    }

    /// A number that a face can do without.
    fn number_or_zero(&mut self, word: Word<'_>) -> Result<f64, Fault> {
        let number = word.number_or_nan()?;
        if number.is_nan() {
            warn_of_gaps(&mut self.model.warnings);
            return Ok(0.0);
        }
        Ok(number)
    }

    /// Three numbers behind a point are its color, as many programs write them; a single one is its weight.
    fn point_color(&mut self, text: &mut Text<'_>) -> Result<(), Fault> {
        let Some(first) = text.word() else {
            if !self.colors.is_empty() {
                self.colors.push([1.0; 3]);
            }
            return Ok(());
        };
        let Some(second) = text.word() else { return first.number_or_nan().map(drop) };
        let third = text.expected("a number")?;
        let color = [self.number_or_zero(first)?, self.number_or_zero(second)?, self.number_or_zero(third)?];
        self.colors.resize(self.points.len(), [1.0; 3]);
        self.colors.push(color.map(|channel| math::srgb_to_linear(channel.clamp(0.0, 1e6))));
        Ok(())
    }

    fn library(&mut self, text: &mut Text<'_>, parts: &Parts<'_>) -> Result<(), Fault> {
        let line = text.name();
        if self.libraries.contains(&line) {
            return Ok(());
        }
        if let Ok(bytes) = parts(&line) {
            self.is_new_library(&line)?;
            return self.materials_of(&line, &bytes, parts);
        }
        for name in libraries(&line).take_while(|name| !name.starts_with('#')) {
            worked(1)?;
            if !self.is_new_library(name)? {
                continue;
            }
            match parts(name) {
                Ok(bytes) => self.materials_of(name, &bytes, parts)?,
                Err(why) => {
                    let shown: String = name.chars().take(60).collect();
                    let detail = format!("materials of a file that is missing are grey: {shown:?} {why}");
                    warn(&mut self.model.warnings, Subject::Skipped, "materials", String::new(), &detail);
                }
            }
        }
        Ok(())
    }

    /// Whether a library has not been named before: each is read once.
    fn is_new_library(&mut self, name: &str) -> Result<bool, Fault> {
        if self.libraries.contains(name) {
            return Ok(false);
        }
        if self.libraries.len() == LIBRARIES {
            let detail =
                format!("the model names more than {LIBRARIES} material libraries: put its materials into fewer");
            return Err(Fault::new("", Kind::Limit, detail));
        }
        Ok(self.libraries.insert(name.to_owned()))
    }

    fn materials_of(&mut self, file: &str, bytes: &[u8], parts: &Parts<'_>) -> Result<(), Fault> {
        self.model.has_parts = true;
        self.budget.take(bytes.len() as u64, 1)?;
        self.materials.read(file, bytes, parts, &mut self.model, &self.budget)
    }

    fn face(&mut self, word: Word<'_>, text: &mut Text<'_>) -> Result<(), Fault> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        while let Some(word) = text.word() {
            corners.push(self.corner(word)?);
            if corners.len() > MOST_CORNERS {
                return Err(too_many_corners().at(word.place));
            }
        }
        if corners.len() < 3 {
            return Err(word.fault(Kind::Degenerate, format!("the face has {} corners, and needs 3", corners.len())));
        }
        self.budget.take(corners.len() as u64, 12 + 24 + 24 + 16 + 32)?;
        let points = &self.points;
        let triangles = self.polygons.cut(corners.len(), |corner| points[corners[corner].0 as usize]);
        let triangles = triangles.map_err(|fault| fault.at(word.place))?;
        let groups = &mut self.groups;
        let group = *self.of_material.entry(self.material).or_insert_with(|| {
            groups.push(Group::default());
            groups.len() - 1
        });
        let indices: Vec<u32> = corners.iter().map(|corner| self.index(group, *corner)).collect();
        let faces = triangles.into_iter().map(|triangle| triangle.map(|i| indices[i as usize]));
        let faces = faces.filter(|[a, b, c]| a != b && b != c && c != a);
        let part = &mut self.groups[group].part;
        part.geometry.triangles.extend(faces);
        part.groups.resize(part.geometry.triangles.len(), self.smoothing.unwrap_or(u32::MAX));
        self.corners = corners;
        Ok(())
    }

    /// A corner: `point`, `point/uv`, `point//normal` or `point/uv/normal`, from 1, or from -1 backwards.
    fn corner(&self, word: Word<'_>) -> Result<Corner, Fault> {
        let mut indices = word.text.split(|byte| *byte == b'/');
        let mut index = |count: usize, what: &str| -> Result<Option<u32>, Fault> {
            let Some(text) = indices.next().filter(|text| !text.is_empty()) else { return Ok(None) };
            let number = std::str::from_utf8(text).ok().and_then(|text| text.parse::<i64>().ok());
            let place = match number {
                Some(number) if number > 0 => usize::try_from(number - 1).ok(),
                Some(number) if number < 0 => usize::try_from(count as i64 + number).ok(),
                _ => None,
            };
            place.filter(|place| *place < count).map(|place| Some(place as u32)).ok_or_else(|| {
                let detail = format!("{} names no {what}: there are {count} before it", word.quoted());
                word.fault(Kind::UnknownReference, detail)
            })
        };
        let point = index(self.points.len(), "point")?;
        let uv = index(self.uvs.len(), "texture coordinates")?;
        let normal = index(self.normals.len(), "normal")?;
        match point.filter(|_| indices.next().is_none()) {
            Some(point) => Ok((point, uv, normal)),
            None => Err(word.fault(Kind::Invalid, format!("{} is no corner: write point/uv/normal", word.quoted()))),
        }
    }

    fn index(&mut self, group: usize, corner: Corner) -> u32 {
        let (points, all_uvs, all_normals, all_colors) = (&self.points, &self.uvs, &self.normals, &self.colors);
        let group = &mut self.groups[group];
        let Group { part, normals, uvs, colors, has_normals, has_uvs, known } = group;
        let geometry = &mut part.geometry;
        *known.entry(corner).or_insert_with(|| {
            let (point, uv, normal) = corner;
            geometry.positions.push(points[point as usize]);
            *has_normals |= normal.is_some();
            *has_uvs |= uv.is_some();
            normals.push(normal.map_or([0.0; 3], |normal| all_normals[normal as usize]));
            uvs.push(uv.map_or([0.0; 2], |uv| all_uvs[uv as usize]));
            if !all_colors.is_empty() {
                // Points before the first color are white.
                colors.resize(geometry.positions.len() - 1, [1.0; 4]);
                let [r, g, b] = all_colors.get(point as usize).copied().unwrap_or([1.0; 3]);
                colors.push([r, g, b, 1.0]);
            }
            geometry.positions.len() as u32 - 1
        })
    }

    fn into_model(self) -> Result<Model, Fault> {
        let mut model = self.model;
        model.materials = self.materials.materials;
        let mut grey = None;
        let mut groups: Vec<_> = self.of_material.into_iter().collect();
        // In the order in which they were first used.
        groups.sort_by_key(|(_, group)| *group);
        let mut parts = Vec::new();
        for mut group in self.groups {
            let geometry = &mut group.part.geometry;
            geometry.normals = group.has_normals.then_some(group.normals);
            geometry.uvs[0] = group.has_uvs.then_some(group.uvs);
            geometry.colors = (!group.colors.is_empty()).then_some(group.colors);
            geometry.drop_unused();
            parts.push(group.part);
        }
        if complete_normals(&mut parts)? {
            let detail = "faces without normals that meet at less than 40 degrees are one smooth surface";
            warn(&mut model.warnings, Subject::Assumed, "normals", String::new(), detail);
        }
        for (material, group) in groups {
            let geometry = std::mem::take(&mut parts[group].geometry);
            if geometry.triangles.is_empty() {
                continue;
            }
            let material = material.unwrap_or_else(|| {
                *grey.get_or_insert_with(|| {
                    // Colors of points are the surface's own.
                    model.materials.push(ModelMaterial::plain(if geometry.colors.is_some() { 1.0 } else { 0.8 }));
                    model.materials.len() - 1
                })
            });
            model.geometries.push(geometry);
            let geometry = model.geometries.len() - 1;
            let transforms = vec![DMat4::IDENTITY];
            model.placements.push(Placement { geometry, material: Some(material), name: None, transforms });
        }
        Ok(model)
    }
}

#[cfg(test)]
mod tests;
