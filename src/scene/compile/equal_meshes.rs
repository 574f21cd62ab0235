//! Meshes that differ in nothing but their materials, as models have them: they share their list of faces, and so they can share what
//! is built of them.

use crate::scene::description::Mesh;
use std::collections::HashMap;
use std::sync::Arc;

/// The first of equal meshes among lists of one mesh alone.
#[derive(Debug, Default)]
pub(super) struct EqualMeshes<'a> {
    /// By where the faces are in memory, and whether the mesh has one side: the mesh, and the geometry that it has become.
    first: HashMap<(usize, bool), (&'a Mesh, usize)>,
}

impl<'a> EqualMeshes<'a> {
    /// Notes what a mesh has become.
    pub(super) fn note(&mut self, mesh: &'a Mesh, one_sided: bool, geometry: usize) {
        self.first.entry((place(mesh), one_sided)).or_insert((mesh, geometry));
    }

    /// The geometry that an equal mesh has become.
    pub(super) fn find(&self, mesh: &Mesh, one_sided: bool) -> Option<usize> {
        let (first, geometry) = self.first.get(&(place(mesh), one_sided))?;
        are_equal(first, mesh).then_some(*geometry)
    }
}

fn place(mesh: &Mesh) -> usize {
    mesh.faces.as_ptr() as usize
}

fn are_equal(a: &Mesh, b: &Mesh) -> bool {
    let has_corners = Arc::ptr_eq(&a.faces, &b.faces) && a.vertices == b.vertices && a.normals == b.normals;
    has_corners && a.uvs == b.uvs && a.uvs1 == b.uvs1 && a.tangents == b.tangents && a.colors == b.colors
}
