//! Highlights of lights on the lobes of metallic-roughness materials, in closed form, and how likely rays of lobes find directions.

use super::lobes::{BRIGHTEST, EDGE_ON, Lobes, fifth};
use super::microfacet::smith_g1;
use crate::lanes::{Lanes, Mask, Real, V3};
use std::f64::consts::PI;

/// What a lobe of facets does with light from a direction.
#[derive(Debug, Clone, Copy)]
pub struct LobeSample<L: Lanes> {
    /// The share of its irradiance over pi that is reflected to the eye.
    pub reflected: V3<L>,
    /// How likely a ray of the lobe has that direction, by solid angle; 0 where it has one only.
    pub density: L,
}

impl<L: Lanes> Lobes<L> {
    /// The cosine between a light's direction and the normal of the surface, given that, and the lanes where the light may be
    /// reflected: the surface or the clearcoat over it faces it.
    #[inline(always)]
    pub fn faces(&self, s: L::Simd, to_light: V3<L>, cosine: L) -> (L, L::Mask) {
        let zero = L::lit(s, 0.0);
        let faces = cosine.gt(zero);
        if self.apart == 0 {
            return (cosine, faces);
        }
        let apart = L::mask(s, self.apart);
        (L::select(apart, cosine.max(zero), cosine), faces | (apart & self.clearcoat_ns.dot(to_light).gt(zero)))
    }

    /// The share of a light's irradiance over pi that is reflected to the eye. All vectors are unit and point away from the
    /// surface; `cosine` is that between light and normal, 0 or more where it counts.
    #[inline(always)]
    pub fn reflected(&self, s: L::Simd, ns: V3<L>, to_light: V3<L>, to_eye: V3<L>, cosine: L) -> V3<L> {
        let half = Half::new(s, to_light, to_eye);
        let mut reflected = self.scattered(s, &half, cosine) + self.mirrored_by_facets(s, &half, ns, cosine);
        if self.clearcoat.gt(L::lit(s, 0.0)).bits() & self.lanes != 0 {
            let clearcoat = self.mirrored_by_clearcoat(s, &half, to_light);
            reflected = reflected + V3 { x: clearcoat, y: clearcoat, z: clearcoat };
        }
        reflected
    }

    /// What the surface and the clearcoat over it do with light from a direction, where their rays choose among facets. All vectors
    /// are as for [`Self::reflected`].
    #[inline(always)]
    pub fn sampled_lobes(
        &self,
        s: L::Simd,
        ns: V3<L>,
        to_light: V3<L>,
        to_eye: V3<L>,
        cosine: L,
    ) -> [LobeSample<L>; 2] {
        let zero = L::lit(s, 0.0);
        let half = Half::new(s, to_light, to_eye);
        let own = self.mirrored_by_facets(s, &half, ns, cosine);
        let over = self.mirrored_by_clearcoat(s, &half, to_light);
        let nothing = V3 { x: zero, y: zero, z: zero };
        let [open, open_clearcoat] = self.open;
        let (rough, clearcoat_rough) = (self.facets.gt(zero), self.clearcoat_facets.gt(zero));
        [
            LobeSample {
                reflected: V3::select(rough, own, nothing),
                density: L::select(rough, half.pdf(s, ns, to_light, self.width, open), zero),
            },
            LobeSample {
                reflected: V3::select(clearcoat_rough, V3 { x: over, y: over, z: over }, nothing),
                density: L::select(
                    clearcoat_rough,
                    half.pdf(s, self.clearcoat_ns, to_light, self.clearcoat_width, open_clearcoat),
                    zero,
                ),
            },
        ]
    }

    /// What the surface and the clearcoat reflect of a light from a direction, as [`Self::reflected`] has it with what is scattered, and
    /// how likely [`super::microfacet::visible_facet`] mirrors the eye there. All vectors are as there.
    #[inline(always)]
    pub fn highlights(&self, s: L::Simd, ns: V3<L>, to_light: V3<L>, to_eye: V3<L>, cosine: L) -> [LobeSample<L>; 2] {
        let half = Half::new(s, to_light, to_eye);
        let own = self.mirrored_by_facets(s, &half, ns, cosine);
        let over = self.mirrored_by_clearcoat(s, &half, to_light);
        let over_pdf = half.visible_pdf(s, self.clearcoat_ns, self.clearcoat_width);
        [
            LobeSample { reflected: own, density: half.visible_pdf(s, ns, self.width) },
            LobeSample { reflected: V3 { x: over, y: over, z: over }, density: over_pdf },
        ]
    }

    /// What is scattered of a light from a direction, of what [`Self::reflected`] has in all.
    #[inline(always)]
    pub fn scattered_of(&self, s: L::Simd, to_light: V3<L>, to_eye: V3<L>, cosine: L) -> V3<L> {
        self.scattered(s, &Half::new(s, to_light, to_eye), cosine)
    }

    #[inline(always)]
    fn scattered(&self, s: L::Simd, half: &Half<L>, cosine: L) -> V3<L> {
        // What rays bring is scattered as light from all around is; else lights would depend on how they are found.
        let kept = if self.global_illumination { self.let_in } else { L::lit(s, 1.0) - self.schlick(half.grazing(s)) };
        self.diffuse * (kept * cosine)
    }

    #[inline(always)]
    fn mirrored_by_facets(&self, s: L::Simd, half: &Half<L>, ns: V3<L>, cosine: L) -> V3<L> {
        let fresnel = self.f0 + (self.f90 - self.f0) * half.grazing(s);
        fresnel * half.highlight(s, ns, cosine, self.width)
    }

    #[inline(always)]
    fn mirrored_by_clearcoat(&self, s: L::Simd, half: &Half<L>, to_light: V3<L>) -> L {
        let cosine = self.clearcoat_ns.dot(to_light).max(L::lit(s, 0.0));
        self.clearcoat * self.clearcoat_gain * half.highlight(s, self.clearcoat_ns, cosine, self.clearcoat_width)
    }

    /// The lanes whose lobe, and those whose clearcoat, has directions that are more likely than a density by solid angle: at most
    /// 1 / (4 pi width^2).
    #[inline(always)]
    pub fn narrower_than(&self, s: L::Simd, density: L) -> [u32; 2] {
        let widest = L::lit(s, 0.25 / PI) / density;
        let surface = (self.width * self.width).lt(widest);
        let clearcoat = (self.clearcoat_width * self.clearcoat_width).lt(widest) & self.clearcoat.gt(L::lit(s, 0.0));
        [surface.bits() & self.lanes, clearcoat.bits() & self.lanes]
    }

    /// Widths of the facets' distributions of the surface and of the clearcoat.
    #[inline(always)]
    pub fn widths(&self) -> [L; 2] {
        [self.width, self.clearcoat_width]
    }

    /// How likely facets of the surface that are chosen mirror the eye into a direction, by solid angle.
    #[inline(always)]
    pub fn pdf(&self, s: L::Simd, ns: V3<L>, dir: V3<L>, to_eye: V3<L>) -> L {
        Half::new(s, dir, to_eye).pdf(s, ns, dir, self.width, self.open[0])
    }

    /// The same of facets of the clearcoat.
    #[inline(always)]
    pub fn clearcoat_pdf(&self, s: L::Simd, dir: V3<L>, to_eye: V3<L>) -> L {
        Half::new(s, dir, to_eye).pdf(s, self.clearcoat_ns, dir, self.clearcoat_width, self.open[1])
    }
}

/// The vector halfway between two unit vectors, of any length.
struct Half<L> {
    vector: V3<L>,
    to_eye: V3<L>,
    square: L,
}

impl<L: Lanes> Half<L> {
    #[inline(always)]
    fn new(s: L::Simd, to_light: V3<L>, to_eye: V3<L>) -> Self {
        // Against each other they have no middle.
        let vector = to_light + to_eye;
        Self { vector, to_eye, square: vector.dot(vector).max(L::lit(s, 1e-12)) }
    }

    /// (1 - cos)^5 of the angle between the vector and the eye or the light.
    #[inline(always)]
    fn grazing(&self, s: L::Simd) -> L {
        fifth((L::lit(s, 1.0) - self.square.sqrt() * L::lit(s, 0.5)).max(L::lit(s, 0.0)))
    }

    /// |n x h|^2 + width^2 (n.h)^2, of which GGX has the square. With |n x h|^2 in place of 1 - (n.h)^2 nothing cancels in narrow lobes.
    #[inline(always)]
    fn spread(&self, n: V3<L>, square: L) -> L {
        let (along, across) = (n.dot(self.vector), n.cross(self.vector));
        (square * along * along + across.dot(across)) / self.square
    }

    /// pi D V cos, with the distribution of GGX and Smith's shadowing.
    #[inline(always)]
    fn highlight(&self, s: L::Simd, n: V3<L>, cosine: L, width: L) -> L {
        let square = width * width;
        let spread = self.spread(n, square);
        let seen = n.dot(self.to_eye).max(L::lit(s, EDGE_ON));
        cosine * square
            / (spread * spread * (smith_denominator(s, cosine, square) * smith_denominator(s, seen, square)))
    }

    /// D G1(v) G1(l) / (4 v.n open): among the facets that neither the eye nor the light is hidden from.
    #[inline(always)]
    fn pdf(&self, s: L::Simd, n: V3<L>, to_light: V3<L>, width: L, open: L) -> L {
        self.visible_pdf(s, n, width) * smith_g1(s, n, to_light, width) / open
    }

    /// D G1(v) / (4 v.n): among the facets that are not hidden from the eye.
    #[inline(always)]
    fn visible_pdf(&self, s: L::Simd, n: V3<L>, width: L) -> L {
        let square = width * width;
        let spread = self.spread(n, square);
        let seen = n.dot(self.to_eye).max(L::lit(s, EDGE_ON));
        square / (L::lit(s, 2.0 * PI) * spread * spread * smith_denominator(s, seen, square))
    }
}

/// Smith's shadowing of GGX in one direction, of which 1 / (smith_denominator(l) smith_denominator(v)) is the whole.
#[inline(always)]
fn smith_denominator<L: Lanes>(s: L::Simd, cosine: L, square: L) -> L {
    cosine + (square + (L::lit(s, 1.0) - square) * cosine * cosine).sqrt()
}

/// The shares that are left of factors on a light's irradiance, of which all together are to be at most [`BRIGHTEST`].
#[inline(always)]
pub fn shares_of_limit<L: Lanes>(s: L::Simd, all: V3<L>) -> V3<L> {
    let (most, one) = (L::splat(s, L::Real::from_f64(BRIGHTEST)), L::lit(s, 1.0));
    V3 { x: (most / all.x).min(one), y: (most / all.y).min(one), z: (most / all.z).min(one) }
}

/// Where a factor on a light's irradiance is beyond [`BRIGHTEST`], that.
#[inline(always)]
pub fn limited<L: Lanes>(s: L::Simd, reflected: V3<L>) -> V3<L> {
    let most = L::splat(s, L::Real::from_f64(BRIGHTEST));
    V3 { x: reflected.x.min(most), y: reflected.y.min(most), z: reflected.z.min(most) }
}
