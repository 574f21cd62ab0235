//! What is built already of a scene: the bodies and hierarchies of another one with the same objects. Its camera, lights and
//! materials may differ.
//!
//! Everything else is built as for any scene, so a variation cannot differ from the scene that it is a variation of
//! (`tests/renderer/scene/variations.rs`).

use super::{Precise, Scene};
use crate::accel::{Geometry, Item, Shape};
use crate::lanes::Real;
use crate::scene::description::{Description, Precision};
use crate::scene::world::World;
use std::sync::Arc;

/// A scene that was built, and what it was built from.
#[derive(Debug, Clone, Copy)]
pub struct Original<'a> {
    /// What it was built from, without options.
    pub description: &'a Description,
    /// The scene.
    pub scene: &'a Scene,
}

impl<'a> Original<'a> {
    /// Whether a description has the same objects, by sharing them as they are built.
    pub fn has_objects_of(&self, other: &Description) -> bool {
        let (own, other) = (self.description.built(), other.built());
        Arc::ptr_eq(own.0, other.0) && Arc::ptr_eq(own.1, other.1)
    }

    /// Whether the same objects have the same materials, too.
    pub(in crate::scene) fn has_bodies_of(&self, other: &Description) -> bool {
        self.has_objects_of(other) && self.description.materials == other.materials
    }

    pub(super) fn single(&self, precision: Precision) -> Option<&'a World<f32>> {
        match &self.scene.world {
            Precise::Single(world) if precision == Precision::Single => Some(world),
            _ => None,
        }
    }

    pub(super) fn double(&self, precision: Precision) -> Option<&'a World<f64>> {
        match &self.scene.world {
            Precise::Double(world) if precision == Precision::Double => Some(world),
            _ => None,
        }
    }
}

/// The geometries of a world.
pub(super) struct Known<'a, R> {
    geometries: &'a Arc<[Geometry<R>]>,
    /// The items by their sources, which are numbered in the order of the objects.
    items: Vec<Option<&'a Item<R>>>,
}

impl<'a, R: Real> Known<'a, R> {
    pub(super) fn new(world: &'a World<R>) -> Self {
        let all = || world.geometries.iter().flat_map(|geometry| &geometry.items);
        let count = all().map(|item| item.source as usize + 1).max().unwrap_or(0);
        let mut items = vec![None; count];
        all().for_each(|item| items[item.source as usize] = Some(item));
        Self { geometries: &world.geometries, items }
    }

    /// The item that an object became.
    pub(super) fn item(&self, source: u32) -> Option<&'a Item<R>> {
        self.items.get(source as usize).copied().flatten()
    }

    /// Marks the items that might touch others.
    pub(super) fn mark(&self, items: &mut [Item<R>]) {
        for item in items {
            item.may_touch = self.item(item.source).is_some_and(|known| known.may_touch);
        }
    }

    /// The geometry of some items that is built as the n-th.
    pub(super) fn geometry(&self, n: usize, items: Vec<Item<R>>) -> Result<Geometry<R>, Vec<Item<R>>> {
        match self.geometries.get(n) {
            Some(known) => known.with_items(items),
            None => Err(items),
        }
    }

    /// All geometries: those that are known, if every item is.
    pub(super) fn share(&self, built: Vec<Geometry<R>>) -> Arc<[Geometry<R>]> {
        let looks_alike = |(a, b): (&Item<R>, &Item<R>)| {
            let is_same_mesh = match (&a.shape, &b.shape) {
                (Shape::Mesh(a), Shape::Mesh(b)) => Arc::ptr_eq(a, b),
                _ => true,
            };
            let is_alike = a.sides == b.sides && a.closed == b.closed && a.has_holes == b.has_holes;
            is_same_mesh && is_alike && a.material == b.material && a.transmission == b.transmission
        };
        let is_known = |(built, known): (&Geometry<R>, &Geometry<R>)| {
            built.has_hierarchy_of(known) && built.items.iter().zip(&known.items).all(looks_alike)
        };
        let all_known = built.len() == self.geometries.len() && built.iter().zip(self.geometries.iter()).all(is_known);
        if all_known { Arc::clone(self.geometries) } else { built.into() }
    }
}
