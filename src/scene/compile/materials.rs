//! Materials in the kernel's format.

use super::pbr;
use super::textures::textures;
use crate::lanes::Real;
use crate::math::{self, Rgb};
use crate::scene::description::{self as d, Description};
use crate::scene::pictures::Pictures;
use crate::shading::material::{Fresnel, Material};

/// `colored`: whether vertices may have an alpha of their own ([`has_colors`]).
pub(super) fn material<R: Real>(
    material: &d::Material,
    pictures: &Pictures,
    scene: &Description,
    colored: bool,
) -> Material<R> {
    if let Some(described) = &material.pbr {
        let mut material = pbr::material(described, pictures, pbr::wants_global_illumination(&scene.render));
        pbr::show_unlit(&mut material, &scene.film);
        if !colored
            && described.opacity.as_ref().is_some_and(|opacity| is_whole(opacity))
            && let Some(pbr) = &mut material.pbr
            && !pbr.catches_shadows
        {
            pbr.opacity = None;
        }
        return material;
    }
    let (ambient, diffuse, textures) = textures(material, pictures);
    Material {
        ambient,
        diffuse,
        specular: narrow_rgb(material.specular.0),
        shininess: R::from_f64(material.shininess),
        reflection: narrow_rgb(material.reflection.0),
        transmission: narrow_rgb(material.transmission.0),
        ior: R::from_f64(material.ior),
        absorption: narrow_rgb(material.absorption.0),
        emission: narrow_rgb(material.emission.0),
        fresnel: match material.fresnel {
            d::Fresnel::None => Fresnel::None,
            d::Fresnel::Dielectric => Fresnel::Dielectric,
            d::Fresnel::Conductor => Fresnel::Conductor,
        },
        alpha: R::from_f64(material.roughness * material.roughness),
        dispersion: R::from_f64(material.dispersion),
        textures,
        pbr: None,
    }
}

/// Whether all of a surface is there, as far as its material says.
fn is_whole(opacity: &d::Opacity) -> bool {
    let least = match opacity.mode {
        d::AlphaMode::Blend => 1.0,
        d::AlphaMode::Mask => opacity.cutoff.min(1.0),
    };
    matches!(opacity.alpha, d::Channel::Value(alpha) if alpha >= least)
}

/// Whether vertices of any mesh may have an alpha of their own.
pub(super) fn has_colors(scene: &Description) -> bool {
    fn any(objects: &[d::Object]) -> bool {
        objects.iter().any(|object| match object {
            d::Object::Mesh(mesh) => mesh.colors.is_some(),
            d::Object::Group(group) => any(&group.objects),
            d::Object::Model(_) => true,
            _ => false,
        })
    }
    any(&scene.objects) || scene.definitions.values().any(|objects| any(objects))
}

pub(super) fn narrow_rgb<R: Real>(color: Rgb) -> [R; 3] {
    color.to_array().map(R::from_f64)
}

/// 1/x for powers of two, whose reciprocals are exact.
pub(super) fn exact_inverse<R: Real>(x: f64) -> Option<R> {
    (math::scale_by_power(1.0, math::exponent(x)) == x).then(|| R::from_f64(1.0 / x))
}
