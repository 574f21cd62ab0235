//! The elements of a PLY file: vertices, polygons and strips.

use super::super::budget::{Budget, worked};
use super::super::fault::{Fault, Kind, Place, Subject, warn, warn_of_gaps};
use super::super::geometry::Geometry;
use super::super::material::{Alpha, ModelMaterial};
use super::super::model::{Model, Placement};
use super::super::polygon::{MOST_CORNERS, PolygonCutter, too_many_corners};
use super::header::{Element, Property};
use super::numbers::{Numbers, Scalar};
use crate::math;
use glam::DMat4;

/// What a property of a vertex is.
#[derive(Debug, Clone, Copy)]
enum Meaning {
    Position(usize),
    Normal(usize),
    Uv(usize),
    Color(usize),
}

impl Meaning {
    fn of(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"x" => Self::Position(0),
            b"y" => Self::Position(1),
            b"z" => Self::Position(2),
            b"nx" => Self::Normal(0),
            b"ny" => Self::Normal(1),
            b"nz" => Self::Normal(2),
            b"u" | b"s" | b"texture_u" => Self::Uv(0),
            b"v" | b"t" | b"texture_v" => Self::Uv(1),
            b"red" | b"r" | b"diffuse_red" => Self::Color(0),
            b"green" | b"g" | b"diffuse_green" => Self::Color(1),
            b"blue" | b"b" | b"diffuse_blue" => Self::Color(2),
            b"alpha" | b"a" => Self::Color(3),
            _ => return None,
        })
    }
}

/// What is read of a file.
#[derive(Default)]
pub(super) struct Reader {
    geometry: Geometry,
    has_vertices: bool,
    /// Some numbers were NaN or infinite.
    has_gaps: bool,
    /// Faces have colors, or texture coordinates of their own.
    face_colors: bool,
    face_uvs: bool,
    /// A face has less than three corners.
    has_few_corners: bool,
    budget: Budget,
    polygons: PolygonCutter,
}

impl Reader {
    pub(super) fn elements(&mut self, element: &Element, numbers: &mut Numbers<'_>) -> Result<(), Fault> {
        match element.name.as_slice() {
            b"vertex" => self.vertices(element, numbers),
            b"face" | b"tristrips" => self.faces(element, numbers),
            _ => {
                for i in 0..element.count {
                    pause(i)?;
                    for property in &element.properties {
                        skip(property, numbers)?;
                    }
                }
                Ok(())
            }
        }
    }

    fn vertices(&mut self, element: &Element, numbers: &mut Numbers<'_>) -> Result<(), Fault> {
        let meaning = |property: &Property| Meaning::of(&property.name).filter(|_| property.length.is_none());
        let meanings: Vec<_> = element.properties.iter().map(meaning).collect();
        let has = |wanted: fn(&Meaning) -> bool| meanings.iter().flatten().filter(|meaning| wanted(meaning)).count();
        let places = [0, 1, 2].map(|c| {
            meanings.iter().flatten().filter(|meaning| matches!(meaning, Meaning::Position(at) if *at == c)).count()
        });
        if places != [1; 3] {
            let detail = "vertices need the properties x, y and z, each as one number";
            return Err(Fault::new("", Kind::MissingKey, detail).at(element.place));
        }
        if self.has_vertices {
            return Err(Fault::new("", Kind::Invalid, "vertices are declared twice").at(element.place));
        }
        let has_normals = has(|meaning| matches!(meaning, Meaning::Normal(_))) >= 3;
        let has_uvs = has(|meaning| matches!(meaning, Meaning::Uv(_))) >= 2;
        let has_colors = has(|meaning| matches!(meaning, Meaning::Color(_))) >= 3;
        self.budget.take(element.count, 96)?;
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        let (mut uvs, mut colors) = (Vec::new(), Vec::new());
        for i in 0..element.count {
            pause(i)?;
            let (mut point, mut normal, mut uv, mut color) = ([0.0; 3], [0.0; 3], [0.0; 2], [1.0; 4]);
            for (property, meaning) in element.properties.iter().zip(&meanings) {
                let Some(meaning) = *meaning else {
                    skip(property, numbers)?;
                    continue;
                };
                let number = match meaning {
                    Meaning::Position(_) => numbers.next(property.scalar)?,
                    _ => numbers.next_or_nan(property.scalar)?,
                };
                self.has_gaps |= number.is_nan();
                let number = if number.is_nan() { 0.0 } else { number };
                let most = match property.scalar {
                    Scalar::U8 => 255.0,
                    Scalar::U16 => 65_535.0,
                    _ => 1.0,
                };
                match meaning {
                    Meaning::Position(c) => point[c] = number,
                    Meaning::Normal(c) => normal[c] = number,
                    // The origin is the lower left corner here.
                    Meaning::Uv(c) => uv[c] = if c == 1 { 1.0 - number } else { number },
                    Meaning::Color(3) => color[3] = (number / most).clamp(0.0, 1.0),
                    Meaning::Color(c) => color[c] = math::srgb_to_linear((number / most).clamp(0.0, 1e6)),
                }
            }
            points.push(point);
            normals.extend(has_normals.then_some(normal));
            uvs.extend(has_uvs.then_some(uv));
            colors.extend(has_colors.then_some(color));
        }
        self.geometry.positions = points;
        self.geometry.normals = has_normals.then_some(normals);
        self.geometry.uvs[0] = has_uvs.then_some(uvs);
        self.geometry.colors = has_colors.then_some(colors);
        self.has_vertices = true;
        Ok(())
    }

    fn faces(&mut self, element: &Element, numbers: &mut Numbers<'_>) -> Result<(), Fault> {
        if !self.has_vertices {
            let detail = "vertices come before faces";
            return Err(Fault::new("", Kind::Invalid, detail).at(element.place));
        }
        let is_list = |property: &Property| {
            property.length.is_some() && matches!(property.name.as_slice(), b"vertex_indices" | b"vertex_index")
        };
        if element.count > 0 && !element.properties.iter().any(is_list) {
            let detail = "faces and strips need a list vertex_indices";
            return Err(Fault::new("", Kind::MissingKey, detail).at(element.place));
        }
        let has = |names: &[&[u8]]| element.properties.iter().any(|property| names.contains(&property.name.as_slice()));
        self.face_colors |= has(&[b"red", b"green", b"blue"]);
        self.face_uvs |= has(&[b"texcoord"]);
        let mut corners = Vec::new();
        for i in 0..element.count {
            pause(i)?;
            for property in &element.properties {
                let Some(length) = property.length.filter(|_| is_list(property)) else {
                    skip(property, numbers)?;
                    continue;
                };
                let place = numbers.place();
                let count = length_of_list(numbers.next(length)?, numbers.left(), place)?;
                corners.clear();
                for _ in 0..count {
                    let place = numbers.place();
                    let index = numbers.next(property.scalar)?;
                    let is_known = index >= 0.0 && index < self.geometry.positions.len() as f64 && index % 1.0 == 0.0;
                    // -1 ends a strip.
                    let is_end = index == -1.0 && element.name == b"tristrips";
                    if !is_known && !is_end {
                        let detail = format!("{index} is no vertex: there are {}", self.geometry.positions.len());
                        return Err(Fault::new("", Kind::UnknownReference, detail).at(place));
                    }
                    corners.push(if is_known { index as u32 } else { u32::MAX });
                }
                if element.name == b"tristrips" {
                    self.strips(&corners)?;
                } else {
                    self.polygon(&corners).map_err(|fault| fault.at(place))?;
                }
            }
        }
        Ok(())
    }

    fn strips(&mut self, corners: &[u32]) -> Result<(), Fault> {
        self.budget.take(corners.len() as u64, 12)?;
        for strip in corners.split(|corner| *corner == u32::MAX) {
            let triangles =
                (0..strip.len().saturating_sub(2)).map(|i| [i, i + 1 + i % 2, i + 2 - i % 2].map(|at| strip[at]));
            self.geometry.triangles.extend(triangles.filter(|[a, b, c]| a != b && b != c && c != a));
        }
        Ok(())
    }

    fn polygon(&mut self, corners: &[u32]) -> Result<(), Fault> {
        if corners.len() > MOST_CORNERS {
            return Err(too_many_corners());
        }
        self.has_few_corners |= corners.len() < 3;
        self.budget.take(corners.len() as u64, 12)?;
        let positions = &self.geometry.positions;
        let triangles = self.polygons.cut(corners.len(), |corner| positions[corners[corner] as usize])?;
        let triangles = triangles.into_iter().map(|triangle| triangle.map(|i| corners[i as usize]));
        self.geometry.triangles.extend(triangles.filter(|[a, b, c]| a != b && b != c && c != a));
        Ok(())
    }

    pub(super) fn into_model(mut self) -> Model {
        let mut model = Model::default();
        if self.geometry.triangles.is_empty() {
            if !self.geometry.positions.is_empty() {
                let detail = "they have no surface and are left out";
                warn(&mut model.warnings, Subject::Skipped, "points", String::new(), detail);
            }
            return model;
        }
        let detail = "the file does not say which axis is up: up=z turns it";
        warn(&mut model.warnings, Subject::Assumed, "up-y", String::new(), detail);
        if self.has_gaps {
            warn_of_gaps(&mut model.warnings);
        }
        for (is_there, what, detail) in [
            (self.face_colors, "colors", "colors of faces are left out: those of vertices are not"),
            (self.has_few_corners, "faces", "faces with less than three corners are left out"),
            (self.face_uvs, "textures", "texture coordinates of faces are left out: those of vertices are not"),
        ] {
            if is_there {
                warn(&mut model.warnings, Subject::Skipped, what, String::new(), detail);
            }
        }
        self.geometry.drop_unused();
        self.geometry.mend_normals();
        // Colors of vertices are the surface's own.
        let colors = self.geometry.colors.as_deref();
        let mut material = ModelMaterial::plain(if colors.is_some() { 1.0 } else { 0.8 });
        let is_opaque = |color: &[f64; 4]| color[3] >= 1.0;
        // Some programs leave 0 where they mean nothing.
        if colors.is_some_and(|all| !all.iter().all(is_opaque) && all.iter().any(|color| color[3] > 0.0)) {
            material.alpha = Alpha::Blend;
        }
        model.materials.push(material);
        model.geometries.push(self.geometry);
        let transforms = vec![DMat4::IDENTITY];
        model.placements.push(Placement { geometry: 0, material: Some(0), name: None, transforms });
        model
    }
}

/// Looks now and then whether anybody still waits.
fn pause(i: u64) -> Result<(), Fault> {
    if i.is_multiple_of(4_096) { worked(4_096 * 8) } else { Ok(()) }
}

/// The numbers of a list, which must be in the rest of the file.
fn length_of_list(count: f64, left: u64, place: Place) -> Result<u64, Fault> {
    if count < 0.0 || count % 1.0 != 0.0 {
        let detail = format!("a list begins with how many numbers it has, and {count} is no such number");
        return Err(Fault::new("", Kind::OutOfRange, detail).at(place));
    }
    if count > left as f64 {
        let detail = format!("a list of {count} numbers does not fit into the rest of the file");
        return Err(Fault::new("", Kind::OutOfBounds, detail).at(place));
    }
    Ok(count as u64)
}

fn skip(property: &Property, numbers: &mut Numbers<'_>) -> Result<(), Fault> {
    let place = numbers.place();
    let count = property.length.map_or(Ok(1.0), |length| numbers.next(length))?;
    for i in 0..length_of_list(count, numbers.left(), place)? {
        pause(i)?;
        numbers.next_or_nan(property.scalar)?;
    }
    Ok(())
}
