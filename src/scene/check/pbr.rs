//! Checks of materials as in glTF.

use super::findings::Findings;
use super::path::Path;
use crate::scene::description::{Channel, Color, Factor, Material, Pbr, Textured};
use crate::scene::limits;
use crate::scene::problem::Code;

pub(super) fn check_pbr(findings: &mut Findings, at: Path<'_>, material: &Material, pbr: &Pbr) {
    let alone = Material { one_sided: material.one_sided, pbr: material.pbr.clone(), ..Material::default() };
    if *material != alone {
        let detail = "replaces all other keys of a material but one_sided: remove them, or pbr";
        findings.add(at.key("pbr"), Code::Unsupported, detail);
    }
    let at = at.key("pbr");
    for (key, color) in pbr.colors() {
        let most = if key == "base_color" { 1.0 } else { limits::MAGNITUDE };
        findings.color_channel(at.key(key), color, most);
    }
    for (key, number) in pbr.numbers() {
        findings.number_channel(at.key(key), number);
    }
    for (key, map) in pbr.normals() {
        if let Some(map) = map {
            let factor = map.factor;
            findings.number(at.key(key).key("factor"), factor, "between -100 and 100", factor.abs() <= 100.0);
            findings.textured(at.key(key), map, false);
        }
    }
    if let Some(map) = &pbr.occlusion {
        let at = at.key("occlusion");
        findings.share(at.key("factor"), map.factor);
        findings.textured(at, map, true);
    }
    if let Some(opacity) = &pbr.opacity {
        let at = at.key("opacity");
        findings.number_channel(at.key("alpha"), &opacity.alpha);
        findings.share(at.key("cutoff"), opacity.cutoff);
    }
    findings.number(at.key("ior"), pbr.ior, "between 1 and 100", (1.0..=100.0).contains(&pbr.ior));
    let spread = (pbr.ior - 1.0) / 20.0 * pbr.dispersion;
    let range = "at least 0, and (ior - 1)/20 times it at most 0.2";
    findings.number(at.key("dispersion"), pbr.dispersion, range, (0.0..=0.2).contains(&spread));
    findings.number(at.key("edge_fade"), pbr.edge_fade, "between 0 and 0.5", (0.0..=0.5).contains(&pbr.edge_fade));
    if let Some(attenuation) = &pbr.attenuation {
        let at = at.key("attenuation");
        let least = attenuation.color.0.min_element();
        let passes = least >= limits::SMALLEST_SHARE && attenuation.color.0.max_element() <= 1.0;
        let range = format!("in each channel between {:e} and 1", limits::SMALLEST_SHARE);
        findings.number(at.key("color"), least, range, passes);
        findings.length(at.key("distance"), attenuation.distance);
    }
}

impl Findings {
    fn share(&mut self, at: Path<'_>, x: f64) {
        self.number(at, x, "between 0 and 1", (0.0..=1.0).contains(&x));
    }

    fn number_channel(&mut self, at: Path<'_>, channel: &Channel<f64>) {
        match channel {
            Channel::Value(value) => self.share(at, *value),
            Channel::Textured(textured) => {
                self.share(at.key("factor"), textured.factor);
                self.textured(at, textured, true);
            }
        }
    }

    fn color_channel(&mut self, at: Path<'_>, channel: &Channel<Color>, most: f64) {
        match channel {
            Channel::Value(color) => self.color_to(at, *color, most),
            Channel::Textured(textured) => {
                self.color_to(at.key("factor"), textured.factor, most);
                self.textured(at, textured, false);
            }
        }
    }

    /// `is_number`: whether one channel of the picture counts, not all.
    fn textured<T: Factor>(&mut self, at: Path<'_>, textured: &Textured<T>, is_number: bool) {
        if textured.channel.is_some() && !is_number {
            let detail = "is for numbers: here red, green and blue count; remove it";
            self.add(at.key("channel"), Code::Unsupported, detail);
        }
        if textured.uv > 1 {
            self.add(at.key("uv"), Code::OutOfRange, format!("must be 0 or 1, is {}", textured.uv));
        }
        let (transform, max) = (textured.transform, limits::MAGNITUDE);
        let at = at.key("transform");
        for (key, pair) in [("offset", transform.offset), ("scale", transform.scale)] {
            for (i, x) in pair.into_iter().enumerate() {
                let range = format_args!("between -{max:e} and {max:e}");
                self.number(at.key(key).index(i), x, range, x.abs() <= max);
            }
        }
        let turn = transform.rotate_deg;
        self.number(at.key("rotate_deg"), turn, "between -360 and 360", turn.abs() <= 360.0);
    }
}
