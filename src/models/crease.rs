//! Normals for corners that have none: smooth over faces that meet at a small angle, and apart at creases, as modelling programs
//! shade them.

use super::budget::worked;
use super::fault::Fault;
use super::geometry::{Geometry, is_direction};
use crate::math;
use glam::DVec3;
use hashbrown::HashMap;

/// Cosine of the largest angle between faces that are one smooth surface: 40 degrees. The sides of an octagon keep their edges.
const SMOOTH: f64 = 0.766_044_443_118_978;
/// Cosine of the angle between normals from which on a corner is not flat.
const FLAT: f64 = 1.0 - 1e-9;
/// Most faces around a point of which each is held against all others; more stay flat.
const FACES: usize = 64;

/// The smoothing group of faces that are flat.
pub(super) const NOT_SMOOTH: u32 = 0;

/// A part of a surface: the faces of one material.
#[derive(Debug, Default)]
pub(super) struct Part {
    /// Its faces. Normals that are no directions count as none.
    pub(super) geometry: Geometry,
    /// The smoothing group of each triangle. Only faces of one group are smooth together.
    pub(super) groups: Vec<u32>,
}

/// A face of any part.
struct Face {
    part: u32,
    triangle: u32,
    /// Its angle at the point.
    angle: f64,
}

/// Gives each corner without a normal the mean of the normals around it that are no crease away, in whichever part, weighted by the
/// angles of faces at the corner, which no cut of a polygon into triangles changes. Points at creases become several. Parts without
/// normals in which no corner is smooth stay without them. Says whether any is.
pub(super) fn complete_normals(parts: &mut [Part]) -> Result<bool, Fault> {
    // Points that differ in texture coordinates alone are one point of the surface.
    let mut around: HashMap<[u64; 3], Vec<Face>> = HashMap::new();
    let mut lacks = Vec::with_capacity(parts.len());
    for part in &*parts {
        let mut any = false;
        part.lacking(|point| {
            any = true;
            around.entry(point).or_default();
        })?;
        lacks.push(any);
    }
    if around.is_empty() {
        parts.iter_mut().for_each(|part| _ = part.geometry.mend_normals());
        return Ok(false);
    }
    let unit: Vec<Vec<DVec3>> = parts.iter().map(Part::facings).collect();
    for (number, part) in (0..).zip(&*parts) {
        for (triangle, [a, b, c]) in (0..).zip(part.geometry.triangles.iter().copied()) {
            pause(triangle as usize)?;
            for [corner, next, last] in [[a, b, c], [b, c, a], [c, a, b]] {
                if let Some(faces) = around.get_mut(&part.key(corner)) {
                    faces.push(Face { part: number, triangle, angle: part.angle(corner, next, last) });
                }
            }
        }
    }
    let groups: Vec<Vec<u32>> = parts.iter().map(|part| part.groups.clone()).collect();
    let mut any = false;
    for (number, part) in parts.iter_mut().enumerate() {
        if !lacks[number] {
            part.geometry.mend_normals();
            continue;
        }
        let smooth_around = |point: [u64; 3], triangle: usize| {
            let (own, group) = (unit[number][triangle], groups[number][triangle]);
            let faces = &around[&point];
            // Where there are very many, each would be held against all others.
            if group == NOT_SMOOTH || faces.len() > FACES {
                return own;
            }
            let meets = |face: &&Face| {
                let [part, triangle] = [face.part as usize, face.triangle as usize];
                groups[part][triangle] == group && unit[part][triangle].dot(own) >= SMOOTH
            };
            let weighted = |face: &Face| unit[face.part as usize][face.triangle as usize] * face.angle;
            faces.iter().filter(meets).map(weighted).sum::<DVec3>().try_normalize().unwrap_or(own)
        };
        any |= part.complete(&unit[number], smooth_around)?;
    }
    Ok(any)
}

impl Part {
    /// Tells the points at which a corner of a triangle has no normal.
    fn lacking(&self, mut tell: impl FnMut([u64; 3])) -> Result<(), Fault> {
        for (number, triangle) in self.geometry.triangles.iter().enumerate() {
            pause(number)?;
            for corner in triangle.iter().copied() {
                if !self.geometry.normals.as_ref().is_some_and(|normals| is_direction(normals[corner as usize])) {
                    tell(self.key(corner));
                }
            }
        }
        Ok(())
    }

    /// Gives corners without a normal the one that `around` finds for a point and a triangle. Whether any of them is smooth.
    fn complete(&mut self, unit: &[DVec3], around: impl Fn([u64; 3], usize) -> DVec3) -> Result<bool, Fault> {
        let mut points: HashMap<(u32, [u64; 3]), u32> = HashMap::new();
        let (mut sources, mut normals) = (Vec::new(), Vec::new());
        let (mut triangles, mut any) = (self.geometry.triangles.clone(), false);
        for (face, triangle) in triangles.iter_mut().enumerate() {
            pause(face)?;
            for corner in triangle {
                let given = self.geometry.normals.as_ref().map(|normals| normals[*corner as usize]);
                let normal = match given.filter(|normal| is_direction(*normal)) {
                    Some(given) => DVec3::from_array(given).normalize(),
                    None => {
                        let normal = around(self.key(*corner), face);
                        any |= unit[face] != DVec3::ZERO && normal.dot(unit[face]) < FLAT;
                        normal
                    }
                };
                let normal = if normal == DVec3::ZERO { DVec3::Y } else { normal }.to_array();
                let point = points.entry((*corner, normal.map(f64::to_bits))).or_insert_with(|| {
                    sources.push(*corner as usize);
                    normals.push(normal);
                    sources.len() as u32 - 1
                });
                *corner = *point;
            }
        }
        let Geometry { positions, triangles: own, normals: given, uvs, colors, .. } = &mut self.geometry;
        if !any && given.is_none() {
            return Ok(false);
        }
        *own = triangles;
        *positions = sources.iter().map(|i| positions[*i]).collect();
        for uvs in uvs.iter_mut().flatten() {
            *uvs = sources.iter().map(|i| uvs[*i]).collect();
        }
        if let Some(colors) = colors {
            *colors = sources.iter().map(|i| colors[*i]).collect();
        }
        *given = Some(normals);
        Ok(any)
    }

    /// The unit normals of the triangles, 0 of those that have no area.
    fn facings(&self) -> Vec<DVec3> {
        let point = |i: u32| DVec3::from_array(self.geometry.positions[i as usize]);
        let facing = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(point);
            (b - a).cross(c - a).normalize_or_zero()
        };
        self.geometry.triangles.iter().map(facing).collect()
    }

    /// The angle of a triangle at its first corner.
    fn angle(&self, corner: u32, next: u32, last: u32) -> f64 {
        let [a, b, c] = [corner, next, last].map(|i| DVec3::from_array(self.geometry.positions[i as usize]));
        math::atan2((b - a).cross(c - a).length(), (b - a).dot(c - a))
    }

    /// Equal for equal points; -0 is 0.
    fn key(&self, point: u32) -> [u64; 3] {
        self.geometry.positions[point as usize].map(|x| (x + 0.0).to_bits())
    }
}

/// Looks now and then whether anybody still waits.
fn pause(triangle: usize) -> Result<(), Fault> {
    if triangle.is_multiple_of(4_096) { worked(4_096 * 64) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares that meet at an angle along the z axis, cut into triangles.
    fn bent(degrees: f64) -> Geometry {
        let (sin, cos) = math::sin_cos(degrees.to_radians());
        Geometry {
            positions: vec![
                [-1.0, 0.0, 0.0],
                [-1.0, 0.0, 1.0],
                [0.0, 0.0, 1.0],
                [0.0, 0.0, 0.0],
                [cos, sin, 1.0],
                [cos, sin, 0.0],
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]],
            ..Geometry::default()
        }
    }

    /// How much the normals at the edge lean from those of their faces: not at all, or by half of the angle.
    fn lean(parts: &[Part]) -> Vec<bool> {
        let of_part = |part: &Part| {
            let facings = part.facings();
            let normals = part.geometry.normals.as_ref()?;
            let leans = |(triangle, facing): (&[u32; 3], &DVec3)| {
                triangle.iter().any(|i| DVec3::from_array(normals[*i as usize]).dot(*facing) < FLAT)
            };
            Some(part.geometry.triangles.iter().zip(&facings).map(leans).collect::<Vec<_>>())
        };
        let flat = |part: &Part| vec![false; part.geometry.triangles.len()];
        parts.iter().flat_map(|part| of_part(part).unwrap_or_else(|| flat(part))).collect()
    }

    fn part(geometry: Geometry, groups: &[u32]) -> Part {
        Part { geometry, groups: groups.to_vec() }
    }

    #[test]
    fn faces_are_smooth_together_by_their_angle_and_their_group() {
        for (degrees, groups, expected) in [
            (30.0, [7; 4], true),
            (50.0, [7; 4], false),
            (30.0, [NOT_SMOOTH; 4], false),
            (30.0, [1, 1, 2, 2], false),
            (30.0, [NOT_SMOOTH, NOT_SMOOTH, 1, 1], false),
        ] {
            let mut parts = [part(bent(degrees), &groups)];
            assert_eq!(complete_normals(&mut parts).unwrap(), expected, "{degrees} {groups:?}");
            assert_eq!(lean(&parts), [expected; 4], "{degrees} {groups:?}");
            assert_eq!(parts[0].geometry.normals.is_some(), expected);
        }
    }

    #[test]
    fn a_surface_of_two_materials_is_one_surface() {
        let cut = |keep: std::ops::Range<usize>| {
            let mut geometry = bent(30.0);
            geometry.triangles = geometry.triangles[keep].to_vec();
            geometry.drop_unused();
            part(geometry, &[1; 2])
        };
        let mut parts = [cut(0..2), cut(2..4)];
        assert!(complete_normals(&mut parts).unwrap());
        let mut whole = [part(bent(30.0), &[1; 4])];
        complete_normals(&mut whole).unwrap();
        let normals = |parts: &[Part]| -> Vec<[f64; 3]> {
            let of_part = |part: &Part| {
                let normals = part.geometry.normals.clone().unwrap();
                part.geometry.triangles.iter().flatten().map(|i| normals[*i as usize]).collect::<Vec<_>>()
            };
            parts.iter().flat_map(of_part).collect()
        };
        assert_eq!(normals(&parts), normals(&whole));
    }

    #[test]
    fn normals_that_are_given_stay_and_others_do_not_follow_them() {
        let mut geometry = bent(80.0);
        let given = [0.0, 0.6, 0.8];
        geometry.normals = Some(vec![given, given, [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]]);
        let mut parts = [part(geometry, &[1; 4])];
        assert!(!complete_normals(&mut parts).unwrap(), "the edge is sharp");
        assert_eq!(lean(&parts), [true, true, false, false]);
        let Geometry { normals, positions, .. } = &parts[0].geometry;
        assert!(normals.as_ref().unwrap().contains(&given) && positions.len() == 8, "{positions:?}");
    }
}
