//! What surfaces of metallic-roughness materials do with light (glTF 2.0, appendix B): a diffuse lobe below, a GGX lobe over it,
//! and a second GGX lobe of clearcoat over both.
//!
//! Highlights of lights have a closed form, so they need no sample. Rays are followed where a lobe is so narrow that one ray
//! stands for it; wider lobes are to see light from all around instead (`split_sum.rs`). With global illumination, each lobe sends a
//! ray by a facet that it chooses.

use super::pbr::Parameters;
use super::split_sum::reflected_share;
use crate::lanes::{Lanes, Mask, V3};

/// The roughness up to which a mirror ray stands for the lobe of what is no metal: 0.3 codes off on average, and of metals 0.3
/// codes up to half of it.
pub const MIRROR: f64 = 0.1;

/// Roughness of clearcoat up to which it is a mirror, and from which on its surroundings are blurred. In between it is some of both:
/// where a picture makes it rougher, no edge is to be seen.
pub const CLEARCOAT: [f64; 2] = [0.08, 0.15];

/// Narrowest lobe that lights have a highlight in: that of roughness 0.03.
pub const NARROWEST: f64 = 1.0 / 1024.0;

/// No lobe reflects less of white light that its facets do not absorb; lanes without a lobe have none.
const LEAST_SHARE: f64 = 0.1;

/// Least cosine between the eye and a normal that is turned away from it.
pub(super) const EDGE_ON: f64 = 1e-4;

/// Most that a surface that is seen by way of others reflects of a light, as a factor on what white would scatter: by far more
/// than white even if only 4 % of it is seen. Without a limit nothing could be proved about rays that are not followed.
pub const BRIGHTEST: f64 = 64.0;

/// What the surfaces under a packet do with light.
#[derive(Debug, Clone, Copy)]
pub struct Lobes<L: Lanes> {
    /// The lanes with such materials; others hold anything.
    pub lanes: u32,
    /// What is scattered below the mirroring surface.
    pub(super) diffuse: V3<L>,
    /// Reflectance of the surface at normal incidence and along it, with what facets reflect on to each other.
    pub(super) f0: V3<L>,
    pub(super) f90: V3<L>,
    /// The share that is missing below because the surface has reflected it, at normal incidence and along it.
    pub(super) lost: [L; 2],
    /// Whether rays bring light to each lobe.
    pub(super) global_illumination: bool,
    /// Width of the facets' distribution.
    pub(super) width: L,
    /// What the clearcoat reflects, and the factor on its highlights: its facets reflect on to each other, too.
    pub(super) clearcoat: L,
    pub(super) clearcoat_gain: L,
    pub(super) clearcoat_width: L,
    /// The shares of light that facets which others do not hide reflect, of all, on the surface and the clearcoat.
    pub(super) open: [L; 2],
    /// The share of all light that what is no metal gets.
    pub(super) other: L,
    /// The lanes of what is no metal and reflects by Schlick's law, rather than by its index of refraction.
    pub(super) by_schlick: u32,
    /// The normal of the clearcoat.
    pub clearcoat_ns: V3<L>,
    /// The lanes with clearcoat whose normal is not that of the surface below.
    pub apart: u32,
    /// What all light from around is multiplied with: what is scattered, and what wide lobes reflect.
    pub ambient: V3<L>,
    /// The share that is scattered of light from all around.
    pub scattered: V3<L>,
    /// The share of it that a wide lobe of the surface reflects.
    pub blurred: V3<L>,
    /// Roughness of the surface.
    pub roughness: L,
    /// The share that a wide lobe of the clearcoat reflects.
    pub clearcoat_blurred: L,
    /// Roughness of the clearcoat.
    pub clearcoat_roughness: L,
    /// The share of light from all around that arrives.
    pub occlusion: L,
    /// The lanes whose mirror ray is followed.
    pub mirrored: u32,
    /// Width of the facets that rays choose among; 0 where a mirror ray stands for the lobe.
    pub facets: L,
    /// What the clearcoat reflects by rays of its own: with global illumination, and where its normal is another.
    pub clearcoat_by_rays: L,
    /// Width of the facets of the clearcoat; 0 where it is a mirror.
    pub clearcoat_facets: L,
    /// Factor on Fresnel's reflectance of a dielectric.
    pub reflection: V3<L>,
    /// Reflectance of metal at normal incidence and along the surface.
    pub metal: [V3<L>; 2],
    /// What the clearcoat mirrors by the ray of the surface below.
    pub clearcoat_mirror: L,
    /// The share that passes what the surface does not reflect, and its color.
    pub passing: L,
    /// That share in color.
    pub transmission: V3<L>,
    /// The lanes whose surface reflects by a wide lobe.
    pub wide: u32,
    /// The share of light that the surface lets in at the angle of the eye: what it does not reflect of light from all around, so
    /// that white keeps all light.
    pub let_in: L,
    /// Emitted radiance.
    pub emission: V3<L>,
    /// How much of the surface is there.
    pub opacity: L,
}

// What leaves from facets of rough surfaces that rays choose.
impl<L: Lanes> Lobes<L> {
    /// The most that a facet reflects and the share that passes it, where its dielectric reflects a share. `cosine` is that
    /// between facet and eye.
    #[inline(always)]
    pub fn leaving(&self, s: L::Simd, reflectance: L, cosine: L) -> [L; 2] {
        let [normal, along] = self.metal;
        let grazing = fifth((L::lit(s, 1.0) - cosine).max(L::lit(s, 0.0)));
        let V3 { x, y, z } = self.reflection * reflectance + normal + (along - normal) * grazing;
        [x.max(y).max(z), self.passing * self.let_through(s, reflectance, cosine)]
    }

    /// The share of what meets the dielectric that goes on below it, where its index of refraction reflects a share.
    #[inline(always)]
    pub fn let_through(&self, s: L::Simd, reflectance: L, cosine: L) -> L {
        let V3 { x, y, z } = self.reflection;
        let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
        let strength = L::select(self.other.gt(zero), x.max(y).max(z) / self.other, one);
        let by_schlick = L::mask(s, self.by_schlick);
        L::select(by_schlick, self.left_by_schlick(s, cosine), one - reflectance * strength)
    }

    /// The share that goes on below what reflects by Schlick's law: all where the index of refraction says how much.
    #[inline(always)]
    pub fn left_by_schlick(&self, s: L::Simd, cosine: L) -> L {
        let one = L::lit(s, 1.0);
        let reflected = self.schlick(fifth((one - cosine).max(L::lit(s, 0.0))));
        L::select(L::mask(s, self.by_schlick), one - reflected, one)
    }

    /// What the dielectric reflects by Schlick's law.
    #[inline(always)]
    pub(super) fn schlick(&self, grazing: L) -> L {
        let [normal, along] = self.lost;
        normal + (along - normal) * grazing
    }

    /// What is scattered below a facet, given what the dielectric reflects there: all that it lets in.
    #[inline(always)]
    pub fn below(&self, s: L::Simd, reflected: L) -> V3<L> {
        let zero = L::lit(s, 0.0);
        let share = L::select(self.other.gt(zero), reflected / self.other, zero);
        let all = self.diffuse * (L::lit(s, 1.0) - share).max(zero);
        V3::select(L::mask(s, self.by_schlick), self.scattered, all)
    }
}

impl<L: Lanes> Lobes<L> {
    /// What wide lobes reflect of all light from around.
    #[inline(always)]
    pub fn reflected_from_around(&self) -> V3<L> {
        let clearcoat = self.clearcoat_blurred;
        (self.blurred + V3 { x: clearcoat, y: clearcoat, z: clearcoat }) * self.occlusion
    }

    /// The lobes of some lanes. `to_eye` is unit, `ns` the normal of the surface and `clearcoat_ns` that of the clearcoat, which differ
    /// in the lanes of `apart`. `global_illumination`: whether rays bring light to each lobe.
    #[inline(always)]
    pub fn of(
        s: L::Simd,
        p: &Parameters<L>,
        lanes: u32,
        to_eye: V3<L>,
        ns: V3<L>,
        clearcoat_ns: V3<L>,
        apart: u32,
        global_illumination: bool,
    ) -> Self {
        let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
        let nothing = V3 { x: zero, y: zero, z: zero };
        let (cosine, clearcoat_cosine) = (facing(s, ns, to_eye), facing(s, clearcoat_ns, to_eye));
        let least = L::lit(s, LEAST_SHARE);
        let clearcoat = p.clearcoat * (L::lit(s, 0.04) + L::lit(s, 0.96) * fifth(one - clearcoat_cosine)) * p.lit;
        let rough_clearcoat =
            L::mask(s, lanes) & clearcoat.gt(zero) & p.clearcoat_roughness.gt(L::lit(s, CLEARCOAT[0]));
        let mut open_clearcoat = one;
        if rough_clearcoat.any() {
            let [a, b, _] = reflected_share(s, clearcoat_cosine, p.clearcoat_roughness, rough_clearcoat.bits());
            open_clearcoat = L::select(rough_clearcoat, (a + b).max(least), one);
        }
        let below = (one - clearcoat) * p.lit;
        let (metal, other) = (p.metallic * below, (one - p.metallic) * below);
        let tint = p.specular_color * p.normal_reflectance;
        let tint = V3 { x: tint.x.min(one), y: tint.y.min(one), z: tint.z.min(one) } * p.specular;
        let lost = [tint.x.max(tint.y).max(tint.z), p.specular];
        let diffuse = p.base_color * (other * (one - p.transmission));
        let passing = other * p.transmission;

        let every = L::mask(s, if global_illumination { L::ALL } else { 0 });
        let smooth = p.roughness.le(L::lit(s, MIRROR) - L::lit(s, 0.5 * MIRROR) * p.metallic) | every;
        let clearcoat_smooth = L::select(every, one, one - smoothstep(s, p.clearcoat_roughness, CLEARCOAT));
        let [a, b, facet] = reflected_share(s, cosine, p.roughness, lanes);
        // What facets hide from the eye or the light they reflect on (Fdez-Agüera 2019): 1 + F0 (1/(a + b) - 1).
        let open = (a + b).max(least);
        let again = one / open - one;
        let white = V3 { x: one, y: one, z: one };
        let (more, more_metal) = (white + tint * again, white + p.base_color * again);
        let f0 = (tint * other).times(more) + (p.base_color * metal).times(more_metal);
        let f90 = more * (p.specular * other) + more_metal * metal;
        // What reflects more than its index of refraction follows Schlick's law, as metal does.
        let color = p.specular_color;
        let strongest = color.x.max(color.y).max(color.z);
        let bright = strongest.gt(one);
        // Where a mirror ray takes its share by the index of refraction, so does what is below.
        let mirrors_exactly = smooth & !bright;
        let at = L::select(every, facet, cosine);
        let exact = strongest * p.specular * dielectric_reflectance(s, p.normal_reflectance, at);
        let exact = L::select(every, exact * open, exact);
        let hidden = L::select(mirrors_exactly, exact, lost[0] * a + lost[1] * b);
        let returned = L::select(smooth & !every, one, one + lost[0] * again);
        let let_in = one - hidden * returned;
        let scattered = diffuse * let_in;
        let blurred = V3::select(smooth, nothing, f0 * a + f90 * b);
        let clearcoat_blurred = L::select(L::mask(s, lanes), clearcoat * (one - clearcoat_smooth), zero);
        let ambient = scattered + blurred + V3 { x: clearcoat_blurred, y: clearcoat_blurred, z: clearcoat_blurred };
        let reflection = V3::select(smooth & !bright, color * (p.specular * other), nothing);
        let (mut reflection, mut gain, mut gain_metal) = (reflection, white, white);
        if global_illumination {
            // Rays choose among the facets that others do not hide (`trace/facets.rs`), so each stands for more of them. What
            // glass does not reflect passes, and does not get lost.
            let kept = white * p.transmission;
            (gain, gain_metal) = (kept + more * (open * (one - p.transmission)), more_metal * open);
            reflection = reflection.times(gain);
        }
        let shiny = L::select(bright, other, zero);
        let at_normal = (p.base_color * metal).times(gain_metal) + (tint * shiny).times(gain);
        let along = gain_metal * metal + gain * (shiny * p.specular);
        let metal = [V3::select(smooth, at_normal, nothing), V3::select(smooth, along, nothing)];
        let apart = if apart == 0 { 0 } else { apart & clearcoat.gt(zero).bits() };
        let mut clearcoat_by_rays = if global_illumination { clearcoat } else { zero };
        let mut clearcoat_mirror = if global_illumination { zero } else { clearcoat * clearcoat_smooth };
        if apart != 0 && !global_illumination {
            let mask = L::mask(s, apart);
            (clearcoat_by_rays, clearcoat_mirror) =
                (L::select(mask, clearcoat_mirror, zero), L::select(mask, zero, clearcoat_mirror));
        }
        let (width, clearcoat_width) = (p.roughness * p.roughness, p.clearcoat_roughness * p.clearcoat_roughness);
        let (facets, clearcoat_facets) = (chosen(s, width, every), chosen(s, clearcoat_width, every));
        let mirrors = (smooth & p.lit.gt(zero)) | clearcoat_mirror.gt(zero);
        Self {
            lanes,
            diffuse,
            f0,
            f90,
            lost,
            global_illumination,
            width: width.max(L::lit(s, NARROWEST)),
            clearcoat,
            clearcoat_gain: one / open_clearcoat,
            open: [open, open_clearcoat],
            other,
            by_schlick: bright.bits() & lanes,
            clearcoat_width: clearcoat_width.max(L::lit(s, NARROWEST)),
            clearcoat_ns,
            apart,
            ambient: ambient * p.occlusion,
            scattered,
            blurred,
            roughness: p.roughness,
            clearcoat_blurred,
            clearcoat_roughness: p.clearcoat_roughness,
            occlusion: p.occlusion,
            mirrored: mirrors.bits() & lanes,
            facets,
            clearcoat_by_rays,
            clearcoat_facets,
            reflection,
            metal,
            clearcoat_mirror,
            passing,
            transmission: p.base_color * passing,
            wide: !smooth.bits() & lanes,
            let_in,
            emission: p.emissive * (one - clearcoat),
            opacity: p.opacity,
        }
    }
}

/// Cosine between a normal and the eye, which sees surfaces from their front.
#[inline(always)]
fn facing<L: Lanes>(s: L::Simd, n: V3<L>, to_eye: V3<L>) -> L {
    n.dot(to_eye).max(L::lit(s, EDGE_ON)).min(L::lit(s, 1.0))
}

/// The exact reflectance of a dielectric in empty space, given that at normal incidence.
#[inline(always)]
fn dielectric_reflectance<L: Lanes>(s: L::Simd, normal: L, cosine: L) -> L {
    let one = L::lit(s, 1.0);
    let root = normal.sqrt().min(L::lit(s, 0.9999));
    let ior = (one + root) / (one - root);
    let sine = (one - cosine * cosine).max(L::lit(s, 0.0));
    let inside = (ior * ior - sine).max(L::lit(s, 0.0)).sqrt();
    // Equal media reflect nothing; along them it would be 0/0.
    let across = (cosine - inside) / (cosine + inside).max(L::lit(s, 1e-6));
    let flat = (ior * ior * cosine - inside) / (ior * ior * cosine + inside).max(L::lit(s, 1e-6));
    ((across * across + flat * flat) * L::lit(s, 0.5)).min(one)
}

/// 0 up to the first edge, 1 from the second on, and smooth in between.
#[inline(always)]
fn smoothstep<L: Lanes>(s: L::Simd, x: L, [from, to]: [f64; 2]) -> L {
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let part = ((x - L::lit(s, from)) / L::lit(s, to - from)).max(zero).min(one);
    part * part * (L::lit(s, 3.0) - part - part)
}

#[inline(always)]
pub(super) fn fifth<L: Lanes>(x: L) -> L {
    let square = x * x;
    square * square * x
}

/// The width of facets that rays choose among, in some lanes; 0 where all are alike.
#[inline(always)]
fn chosen<L: Lanes>(s: L::Simd, width: L, lanes: L::Mask) -> L {
    L::select(width.gt(L::lit(s, NARROWEST)) & lanes, width, L::lit(s, 0.0))
}
