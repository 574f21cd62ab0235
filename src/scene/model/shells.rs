//! Shells of glass. A body is one medium: a ray that has entered it by two shells would leave it with the first of them. So closed
//! surfaces of one mesh that overlap, touch or lie in one another are bodies of their own, as the parts of a thing are that was
//! joined for export.

use crate::control;
use crate::models::{Geometry, Model, Placement};
use glam::DVec3;
use hashbrown::HashMap;
use std::collections::HashSet;

/// Shells of a mesh that are compared with each other. More stay one body.
const SHELLS: usize = 1_000;
/// Bodies that shells become in all places together. More stay as they are.
const BODIES: usize = 1 << 16;
/// Boxes that are apart by less of their size may touch.
const NEAR: f64 = 1e-6;

/// Gives shells that are not apart a placement each, where a material bends light. `open` are materials that do not. Whether all of
/// them have one.
pub(super) fn set_apart(model: &mut Model, open: &HashSet<usize>) -> bool {
    // The parts of each geometry, as others; none if they are too many.
    let mut parts: HashMap<usize, Option<Vec<usize>>> = HashMap::new();
    let (mut left, mut all) = (BODIES, true);
    let mut placements = Vec::with_capacity(model.placements.len());
    for placement in std::mem::take(&mut model.placements) {
        let bends = |index: &usize| !open.contains(index) && model.materials[*index].bends_light();
        if !placement.material.as_ref().is_some_and(bends) {
            placements.push(placement);
            continue;
        }
        let whole = placement.geometry;
        let parts = parts.entry(whole).or_insert_with(|| {
            let geometry = &model.geometries[whole];
            let divided: Vec<Geometry> = division(geometry)?.iter().map(|part| geometry.part(part)).collect();
            let first = model.geometries.len();
            model.geometries.extend(divided);
            Some((first..model.geometries.len()).collect())
        });
        let bodies = parts.as_ref().map(|parts| parts.len() * placement.transforms.len());
        match (parts, bodies.and_then(|bodies| left.checked_sub(bodies))) {
            (Some(parts), Some(rest)) if !parts.is_empty() => {
                left = rest;
                placements.extend(parts.iter().map(|part| Placement { geometry: *part, ..placement.clone() }));
            }
            (_, rest) => {
                all &= rest.is_some();
                placements.push(placement);
            }
        }
    }
    model.placements = placements;
    all
}

/// A closed surface, with the hollows in it.
struct Shell {
    triangles: Vec<[u32; 3]>,
    low: DVec3,
    high: DVec3,
    /// Six times the volume, negative if fronts are inside.
    volume: f64,
}

impl Shell {
    fn is_near(&self, other: &Self) -> bool {
        let slack = DVec3::splat(NEAR * (self.high - self.low).max(other.high - other.low).max_element());
        (self.low - slack).cmple(other.high).all() && (other.low - slack).cmple(self.high).all()
    }

    fn holds(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && other.high.cmple(self.high).all()
    }
}

/// The triangles of each part: shells that may meet another one, and the rest. Empty if there is nothing to divide, or no telling;
/// none if there are too many shells.
fn division(geometry: &Geometry) -> Option<Vec<Vec<[u32; 3]>>> {
    let shells = shells(geometry)?;
    // Hollows have their fronts the other way around than what they are in.
    let all: f64 = shells.iter().map(|shell| shell.volume).sum();
    let (mut bodies, hollows): (Vec<Shell>, Vec<Shell>) = shells.into_iter().partition(|it| it.volume * all > 0.0);
    for hollow in hollows {
        let around = bodies.iter_mut().filter(|body| body.holds(&hollow));
        let smallest = around.min_by(|a, b| a.volume.abs().total_cmp(&b.volume.abs()));
        let Some(body) = smallest else { return Some(Vec::new()) };
        body.triangles.extend(hollow.triangles);
    }
    let meets = |i: usize| (0..bodies.len()).any(|k| k != i && bodies[i].is_near(&bodies[k]));
    let (near, apart): (Vec<usize>, Vec<usize>) = (0..bodies.len()).partition(|i| meets(*i));
    if near.is_empty() {
        return Some(Vec::new());
    }
    let rest: Vec<[u32; 3]> = apart.iter().flat_map(|i| bodies[*i].triangles.iter().copied()).collect();
    let mut parts: Vec<_> = near.into_iter().map(|i| std::mem::take(&mut bodies[i].triangles)).collect();
    parts.extend((!rest.is_empty()).then_some(rest));
    Some(parts)
}

/// The connected surfaces of a geometry in the order of their first triangles; none if there are too many.
fn shells(geometry: &Geometry) -> Option<Vec<Shell>> {
    // Vertices at one position are one. Adding 0 turns -0 into 0.
    let mut numbers = HashMap::with_capacity(geometry.positions.len());
    let points: Vec<usize> = geometry
        .positions
        .iter()
        .map(|position| {
            let next = numbers.len();
            *numbers.entry(position.map(|x| (x + 0.0).to_bits())).or_insert(next)
        })
        .collect();
    let mut above: Vec<usize> = (0..numbers.len()).collect();
    for triangle in &geometry.triangles {
        if control::step(1) {
            return Some(Vec::new());
        }
        let [a, b, c] = triangle.map(|i| points[i as usize]);
        for other in [b, c] {
            let (one, other) = (top(&mut above, a), top(&mut above, other));
            above[one.max(other)] = one.min(other);
        }
    }
    let mut places = HashMap::new();
    let mut shells: Vec<Shell> = Vec::new();
    for triangle in &geometry.triangles {
        let place = *places.entry(top(&mut above, points[triangle[0] as usize])).or_insert(shells.len());
        if place == SHELLS {
            return None;
        }
        let corners = triangle.map(|i| DVec3::from_array(geometry.positions[i as usize]));
        if place == shells.len() {
            shells.push(Shell { triangles: Vec::new(), low: corners[0], high: corners[0], volume: 0.0 });
        }
        let shell = &mut shells[place];
        // From a corner of the shell, so that volumes far from the origin keep their digits.
        let from = shell
            .triangles
            .first()
            .map_or(corners[0], |first| DVec3::from_array(geometry.positions[first[0] as usize]));
        let [a, b, c] = corners.map(|corner| corner - from);
        shell.volume += a.cross(b).dot(c);
        for corner in corners {
            (shell.low, shell.high) = (shell.low.min(corner), shell.high.max(corner));
        }
        shell.triangles.push(*triangle);
    }
    Some(shells)
}

/// The first of the points that one is connected with. Ways there are halved as they are walked.
fn top(above: &mut [usize], mut point: usize) -> usize {
    while above[point] != point {
        above[point] = above[above[point]];
        point = above[point];
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{Channel, ModelMaterial};
    use glam::DMat4;

    /// Boxes in one mesh, each with twelve triangles; those of a negative size are hollows.
    fn boxes(all: &[([f64; 3], f64)]) -> Geometry {
        let mut geometry = Geometry::default();
        for (low, size) in all {
            let first = geometry.positions.len() as u32;
            let corner = |i: u32| [0, 1, 2].map(|k| low[k] + f64::from(i >> k & 1) * size.abs());
            geometry.positions.extend((0..8).map(corner));
            let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
            for [a, b, c, d] in quads.map(|quad| quad.map(|i| first + i)) {
                let (b, d) = if *size < 0.0 { (d, b) } else { (b, d) };
                geometry.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        geometry
    }

    fn sizes(all: &[([f64; 3], f64)]) -> Vec<usize> {
        division(&boxes(all)).unwrap().iter().map(|part| part.len() / 12).collect()
    }

    #[test]
    fn what_may_meet_is_divided() {
        let one = ([0.0; 3], 1.0);
        for other in
            [([0.9, 0.2, 0.3], 1.0), ([1.0, 0.25, 0.25], 0.5), ([1.0 + 1e-9, 0.25, 0.25], 0.5), ([0.25; 3], 0.5)]
        {
            assert_eq!(sizes(&[one, other]), [1, 1], "{other:?}");
        }
        assert_eq!(sizes(&[one, ([5.0; 3], 1.0), ([0.5; 3], 1.0), ([9.0; 3], 1.0)]), [1, 1, 2]);
    }

    #[test]
    fn what_is_apart_or_hollow_stays_one_body() {
        let one = ([0.0; 3], 1.0);
        assert!(sizes(&[one]).is_empty() && sizes(&[one, ([1.001, 0.0, 0.0], 1.0)]).is_empty());
        assert!(sizes(&[one, ([0.25; 3], -0.5)]).is_empty());
        // A hollow goes with the smaller body around it. Where it belongs to none, nothing is known.
        assert_eq!(sizes(&[([-1.0; 3], 3.0), one, ([0.25; 3], -0.5)]), [1, 2]);
        assert!(sizes(&[one, ([0.5; 3], 1.0), ([3.0; 3], -0.5)]).is_empty());
        // The fronts of all of it may be inside.
        assert_eq!(sizes(&[([0.0; 3], -1.0), ([0.5; 3], -1.0)]), [1, 1]);
        let many: Vec<_> = (0..=SHELLS).map(|i| ([0.3 * i as f64, 0.0, 0.0], 1.0)).collect();
        assert!(division(&boxes(&many)).is_none() && sizes(&many[1..]).len() == SHELLS);
    }

    #[test]
    fn bodies_are_counted_in_all_places() {
        let glass = ModelMaterial { transmission: Channel::of(1.0), thickness: 1.0, ..ModelMaterial::new() };
        let count = |boxes_of_one: usize, places: usize| {
            let all: Vec<_> = (0..boxes_of_one).map(|i| ([0.3 * i as f64, 0.0, 0.0], 1.0)).collect();
            let transforms = vec![DMat4::IDENTITY; places];
            let placement = Placement { geometry: 0, material: Some(0), name: None, transforms };
            let mut model = Model {
                geometries: vec![boxes(&all)],
                materials: vec![glass.clone()],
                placements: vec![placement],
                ..Model::default()
            };
            (set_apart(&mut model, &HashSet::new()), model.placements.len())
        };
        assert_eq!(count(2, 1), (true, 2));
        assert_eq!(count(2, BODIES / 2), (true, 2));
        assert_eq!(count(2, BODIES / 2 + 1), (false, 1));
        assert_eq!(count(SHELLS + 1, 1), (false, 1));
        assert_eq!(count(1, BODIES + 1), (true, 1));
    }
}
