//! The body that a primitive belongs to.

use super::geometry::Geometry;
use super::item::{Instance, Item, Shape};
use crate::lanes::{Double, Ids, Lanes, Mask, Real, V3};
use glam::DVec3;
use smallvec::SmallVec;

/// The body that a primitive belongs to, and its path in the expanded scene.
#[derive(Debug)]
pub struct Owner<'a, R> {
    /// The item.
    pub item: &'a Item<R>,
    /// Expanded index of its first primitive, which identifies the placed body.
    pub body: u64,
    /// The placed geometries around it, outermost first.
    pub instances: SmallVec<[&'a Item<R>; 4]>,
}

impl<'a, R: Real> Owner<'a, R> {
    /// Finds the owner of an expanded index.
    #[inline(always)]
    pub fn find(geometries: &'a [Geometry<R>], root: usize, expanded: u64) -> Self {
        let item = geometries[root].owner(expanded);
        match &item.shape {
            Shape::Instance(_) => Self::find_placed(geometries, root, expanded),
            _ => Self { item, body: item.offset, instances: SmallVec::new() },
        }
    }

    fn find_placed(geometries: &'a [Geometry<R>], root: usize, expanded: u64) -> Self {
        let mut geometry = &geometries[root];
        let mut base = 0;
        let mut instances = SmallVec::new();
        loop {
            let item = geometry.owner(expanded - base);
            base += item.offset;
            match &item.shape {
                Shape::Instance(instance) => {
                    instances.push(item);
                    geometry = &geometries[instance.geometry as usize];
                }
                _ => return Self { item, body: base, instances },
            }
        }
    }

    /// Volume of the placed body.
    pub fn volume(&self) -> f64 {
        let scale = |item: &&Item<R>| match &item.shape {
            Shape::Instance(instance) => instance.to_world.volume_scale(),
            _ => 1.0,
        };
        self.item.volume * self.instances.iter().map(scale).product::<f64>()
    }

    /// The lanes of `among` that have hit this body.
    #[inline(always)]
    pub fn lanes<L: Lanes<Real = R>>(&self, s: L::Simd, expanded: L::Ids, among: u32) -> u32 {
        let first = L::Ids::splat(s, self.body);
        let own = if self.item.expanded == 1 {
            expanded.eq(first)
        } else {
            expanded.ge(first) & !expanded.ge(L::Ids::splat(s, self.body + self.item.expanded))
        };
        own.bits() & among
    }
}

impl<R: Real> Owner<'_, R> {
    /// The placements around the body, outermost first.
    fn placements(&self) -> impl DoubleEndedIterator<Item = &Instance<R>> {
        self.instances.iter().filter_map(|item| match &item.shape {
            Shape::Instance(instance) => Some(&**instance),
            _ => None,
        })
    }

    /// A point of the scene in the body's own coordinates; none if it moves.
    pub(super) fn point_into_object(&self, p: DVec3) -> Option<DVec3> {
        let inside = |p: DVec3, placed: &Instance<R>| {
            let translation = DVec3::from_array(placed.to_local.translation.map(Real::to_f64));
            placed.motion.is_none().then(|| placed.to_local.matrix() * p + translation)
        };
        self.placements().try_fold(p, inside)
    }

    /// A direction of the scene in the body's own coordinates, of what moves at its start.
    pub fn direction_into_object(&self, d: DVec3) -> DVec3 {
        self.placements().fold(d, |d, placed| placed.to_local.matrix() * d)
    }

    /// Directions of the scene in the body's own coordinates, at each lane's time if bodies move.
    #[inline(always)]
    pub fn directions_into_object<W: Double>(&self, s: W::Simd, d: V3<W>, time: Option<W>) -> V3<W> {
        let mut turned = d;
        for placed in self.placements() {
            turned = back(s, placed, turned, time).turned(s, placed.to_local.matrix().to_cols_array_2d());
        }
        turned
    }

    /// Directions of the body's own coordinates in those of the scene, at each lane's time if bodies move.
    #[inline(always)]
    pub fn directions_out_of_object<W: Double>(&self, s: W::Simd, d: V3<W>, time: Option<W>) -> V3<W> {
        let mut turned = d;
        for placed in self.placements().rev() {
            turned = forth(s, placed, turned.turned(s, placed.to_world.matrix().to_cols_array_2d()), time);
        }
        turned
    }

    /// Normals of the scene in the body's own coordinates, unit again, at each lane's time if bodies move.
    #[inline(always)]
    pub fn normals_into_object<W: Double>(&self, s: W::Simd, n: V3<W>, time: Option<W>) -> V3<W> {
        let mut turned = n;
        for placed in self.placements() {
            let columns = placed.to_world.matrix().transpose().to_cols_array_2d();
            turned = back(s, placed, turned, time).turned(s, columns).normalized(s);
        }
        turned
    }

    /// Unit normals of the body's own coordinates in those of the scene, unit again, at each lane's time if bodies move.
    #[inline(always)]
    pub fn normals_out_of_object<W: Double>(&self, s: W::Simd, n: V3<W>, time: Option<W>) -> V3<W> {
        let mut turned = n;
        for placed in self.placements().rev() {
            let columns = placed.to_local.matrix().transpose().to_cols_array_2d();
            turned = forth(s, placed, turned.turned(s, columns).normalized(s), time);
        }
        turned
    }
}

/// Directions around a placed body that moves, as they were at time 0.
#[inline(always)]
fn back<R: Real, W: Double>(s: W::Simd, placed: &Instance<R>, d: V3<W>, time: Option<W>) -> V3<W> {
    match (&placed.motion, time) {
        (Some(motion), Some(time)) => motion.directions_back(s, d, time),
        _ => d,
    }
}

/// Directions around a placed body at time 0, as they are at each lane's time.
#[inline(always)]
fn forth<R: Real, W: Double>(s: W::Simd, placed: &Instance<R>, d: V3<W>, time: Option<W>) -> V3<W> {
    match (&placed.motion, time) {
        (Some(motion), Some(time)) => motion.directions_forth(s, d, time),
        _ => d,
    }
}
