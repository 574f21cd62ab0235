//! Materials as in glTF in the kernel's format. Their coefficients are the most that they can be anywhere, so that bounds and
//! effects follow from them as from those of other materials.

use super::materials::narrow_rgb;
use super::textures::wrap;
use crate::film::ToneMapping;
use crate::lanes::Real;
use crate::math::{self, Rgb};
use crate::scene::description::{
    self as d, AlphaMode, Color, Enlarged, Factor, Fidelity, RenderSettings, TexelChannel, Textured, UvTransform,
};
use crate::scene::picture_decoding::Meaning;
use crate::scene::pictures::{Pictures, alpha_of, number_of};
use crate::shading::lobes::{CLEARCOAT, MIRROR};
use crate::shading::material::{Fresnel, Material};
use crate::shading::pbr::{Channel, Opacity, Pbr, Texel};
use crate::shading::texture::bump::BumpMap;
use crate::shading::texture::checker::BaseColor;
use crate::shading::texture::image::ImageTexture;
use crate::shading::texture::lookup::Sampler;
use crate::shading::texture::pattern::Textures;
use crate::shading::texture::uv::UvMapping;

/// Whether the settings ask for global illumination, and for rays beyond the first.
pub(super) fn wants_global_illumination(render: &RenderSettings) -> bool {
    render.fidelity == Fidelity::Faithful && render.max_depth != Some(1)
}

/// `global_illumination`: whether rays bring light to its lobes.
pub(super) fn material<R: Real>(described: &d::Pbr, pictures: &Pictures, global_illumination: bool) -> Material<R> {
    if described.shadow_catcher {
        // Nothing of it is there until a shadow falls on it, and that is black.
        let clear = d::Pbr {
            unlit: true,
            opacity: Some(Box::new(d::Opacity { alpha: d::Channel::Value(0.0), mode: AlphaMode::Blend, cutoff: 0.0 })),
            ..d::Pbr::default()
        };
        let mut material = material(&clear, pictures, false);
        material.emission = narrow_rgb(Rgb::ZERO);
        if let Some(pbr) = &mut material.pbr {
            (pbr.dark, pbr.catches_shadows, pbr.edge_fade) = (true, true, described.edge_fade);
        }
        return material;
    }
    let mut album = Album { pictures, kept: Vec::new() };
    let roughness = album.number(&described.roughness);
    let mut pbr = Pbr {
        pictures: Vec::new(),
        base_color: album.color(&described.base_color),
        metallic: album.number(&described.metallic),
        roughness,
        occlusion: album.occlusion(described.occlusion.as_deref()),
        emissive: album.color(&described.emissive),
        opacity: described.opacity.as_ref().and_then(|opacity| album.opacity(opacity)),
        transmission: album.number(&described.transmission),
        specular: album.number(&described.specular),
        specular_color: album.color(&described.specular_color),
        normal_reflectance: ((described.ior - 1.0) / (described.ior + 1.0)).powi(2),
        clearcoat: album.number(&described.clearcoat),
        clearcoat_roughness: album.number(&described.clearcoat_roughness),
        unlit: described.unlit,
        undone: None,
        dark: false,
        catches_shadows: false,
        edge_fade: 0.0,
    };
    let [bump, clearcoat] = described.normals().map(|(_, normals)| {
        let normals = normals.filter(|normals| normals.factor != 0.0 && !pbr.unlit)?;
        let picture = album.picture(normals, Meaning::Normal);
        let flat = matches!(picture.mipmap.uniform(), Some([x, y, _]) if x == 0.0 && y == 0.0);
        let by_tangents = described.takes_tangents(normals);
        (!flat).then_some(BumpMap::Normals { picture, strength: normals.factor, by_tangents, reframed: true })
    });
    pbr.pictures = album.kept.into_iter().map(|(_, picture)| picture).collect();
    let most = Most::of(&pbr);
    let clearcoat = clearcoat.filter(|_| most.most(&pbr.clearcoat) > 0.0);
    let textures = Textures { bump, clearcoat, ..Textures::default() };
    let textures = (!textures.is_plain()).then(|| Box::new(textures));
    let white = |on: bool| narrow_rgb(if on { Rgb::ONE } else { Rgb::ZERO });
    let (mirrors, passing) = (most.mirrors(&pbr) || (global_illumination && !pbr.unlit), most.passing(&pbr));
    let rough = if global_illumination && !pbr.unlit { most.most(&pbr.roughness).powi(2) } else { 0.0 };
    Material {
        ambient: Some(BaseColor::Uniform(white(!pbr.unlit))),
        diffuse: BaseColor::Uniform(narrow_rgb(most.scattered(&pbr))),
        specular: white(!pbr.unlit),
        shininess: R::from_f64(0.0),
        reflection: white(mirrors),
        transmission: narrow_rgb(passing),
        ior: R::from_f64(described.ior),
        alpha: R::from_f64(rough),
        dispersion: R::from_f64(if described.thin { 0.0 } else { (described.ior - 1.0) * described.dispersion / 20.0 }),
        absorption: described.attenuation.filter(|_| !described.thin).map_or([R::from_f64(0.0); 3], absorption),
        emission: narrow_rgb(if pbr.unlit { most.base } else { most.emissive }),
        fresnel: if mirrors || passing.max_element() > 0.0 { Fresnel::Layered } else { Fresnel::None },
        textures,
        pbr: Some(Box::new(pbr)),
    }
}

/// Makes what is unlit so bright that the film shows its colors as they are: exactly those that its tone curve does not compress.
pub(super) fn show_unlit<R: Real>(material: &mut Material<R>, film: &d::Film) {
    let Some(pbr) = material.pbr.as_mut().filter(|pbr| pbr.unlit && !pbr.dark) else { return };
    if film.tone == ToneMapping::KhronosPbrNeutral {
        let gain = math::pow(2.0, -film.exposure);
        pbr.undone = Some(gain);
        // At most 0.04 is added to any color.
        material.emission = narrow_rgb((Most::of(pbr).base + 0.04) * gain);
    }
}

/// sigma of the law of Beer and Lambert: e^(-sigma distance) is the color.
fn absorption<R: Real>(d::Attenuation { color, distance }: d::Attenuation) -> [R; 3] {
    let natural = |x: f64| math::log2(x) * std::f64::consts::LN_2;
    color.0.to_array().map(|share| R::from_f64((-natural(share) / distance).max(0.0)))
}

/// A picture and how it is laid on a surface.
type Laid = (String, Meaning, u32, UvTransform, d::Wraps, Enlarged);

/// The pictures of a material, each once.
struct Album<'a> {
    pictures: &'a Pictures,
    kept: Vec<(Laid, ImageTexture)>,
}

impl Album<'_> {
    fn picture<T: Factor>(&self, textured: &Textured<T>, meaning: Meaning) -> ImageTexture {
        let mipmap = self.pictures.get(&textured.image, meaning);
        ImageTexture {
            mipmap,
            mapping: mapping(textured.uv, &textured.transform),
            sampler: Sampler { wrap: textured.wrap.each().map(wrap), nearest: textured.enlarged == Enlarged::Nearest },
        }
    }

    /// The index of a picture, which is kept.
    fn index<T: Factor>(&mut self, textured: &Textured<T>, meaning: Meaning) -> usize {
        let key = (textured.image.clone(), meaning, textured.uv, textured.transform, textured.wrap, textured.enlarged);
        if let Some(known) = self.kept.iter().position(|(known, _)| *known == key) {
            return known;
        }
        let picture = self.picture(textured, meaning);
        self.kept.push((key, picture));
        self.kept.len() - 1
    }

    fn color(&mut self, channel: &d::Channel<Color>) -> Channel<[f64; 3]> {
        let factor = channel.factor().0.to_array();
        let Some(textured) = channel.textured() else { return Channel { factor, texel: None } };
        match self.pictures.get(&textured.image, Meaning::Color).uniform() {
            Some(texel) => Channel { factor: std::array::from_fn(|c| factor[c] * texel[c]), texel: None },
            None => {
                let picture = self.index(textured, Meaning::Color);
                Channel { factor, texel: Some(Texel { picture, channel: 0 }) }
            }
        }
    }

    fn number(&mut self, channel: &d::Channel<f64>) -> Channel<f64> {
        match channel.textured() {
            Some(textured) => self.lookup(textured, part(textured)),
            None => Channel { factor: channel.factor(), texel: None },
        }
    }

    fn lookup(&mut self, textured: &Textured<f64>, (meaning, channel): (Meaning, usize)) -> Channel<f64> {
        let factor = textured.factor;
        match self.pictures.get(&textured.image, meaning).uniform() {
            Some(texel) => Channel { factor: factor * texel[channel], texel: None },
            None => Channel { factor, texel: Some(Texel { picture: self.index(textured, meaning), channel }) },
        }
    }

    fn occlusion(&mut self, textured: Option<&Textured<f64>>) -> Channel<f64> {
        let Some(textured) = textured.filter(|textured| textured.factor > 0.0) else {
            return Channel { factor: 0.0, texel: None };
        };
        let (meaning, channel) = part(textured);
        let picture = self.index(textured, meaning);
        Channel { factor: textured.factor, texel: Some(Texel { picture, channel }) }
    }

    fn opacity(&mut self, opacity: &d::Opacity) -> Option<Opacity> {
        let cutoff = (opacity.mode == AlphaMode::Mask).then_some(opacity.cutoff);
        let alpha = match opacity.alpha.textured() {
            Some(textured) => self.lookup(textured, (alpha_of(opacity, textured), 0)),
            None => Channel { factor: opacity.alpha.factor(), texel: None },
        };
        // All of it is there if every alpha is large enough.
        (cutoff != Some(0.0)).then_some(Opacity { alpha, cutoff })
    }
}

/// The meaning of a number's picture, and the channel that it then is.
fn part(textured: &Textured<f64>) -> (Meaning, usize) {
    let channel = match textured.channel.unwrap_or_default() {
        TexelChannel::R | TexelChannel::A => 0,
        TexelChannel::G => 1,
        TexelChannel::B => 2,
    };
    (number_of(textured), channel)
}

/// With v down, from the upper left corner: scaled, rotated, moved (KHR_texture_transform).
fn mapping(uv: u32, transform: &UvTransform) -> UvMapping {
    if uv == 0 && *transform == UvTransform::default() {
        return UvMapping::Uv;
    }
    let (sin, cos) = math::sin_cos(transform.rotate_deg.to_radians());
    let ([across, down], [right, below]) = (transform.scale, transform.offset);
    let rows = [[cos * across, -sin * down], [sin * across, cos * down]];
    UvMapping::Moved { second: uv == 1, rows, offset: [sin * down + right, 1.0 - cos * down - below] }
}

/// The largest, the smallest and the middle values of channels.
struct Most<'a> {
    pictures: &'a [ImageTexture],
    base: Rgb,
    emissive: Rgb,
}

impl<'a> Most<'a> {
    fn of(pbr: &'a Pbr) -> Self {
        let brightest = |channel: &Channel<[f64; 3]>| {
            let texel = channel.texel.map_or(Rgb::ONE, |t| Rgb::from_array(pbr.pictures[t.picture].mipmap.brightest()));
            Rgb::from_array(channel.factor) * texel
        };
        Self { pictures: &pbr.pictures, base: brightest(&pbr.base_color), emissive: brightest(&pbr.emissive) }
    }

    fn most(&self, channel: &Channel<f64>) -> f64 {
        channel.factor * channel.texel.map_or(1.0, |t| self.pictures[t.picture].mipmap.brightest()[t.channel])
    }

    fn least(&self, channel: &Channel<f64>) -> f64 {
        channel.factor * channel.texel.map_or(1.0, |t| self.pictures[t.picture].mipmap.darkest()[t.channel])
    }

    fn mean(&self, channel: &Channel<f64>) -> f64 {
        channel.factor * channel.texel.map_or(1.0, |t| self.pictures[t.picture].mipmap.mean()[t.channel])
    }

    fn scattered(&self, pbr: &Pbr) -> Rgb {
        if pbr.unlit {
            return Rgb::ZERO;
        }
        self.base * ((1.0 - self.least(&pbr.metallic)) * (1.0 - self.least(&pbr.transmission)))
    }

    /// Whether a mirror ray may be followed: the surface or the clearcoat is smooth somewhere.
    fn mirrors(&self, pbr: &Pbr) -> bool {
        let smooth = self.least(&pbr.roughness) <= MIRROR - 0.5 * MIRROR * self.least(&pbr.metallic);
        let clearcoated = self.most(&pbr.clearcoat) > 0.0 && self.least(&pbr.clearcoat_roughness) < CLEARCOAT[1];
        !pbr.unlit && (smooth || clearcoated)
    }

    /// The mean of what passes. It is what shadow rays keep at one crossing, and 0 only where nothing passes anywhere.
    fn passing(&self, pbr: &Pbr) -> Rgb {
        let most = self.most(&pbr.transmission) * (1.0 - self.least(&pbr.metallic));
        if pbr.unlit || most <= 0.0 {
            return Rgb::ZERO;
        }
        let mean = self.mean(&pbr.transmission) * (1.0 - self.mean(&pbr.metallic));
        let base = pbr.base_color.texel.map_or(Rgb::ONE, |t| Rgb::from_array(self.pictures[t.picture].mipmap.mean()));
        Rgb::from_array(pbr.base_color.factor) * base * mean
    }
}
