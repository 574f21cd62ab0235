//! Materials of a glTF file in neutral words.

use super::super::fault::{Fault, Kind, Subject, Warning, warn};
use super::super::material::{Alpha, Attenuation, Channel, Clearcoat, ModelMaterial, Texture, Wrap};
use super::extensions::note_look;
use super::json::Document;
use super::json_materials::{Glossiness, Material, TextureInfo};

/// Reads materials.
pub(super) struct Materials<'a> {
    pub(super) document: &'a Document,
    pub(super) warnings: &'a mut Vec<Warning>,
}

impl Materials<'_> {
    /// A material.
    pub(super) fn read(&mut self, index: usize) -> Result<ModelMaterial, Fault> {
        let pointer = format!("/materials/{index}");
        let material = &self.document.materials[index];
        let (pbr, more) = (&material.pbr_metallic_roughness, &material.extensions);
        let base = pbr.base_color_factor.unwrap_or([1.0; 4]);
        let metal = self.texture(pbr.metallic_roughness_texture.as_ref())?;
        let mut read = ModelMaterial {
            name: material.name.clone(),
            base_color: self.channel([base[0], base[1], base[2]], pbr.base_color_texture.as_ref())?,
            opacity: base[3],
            alpha: alpha(material, &pointer)?,
            metallic: Channel { factor: pbr.metallic_factor.unwrap_or(1.0), texture: metal },
            roughness: Channel { factor: pbr.roughness_factor.unwrap_or(1.0), texture: metal },
            normal: self.scaled(material.normal_texture.as_ref())?,
            occlusion: self.scaled(material.occlusion_texture.as_ref())?,
            emissive: self.channel(material.emissive_factor, material.emissive_texture.as_ref())?,
            double_sided: material.double_sided,
            unlit: more.unlit.is_some(),
            ..ModelMaterial::new()
        };
        if let Some(strength) = more.emissive_strength.as_ref().and_then(|it| it.emissive_strength) {
            read.emissive.factor = read.emissive.factor.map(|channel| channel * strength);
        }
        if let Some(ior) = more.ior.as_ref().and_then(|it| it.ior) {
            // 0 stands for a reflection that is the same at all angles.
            read.ior = if ior == 0.0 { 100.0 } else { ior };
        }
        if let Some(specular) = &more.specular {
            let (factor, color) = (specular.specular_factor, specular.specular_color_factor);
            read.specular = self.channel(factor.unwrap_or(1.0), specular.specular_texture.as_ref())?;
            read.specular_color = self.channel(color.unwrap_or([1.0; 3]), specular.specular_color_texture.as_ref())?;
        }
        if let Some(it) = &more.transmission {
            read.transmission = self.channel(it.transmission_factor, it.transmission_texture.as_ref())?;
        }
        if let Some(volume) = &more.volume {
            read.thickness = volume.thickness_factor;
            let color = volume.attenuation_color.unwrap_or([1.0; 3]);
            read.attenuation = volume.attenuation_distance.map(|distance| Attenuation { color, distance });
        }
        read.dispersion = more.dispersion.as_ref().map_or(0.0, |it| it.dispersion);
        if let Some(coat) = &more.clearcoat {
            read.clearcoat = Some(Clearcoat {
                factor: self.channel(coat.clearcoat_factor, coat.clearcoat_texture.as_ref())?,
                roughness: self.channel(coat.clearcoat_roughness_factor, coat.clearcoat_roughness_texture.as_ref())?,
                normal: self.scaled(coat.clearcoat_normal_texture.as_ref())?,
            });
        }
        if let Some(glossiness) = &more.glossiness {
            self.convert(&mut read, glossiness, &pointer)?;
        }
        // By their defaults most do nothing.
        for (name, does_something) in [
            ("KHR_materials_sheen", more.sheen.as_ref().is_some_and(|it| it.sheen_color_factor != [0.0; 3])),
            ("KHR_materials_iridescence", more.iridescence.as_ref().is_some_and(|it| it.iridescence_factor != 0.0)),
            ("KHR_materials_anisotropy", more.anisotropy.as_ref().is_some_and(|it| it.anisotropy_strength != 0.0)),
            (
                "KHR_materials_diffuse_transmission",
                more.diffuse_transmission.as_ref().is_some_and(|it| it.diffuse_transmission_factor != 0.0),
            ),
            ("KHR_materials_volume_scatter", more.volume_scatter.is_some()),
        ] {
            if does_something {
                note_look(self.warnings, name, format!("{pointer}/extensions/{name}"));
            }
        }
        Ok(read)
    }

    /// The archived form by diffuse and specular color: a dielectric with that reflection.
    fn convert(&mut self, read: &mut ModelMaterial, from: &Glossiness, pointer: &str) -> Result<(), Fault> {
        let specular = from.specular_factor.unwrap_or([1.0; 3]);
        let most = specular.iter().copied().fold(0.0, f64::max).min(1.0);
        let [r, g, b, a] = from.diffuse_factor.unwrap_or([1.0; 4]);
        read.base_color =
            self.channel([r, g, b].map(|channel| channel * (1.0 - most)), from.diffuse_texture.as_ref())?;
        read.opacity = a;
        read.metallic = Channel::of(0.0);
        read.roughness = Channel::of(1.0 - from.glossiness_factor.unwrap_or(1.0));
        // That of an ior of 1.5 is 0.04.
        read.specular_color = Channel::of(specular.map(|channel| channel / 0.04));
        if from.specular_glossiness_texture.is_some() {
            let pointer = format!("{pointer}/extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture");
            let detail = "the picture of specular and glossiness is left out, and their factors stand for it";
            warn(self.warnings, Subject::Approximated, "specular-glossiness", pointer, detail);
        }
        Ok(())
    }

    fn channel<T>(&mut self, factor: T, info: Option<&TextureInfo>) -> Result<Channel<T>, Fault> {
        Ok(Channel { factor, texture: self.texture(info)? })
    }

    /// A texture with its scale or strength.
    fn scaled(&mut self, info: Option<&TextureInfo>) -> Result<Option<(Texture, f64)>, Fault> {
        let texture = self.texture(info)?;
        Ok(texture.zip(info.map(|info| info.scale.or(info.strength).unwrap_or(1.0))))
    }

    fn texture(&mut self, info: Option<&TextureInfo>) -> Result<Option<Texture>, Fault> {
        let Some(info) = info else { return Ok(None) };
        let pointer = format!("/textures/{}", info.index);
        let texture = &self.document.textures[info.index];
        // What other readers show is less compressed.
        let others = [&texture.extensions.webp, &texture.extensions.basisu];
        let other = others.into_iter().flatten().find_map(|it| it.source);
        let Some(picture) = texture.source.or(other) else {
            warn(self.warnings, Subject::Skipped, "textures", pointer, "a texture without a picture is left out");
            return Ok(None);
        };
        let sampler = texture.sampler.map(|index| &self.document.samplers[index]);
        let wrap = |code: Option<u32>| match code {
            Some(33_071) => Wrap::Clamp,
            Some(33_648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let uv = info.extensions.transform.as_ref().and_then(|it| it.tex_coord).unwrap_or(info.tex_coord);
        if uv > 1 {
            let detail = "only the texture coordinates 0 and 1 are read: others are taken as 0";
            warn(self.warnings, Subject::Approximated, "texture-coordinates", pointer, detail);
        }
        Ok(Some(Texture {
            picture,
            uv: if uv > 1 { 0 } else { uv },
            transform: info.transform(),
            wrap: [wrap(sampler.map(|it| it.wrap_s)), wrap(sampler.map(|it| it.wrap_t))],
            nearest: sampler.is_some_and(|sampler| sampler.mag_filter == Some(9_728)),
        }))
    }
}

fn alpha(material: &Material, pointer: &str) -> Result<Alpha, Fault> {
    match material.alpha_mode.as_deref() {
        None | Some("OPAQUE") => Ok(Alpha::Opaque),
        Some("MASK") => Ok(Alpha::Mask(material.alpha_cutoff.unwrap_or(0.5))),
        Some("BLEND") => Ok(Alpha::Blend),
        Some(other) => {
            let shown: String = other.chars().take(20).collect();
            let detail = format!("{shown:?} is none of OPAQUE, MASK and BLEND");
            Err(Fault::new(format!("{pointer}/alphaMode"), Kind::OutOfRange, detail))
        }
    }
}
