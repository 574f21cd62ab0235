//! The colours and bumps of a material in the kernel's format. What is the same everywhere becomes a number.

use super::build::{exact_inverse, narrow_rgb};
use crate::lanes::Real;
use crate::math::Rgb;
use crate::scene::color::{Color, Diffuse};
use crate::scene::description::{self as d, ImageMap, Mapping, PlanarAxes, Wrap};
use crate::scene::pictures::{Meaning, Pictures};
use crate::shading::material::Texture;
use crate::shading::texture::bump::Relief;
use crate::shading::texture::mipmap::{Edge, Pyramid};
use crate::shading::texture::noise::Fractal;
use crate::shading::texture::pattern::{Paint, Pattern, Picture};
use crate::shading::texture::uv::Chart;
use glam::DVec3;
use std::sync::Arc;

/// k_a, if the material has its own, k_d, and what no number can say. Patterns are their means where the kernel does not
/// look at them.
pub(super) fn paint<R: Real>(
    material: &d::Material,
    pictures: &Pictures<'_>,
) -> (Option<Texture<R>>, Texture<R>, Option<Box<Paint>>) {
    let colors = |diffuse| colors::<R>(diffuse, pictures);
    let (ambient, of_ambient) = material.ambient.as_ref().map(colors).unzip();
    let (diffuse, of_diffuse) = colors(&material.diffuse);
    let paint = Paint {
        ambient: of_ambient.flatten(),
        diffuse: of_diffuse,
        own_ambient: ambient.is_some(),
        relief: relief(material, pictures),
    };
    let plain = paint.ambient.is_none() && paint.diffuse.is_none() && paint.relief.is_none();
    (ambient, diffuse, (!plain).then(|| Box::new(paint)))
}

fn colors<R: Real>(diffuse: &Diffuse, pictures: &Pictures<'_>) -> (Texture<R>, Option<Pattern>) {
    let between = |a: Color, b: Color, pattern: Pattern| {
        let mean = Texture::Uniform(narrow_rgb((a.0 + b.0) * 0.5));
        if a == b { (Texture::Uniform(narrow_rgb(a.0)), None) } else { (mean, Some(pattern)) }
    };
    match diffuse {
        Diffuse::Uniform(Color(color)) => (Texture::Uniform(narrow_rgb(*color)), None),
        Diffuse::Checker(checker) if checker.a == checker.b => (Texture::Uniform(narrow_rgb(checker.a.0)), None),
        Diffuse::Checker(checker) => {
            let texture = Texture::Checker {
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
            let mean = Texture::Uniform(narrow_rgb(Rgb::from_array(picture.pyramid.mean())));
            (mean, picture.pyramid.uniform().is_none().then_some(Pattern::Image(picture)))
        }
        Diffuse::Noise(noise) => {
            let colors = [noise.a.0.to_array(), noise.b.0.to_array()];
            let fractal = Fractal { frequency: 1.0 / noise.size, octaves: noise.octaves };
            between(noise.a, noise.b, Pattern::Noise { fractal, colors })
        }
    }
}

fn relief(material: &d::Material, pictures: &Pictures<'_>) -> Option<Relief> {
    if let Some(d::NormalMap { image }) = &material.normal_map {
        let picture = picture(image, Meaning::Normal, pictures);
        let flat = matches!(picture.pyramid.uniform(), Some([x, y, _]) if x == 0.0 && y == 0.0);
        return (!flat).then_some(Relief::Normals(picture));
    }
    let d::Bump { height, texture } = material.bump.as_ref()?;
    if *height == 0.0 {
        return None;
    }
    match texture {
        d::Relief::Noise(grain) => {
            let fractal = Fractal { frequency: 1.0 / grain.size, octaves: grain.octaves };
            Some(Relief::Noise { fractal, height: *height })
        }
        d::Relief::Image(image) => {
            let picture = picture(image, Meaning::Height, pictures);
            picture.pyramid.uniform().is_none().then_some(Relief::Heights { picture, height: *height })
        }
    }
}

fn picture(image: &ImageMap, meaning: Meaning, pictures: &Pictures<'_>) -> Picture {
    let pyramid = pictures.get(&image.source, meaning);
    let chart = chart(&image.mapping, &pyramid);
    let edge = match image.wrap {
        Wrap::Repeat => Edge::Repeat,
        Wrap::Clamp => Edge::Clamp,
    };
    // Longitude has no end, and nothing lies beyond the poles.
    let edges = if matches!(chart, Chart::Spherical { .. }) { [Edge::Repeat, Edge::Clamp] } else { [edge; 2] };
    Picture { pyramid, chart, edges }
}

fn chart(mapping: &Mapping, pyramid: &Arc<Pyramid>) -> Chart {
    match mapping {
        Mapping::Uv => Chart::Uv,
        Mapping::Planar(planar) => {
            let (right, up) = match planar.axes {
                PlanarAxes::Xy => (DVec3::X, DVec3::Y),
                PlanarAxes::Xz => (DVec3::X, DVec3::NEG_Z),
                PlanarAxes::Yz => (DVec3::NEG_Z, DVec3::Y),
            };
            let [width, height] = pyramid.size();
            Chart::Planar { right: right / planar.size, up: up / (planar.size * height / width) }
        }
        Mapping::Spherical(globe) => Chart::globe(DVec3::from_array(globe.center), DVec3::from_array(globe.axis)),
    }
}
