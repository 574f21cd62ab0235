//! What the rays of a packet hit: surfaces, bodies and coefficients, gathered for shading.

use super::touching;
use crate::accel::{Course, Nearest, Surface, nearest_hit, resolve};
use crate::lanes::{Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::ray::Rays;
use crate::scene::world::World;
use crate::shading::material::Coefficients;
use crate::shading::media::{Media, Medium, MediumList};

/// The nearest surface under each ray.
#[derive(Debug, Clone)]
pub struct Hits<L: Lanes> {
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
    pub expanded: [u64; MAX_LANES],
    /// Identity of the placed body: the expanded index of its first primitive.
    pub body: [u64; MAX_LANES],
    /// Number of the body's primitives.
    pub primitives: [u64; MAX_LANES],
    /// Index of the body's material.
    pub material: [u32; MAX_LANES],
    /// Lanes whose body encloses a region.
    pub closed: u32,
    /// Lanes whose body is hollow.
    pub hollow: u32,
    /// Lanes whose facet stands for a curved surface.
    pub smooth: u32,
    /// Lanes whose body might touch another.
    pub may_touch: u32,
    /// Volume of the placed body.
    pub volume: [f64; MAX_LANES],
    /// Other bodies whose surface is at the same place, as far as rounding can tell, crossed together with this one.
    pub touching: Vec<Touch<L::Real>>,
}

/// Another body that light through a surface enters or leaves at the same place.
#[derive(Debug, Clone, Copy)]
pub struct Touch<R> {
    /// The lane.
    pub lane: usize,
    /// Whether light goes into the region the body encloses.
    pub goes_in: bool,
    /// What that region is filled with.
    pub medium: Medium<R>,
}

/// The media on both sides of a surface.
#[derive(Debug, Clone, Copy)]
pub struct Interface<R> {
    /// Index of refraction on the side the ray comes from.
    pub n1: R,
    /// Index of refraction on the other side.
    pub n2: R,
    /// The media of a ray on the other side.
    pub behind: MediumList,
}

/// Follows rays to the nearest surface, and to what touches it.
pub fn find<L: Lanes>(s: L::Simd, world: &World<L::Real>, rays: &Rays<L>, course: Course) -> Hits<L> {
    let mut hits = find_nearest(s, world, rays, &Nearest::none(), course);
    if world.transmits && hits.may_touch != 0 {
        touching::find(s, world, rays, &mut hits);
    }
    hits
}

/// Follows rays to the nearest surface.
pub(super) fn find_nearest<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    rays: &Rays<L>,
    nearest: &Nearest<'_>,
    course: Course,
) -> Hits<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || find_nearest_in(s, world, rays, *nearest, course),
    )
}

#[inline(always)]
fn find_nearest_in<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    rays: &Rays<L>,
    mut nearest: Nearest<'_>,
    course: Course,
) -> Hits<L> {
    let mut shortened = *rays;
    nearest_hit(s, &world.geometries, world.root, &mut shortened, &mut nearest, course);

    let zero = L::lit(s, 0.0);
    let nothing = V3 { x: zero, y: zero, z: zero };
    let mut hits = Hits {
        found: nearest.found,
        t: shortened.t_max,
        surface: Surface {
            point: nothing,
            error: nothing,
            ng: nothing,
            ns: nothing,
            lift: nothing,
            local: nothing,
            met: L::mask(s, 0),
        },
        ng: nothing,
        ns: nothing,
        entering: 0,
        expanded: nearest.expanded,
        body: [0; MAX_LANES],
        primitives: [0; MAX_LANES],
        material: [0; MAX_LANES],
        closed: 0,
        hollow: 0,
        smooth: 0,
        may_touch: 0,
        volume: [0.0; MAX_LANES],
        touching: Vec::new(),
    };
    hits.look_at(s, world, rays, hits.found);
    hits
}

impl<L: Lanes> Hits<L> {
    /// Fills in everything about the primitives `expanded` of some lanes.
    pub(super) fn look_at(&mut self, s: L::Simd, world: &World<L::Real>, rays: &Rays<L>, lanes: u32) {
        L::vectorize(
            s,
            #[inline(always)]
            || self.look_at_in(s, world, rays, lanes),
        );
    }

    #[inline(always)]
    fn look_at_in(&mut self, s: L::Simd, world: &World<L::Real>, rays: &Rays<L>, lanes: u32) {
        let mut left = lanes;
        self.closed &= !lanes;
        self.hollow &= !lanes;
        self.smooth &= !lanes;
        self.may_touch &= !lanes;
        while left != 0 {
            let owner = world.owner(self.expanded[left.trailing_zeros() as usize]);
            let volume = if owner.item.closed { owner.volume() } else { 0.0 };
            let mut same = 0;
            for lane in lanes_of(left) {
                if owner.owns(self.expanded[lane]) {
                    same |= 1 << lane;
                    self.body[lane] = owner.body;
                    self.primitives[lane] = owner.item.expanded;
                    self.material[lane] = owner.item.material;
                    self.volume[lane] = volume;
                }
            }
            left &= !same;
            self.closed |= if owner.item.closed { same } else { 0 };
            self.hollow |= if owner.item.hollow { same } else { 0 };
            self.smooth |= if owner.item.is_smooth() { same } else { 0 };
            self.may_touch |= if owner.item.may_touch { same } else { 0 };
            let new = resolve(s, &owner, &self.expanded, rays);
            let mask = L::mask(s, same);
            let old = self.surface;
            self.surface = Surface {
                point: V3::select(mask, new.point, old.point),
                error: V3::select(mask, new.error, old.error),
                ng: V3::select(mask, new.ng, old.ng),
                ns: V3::select(mask, new.ns, old.ns),
                lift: V3::select(mask, new.lift, old.lift),
                local: V3::select(mask, new.local, old.local),
                met: (mask & new.met) | (!mask & old.met),
            };
        }
        let against = rays.dir.dot(self.surface.ng).lt(L::lit(s, 0.0));
        self.entering = against.bits() & self.found;
        self.ng = V3::select(against, self.surface.ng, -self.surface.ng);
        self.ns = V3::select(against, self.surface.ns, -self.surface.ns);
    }

    /// The coefficients of the materials hit.
    #[inline(always)]
    pub fn coefficients(&self, s: L::Simd, world: &World<L::Real>) -> Coefficients<L> {
        Coefficients::look_up(s, &world.materials, &self.material, self.found, self.surface.local)
    }

    /// The two media at the surface of a closed body that the ray in `lane`, which is in the media `list`, has hit.
    pub fn interface(
        &self,
        world: &World<L::Real>,
        media: &mut Media<L::Real>,
        list: MediumList,
        lane: usize,
    ) -> Interface<L::Real> {
        let medium = self.medium(world, lane);
        let before =
            if self.goes_in(lane) || media.contains(list, medium.body) { list } else { media.enter(list, medium) };
        let n1 = media.ior(before);
        let mut behind = before;
        let own = Touch { lane, goes_in: self.goes_in(lane), medium };
        for touch in self.touching.iter().filter(|touch| touch.lane == lane).chain([&own]) {
            behind =
                if touch.goes_in { media.enter(behind, touch.medium) } else { media.leave(behind, touch.medium.body) };
        }
        Interface { n1, n2: media.ior(behind), behind }
    }

    /// What the region that a lane's closed body encloses is filled with: its material, or empty space in a cavity.
    pub fn medium(&self, world: &World<L::Real>, lane: usize) -> Medium<L::Real> {
        let hollow = self.hollow & (1 << lane) != 0;
        let one = L::Real::from_f64(1.0);
        let ior = if hollow { one } else { world.materials[self.material[lane] as usize].ior };
        Medium { body: self.body[lane], volume: self.volume[lane], ior }
    }

    /// Whether a lane's ray goes into the region its body encloses; one goes into a cavity out of the material.
    pub fn goes_in(&self, lane: usize) -> bool {
        (self.entering ^ self.hollow) & (1 << lane) != 0
    }

    /// Whether a lane's material shows nothing between equal media.
    pub fn is_perfectly_clear(&self, world: &World<L::Real>, lane: usize) -> bool {
        world.materials[self.material[lane] as usize].is_perfectly_clear()
    }

    /// Whether a lane's body transmits light in any channel.
    pub fn transmits(&self, world: &World<L::Real>, lane: usize) -> bool {
        let zero = L::Real::from_f64(0.0);
        world.materials[self.material[lane] as usize].transmission.iter().any(|c| *c > zero)
    }
}
