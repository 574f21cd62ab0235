//! Materials whose reflection and transmission depend on the angle of incidence.
//!
//! Dielectrics take the exact reflectance F between the media on both sides: F r_s and (1 - F) r_t, which is r_s under
//! total internal reflection, where F is 1. Surfaces without a medium behind them, opaque bodies and sheets, take the medium
//! of the ray in front and their material behind: a varnish. Conductors take Schlick's approximation,
//! r_s + (1 - r_s) (1 - cos theta)^5, and transmit the remaining share of r_t. Materials of layers are dielectrics with metal and
//! clearcoat, of which their lobes say how much.

use super::hits::Hits;
use super::ray_packet::RayPacket;
use super::shaded::Shaded;
use crate::lanes::{Ids, Lanes, Mask, V3};
use crate::scene::world::World;
use crate::shading::material::Fresnel;
use crate::shading::media::{Media, MediumList};
use crate::shading::optics::{Refraction, fresnel_dielectric, refract};

/// Snell's law where rays enter and leave bodies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bent<'a, L: Lanes> {
    /// Lanes that enter or leave a body.
    pub(super) lanes: u32,
    /// n1/n2.
    pub(super) eta: L,
    pub(super) refraction: &'a Refraction<L>,
}

/// Lanes that have hit a conductor, which reflects at grazing angles even where r_s is 0.
pub(super) fn conductors<L: Lanes>(s: L::Simd, world: &World<L::Real>, hits: &Hits<L>) -> u32 {
    L::vectorize(
        s,
        #[inline(always)]
        || kinds(s, world, hits).conductor,
    )
}

/// What surfaces do at the angles at which rays hit them.
#[derive(Debug, Clone, Copy)]
pub(super) struct AtAngles<L: Lanes> {
    pub(super) r_s: V3<L>,
    pub(super) r_t: V3<L>,
    /// The lanes whose varnish reflects each wavelength differently.
    pub(super) tinted: u32,
    /// What dielectrics reflect alone.
    pub(super) layer: L,
}

/// n1/n2 for rays that hit surfaces without a medium behind them: that of the medium in front and of the material.
pub(super) fn into_varnish<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    media: &Media<L::Real>,
    rays: &RayPacket<L>,
    hits: &Hits<L>,
    bend: Option<L>,
) -> L {
    L::vectorize(
        s,
        #[inline(always)]
        || varnish(s, media, rays, &kinds(s, world, hits), hits.found, bend).0,
    )
}

/// Reflection and transmission at surfaces with normals `ns`; `bend` says of which wavelength the light is, if it matters.
pub(super) fn at_angles<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    media: &Media<L::Real>,
    shaded: Shaded<'_, L>,
    ns: V3<L>,
    bent: Option<Bent<'_, L>>,
    bend: Option<L>,
) -> AtAngles<L> {
    L::vectorize(
        s,
        #[inline(always)]
        || at_angles_in(s, world, media, shaded, ns, bent, bend),
    )
}

/// Which lanes have hit what, and the index of refraction and the dispersion of its material.
struct Kinds<L: Lanes> {
    dielectric: u32,
    conductor: u32,
    ior: L,
    dispersion: L,
}

#[inline(always)]
fn kinds<L: Lanes>(s: L::Simd, world: &World<L::Real>, hits: &Hits<L>) -> Kinds<L> {
    let mut kinds = Kinds { dielectric: 0, conductor: 0, ior: L::lit(s, 1.0), dispersion: L::lit(s, 0.0) };
    let mut left = hits.found;
    while left != 0 {
        let (id, same) = hits.material.same_as_first(s, left);
        left &= !same;
        let material = &world.materials[id as usize];
        match material.fresnel {
            Fresnel::None => {}
            Fresnel::Dielectric | Fresnel::Layered => kinds.dielectric |= same,
            Fresnel::Conductor => kinds.conductor |= same,
        }
        let mask = L::mask(s, same);
        kinds.ior = L::select(mask, L::splat(s, material.ior), kinds.ior);
        // Layers disperse in volumes alone (glTF, KHR_materials_dispersion).
        if material.fresnel != Fresnel::Layered {
            kinds.dispersion = L::select(mask, L::splat(s, material.dispersion), kinds.dispersion);
        }
    }
    kinds
}

/// n1/n2 of surfaces without a medium behind them, and the lanes where it depends on the wavelength.
#[inline(always)]
fn varnish<L: Lanes>(
    s: L::Simd,
    media: &Media<L::Real>,
    rays: &RayPacket<L>,
    kinds: &Kinds<L>,
    lanes: u32,
    bend: Option<L>,
) -> (L, u32) {
    let outside = around::<L>(s, rays.media, lanes, 1.0, |list| media.ior(list));
    let Some(bend) = bend else { return (outside / kinds.ior, 0) };
    let before = around::<L>(s, rays.media, lanes, 0.0, |list| media.dispersion(list));
    let eta = (outside + before * bend) / (kinds.ior + kinds.dispersion * bend);
    (eta, before.max(kinds.dispersion).gt(L::lit(s, 0.0)).bits() & lanes)
}

#[inline(always)]
fn at_angles_in<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    media: &Media<L::Real>,
    Shaded { rays, hits, coefficients, lobes, .. }: Shaded<'_, L>,
    ns: V3<L>,
    bent: Option<Bent<'_, L>>,
    bend: Option<L>,
) -> AtAngles<L> {
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let kinds = kinds(s, world, hits);
    let Kinds { dielectric, conductor, .. } = kinds;
    let (mut tinted, mut layer) = (0, zero);
    let (mut r_s, mut r_t) = (coefficients.reflection, coefficients.transmission);
    // An interpolated normal may face away from the ray; the geometric one does not.
    let n = V3::select(rays.dir.dot(ns).lt(zero), ns, hits.ng);
    if dielectric != 0 {
        let (mut eta, dispersive) = varnish(s, media, rays, &kinds, dielectric, bend);
        tinted = dispersive & !bent.map_or(0, |bent| bent.lanes);
        let mut refraction = refract(s, rays.dir, n, eta);
        if let Some(bent) = bent {
            let mask = L::mask(s, bent.lanes);
            eta = L::select(mask, bent.eta, eta);
            refraction = Refraction::select(s, mask, bent.refraction, &refraction);
        }
        let reflectance = L::select(eta.eq(one), zero, fresnel_dielectric(s, eta, &refraction));
        let mask = L::mask(s, dielectric);
        let mut left = one - reflectance;
        if let Some(lobes) = lobes {
            left = L::select(L::mask(s, lobes.lanes), lobes.let_through(s, reflectance, (-rays.dir).dot(n)), left);
        }
        r_s = V3::select(mask, r_s * reflectance, r_s);
        r_t = V3::select(mask, r_t * left, r_t);
        layer = L::select(mask, r_s.x.max(r_s.y).max(r_s.z), zero);
    }
    if let Some(lobes) = lobes {
        // Metal and clearcoat mirror beside the dielectric, and inside of it whatever is its roughness.
        let grazing = grazing(s, rays.dir, n);
        let [normal, along] = lobes.metal;
        let metal = normal + (along - normal) * grazing;
        let clearcoat = V3 { x: lobes.clearcoat_mirror, y: lobes.clearcoat_mirror, z: lobes.clearcoat_mirror };
        let mask = L::mask(s, lobes.lanes);
        r_s = V3::select(mask, r_s + metal + clearcoat, r_s);
        // What a wide lobe reflects is its share of light from all around, and what is left passes.
        let wide = L::mask(s, lobes.wide);
        let total = bent.map_or(L::mask(s, 0), |bent| L::mask(s, bent.lanes) & bent.refraction.total);
        r_t = V3::select(wide, coefficients.transmission * lobes.let_in, r_t);
        r_t = V3::select(mask & total, V3 { x: zero, y: zero, z: zero }, r_t);
        // Total reflection takes the share that would pass. The rest of the surface lets none through: it scatters, or mirrors.
        let inside = lobes.passing * L::select(wide, lobes.let_in, lobes.left_by_schlick(s, (-rays.dir).dot(n)));
        let V3 { x, y, z } = V3 { x: inside, y: inside, z: inside } + metal + clearcoat;
        r_s = V3::select(mask & total, V3 { x: x.min(one), y: y.min(one), z: z.min(one) }, r_s);
        layer = L::select(mask & total, zero, layer);
        let mut mirrored = r_s;
        if lobes.apart != 0 {
            let clearcoat = L::select(L::mask(s, lobes.apart), lobes.clearcoat_by_rays, zero);
            mirrored = mirrored + V3 { x: clearcoat, y: clearcoat, z: clearcoat };
        }
        // A reflection may be brighter than the index of refraction makes it.
        let V3 { x, y, z } = mirrored;
        let left = V3 { x: (one - x).max(zero), y: (one - y).max(zero), z: (one - z).max(zero) };
        let kept = V3 { x: r_t.x.min(left.x), y: r_t.y.min(left.y), z: r_t.z.min(left.z) };
        r_t = V3::select(mask, kept, r_t);
    }
    if conductor != 0 {
        let grazing = grazing(s, rays.dir, n);
        let white = V3 { x: one, y: one, z: one };
        let mask = L::mask(s, conductor);
        r_s = V3::select(mask, r_s + (white - r_s) * grazing, r_s);
        r_t = V3::select(mask, r_t * (one - grazing), r_t);
    }
    AtAngles { r_s, r_t, tinted, layer }
}

/// (1 - cos theta)^5.
#[inline(always)]
fn grazing<L: Lanes>(s: L::Simd, dir: V3<L>, n: V3<L>) -> L {
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let versine = (one + dir.dot(n)).max(zero).min(one);
    let squared = versine * versine;
    squared * squared * versine
}

/// A property of the media that rays are in, `other` in lanes that are not asked for.
#[inline(always)]
fn around<L: Lanes>(s: L::Simd, lists: L::Ids, lanes: u32, other: f64, of: impl Fn(MediumList) -> L::Real) -> L {
    let mut all = L::lit(s, other);
    let mut left = lanes;
    while left != 0 {
        let (list, same) = lists.same_as_first(s, left);
        left &= !same;
        all = L::select(L::mask(s, same), L::splat(s, of(list as MediumList)), all);
    }
    all
}
