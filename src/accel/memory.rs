//! How much memory a geometry takes.

use super::geometry::{Geometry, Item, Mesh, Primitive, Shape};
use super::wide::WideNode;
use crate::shape::{Frustum, Torus};
use std::mem::size_of;

impl<R> Geometry<R> {
    /// Bytes of its items, of what they hold, and of its hierarchy; almost exact.
    pub fn bytes(&self) -> usize {
        let of_items: usize = self.items.iter().map(|item| size_of::<Item<R>>() + boxed(&item.shape)).sum();
        let wide = self.wide.as_ref().map_or(0, |wide| {
            let columns: usize = wide.columns.iter().map(|column| size_of_val(&column[..])).sum();
            wide.nodes.len() * size_of::<WideNode<R>>() + size_of_val(&wide.leaves[..]) + columns
        });
        let lists = size_of_val(&self.unbounded[..]) + self.primitives.len() * size_of::<Primitive>();
        size_of::<Self>() + of_items + lists + wide
    }
}

/// What a shape holds beside itself.
fn boxed<R>(shape: &Shape<R>) -> usize {
    match shape {
        Shape::Mesh(Mesh { vertices, faces, normals, uvs }) => {
            size_of_val(&vertices[..]) + size_of_val(&faces[..]) + size_of_val(&normals[..]) + size_of_val(&uvs[..])
        }
        Shape::Frustum(_) => size_of::<Frustum<R>>(),
        Shape::Torus(_) => size_of::<Torus<R>>(),
        Shape::Instance(instance) => size_of_val(&**instance),
        Shape::Sphere(_) | Shape::Plane(_) | Shape::Disc(_) | Shape::Cuboid(_) => 0,
    }
}
