//! Triangles that a mesh lists one after the other mostly lie side by side. Large geometries are built of runs of such
//! triangles: a leaf tests sixteen at once, so little is gained by telling neighbours apart, and there are fewer to sort.

use super::bounds::Bounds;
use super::build::BvhKind;
use super::build_primitive::{Box4, BuildPrimitive};
use super::item::Mesh;
use crate::lanes::Real;
use rayon::prelude::*;
use std::ops::Range;

/// Geometries of fewer primitives are built of single ones: that takes little time, and their hierarchies are a little better.
const LARGE: usize = 32_768;
/// Triangles are a run while the surface of the box around them is at most this share of the sum of theirs. The two halves of a
/// rectangle are at 0.5.
const COMPACT: f64 = 0.8;
/// Triangles that one thread goes through at a time. No run goes on in the next ones.
const CHUNK: usize = 16_384;
/// Least number of chunks that are gone through before their runs are moved behind the others, so that the next ones can use their memory.
const AT_ONCE: usize = 16;

/// Most triangles in a run, where a geometry has as many primitives as this: those of a leaf.
pub(super) fn longest<R: Real>(primitives: usize, kind: BvhKind) -> u32 {
    if kind == BvhKind::Sah && primitives >= LARGE { R::LANES as u32 } else { 1 }
}

/// Adds the triangles of a mesh to what a hierarchy is built of, in runs of at most `longest`. Its face 0 has the
/// number `first`. Triangles that are but lines are left out. Returns the box around the others.
pub(super) fn push<R: Real>(build: &mut Vec<BuildPrimitive<R>>, mesh: &Mesh<R>, first: u32, longest: u32) -> Bounds {
    let faces = mesh.faces.len();
    let chunk = |start: usize| runs(mesh, first, start..faces.min(start + CHUNK), longest);
    let starts: Vec<usize> = (0..faces).step_by(CHUNK).collect();
    let mut bounds = Bounds::EMPTY;
    for some in starts.chunks(AT_ONCE.max(2 * rayon::current_num_threads())) {
        let chunks: Vec<_> = some.par_iter().copied().map(chunk).collect();
        for (runs, around) in chunks {
            build.extend(runs);
            bounds = bounds.union(around);
        }
    }
    bounds
}

/// The runs of some triangles, and the box around them.
fn runs<R: Real>(mesh: &Mesh<R>, first: u32, faces: Range<usize>, longest: u32) -> (Vec<BuildPrimitive<R>>, Bounds) {
    let mut runs = Vec::with_capacity(faces.len() / longest as usize + 1);
    let mut around = Bounds::EMPTY;
    let mut end = |run: &Run<R>| {
        let tight = run.tight.slab().widened();
        around = around.union(tight);
        runs.push(BuildPrimitive::new(&tight.narrowed(), run.first, run.count));
    };
    let mut open: Option<Run<R>> = None;
    for face in faces {
        if mesh.is_collapsed(face) {
            open.take().iter().for_each(&mut end);
            continue;
        }
        let alone = Run::alone(Box4::around(mesh.corners(face)), first + face as u32);
        open = Some(match open {
            None => alone,
            Some(run) => run.with(&alone, longest).unwrap_or_else(|| {
                end(&run);
                alone
            }),
        });
    }
    open.iter().for_each(&mut end);
    (runs, around)
}

/// Triangles one after the other.
#[derive(Debug, Clone, Copy)]
struct Run<R> {
    /// The box around their corners.
    tight: Box4<R>,
    /// The sum of half the surface areas of their boxes.
    areas: f64,
    first: u32,
    count: u32,
}

impl<R: Real> Run<R> {
    fn alone(tight: Box4<R>, first: u32) -> Self {
        Self { tight, areas: tight.slab().half_area(), first, count: 1 }
    }

    /// With the next triangle, if they are compact together.
    fn with(&self, next: &Self, longest: u32) -> Option<Self> {
        if self.count >= longest {
            return None;
        }
        let together = Self {
            tight: self.tight.union(next.tight),
            areas: self.areas + next.areas,
            count: self.count + next.count,
            ..*self
        };
        (together.tight.slab().half_area() <= COMPACT * together.areas).then_some(together)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Triangles with a corner at each of these places along x, of sides of 1.
    fn mesh(places: impl Iterator<Item = f32>) -> Mesh<f32> {
        let vertices: Vec<[f32; 3]> =
            places.flat_map(|x| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.5]]).collect();
        let faces = (0..vertices.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let (faces, normals, uvs) = (Arc::new(faces), Vec::new(), Vec::new());
        Mesh { vertices, faces, normals, uvs, attributes: None }
    }

    fn counts(mesh: &Mesh<f32>, kind: BvhKind) -> Vec<u32> {
        let mut build = Vec::new();
        let bounds = push(&mut build, mesh, 7, longest::<f32>(mesh.faces.len(), kind));
        let all = (0..mesh.faces.len()).map(|face| Bounds::around(mesh.points(face)));
        assert_eq!(bounds, all.fold(Bounds::EMPTY, Bounds::union));
        let places = build.iter().flat_map(BuildPrimitive::indices);
        assert!(places.eq(7..7 + mesh.faces.len()), "each triangle once, in the order of the mesh");
        build.iter().map(BuildPrimitive::count).collect()
    }

    #[test]
    fn neighbours_are_together_and_others_are_not() {
        let near = mesh((0..LARGE).map(|i| (i / 2) as f32));
        assert!(counts(&near, BvhKind::Sah).iter().all(|&count| count == f32::LANES as u32));
        let far = mesh((0..LARGE).map(|i| (i * 7919 % LARGE) as f32));
        assert!(counts(&far, BvhKind::Sah).iter().all(|&count| count == 1));
        let pairs = mesh((0..LARGE + 1).map(|i| (i / 2 * 3) as f32));
        assert!(counts(&pairs, BvhKind::Sah)[..LARGE / 2].iter().all(|&count| count == 2));
    }

    #[test]
    fn triangles_that_are_but_lines_are_left_out() {
        let mut mesh = mesh((0..LARGE).map(|i| (i / 2) as f32));
        let faces = Arc::make_mut(&mut mesh.faces);
        // Two corners in one place, by their index and by their coordinates.
        faces[10] = [30, 31, 30];
        mesh.vertices[3 * 20 + 1] = mesh.vertices[3 * 20];
        let mut build = Vec::new();
        push(&mut build, &mesh, 0, longest::<f32>(mesh.faces.len(), BvhKind::Sah));
        let places = build.iter().flat_map(BuildPrimitive::indices);
        assert!(places.eq((0..LARGE).filter(|i| ![10, 20].contains(i))));
    }

    #[test]
    fn small_meshes_and_other_hierarchies_have_single_triangles() {
        let small = mesh((0..LARGE - 1).map(|i| (i / 2) as f32));
        assert!(counts(&small, BvhKind::Sah).iter().all(|&count| count == 1));
        let large = mesh((0..LARGE).map(|i| (i / 2) as f32));
        assert!(counts(&large, BvhKind::Median).iter().all(|&count| count == 1));
    }
}
