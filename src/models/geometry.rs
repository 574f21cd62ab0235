//! Triangles over shared vertices, as every format gives them.

use glam::{DMat3, DMat4, DVec3};
use hashbrown::HashMap;

/// Triangles. All lists of vertices are as long as `positions`; indices are below that.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Geometry {
    /// Points.
    pub positions: Vec<[f64; 3]>,
    /// The triangles, with fronts counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals; without them faces are flat.
    pub normals: Option<Vec<[f64; 3]>>,
    /// Unit tangents, and the side of the bitangent.
    pub tangents: Option<Vec<[f64; 4]>>,
    /// The sets of texture coordinates, of which the origin is the upper left corner of the picture.
    pub uvs: [Option<Vec<[f64; 2]>>; 2],
    /// Linear colors and opacity, which multiply those of the material.
    pub colors: Option<Vec<[f64; 4]>>,
}

impl Geometry {
    /// Bytes of its lists.
    pub fn bytes(&self) -> usize {
        fn of<T>(list: Option<&Vec<T>>) -> usize {
            list.map_or(0, |list| size_of_val(&list[..]))
        }
        let Self { positions, triangles, normals, tangents, uvs: [uvs, uvs1], colors } = self;
        let of_numbers = of(normals.as_ref()) + of(tangents.as_ref()) + of(uvs.as_ref()) + of(uvs1.as_ref());
        of(Some(positions)) + of(Some(triangles)) + of_numbers + of(colors.as_ref())
    }

    /// Unit normals in the place of those that are none; how many were. They are the means of their faces, weighted by area.
    pub(super) fn mend_normals(&mut self) -> usize {
        let Some(normals) = &mut self.normals else { return 0 };
        let broken = normals.iter().filter(|normal| !is_direction(**normal)).count();
        if broken > 0 {
            let mut means = vec![DVec3::ZERO; normals.len()];
            for triangle in &self.triangles {
                let [a, b, c] = triangle.map(|i| DVec3::from_array(self.positions[i as usize]));
                triangle.iter().for_each(|&i| means[i as usize] += (b - a).cross(c - a));
            }
            for (normal, mean) in normals.iter_mut().zip(means).filter(|(normal, _)| !is_direction(**normal)) {
                *normal = mean.try_normalize().unwrap_or(DVec3::Y).to_array();
            }
        }
        for normal in normals {
            *normal = DVec3::from_array(*normal).normalize().to_array();
        }
        broken
    }

    /// Whether any triangle has three corners.
    pub(super) fn has_area(&self) -> bool {
        self.first_with_area(usize::MAX, DVec3::from_array).is_some()
    }

    /// The first of so many triangles that has three corners where its points are moved.
    pub(super) fn first_with_area(&self, most: usize, moved: impl Fn([f64; 3]) -> DVec3) -> Option<usize> {
        self.triangles.iter().take(most).position(|triangle| {
            let [a, b, c] = triangle.map(|i| moved(self.positions[i as usize]));
            a != b && b != c && c != a
        })
    }

    /// Drops the points that no triangle has: a box around all of them would be too large.
    pub(super) fn drop_unused(&mut self) {
        let mut places = vec![u32::MAX; self.positions.len()];
        self.triangles.iter().flatten().for_each(|&i| places[i as usize] = 0);
        let mut used = 0;
        for place in places.iter_mut().filter(|place| **place == 0) {
            *place = used;
            used += 1;
        }
        if used as usize == places.len() {
            return;
        }
        self.triangles.iter_mut().flatten().for_each(|i| *i = places[*i as usize]);
        keep(&mut self.positions, &places);
        self.normals.iter_mut().for_each(|list| keep(list, &places));
        self.tangents.iter_mut().for_each(|list| keep(list, &places));
        self.uvs.iter_mut().flatten().for_each(|list| keep(list, &places));
        self.colors.iter_mut().for_each(|list| keep(list, &places));
    }

    /// Some of its triangles, with the points that these have.
    pub(crate) fn part(&self, triangles: &[[u32; 3]]) -> Self {
        fn of<T: Copy>(list: &[T], points: &[u32]) -> Vec<T> {
            points.iter().map(|i| list[*i as usize]).collect()
        }
        let (mut places, mut points) = (HashMap::new(), Vec::new());
        let mut place = |i: u32| {
            *places.entry(i).or_insert_with(|| {
                points.push(i);
                points.len() as u32 - 1
            })
        };
        let triangles = triangles.iter().map(|triangle| triangle.map(&mut place)).collect();
        Self {
            positions: of(&self.positions, &points),
            triangles,
            normals: self.normals.as_ref().map(|list| of(list, &points)),
            tangents: self.tangents.as_ref().map(|list| of(list, &points)),
            uvs: self.uvs.each_ref().map(|list| list.as_ref().map(|list| of(list, &points))),
            colors: self.colors.as_ref().map(|list| of(list, &points)),
        }
    }

    /// The same with all points moved by a matrix each. Triangles that are mirrored are turned around, so that their fronts stay
    /// outside.
    pub(crate) fn moved(mut self, matrix: impl Fn(usize) -> DMat4) -> Self {
        let mirrors = |i: usize| DMat3::from_mat4(matrix(i)).determinant() < 0.0;
        for [a, b, c] in &mut self.triangles {
            let mirrored = [*a, *b, *c].into_iter().filter(|corner| mirrors(*corner as usize)).count();
            if mirrored >= 2 {
                std::mem::swap(b, c);
            }
        }
        for (i, position) in self.positions.iter_mut().enumerate() {
            *position = matrix(i).transform_point3(DVec3::from_array(*position)).to_array();
        }
        let across = |i: usize| {
            let linear = DMat3::from_mat4(matrix(i));
            // The cofactors turn normals also where the matrix has no inverse.
            let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
            let side = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
            DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * side
        };
        for (i, normal) in self.normals.iter_mut().flatten().enumerate() {
            let turned = across(i) * DVec3::from_array(*normal);
            *normal = turned.try_normalize().unwrap_or(DVec3::Y).to_array();
        }
        for (i, tangent) in self.tangents.iter_mut().flatten().enumerate() {
            let [x, y, z, w] = *tangent;
            let turned = matrix(i).transform_vector3(DVec3::new(x, y, z)).try_normalize().unwrap_or(DVec3::X);
            // A mirror image has the other hand.
            let side = if mirrors(i) { -1.0 } else { 1.0 };
            *tangent = [turned.x, turned.y, turned.z, side * w];
        }
        self
    }
}

/// Whether a normal is one, once it has a length of 1. The square of a length of 1e154 is no number any more.
pub(super) fn is_direction(normal: [f64; 3]) -> bool {
    let squared = DVec3::from_array(normal).length_squared();
    squared > 1e-12 && squared.is_finite()
}

/// Keeps the elements that have a place.
fn keep<T>(list: &mut Vec<T>, places: &[u32]) {
    let mut i = 0;
    list.retain(|_| {
        i += 1;
        places[i - 1] != u32::MAX
    });
}
