//! The hits of a packet: surfaces, bodies and coefficients for shading.

use super::coincident;
use crate::accel::{Coherence, Nearest, Owner, Spheres, Surface, nearest_hit, resolve};
use crate::lanes::{Ids, Lanes, Mask, Real, V3, lanes_of};
use crate::ray::{Hit, Rays};
use crate::scene::world::World;
use crate::shading::material::{Coefficients, Material, look_up};
use crate::shading::media::Medium;
use glam::DVec3;

/// Most surfaces that a walk along a straight line crosses.
pub(super) const MAX_CROSSINGS: usize = 1000;

/// Most surfaces through an eye that it looks behind.
const MAX_AT_EYE: usize = 64;

/// The nearest surface of each ray. Lanes that hit nothing hold anything.
#[derive(Debug, Clone)]
pub(crate) struct Hits<L: Lanes> {
    /// Lanes that hit anything.
    pub found: u32,
    /// Ray parameter.
    pub t: L,
    /// Point, normals and local coordinates.
    pub surface: Surface<L>,
    /// Geometric normal, turned to the side the ray comes from.
    pub ng: V3<L>,
    /// Shading normal, turned to the side the ray comes from.
    pub ns: V3<L>,
    /// Lanes whose ray goes into the body's material.
    pub entering: u32,
    /// Expanded index of the primitive.
    pub expanded: L::Ids,
    /// Identity of the placed body: the expanded index of its first primitive.
    pub body: L::Ids,
    /// Index of the body's material.
    pub material: L::Ids,
    /// Lanes whose body encloses a region.
    pub closed: u32,
    /// Lanes whose body is hollow.
    pub hollow: u32,
    /// Lanes whose body transmits light in some channel.
    pub transmissive: u32,
    /// Lanes whose facet approximates a curved surface.
    pub smooth: u32,
    /// Lanes whose body might touch another.
    pub may_touch: u32,
    /// Other bodies whose surface is at the same place within rounding; they are crossed together with this one.
    pub touching: Vec<Touch<L::Real>>,
    /// When the rays are cast, if anything moves: from 0, when the shutter opens, to 1.
    pub time: Option<L>,
}

/// Another body that a ray enters or leaves at the same place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touch<R> {
    /// The lane.
    pub lane: usize,
    /// Whether light goes into the region the body encloses.
    pub goes_in: bool,
    /// The medium of that region.
    pub medium: Medium<R>,
}

impl<L: Lanes> Hits<L> {
    /// No ray has hit anything.
    #[inline(always)]
    pub(crate) fn none(s: L::Simd) -> Self {
        let zero = L::lit(s, 0.0);
        let nothing = V3 { x: zero, y: zero, z: zero };
        let nobody = L::Ids::splat(s, 0);
        Self {
            found: 0,
            t: zero,
            surface: Surface {
                point: nothing,
                inwards: nothing,
                error: nothing,
                ng: nothing,
                ns: nothing,
                lift: nothing,
                local: nothing,
                hit: L::mask(s, 0),
            },
            ng: nothing,
            ns: nothing,
            entering: 0,
            expanded: nobody,
            body: nobody,
            material: nobody,
            closed: 0,
            hollow: 0,
            transmissive: 0,
            smooth: 0,
            may_touch: 0,
            touching: Vec::new(),
            time: None,
        }
    }

    /// Finds the nearest surface of each ray, and the surfaces that touch it. Hits are overwritten in place, and traversal
    /// changes the rays temporarily, since copies of both are expensive.
    #[inline(always)]
    pub(crate) fn find(&mut self, s: L::Simd, world: &World<L::Real>, rays: &mut Rays<L>, coherence: Coherence) {
        self.find_nearest(s, world, rays, &Nearest::none(s), coherence);
        if self.may_touch & self.transmissive != 0 {
            coincident::find(s, world, rays, self);
        }
    }

    /// Looks behind triangles and frustums that the rays of an eye start on: what is exactly there has t = 0, which is no hit, but
    /// rounding may make a little more of it. Rays with a `t_min` are taken at their word.
    #[inline(always)]
    pub(crate) fn leave_eye(&mut self, s: L::Simd, world: &World<L::Real>, rays: &Rays<L>, coherence: Coherence) {
        let near = self.near_origin(s, rays) & rays.t_min.le(L::lit(s, 0.0)).bits();
        if near != 0 {
            self.leave(s, world, rays, coherence, near);
        }
    }

    /// The lanes whose rays may start on the plane of what they hit: |n (o - p)| is at most 4 u |n| (|o| + |p|), component by component.
    #[inline(always)]
    fn near_origin(&self, s: L::Simd, rays: &Rays<L>) -> u32 {
        let height = self.ng.dot(rays.origin - self.surface.point).abs();
        let size = self.ng.abs().dot(rays.origin.abs() + self.surface.point.abs());
        height.le(size * L::lit(s, 4.0 * L::Real::ROUNDOFF)).bits() & self.found
    }

    #[inline(never)]
    fn leave(&mut self, s: L::Simd, world: &World<L::Real>, rays: &Rays<L>, coherence: Coherence, mut near: u32) {
        let mut rays = Rays { ..*rays };
        for _ in 0..MAX_AT_EYE {
            let starts_on = |lane: &usize| {
                let [origin, dir] = [rays.origin, rays.dir].map(|v| DVec3::from_array(v.lane(*lane).map(Real::to_f64)));
                let (expanded, t) = (self.expanded.lane(*lane), self.t.lane(*lane).to_f64());
                world.owner(expanded).touches(expanded, origin, dir, t)
            };
            let lanes = lanes_of(near).filter(starts_on).fold(0, |lanes, lane| lanes | 1 << lane);
            if lanes == 0 {
                return;
            }
            L::vectorize(
                s,
                #[inline(always)]
                || {
                    rays.t_min = L::select(L::mask(s, lanes), self.t, rays.t_min);
                    self.find(s, world, &mut rays, coherence);
                    near = self.near_origin(s, &rays);
                },
            );
        }
    }

    /// Finds the nearest surface of each ray. Both steps are functions; a third one around them would take 3 % of the time of
    /// simple scenes.
    #[inline(always)]
    pub(super) fn find_nearest(
        &mut self,
        s: L::Simd,
        world: &World<L::Real>,
        rays: &mut Rays<L>,
        nearest: &Nearest<'_, L>,
        coherence: Coherence,
    ) {
        let mut nearest = *nearest;
        let t_max = rays.t_max;
        nearest_hit(s, &world.geometries, world.root, rays, &mut nearest, coherence, self.time.as_ref());
        self.forget(u32::MAX);
        self.touching.clear();
        self.found = nearest.found;
        self.t = std::mem::replace(&mut rays.t_max, t_max);
        self.expanded = nearest.expanded;
        if self.found != 0 {
            let lanes = L::mask(s, self.found);
            let hit = Hit { t: self.t, lanes, weights: nearest.weights };
            self.resolve(s, world, rays, self.found, Some(&hit));
        }
    }

    /// Clears the flags of the bodies that some lanes have hit.
    pub(super) fn forget(&mut self, lanes: u32) {
        for flags in [&mut self.closed, &mut self.hollow, &mut self.transmissive, &mut self.smooth, &mut self.may_touch]
        {
            *flags &= !lanes;
        }
    }

    /// Fills in everything about the primitives `expanded` that some lanes have hit. `known` are the hits, if
    /// traversal has found them.
    pub(super) fn resolve(
        &mut self,
        s: L::Simd,
        world: &World<L::Real>,
        rays: &Rays<L>,
        lanes: u32,
        known: Option<&Hit<L>>,
    ) {
        L::vectorize(
            s,
            #[inline(always)]
            || self.resolve_in(s, world, rays, lanes, known),
        );
    }

    #[inline(always)]
    fn resolve_in(&mut self, s: L::Simd, world: &World<L::Real>, rays: &Rays<L>, lanes: u32, known: Option<&Hit<L>>) {
        let mut spheres = Spheres::none();
        let mut left = lanes;
        while left != 0 {
            let owner = world.owner(self.expanded.lane(left.trailing_zeros() as usize));
            let same = owner.lanes::<L>(s, self.expanded, left);
            left &= !same;
            self.take(s, &owner, same);
            // Hits on different spheres are resolved together.
            if same != lanes && spheres.take(&owner, same) {
                continue;
            }
            self.put(s, same, resolve(s, &owner, self.expanded, same, rays, known, self.time.as_ref()));
        }
        if spheres.lanes != 0 {
            self.put(s, spheres.lanes, spheres.resolve(s, rays, known));
        }
        let against = rays.dir.dot(self.surface.ng).lt(L::lit(s, 0.0));
        self.entering = against.bits() & self.found;
        self.ng = V3::select(against, self.surface.ng, -self.surface.ng);
        self.ns = V3::select(against, self.surface.ns, -self.surface.ns);
    }

    /// Stores the surface that some lanes have hit. In most packets all have hit the same one.
    #[inline(always)]
    fn put(&mut self, s: L::Simd, lanes: u32, surface: Surface<L>) {
        self.surface =
            if lanes == self.found { surface } else { Surface::select(L::mask(s, lanes), surface, self.surface) };
    }

    /// Stores the body that some lanes have hit.
    #[inline(always)]
    fn take(&mut self, s: L::Simd, owner: &Owner<'_, L::Real>, lanes: u32) {
        let (mask, item) = (L::mask(s, lanes), owner.item);
        let put = |new: u64, old: L::Ids| L::Ids::select(mask, L::Ids::splat(s, new), old);
        self.body = put(owner.body, self.body);
        self.material = put(u64::from(item.material), self.material);
        self.closed |= if item.closed { lanes } else { 0 };
        self.hollow |= if item.hollow { lanes } else { 0 };
        self.transmissive |= if item.lets_light_through() { lanes } else { 0 };
        self.smooth |= if item.is_smooth() { lanes } else { 0 };
        self.may_touch |= if item.may_touch { lanes } else { 0 };
    }

    /// The coefficients of the materials hit. Checkers are averaged over `extents` around the hits.
    #[inline(always)]
    pub(crate) fn coefficients(
        &self,
        s: L::Simd,
        world: &World<L::Real>,
        extents: Option<&dyn Fn() -> V3<L>>,
    ) -> Coefficients<L> {
        Coefficients::look_up(s, &world.materials, self.material, self.found, self.surface.local, extents)
    }

    /// The radiance that the surfaces emit.
    #[inline(always)]
    pub(crate) fn emission(&self, s: L::Simd, world: &World<L::Real>) -> V3<L> {
        look_up(s, &world.materials, self.material, self.found, |material| material.emission)
    }

    /// A lane's material.
    fn material_of<'w>(&self, world: &'w World<L::Real>, lane: usize) -> &'w Material<L::Real> {
        &world.materials[self.material.lane(lane) as usize]
    }

    /// The medium inside a lane's closed body: its material, or empty space in a cavity.
    pub(crate) fn medium(&self, world: &World<L::Real>, lane: usize) -> Medium<L::Real> {
        let hollow = self.hollow & (1 << lane) != 0;
        let material = self.material_of(world, lane);
        let (ior, dispersion) =
            if hollow { (L::Real::from_f64(1.0), L::Real::from_f64(0.0)) } else { (material.ior, material.dispersion) };
        Medium { body: self.body.lane(lane), volume: world.owner(self.expanded.lane(lane)).volume(), ior, dispersion }
    }

    /// Whether light fades inside of a lane's closed body.
    pub(super) fn absorbs(&self, world: &World<L::Real>, lane: usize) -> bool {
        let filled = self.closed & !self.hollow & (1 << lane) != 0;
        filled && self.material_of(world, lane).absorption.iter().any(|c| *c > L::Real::from_f64(0.0))
    }

    /// Whether a lane's ray goes into the region that its body encloses. For a cavity that is the way out of the material.
    pub(crate) fn goes_in(&self, lane: usize) -> bool {
        (self.entering ^ self.hollow) & (1 << lane) != 0
    }

    /// The lanes of `among` whose surface is invisible between equal media.
    #[inline(never)]
    pub(crate) fn perfectly_clear(&self, world: &World<L::Real>, among: u32) -> u32 {
        let clear = lanes_of(among).filter(|&lane| self.material_of(world, lane).is_perfectly_clear());
        clear.fold(0, |lanes, lane| lanes | 1 << lane)
    }
}
