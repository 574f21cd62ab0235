//! Materials of a model in the form `pbr` of scenes, which has the words of glTF.

use super::shells;
use crate::math;
use crate::models::gltf::media_type;
use crate::models::{
    Alpha, Attenuation, Channel, Model, ModelMaterial, NAME_BYTES, Picture, Subject, Texture, Warning, Wrap, shortened,
};
use crate::scene::closed_mesh::is_closed;
use crate::scene::description::{
    self as d, AlphaMode, Color, Enlarged, Material, Pbr, PictureNames, TexelChannel, Textured, Wraps,
};
use crate::scene::limits::{MAGNITUDE, SMALLEST_LENGTH};
use crate::scene::named::Named;
use crate::shading::lobes::MIRROR;
use data_encoding::BASE64;
use glam::DVec3;
use std::collections::HashSet;
use std::f64::consts::PI;

/// What a material is called that has no name.
const NAMELESS: &str = "material";

/// The name by which a scene may replace a material of a model.
pub(super) fn name_of(material: &ModelMaterial) -> &str {
    material.name.as_deref().filter(|name| !name.is_empty()).unwrap_or(NAMELESS)
}

/// Gives bodies without a material the default one, which a scene may replace.
pub(super) fn add_default(model: &mut Model) {
    let nameless = model.materials.len();
    let mut lacking = model.placements.iter_mut().filter(|placement| placement.material.is_none()).peekable();
    if lacking.peek().is_some() {
        lacking.for_each(|placement| placement.material = Some(nameless));
        model.materials.push(ModelMaterial::new());
    }
}

/// Stands in a model for a material that the scene replaces: it only says whether that bends light.
pub(super) fn placeholder(name: Option<String>, replacing: &Material) -> ModelMaterial {
    let bends = match &replacing.pbr {
        Some(pbr) => !pbr.thin && pbr.transmission.factor() > 0.0,
        None => replacing.transmission.0.max_element() > 0.0,
    };
    let amount = if bends { 1.0 } else { 0.0 };
    let (transmission, roughness) = (Channel::of(amount), Channel::of(0.0));
    ModelMaterial { name, transmission, roughness, thickness: amount, ..ModelMaterial::new() }
}

/// Materials by name, and the name of each of the model's, which begins with a prefix. And what the model calls its pictures. Some
/// are `replaced` by materials of a scene.
pub(super) fn materials(
    model: &mut Model,
    prefix: &str,
    replaced: &HashSet<usize>,
    warnings: &mut Vec<Warning>,
) -> (Named<Material>, Vec<String>, PictureNames) {
    add_default(model);
    lay_pictures(model, warnings);
    let open = open_volumes(model, replaced, warnings);
    if !shells::set_apart(model, &open) {
        let detail = "closed parts of a mesh of glass are so many that they are one body: light that leaves one of them leaves all";
        warnings.push(warning(Subject::Approximated, "shells", detail));
    }
    let pictures = std::mem::take(&mut model.pictures);
    let sources: Vec<String> = pictures.iter().map(source).collect();
    let pictures = PictureNames::of(&pictures, &sources);
    let mut named = Named::default();
    let mut names = Vec::new();
    for (index, material) in model.materials.iter().enumerate() {
        let name = free_name(&named, &format!("{prefix}{}", name_of(material)));
        let pbr = Some(Box::new(pbr(material, &sources, open.contains(&index))));
        // Light must be able to leave what it has entered.
        let one_sided = !material.double_sided && material.transmission.factor <= 0.0;
        named.insert(name.clone(), Material { one_sided, pbr, ..Material::default() });
        names.push(name);
    }
    note(model, warnings);
    (named, names, pictures)
}

/// Gives meshes without the texture coordinates of a picture those of its corner, as WebGL does.
fn lay_pictures(model: &mut Model, warnings: &mut Vec<Warning>) {
    let mut any = false;
    for placement in &model.placements {
        let textures = placement.material.into_iter().flat_map(|index| model.materials[index].textures());
        let geometry = &mut model.geometries[placement.geometry];
        for texture in textures {
            geometry.uvs[texture.uv].get_or_insert_with(|| {
                any = true;
                vec![[0.0; 2]; geometry.positions.len()]
            });
        }
    }
    if any {
        let detail = "meshes without texture coordinates show one pixel of their picture, that at its corner";
        warnings.push(warning(Subject::Approximated, "no-texture-coordinates", detail));
    }
}

/// Whether nothing in the model asks for light: then its colors are what the picture is to show.
pub(super) fn is_unlit(model: &Model) -> bool {
    model.placements.iter().all(|placement| placement.material.is_some_and(|index| model.materials[index].unlit))
}

/// A name that no other material has.
pub(super) fn free_name(named: &Named<Material>, wanted: &str) -> String {
    let wanted = shortened(if wanted.is_empty() { NAMELESS } else { wanted }, NAME_BYTES);
    if !named.contains_key(&wanted) {
        return wanted;
    }
    let stem: String = wanted.chars().take(50).collect();
    let mut number = named.len() as u64;
    loop {
        let name = format!("{stem} {number}");
        if !named.contains_key(&name) {
            return name;
        }
        // If they were tried one by one, a file of such names would take hours (Knuth's linear congruential generator).
        number = number.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
    }
}

/// A picture inside of the scene, so that the scene is whole, and its id says what is in it.
fn source(picture: &Picture) -> String {
    let media_type = media_type(&picture.bytes).unwrap_or("image/png");
    format!("data:{media_type};base64,{}", BASE64.encode(&picture.bytes))
}

fn pbr(material: &ModelMaterial, sources: &[String], is_open: bool) -> Pbr {
    let number =
        |channel: &Channel<f64>, texel| of_number(channel.factor.clamp(0.0, 1.0), channel.texture, texel, sources);
    let color = |factor: [f64; 3], texture: Option<Texture>| {
        let factor = Color(DVec3::from_array(factor.map(|channel| channel.max(0.0))));
        match texture {
            Some(texture) => d::Channel::Textured(Box::new(textured(factor, texture, None, sources))),
            None => d::Channel::Value(factor),
        }
    };
    let within = |factor: [f64; 3], most: f64| factor.map(|channel| channel.min(most));
    let map = |(texture, factor): (Texture, f64)| Box::new(textured(factor, texture, None, sources));
    // Beyond that all of them lie flat.
    let bumps = |(texture, scale): (Texture, f64)| map((texture, scale.clamp(-100.0, 100.0)));
    let transmits = material.transmission.factor > 0.0;
    let thin = transmits && (material.thickness <= 0.0 || is_open);
    let attenuation = material.attenuation.filter(|_| transmits);
    let mut base_color = material.base_color.factor;
    if is_open && let Some(Attenuation { color, distance }) = attenuation {
        // Beer's law over the way that the file says a body is thick.
        let left = |channel: f64| math::pow(channel.clamp(1e-6, 1.0), material.thickness / distance);
        base_color = std::array::from_fn(|c| base_color[c] * left(color[c]));
    }
    let coat = material.clearcoat.as_ref();
    Pbr {
        base_color: color(within(base_color, 1.0), material.base_color.texture),
        metallic: number(&material.metallic, TexelChannel::B),
        roughness: number(&material.roughness, TexelChannel::G),
        normal: material.normal.map(bumps),
        occlusion: material.occlusion.map(|(texture, strength)| map((texture, strength.clamp(0.0, 1.0)))),
        // The darkest film shows what is brighter as white.
        emissive: color(within(material.emissive.factor, MAGNITUDE), material.emissive.texture),
        opacity: opacity(material, sources),
        transmission: number(&material.transmission, TexelChannel::R),
        thin,
        ior: material.ior.clamp(1.0, 100.0),
        specular: number(&material.specular, TexelChannel::A),
        specular_color: color(within(material.specular_color.factor, MAGNITUDE), material.specular_color.texture),
        // Over more than that nothing is lost that could be seen: programs write the largest number for a clear body.
        attenuation: attenuation.filter(|it| it.distance <= MAGNITUDE).map(|attenuation| d::Attenuation {
            color: Color(DVec3::from_array(attenuation.color.map(|channel| channel.clamp(1e-6, 1.0)))),
            distance: attenuation.distance.max(SMALLEST_LENGTH),
        }),
        // A thin sheet bends no light.
        dispersion: if thin { 0.0 } else { material.dispersion.min(4.0 / (material.ior - 1.0).max(1e-9)) },
        clearcoat: coat.map_or(d::Channel::Value(0.0), |coat| number(&coat.factor, TexelChannel::R)),
        clearcoat_roughness: coat.map_or(d::Channel::Value(0.0), |coat| number(&coat.roughness, TexelChannel::G)),
        clearcoat_normal: coat.and_then(|coat| coat.normal).map(bumps),
        unlit: material.unlit,
        shadow_catcher: false,
        edge_fade: 0.0,
    }
}

fn of_number(factor: f64, texture: Option<Texture>, texel: TexelChannel, sources: &[String]) -> d::Channel<f64> {
    match texture {
        Some(texture) => d::Channel::Textured(Box::new(textured(factor, texture, Some(texel), sources))),
        None => d::Channel::Value(factor),
    }
}

/// Opacity is the alpha of the base color.
fn opacity(material: &ModelMaterial, sources: &[String]) -> Option<Box<d::Opacity>> {
    let (mode, cutoff) = match material.alpha {
        Alpha::Opaque => return None,
        // No opacity is above 1, so nothing of it is seen.
        Alpha::Mask(cutoff) if cutoff > 1.0 => {
            return Some(Box::new(d::Opacity { alpha: d::Channel::Value(0.0), mode: AlphaMode::Mask, cutoff: 1.0 }));
        }
        Alpha::Mask(cutoff) => (AlphaMode::Mask, cutoff.max(0.0)),
        Alpha::Blend => (AlphaMode::Blend, 0.5),
    };
    let alpha = of_number(material.opacity.clamp(0.0, 1.0), material.base_color.texture, TexelChannel::A, sources);
    Some(Box::new(d::Opacity { alpha, mode, cutoff }))
}

fn textured<T: d::Factor>(
    factor: T,
    texture: Texture,
    channel: Option<TexelChannel>,
    sources: &[String],
) -> Textured<T> {
    let transform = texture.transform.map_or_else(d::UvTransform::default, |it| d::UvTransform {
        offset: it.offset,
        rotate_deg: (it.rotation * 180.0 / PI) % 360.0,
        scale: it.scale,
    });
    let wrap = texture.wrap.map(|wrap| match wrap {
        Wrap::Repeat => d::Wrap::Repeat,
        Wrap::Clamp => d::Wrap::Clamp,
        Wrap::Mirror => d::Wrap::Mirror,
    });
    let wrap = if wrap[0] == wrap[1] { Wraps::Both(wrap[0]) } else { Wraps::Each(wrap) };
    let enlarged = if texture.nearest { Enlarged::Nearest } else { Enlarged::Smooth };
    let image = sources[texture.picture].clone();
    Textured { factor, image, channel, uv: texture.uv as u32, transform, wrap, enlarged }
}

/// Materials that bend light, but whose surfaces do not close. They are taken as thin sheets. Seams whose ends are nearly in one place
/// are closed.
fn open_volumes(model: &mut Model, replaced: &HashSet<usize>, warnings: &mut Vec<Warning>) -> HashSet<usize> {
    let mut open = HashSet::new();
    for placement in &model.placements {
        let Some(index) = placement.material.filter(|index| !open.contains(index)) else { continue };
        let geometry = &mut model.geometries[placement.geometry];
        if !model.materials[index].bends_light() || is_closed(&geometry.positions, &geometry.triangles) {
            continue;
        }
        let welded = geometry.welded();
        if is_closed(&welded, &geometry.triangles) {
            geometry.positions = welded;
        } else {
            open.insert(index);
        }
    }
    // Those of the scene stay as they are; a warning about meshes says more.
    if !open.is_subset(replaced) {
        let detail = "glass whose surface is not closed is taken as a thin sheet, which bends no light, and absorbs as much as a way \
                      of thicknessFactor does";
        warnings.push(warning(Subject::Approximated, "open-volume", detail));
    }
    open
}

fn warning(subject: Subject, what: &'static str, detail: &str) -> Warning {
    Warning { subject, what, detail: detail.to_owned(), pointer: String::new() }
}

/// Notes what scenes cannot say.
fn note(model: &Model, warnings: &mut Vec<Warning>) {
    // Pictures and colors of vertices only take from it.
    let is_invisible = |material: &ModelMaterial| match material.alpha {
        Alpha::Opaque => false,
        Alpha::Mask(cutoff) => material.opacity < cutoff,
        Alpha::Blend => material.opacity <= 0.0,
    };
    if model.placements.iter().all(|it| it.material.is_some_and(|index| is_invisible(&model.materials[index]))) {
        let detail = "nothing is seen: all materials have an opacity of 0, or below their alphaCutoff (in MTL, Tr 1 and d 0 say so)";
        warnings.push(warning(Subject::Skipped, "invisible", detail));
    }
    let is_beyond = |color: &[f64]| color.iter().any(|channel| *channel > 1.0);
    let of_vertices = model.geometries.iter().flat_map(|geometry| &geometry.colors).flatten();
    if model.materials.iter().any(|material| is_beyond(&material.base_color.factor))
        || of_vertices.into_iter().any(|color| is_beyond(&color[..3]))
    {
        let detail = "colors above 1 are taken as 1: they go from 0 to 1, not to 255";
        warnings.push(warning(Subject::Approximated, "colors", detail));
    }
    if model.materials.iter().any(|material| material.unlit) && !is_unlit(model) {
        let detail = "beside lit materials, unlit colors of more than 226 fade, unless tone is none";
        warnings.push(warning(Subject::Approximated, "unlit", detail));
    }
}

/// What of its materials only rays can bring: said unless the fidelity is faithful.
pub(super) fn without_rays(model: &Model) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let materials = &model.materials;
    // No light passes what is all metal.
    let is_metal = |material: &ModelMaterial| material.metallic.texture.is_none() && material.metallic.factor >= 1.0;
    let is_rough = |material: &ModelMaterial| material.transmission.factor > 0.0 && material.roughness.factor > MIRROR;
    if materials.iter().any(|material| is_rough(material) && !is_metal(material)) {
        let detail = "rough glass does not spread the light that passes it, unless fidelity is faithful";
        warnings.push(warning(Subject::Approximated, "rough-glass", detail));
    }
    let most = materials.iter().flat_map(|material| material.emissive.factor).fold(0.0, f64::max);
    if most > 1.0 {
        let most = if most < 1e6 { format!("{most:.1}") } else { format!("{most:e}") };
        let detail = format!("bodies that glow (up to {most}) light nothing else, unless fidelity is faithful");
        warnings.push(warning(Subject::NotSimulated, "emissive-light", &detail));
    }
    warnings
}
