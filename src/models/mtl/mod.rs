//! MTL: materials of OBJ files, by Phong's model or with the keys that PBR programs have added.

use super::Parts;
use super::budget::{Budget, LINES, worked};
use super::fault::{Fault, Kind, Subject, warn};
use super::material::{Alpha, Channel, Clearcoat, ModelMaterial, Texture};
use super::model::{Model, Picture};
use super::mtl_map::Map;
use super::parts::{Uri, uri};
use super::text::{Text, Word};
use hashbrown::HashMap;

/// Most materials and pictures of a model.
const MATERIALS: usize = 1 << 16;

/// How far numbers may be out of range: programs have single precision.
const ROUNDING: f64 = 1e-6;
const UNIT: [f64; 2] = [0.0, 1.0];
const POSITIVE: [f64; 2] = [0.0, f64::INFINITY];

/// Materials by name.
#[derive(Default)]
pub(super) struct Library {
    pub(super) materials: Vec<ModelMaterial>,
    names: HashMap<String, usize>,
    pictures: HashMap<String, Option<usize>>,
}

impl Library {
    /// The material of a name.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.names.get(name).copied()
    }

    /// Reads a file. Its faults have a place in it, and say its name.
    pub(super) fn read(
        &mut self,
        file: &str,
        bytes: &[u8],
        parts: &Parts<'_>,
        model: &mut Model,
        budget: &Budget,
    ) -> Result<(), Fault> {
        let mut text = Text::new(bytes);
        let mut phong = Phong::default();
        for line in 0_u64.. {
            if line % LINES == 0 {
                worked(LINES * 64)?;
            }
            if let Some(word) = text.word() {
                let read = self.statement(word, &mut text, &mut phong, parts, model, budget);
                read.map_err(|fault| {
                    let shown: String = file.chars().take(60).collect();
                    Fault { detail: format!("{shown}: {}", fault.detail), ..fault }
                })?;
            }
            if !text.next_line() {
                break;
            }
        }
        phong.finish(self.materials.last_mut(), model);
        Ok(())
    }

    fn statement(
        &mut self,
        word: Word<'_>,
        text: &mut Text<'_>,
        phong: &mut Phong,
        parts: &Parts<'_>,
        model: &mut Model,
        budget: &Budget,
    ) -> Result<(), Fault> {
        let key = word.text.to_ascii_lowercase();
        if key == b"newmtl" {
            std::mem::take(phong).finish(self.materials.last_mut(), model);
            if self.materials.len() >= MATERIALS {
                let detail = format!("there are more than {MATERIALS} materials");
                return Err(Fault::new("", Kind::Limit, detail).at(text.place()));
            }
            let name = text.name();
            // A comment may stand behind it.
            if let Some((plain, _)) = name.split_once(" #") {
                self.names.entry(plain.trim_end().to_owned()).or_insert(self.materials.len());
            }
            self.names.insert(name.clone(), self.materials.len());
            self.materials.push(ModelMaterial { name: Some(name), ..ModelMaterial::plain(0.8) });
            return Ok(());
        }
        // What stands before the first material belongs to none.
        if self.materials.is_empty() {
            return Ok(());
        }
        let last = self.materials.len() - 1;
        let texture = match key.as_slice() {
            b"map_kd" | b"map_d" | b"map_ke" | b"map_pr" | b"map_pm" | b"map_bump" | b"bump" | b"norm" => {
                self.texture(word, &text.name(), parts, model, budget)?
            }
            _ => None,
        };
        let material = &mut self.materials[last];
        match key.as_slice() {
            b"kd" => {
                if let Some(color) = color(text, word, model)? {
                    (phong.has_diffuse, material.base_color.factor) = (true, color);
                }
            }
            b"ks" => phong.specular = color(text, word, model)?.or(phong.specular),
            b"ns" => phong.exponent = Some(within(text, POSITIVE, word, model)?),
            b"ke" => phong.emission = color(text, word, model)?.or(phong.emission),
            b"ni" => material.ior = within(text, [1.0, 100.0], word, model)?,
            b"d" => {
                let first = text.expected("a number")?;
                // The halo, which is more opaque at the edges of a body, is left out.
                let opacity =
                    if first.text.eq_ignore_ascii_case(b"-halo") { text.number()? } else { first.number()? };
                (phong.has_dissolve, material.opacity) = (true, taken(opacity, UNIT, word, model));
            }
            b"tr" => {
                let opacity = 1.0 - within(text, UNIT, word, model)?;
                // Programs do not agree on what Tr means: of both keys d counts.
                if !phong.has_dissolve {
                    material.opacity = opacity;
                }
            }
            b"tf" => phong.filter = color(text, word, model)?.or(phong.filter),
            b"illum" => phong.model = Some(text.number()? as i64),
            b"pr" => phong.roughness = Some(within(text, UNIT, word, model)?),
            b"pm" => phong.metallic = Some(within(text, UNIT, word, model)?),
            b"pc" => phong.coat = Some(within(text, UNIT, word, model)?),
            b"pcr" => phong.coat_roughness = within(text, UNIT, word, model)?,
            b"ps" if text.number()? > 0.0 => {
                warn(&mut model.warnings, Subject::NotSimulated, "sheen", String::new(), "sheen is left out");
            }
            b"aniso" if text.number()? != 0.0 => {
                let detail = "roughness is the same in all directions";
                warn(&mut model.warnings, Subject::NotSimulated, "anisotropy", String::new(), detail);
            }
            b"map_kd" => material.base_color.texture = texture,
            b"map_ke" => material.emissive.texture = texture,
            b"map_pr" => material.roughness.texture = texture,
            b"map_pm" => material.metallic.texture = texture,
            b"norm" => material.normal = texture.map(|texture| (texture, 1.0)),
            b"map_bump" | b"bump" if texture.is_some() => {
                let detail = "bump maps of heights are left out: norm names a normal map";
                warn(&mut model.warnings, Subject::NotSimulated, "bump", String::new(), detail);
            }
            b"map_d" if texture.is_some() => {
                phong.opacity_map = texture.map(|texture| texture.picture);
            }
            b"map_ks" | b"map_ns" | b"map_tr" | b"map_opacity" | b"map_ps" | b"map_pc" | b"map_pcr" | b"map_aniso"
            | b"disp" | b"map_disp" | b"decal" | b"refl" | b"map_refl" => {
                let detail =
                    "pictures of other keys of MTL than map_Kd, map_d, map_Ke, map_Pr, map_Pm and norm are left out";
                warn(&mut model.warnings, Subject::Skipped, "texture-keys", String::new(), detail);
            }
            _ => {}
        }
        Ok(())
    }

    /// The picture of a statement. One that is missing is left out with a warning.
    fn texture(
        &mut self,
        word: Word<'_>,
        line: &str,
        parts: &Parts<'_>,
        model: &mut Model,
        budget: &Budget,
    ) -> Result<Option<Texture>, Fault> {
        let map = Map::of(line);
        if map.is_changed {
            let detail = "the options -mm and -imfchan of pictures are left out";
            warn(&mut model.warnings, Subject::Skipped, "texture-options", String::new(), detail);
        }
        let transform = map.transform();
        if let Some(detail) = transform.and_then(|transform| transform.fault()) {
            return Err(word.fault(Kind::OutOfRange, detail));
        }
        let picture = match self.pictures.get(map.name) {
            Some(known) => *known,
            None => {
                let read = self.picture(map.name, parts, model, budget)?;
                self.pictures.insert(map.name.to_owned(), read);
                read
            }
        };
        Ok(picture.map(|picture| Texture { picture, uv: 0, transform, wrap: [map.wrap; 2], nearest: false }))
    }

    /// Reads a picture; its index.
    fn picture(
        &self,
        name: &str,
        parts: &Parts<'_>,
        model: &mut Model,
        budget: &Budget,
    ) -> Result<Option<usize>, Fault> {
        let bytes = match uri(name) {
            Ok(Uri::Name(decoded)) => {
                parts(name).or_else(|why| if decoded == name { Err(why) } else { parts(&decoded) })
            }
            Ok(Uri::Data(bytes)) => Ok(bytes),
            Err(why) => Err(why),
        };
        // One file may have many names.
        budget.take(bytes.as_ref().map_or(0, Vec::len) as u64, 1)?;
        match bytes {
            Ok(_) if self.pictures.len() >= MATERIALS => skip_picture(model, name, "is one too many"),
            Ok(bytes) if super::gltf::media_type(&bytes).is_some() => {
                model.has_parts = true;
                model.pictures.push(Picture { bytes, pointer: name.chars().take(60).collect() });
                return Ok(Some(model.pictures.len() - 1));
            }
            Ok(_) => skip_picture(model, name, "is no PNG, JPEG, WebP or KTX 2.0"),
            Err(why) => skip_picture(model, name, &why),
        }
        Ok(None)
    }
}

fn skip_picture(model: &mut Model, name: &str, why: &str) {
    let shown: String = name.chars().take(60).collect();
    let detail = format!("the picture {shown:?} {why}");
    warn(&mut model.warnings, Subject::Skipped, "textures", String::new(), &detail);
}

/// A color; none if it is written in a way that is left out.
fn color(text: &mut Text<'_>, key: Word<'_>, model: &mut Model) -> Result<Option<[f64; 3]>, Fault> {
    let first = text.expected("a number")?;
    if matches!(first.text, b"spectral" | b"xyz") {
        let detail = "colors by a spectrum or by XYZ are left out";
        warn(&mut model.warnings, Subject::Skipped, "color-spectra", String::new(), detail);
        return Ok(None);
    }
    let red = taken(first.number()?, POSITIVE, key, model);
    // One number is grey.
    let Some(green) = text.word() else { return Ok(Some([red; 3])) };
    let green = taken(green.number()?, POSITIVE, key, model);
    Ok(Some([red, green, within(text, POSITIVE, key, model)?]))
}

/// The next number, as the nearest in its range.
fn within(text: &mut Text<'_>, range: [f64; 2], key: Word<'_>, model: &mut Model) -> Result<f64, Fault> {
    Ok(taken(text.number()?, range, key, model))
}

/// A number as the nearest in its range. The first that is not is named.
fn taken(number: f64, [least, most]: [f64; 2], key: Word<'_>, model: &mut Model) -> f64 {
    let taken = number.clamp(least, most);
    // Programs write an index of 0 where they have none.
    let is_unset = number == 0.0 && key.text.eq_ignore_ascii_case(b"ni");
    if (taken - number).abs() > ROUNDING && !is_unset {
        let key = key.quoted();
        let detail =
            format!("numbers of MTL out of their ranges are taken as the nearest within: {number} of {key} as {taken}");
        warn(&mut model.warnings, Subject::Assumed, "ranges", String::new(), &detail);
    }
    taken
}

/// What of Phong's model becomes something else.
#[derive(Default)]
struct Phong {
    specular: Option<[f64; 3]>,
    exponent: Option<f64>,
    roughness: Option<f64>,
    metallic: Option<f64>,
    coat: Option<f64>,
    coat_roughness: f64,
    emission: Option<[f64; 3]>,
    filter: Option<[f64; 3]>,
    /// The picture of `map_d`.
    opacity_map: Option<usize>,
    /// The illumination model.
    model: Option<i64>,
    /// Whether the material has a `Kd`.
    has_diffuse: bool,
    /// Whether the material has a `d`.
    has_dissolve: bool,
}

impl Phong {
    fn finish(self, material: Option<&mut ModelMaterial>, model: &mut Model) {
        let Some(material) = material else { return };
        // A picture that stands alone is the value.
        let alone = |texture: Option<Texture>, none: f64| if texture.is_some() { 1.0 } else { none };
        if !self.has_diffuse && material.base_color.texture.is_some() {
            material.base_color.factor = [1.0; 3];
        }
        let glow = alone(material.emissive.texture, 0.0);
        material.emissive.factor = self.emission.unwrap_or([glow; 3]);
        let metallic = self.metallic.unwrap_or_else(|| alone(material.metallic.texture, 0.0));
        material.metallic = Channel { factor: metallic, ..material.metallic };
        let is_pbr = self.roughness.or(self.metallic).is_some()
            || material.roughness.texture.or(material.metallic.texture).is_some();
        // Models 0 and 1 are diffuse.
        let is_diffuse = matches!(self.model, Some(0 | 1)) && !is_pbr;
        let has_highlight = !is_diffuse && self.specular.is_none_or(|color| color.iter().any(|channel| *channel > 0.0));
        // m = 2 / alpha^2 - 2, and alpha is the square of the roughness.
        let of_exponent = |exponent: f64| (2.0 / (exponent + 2.0)).sqrt().sqrt();
        // Glass: illumination models 4, 6, 7 and 9 trace what is seen through it.
        let is_glass = matches!(self.model, Some(4 | 6 | 7 | 9)) && material.opacity < 1.0;
        if !is_glass && material.ior <= 1.0 {
            // Programs write so where nothing is bent; it is no index of what reflects.
            material.ior = ModelMaterial::new().ior;
        }
        // What rays are to mirror is sharp unless the file says otherwise.
        let mirrors = matches!(self.model, Some(3 | 5 | 8)) && !is_pbr;
        let by_phong = self.exponent.map_or(if mirrors { 0.0 } else { 0.5 }, of_exponent);
        let roughness = self.roughness.unwrap_or_else(|| alone(material.roughness.texture, by_phong));
        material.roughness = Channel { factor: roughness, ..material.roughness };
        if let Some(coat) = self.coat.filter(|coat| *coat > 0.0) {
            let (factor, roughness) = (Channel::of(coat), Channel::of(self.coat_roughness));
            material.clearcoat = Some(Clearcoat { factor, roughness, normal: None });
        }
        if !has_highlight {
            material.specular = Channel::of(0.0);
        } else if let Some(specular) = self.specular.filter(|_| !is_pbr && !is_glass) {
            // Models 3, 5 and 8 mirror that much. For the others a half is what the index of refraction reflects, as Blender writes it.
            let by_index = ((material.ior - 1.0) / (material.ior + 1.0)).powi(2).max(1e-6);
            let whole = if mirrors { by_index } else { 0.5 };
            material.specular_color = Channel::of(specular.map(|channel| channel.clamp(0.0, 1.0) / whole));
        }
        if is_glass {
            let tint = self.filter.unwrap_or([1.0; 3]);
            material.base_color.factor = tint;
            material.transmission = Channel::of(1.0 - material.opacity);
            material.thickness = 1.0;
            material.opacity = 1.0;
        }
        // As a rule the picture of opacity is that of the color, which has an alpha channel.
        let is_own = |picture: usize| material.base_color.texture.is_some_and(|texture| texture.picture == picture);
        let has_alpha = self.opacity_map.is_some_and(is_own);
        if self.opacity_map.is_some() && !has_alpha {
            let detail = "pictures of opacity are left out, but for that of map_Kd, whose alpha channel counts";
            warn(&mut model.warnings, Subject::NotSimulated, "opacity-map", String::new(), detail);
        }
        if (material.opacity < 1.0 || has_alpha) && !is_glass {
            material.alpha = Alpha::Blend;
        }
    }
}

#[cfg(test)]
mod tests;
