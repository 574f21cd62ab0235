//! What the rays of a packet hit: surfaces, bodies and coefficients, gathered for shading.

use crate::accel::{Nearest, Surface, closest_hit, resolve};
use crate::lanes::{Lanes, MAX_LANES, Real, V3, lanes_of};
use crate::ray::Rays;
use crate::scene::world::World;
use crate::shading::material::Coefficients;
use crate::shading::media::{Media, MediumList};

/// The nearest surface under each ray.
#[derive(Debug, Clone, Copy)]
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
    /// Identity of the placed body.
    pub body: [u64; MAX_LANES],
    /// Index of the body's material.
    pub material: [u32; MAX_LANES],
    /// Lanes whose body encloses a region.
    pub closed: u32,
    /// Lanes whose body is hollow.
    pub hollow: u32,
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

/// Follows rays to the nearest surface.
#[inline(always)]
pub fn find<L: Lanes>(s: L::Simd, world: &World<L::Real>, rays: &Rays<L>) -> Hits<L> {
    let mut nearest = Nearest::none();
    let mut shortened = *rays;
    closest_hit(s, &world.geometries, world.root, 0, &mut shortened, &mut nearest);

    let zero = L::lit(s, 0.0);
    let nothing = V3 { x: zero, y: zero, z: zero };
    let mut hits = Hits {
        found: nearest.found,
        t: shortened.t_max,
        surface: Surface { point: nothing, error: nothing, ng: nothing, ns: nothing, local: nothing },
        ng: nothing,
        ns: nothing,
        entering: 0,
        expanded: nearest.expanded,
        body: [0; MAX_LANES],
        material: [0; MAX_LANES],
        closed: 0,
        hollow: 0,
    };
    let mut left = nearest.found;
    while left != 0 {
        let owner = world.owner(nearest.expanded[left.trailing_zeros() as usize]);
        let mut same = 0;
        for lane in lanes_of(left) {
            if owner.owns(nearest.expanded[lane]) {
                same |= 1 << lane;
                hits.body[lane] = owner.body;
                hits.material[lane] = owner.item.material;
            }
        }
        left &= !same;
        hits.closed |= if owner.item.closed { same } else { 0 };
        hits.hollow |= if owner.item.hollow { same } else { 0 };
        let surface = resolve(s, &owner, &nearest.expanded, rays);
        let mask = L::mask(s, same);
        let old = hits.surface;
        hits.surface = Surface {
            point: V3::select(mask, surface.point, old.point),
            error: V3::select(mask, surface.error, old.error),
            ng: V3::select(mask, surface.ng, old.ng),
            ns: V3::select(mask, surface.ns, old.ns),
            local: V3::select(mask, surface.local, old.local),
        };
    }
    let against = rays.dir.dot(hits.surface.ng).lt(zero);
    hits.entering = crate::lanes::Mask::bits(against) & hits.found;
    hits.ng = V3::select(against, hits.surface.ng, -hits.surface.ng);
    hits.ns = V3::select(against, hits.surface.ns, -hits.surface.ns);
    hits
}

impl<L: Lanes> Hits<L> {
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
        let body = self.body[lane];
        let hollow = self.hollow & (1 << lane) != 0;
        let entering = self.entering & (1 << lane) != 0;
        // A hollow body's region is its cavity, which holds empty space; one goes into it out of the material.
        let (goes_in, inside) = if hollow {
            (!entering, L::Real::from_f64(1.0))
        } else {
            (entering, world.materials[self.material[lane] as usize].ior)
        };
        if goes_in {
            return Interface { n1: media.ior(list), n2: inside, behind: media.enter(list, body, inside) };
        }
        let n1 = if media.contains(list, body) { media.ior(list) } else { inside };
        let behind = media.leave(list, body);
        Interface { n1, n2: media.ior(behind), behind }
    }

    /// Whether a lane's body transmits light in any channel.
    pub fn transmits(&self, world: &World<L::Real>, lane: usize) -> bool {
        let zero = L::Real::from_f64(0.0);
        world.materials[self.material[lane] as usize].transmission.iter().any(|c| *c > zero)
    }
}
