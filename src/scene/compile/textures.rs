//! The textures of a material in the kernel's format. Uniform ones become colors.

use super::materials::{exact_inverse, narrow_rgb};
use crate::lanes::Real;
use crate::math::Rgb;
use crate::scene::description::{self as d, Color, Diffuse, ImageMap, Mapping, PlanarAxes};
use crate::scene::picture_decoding::Meaning;
use crate::scene::pictures::Pictures;
use crate::shading::texture::bump::BumpMap;
use crate::shading::texture::checker::BaseColor;
use crate::shading::texture::image::ImageTexture;
use crate::shading::texture::lookup::Wrap;
use crate::shading::texture::mipmap::Mipmap;
use crate::shading::texture::noise::Fractal;
use crate::shading::texture::pattern::{Pattern, Textures};
use crate::shading::texture::uv::UvMapping;
use glam::DVec3;
use std::sync::Arc;

/// k_a, if the material has its own, k_d, and what no number can say. Patterns are their means where the kernel does not
/// look at them.
pub(super) fn textures<R: Real>(
    material: &d::Material,
    pictures: &Pictures,
) -> (Option<BaseColor<R>>, BaseColor<R>, Option<Box<Textures>>) {
    let colors = |diffuse| colors::<R>(diffuse, pictures);
    let (ambient, of_ambient) = material.ambient.as_ref().map(colors).unzip();
    let (diffuse, of_diffuse) = colors(&material.diffuse);
    let textures = Textures {
        ambient: of_ambient.flatten(),
        diffuse: of_diffuse,
        own_ambient: ambient.is_some(),
        bump: bump(material, pictures),
        clearcoat: None,
    };
    (ambient, diffuse, (!textures.is_plain()).then(|| Box::new(textures)))
}

fn colors<R: Real>(diffuse: &Diffuse, pictures: &Pictures) -> (BaseColor<R>, Option<Pattern>) {
    let between = |a: Color, b: Color, pattern: Pattern| {
        let mean = BaseColor::Uniform(narrow_rgb((a.0 + b.0) * 0.5));
        if a == b { (BaseColor::Uniform(narrow_rgb(a.0)), None) } else { (mean, Some(pattern)) }
    };
    match diffuse {
        Diffuse::Uniform(Color(color)) => (BaseColor::Uniform(narrow_rgb(*color)), None),
        Diffuse::Checker(checker) if checker.a == checker.b => (BaseColor::Uniform(narrow_rgb(checker.a.0)), None),
        Diffuse::Checker(checker) => {
            let texture = BaseColor::Checker {
                a: narrow_rgb(checker.a.0),
                b: narrow_rgb(checker.b.0),
                size: R::from_f64(checker.size),
                inverse: exact_inverse(checker.size),
                axes: checker.axes.flags(),
            };
            (texture, None)
        }
        Diffuse::Gradient(gradient) => {
            let from = DVec3::from_array(gradient.from);
            let way = DVec3::from_array(gradient.to) - from;
            let colors = [gradient.a.0.to_array(), gradient.b.0.to_array()];
            let along = way / way.length_squared();
            between(gradient.a, gradient.b, Pattern::Gradient { from, along, colors })
        }
        Diffuse::Image(image) => {
            let picture = picture(image, Meaning::Color, pictures);
            let mean = BaseColor::Uniform(narrow_rgb(Rgb::from_array(picture.mipmap.mean())));
            (mean, picture.mipmap.uniform().is_none().then_some(Pattern::Image(picture)))
        }
        Diffuse::Noise(noise) => {
            let colors = [noise.a.0.to_array(), noise.b.0.to_array()];
            let fractal = Fractal { frequency: 1.0 / noise.size, octaves: noise.octaves };
            between(noise.a, noise.b, Pattern::Noise { fractal, colors })
        }
    }
}

fn bump(material: &d::Material, pictures: &Pictures) -> Option<BumpMap> {
    if let Some(d::NormalMap { image }) = &material.normal_map {
        let picture = picture(image, Meaning::Normal, pictures);
        let flat = matches!(picture.mipmap.uniform(), Some([x, y, _]) if x == 0.0 && y == 0.0);
        return (!flat).then_some(BumpMap::Normals { picture, strength: 1.0, by_tangents: false, reframed: false });
    }
    let d::Bump { height, texture } = material.bump.as_ref()?;
    if *height == 0.0 {
        return None;
    }
    match texture {
        d::Relief::Noise(grain) => {
            let fractal = Fractal { frequency: 1.0 / grain.size, octaves: grain.octaves };
            Some(BumpMap::Noise { fractal, height: *height })
        }
        d::Relief::Image(image) => {
            let picture = picture(image, Meaning::Height, pictures);
            picture.mipmap.uniform().is_none().then_some(BumpMap::Heights { picture, height: *height })
        }
    }
}

fn picture(image: &ImageMap, meaning: Meaning, pictures: &Pictures) -> ImageTexture {
    let mipmap = pictures.get(&image.source, meaning);
    let mapping = mapping(&image.mapping, &mipmap);
    let each = wrap(image.wrap);
    // Longitude repeats, and latitude ends at the poles.
    let wrap = if matches!(mapping, UvMapping::Spherical { .. }) { [Wrap::Repeat, Wrap::Clamp] } else { [each; 2] };
    ImageTexture { mipmap, mapping, sampler: wrap.into() }
}

pub(super) fn wrap(wrap: d::Wrap) -> Wrap {
    match wrap {
        d::Wrap::Repeat => Wrap::Repeat,
        d::Wrap::Clamp => Wrap::Clamp,
        d::Wrap::Mirror => Wrap::Mirror,
    }
}

fn mapping(mapping: &Mapping, mipmap: &Arc<Mipmap>) -> UvMapping {
    match mapping {
        Mapping::Uv => UvMapping::Uv,
        Mapping::Planar(planar) => {
            let (right, up) = match planar.axes {
                PlanarAxes::Xy => (DVec3::X, DVec3::Y),
                PlanarAxes::Xz => (DVec3::X, DVec3::NEG_Z),
                PlanarAxes::Yz => (DVec3::NEG_Z, DVec3::Y),
            };
            let [width, height] = mipmap.size();
            UvMapping::Planar { right: right / planar.size, up: up / (planar.size * height / width) }
        }
        Mapping::Spherical(globe) => UvMapping::globe(DVec3::from_array(globe.center), DVec3::from_array(globe.axis)),
    }
}
