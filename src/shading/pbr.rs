//! Materials as in glTF 2.0 (appendix B and its extensions): their channels at the points that rays hit.

use super::texture::image::{ImageTexture, Lookup};
use crate::film::taken_by_khronos_pbr_neutral;
use crate::lanes::{Double, Lanes, V3};
use smallvec::SmallVec;

/// A material of metal and of what is none, in double precision: few numbers, and pictures.
#[derive(Debug, Clone)]
pub struct Pbr {
    /// The pictures of its channels, each once.
    pub pictures: Vec<ImageTexture>,
    /// Color of what is scattered, or of a metal's reflection.
    pub base_color: Channel<[f64; 3]>,
    /// 1 for metals.
    pub metallic: Channel<f64>,
    /// Square root of the width of the GGX distribution.
    pub roughness: Channel<f64>,
    /// Strength of a picture of occlusion.
    pub occlusion: Channel<f64>,
    /// Emitted radiance.
    pub emissive: Channel<[f64; 3]>,
    /// How much of it is there.
    pub opacity: Option<Opacity>,
    /// Share of the light that is not mirrored and passes.
    pub transmission: Channel<f64>,
    /// Strength of a dielectric's reflection.
    pub specular: Channel<f64>,
    /// Its color at normal incidence.
    pub specular_color: Channel<[f64; 3]>,
    /// Reflectance of a dielectric at normal incidence, ((ior - 1)/(ior + 1))^2.
    pub normal_reflectance: f64,
    /// Strength of the clearcoat.
    pub clearcoat: Channel<f64>,
    /// Its roughness.
    pub clearcoat_roughness: Channel<f64>,
    /// Whether it shows its color and nothing else.
    pub unlit: bool,
    /// What its color is multiplied with if it is unlit, so that a film with Khronos PBR Neutral shows it as it is.
    pub undone: Option<f64>,
    /// Whether it emits nothing, not even if it is unlit.
    pub dark: bool,
    /// Whether it is there only where bodies hide lights from it.
    pub catches_shadows: bool,
    /// The border of the picture in which the shadows that it catches fade, as a share of the picture.
    pub edge_fade: f64,
}

/// A factor, and the texel that it multiplies.
#[derive(Debug, Clone, Copy)]
pub struct Channel<T> {
    /// The factor.
    pub factor: T,
    /// The texel, if a picture has it.
    pub texel: Option<Texel>,
}

/// Where a texel is.
#[derive(Debug, Clone, Copy)]
pub struct Texel {
    /// Index of the picture.
    pub picture: usize,
    /// Its channel, of numbers.
    pub channel: usize,
}

/// How much of a surface is there.
#[derive(Debug, Clone, Copy)]
pub struct Opacity {
    /// The share.
    pub alpha: Channel<f64>,
    /// The least alpha at which all of it is there, and none below; otherwise the share itself counts.
    pub cutoff: Option<f64>,
}

/// How many numbers [`Parameters`] are.
pub const NUMBERS: usize = 19;

/// The channels at some points.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "as in Pbr")]
pub struct Parameters<L> {
    pub base_color: V3<L>,
    pub specular_color: V3<L>,
    pub emissive: V3<L>,
    pub metallic: L,
    pub roughness: L,
    /// The share of the light from all around that arrives.
    pub occlusion: L,
    pub opacity: L,
    pub transmission: L,
    pub specular: L,
    pub normal_reflectance: L,
    pub clearcoat: L,
    pub clearcoat_roughness: L,
    /// 1 if it is lit, otherwise 0.
    pub lit: L,
}

/// What pictures show at some points.
type Texels<W> = SmallVec<[V3<W>; 6]>;

impl Pbr {
    /// Whether light may go straight through.
    pub fn has_holes(&self) -> bool {
        self.opacity.is_some()
    }

    /// One that emits radiance 1 where this one is there, and does nothing else.
    #[must_use]
    pub fn shining(&self) -> Self {
        let (none, black) = (Channel { factor: 0.0, texel: None }, Channel { factor: [0.0; 3], texel: None });
        Self {
            pictures: self.pictures.clone(),
            base_color: black,
            metallic: none,
            roughness: none,
            occlusion: none,
            emissive: Channel { factor: [1.0; 3], texel: None },
            opacity: self.opacity,
            transmission: none,
            specular: none,
            specular_color: black,
            normal_reflectance: 0.0,
            clearcoat: none,
            clearcoat_roughness: none,
            unlit: false,
            undone: None,
            dark: false,
            catches_shadows: false,
            edge_fade: 0.0,
        }
    }

    /// Puts means in the place of pictures.
    pub fn forget_pictures(&mut self) {
        let means: Vec<[f64; 3]> = self.pictures.iter().map(|picture| picture.mipmap.mean()).collect();
        for channel in [&mut self.base_color, &mut self.emissive, &mut self.specular_color] {
            if let Some(texel) = channel.texel.take() {
                channel.factor = std::array::from_fn(|c| channel.factor[c] * means[texel.picture][c]);
            }
        }
        let alpha = self.opacity.as_mut().map(|opacity| &mut opacity.alpha);
        let numbers = [
            &mut self.metallic,
            &mut self.roughness,
            &mut self.transmission,
            &mut self.specular,
            &mut self.clearcoat,
            &mut self.clearcoat_roughness,
        ];
        for channel in numbers.into_iter().chain(alpha) {
            if let Some(texel) = channel.texel.take() {
                channel.factor *= means[texel.picture][texel.channel];
            }
        }
        self.occlusion.texel = None;
        self.pictures = Vec::new();
    }

    /// Bytes of memory it takes beside its pictures.
    pub fn bytes(&self) -> usize {
        size_of_val(self) + size_of_val(&self.pictures[..])
    }

    /// The channels where rays hit.
    #[inline(always)]
    pub fn at<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>) -> Parameters<W> {
        let texels = self.texels(s, lookup);
        let number = |channel: &Channel<f64>| number(s, channel, &texels);
        let [red, green, blue, alpha] = colors_of_vertices(s, lookup);
        let tint = V3 { x: red, y: green, z: blue };
        let base_color = color(s, &self.base_color, &texels).times(tint);
        let (zero, one) = (W::lit(s, 0.0), W::lit(s, 1.0));
        let occlusion = match self.occlusion.texel {
            Some(texel) => one + W::lit(s, self.occlusion.factor) * (component(&texels, texel) - one),
            // What catches shadows shows only this much of them.
            None if self.catches_shadows => alpha,
            None => one,
        };
        let black = V3 { x: zero, y: zero, z: zero };
        let emissive = match (self.dark, self.unlit) {
            (true, _) => black,
            (false, true) => match self.undone {
                Some(gain) => {
                    let least = base_color.x.min(base_color.y).min(base_color.z);
                    let added = taken_by_khronos_pbr_neutral(s, least);
                    (base_color + V3 { x: added, y: added, z: added }) * W::lit(s, gain)
                }
                None => base_color,
            },
            (false, false) => color(s, &self.emissive, &texels),
        };
        Parameters {
            base_color,
            specular_color: color(s, &self.specular_color, &texels),
            emissive,
            metallic: number(&self.metallic),
            roughness: number(&self.roughness),
            occlusion,
            opacity: self.opacity_of(s, lookup, &texels, alpha),
            transmission: number(&self.transmission),
            specular: number(&self.specular),
            normal_reflectance: W::lit(s, self.normal_reflectance),
            clearcoat: number(&self.clearcoat),
            clearcoat_roughness: number(&self.clearcoat_roughness),
            lit: if self.unlit { zero } else { one },
        }
    }

    /// How much of the surface is there where rays hit, and the share of light that passes what is there.
    #[inline(always)]
    pub fn passage<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>) -> (W, V3<W>) {
        let texels = self.texels(s, lookup);
        let [red, green, blue, alpha] = colors_of_vertices(s, lookup);
        let one = W::lit(s, 1.0);
        let passes = number(s, &self.transmission, &texels) * (one - number(s, &self.metallic, &texels));
        let color = color(s, &self.base_color, &texels).times(V3 { x: red, y: green, z: blue });
        (self.opacity_of(s, lookup, &texels, alpha), color * passes)
    }

    #[inline(always)]
    fn texels<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>) -> Texels<W> {
        let mut texels = Texels::new();
        for picture in &self.pictures {
            texels.push(picture.at(s, lookup));
        }
        texels
    }

    /// How much of the surface is there; `of_mesh` is the alpha of the mesh.
    #[inline(always)]
    fn opacity_of<W: Double>(&self, s: W::Simd, lookup: &Lookup<W>, texels: &Texels<W>, of_mesh: W) -> W {
        let (zero, one) = (W::lit(s, 0.0), W::lit(s, 1.0));
        let Some(Opacity { alpha: channel, cutoff }) = &self.opacity else { return one };
        let alpha = (number(s, channel, texels) * of_mesh).max(zero).min(one);
        let Some(cutoff) = cutoff else { return alpha };
        let all_or_nothing = W::select(alpha.ge(W::lit(s, *cutoff)), one, zero);
        let Some(texel) = channel.texel else { return all_or_nothing };
        // A mean of many alphas may be below the cutoff where some are above: leaves would vanish in the distance.
        // Shares know nothing of the mesh, so where it has alpha of its own the mean decides as ever.
        let shared = self.pictures[texel.picture].sees_several(s, lookup) & of_mesh.eq(one);
        W::select(shared, texels[texel.picture].y, all_or_nothing)
    }
}

#[inline(always)]
fn colors_of_vertices<W: Double>(s: W::Simd, lookup: &Lookup<W>) -> [W; 4] {
    // Not by `and_then`, which became a function of its own.
    let colors = match &lookup.face {
        Some(face) => face.colors(s, lookup.point),
        None => None,
    };
    colors.unwrap_or([W::lit(s, 1.0); 4])
}

#[inline(always)]
fn component<W: Double>(texels: &Texels<W>, Texel { picture, channel }: Texel) -> W {
    let V3 { x, y, z } = texels[picture];
    [x, y, z][channel]
}

#[inline(always)]
fn number<W: Double>(s: W::Simd, channel: &Channel<f64>, texels: &Texels<W>) -> W {
    let factor = W::lit(s, channel.factor);
    match channel.texel {
        Some(texel) => factor * component(texels, texel),
        None => factor,
    }
}

#[inline(always)]
fn color<W: Double>(s: W::Simd, channel: &Channel<[f64; 3]>, texels: &Texels<W>) -> V3<W> {
    let factor = V3::splat(s, channel.factor);
    match channel.texel {
        Some(texel) => factor.times(texels[texel.picture]),
        None => factor,
    }
}

impl<L: Lanes> Parameters<L> {
    /// One after the other.
    #[inline(always)]
    pub fn to_numbers(self) -> [L; NUMBERS] {
        let (b, c, e) = (self.base_color, self.specular_color, self.emissive);
        [
            b.x,
            b.y,
            b.z,
            c.x,
            c.y,
            c.z,
            e.x,
            e.y,
            e.z,
            self.metallic,
            self.roughness,
            self.occlusion,
            self.opacity,
            self.transmission,
            self.specular,
            self.normal_reflectance,
            self.clearcoat,
            self.clearcoat_roughness,
            self.lit,
        ]
    }

    /// The inverse of [`Self::to_numbers`].
    #[inline(always)]
    pub fn of_numbers(n: [L; NUMBERS]) -> Self {
        let vector = |i: usize| V3 { x: n[i], y: n[i + 1], z: n[i + 2] };
        Self {
            base_color: vector(0),
            specular_color: vector(3),
            emissive: vector(6),
            metallic: n[9],
            roughness: n[10],
            occlusion: n[11],
            opacity: n[12],
            transmission: n[13],
            specular: n[14],
            normal_reflectance: n[15],
            clearcoat: n[16],
            clearcoat_roughness: n[17],
            lit: n[18],
        }
    }
}
