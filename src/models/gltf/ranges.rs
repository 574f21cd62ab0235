//! Numbers beyond the ranges that the specification gives them, and keys that exclude each other. Files with them are wrong, but what
//! they mean can be told: numbers are taken as the nearest in range. It is said what stands for what.

use super::super::fault::{Subject, Warning, warn};
use super::json::{Camera, Document, Light, Node};
use super::json_materials::Material;
use glam::DQuat;
use std::f64::consts::FRAC_PI_2;
use std::slice::from_mut;

/// Numbers that the warning names.
const SHOWN: usize = 3;
/// How far the length of a rotation may be from 1.
const TURNED: f64 = 1e-3;
/// How far other numbers may be out of range: files have single precision.
const ROUNDING: f64 = 1e-6;

const UNIT: [f64; 2] = [0.0, 1.0];
const POSITIVE: [f64; 2] = [0.0, f64::INFINITY];
/// Angles of spots, in radians.
const CONES: [f64; 2] = [1e-4, FRAC_PI_2];

/// Mends a file whose references have been checked; the warnings say what was wrong.
pub(super) fn mend(document: &mut Document) -> Vec<Warning> {
    let (mut warnings, mut ranges) = (Vec::new(), Ranges::default());
    for (i, material) in document.materials.iter_mut().enumerate() {
        ranges.material(i, material);
    }
    for (i, light) in document.lights.iter_mut().enumerate() {
        ranges.light(i, light);
    }
    for (i, camera) in document.cameras.iter_mut().enumerate() {
        ranges.camera(i, camera, &mut warnings);
    }
    for (i, node) in document.nodes.iter().enumerate() {
        check_node(i, node, &mut warnings);
    }
    ranges.tell(&mut warnings);
    warnings
}

/// The numbers that were out of range.
#[derive(Default)]
struct Ranges {
    /// The pointer of the first.
    first: String,
    shown: Vec<String>,
    count: usize,
}

impl Ranges {
    /// Takes numbers of an element of a list as the nearest in their range.
    fn take(&mut self, list: &str, index: usize, key: &str, numbers: &mut [f64], [least, most]: [f64; 2]) {
        let is_list = numbers.len() > 1;
        for (c, number) in numbers.iter_mut().enumerate().filter(|(_, number)| !(least..=most).contains(*number)) {
            let (says, taken) = (*number, number.clamp(least, most));
            let off = (says - taken).abs();
            *number = taken;
            if off <= ROUNDING * taken.abs().max(1.0) {
                continue;
            }
            let at = if is_list { format!("{list}/{index}/{key}/{c}") } else { format!("{list}/{index}/{key}") };
            self.note(at, &format!("is {says} and taken as {taken}"));
        }
    }

    /// Forgets a number that has to be above 0 and is not.
    fn take_positive(&mut self, list: &str, index: usize, key: &str, number: &mut Option<f64>) {
        if let Some(wrong) = number.take_if(|number| *number <= 0.0) {
            self.note(format!("{list}/{index}/{key}"), &format!("is {wrong} and left out"));
        }
    }

    fn note(&mut self, pointer: String, what: &str) {
        if self.count < SHOWN {
            self.shown.push(format!("{pointer} {what}"));
        }
        if self.count == 0 {
            self.first = pointer;
        }
        self.count += 1;
    }

    fn tell(self, warnings: &mut Vec<Warning>) {
        if self.count > 0 {
            let more = self.count - self.shown.len();
            let more = if more > 0 { format!(", and {more} more") } else { String::new() };
            let detail = format!("numbers out of the ranges of glTF: {}{more}", self.shown.join(", "));
            warn(warnings, Subject::Assumed, "ranges", self.first, &detail);
        }
    }

    /// Colors above 1 have a warning of their own, and what glows was brighter than 1 before there was an extension for it.
    fn material(&mut self, index: usize, material: &mut Material) {
        const LIST: &str = "/materials";
        let mut take = |key: &str, numbers: &mut [f64], range| self.take(LIST, index, key, numbers, range);
        let (pbr, more) = (&mut material.pbr_metallic_roughness, &mut material.extensions);
        if let Some([color @ .., opacity]) = &mut pbr.base_color_factor {
            take("pbrMetallicRoughness/baseColorFactor", color, POSITIVE);
            take("pbrMetallicRoughness/baseColorFactor/3", from_mut(opacity), UNIT);
        }
        take("pbrMetallicRoughness/metallicFactor", pbr.metallic_factor.as_mut_slice(), UNIT);
        take("pbrMetallicRoughness/roughnessFactor", pbr.roughness_factor.as_mut_slice(), UNIT);
        take("emissiveFactor", &mut material.emissive_factor, POSITIVE);
        take("alphaCutoff", material.alpha_cutoff.as_mut_slice(), POSITIVE);
        if let Some(occlusion) = &mut material.occlusion_texture {
            take("occlusionTexture/strength", occlusion.strength.as_mut_slice(), UNIT);
        }
        if let Some(it) = &mut more.emissive_strength {
            let key = "extensions/KHR_materials_emissive_strength/emissiveStrength";
            take(key, it.emissive_strength.as_mut_slice(), POSITIVE);
        }
        // 0 has a meaning of its own.
        if let Some(ior) = more.ior.as_mut().and_then(|it| it.ior.as_mut()).filter(|ior| **ior != 0.0) {
            take("extensions/KHR_materials_ior/ior", from_mut(ior), [1.0, f64::INFINITY]);
        }
        if let Some(it) = &mut more.specular {
            take("extensions/KHR_materials_specular/specularFactor", it.specular_factor.as_mut_slice(), UNIT);
            let color = it.specular_color_factor.as_mut_slice().as_flattened_mut();
            take("extensions/KHR_materials_specular/specularColorFactor", color, POSITIVE);
        }
        if let Some(it) = &mut more.transmission {
            let key = "extensions/KHR_materials_transmission/transmissionFactor";
            take(key, from_mut(&mut it.transmission_factor), UNIT);
        }
        if let Some(it) = &mut more.dispersion {
            take("extensions/KHR_materials_dispersion/dispersion", from_mut(&mut it.dispersion), POSITIVE);
        }
        if let Some(it) = &mut more.clearcoat {
            take("extensions/KHR_materials_clearcoat/clearcoatFactor", from_mut(&mut it.clearcoat_factor), UNIT);
            let key = "extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor";
            take(key, from_mut(&mut it.clearcoat_roughness_factor), UNIT);
        }
        if let Some(it) = &mut more.glossiness {
            for (key, numbers) in [
                ("diffuseFactor", it.diffuse_factor.as_mut_slice().as_flattened_mut()),
                ("specularFactor", it.specular_factor.as_mut_slice().as_flattened_mut()),
                ("glossinessFactor", it.glossiness_factor.as_mut_slice()),
            ] {
                take(&format!("extensions/KHR_materials_pbrSpecularGlossiness/{key}"), numbers, UNIT);
            }
        }
        if let Some(it) = &mut more.volume {
            take("extensions/KHR_materials_volume/thicknessFactor", from_mut(&mut it.thickness_factor), POSITIVE);
            let color = it.attenuation_color.as_mut_slice().as_flattened_mut();
            take("extensions/KHR_materials_volume/attenuationColor", color, UNIT);
            let key = "extensions/KHR_materials_volume/attenuationDistance";
            self.take_positive(LIST, index, key, &mut it.attenuation_distance);
        }
    }

    fn light(&mut self, index: usize, light: &mut Light) {
        const LIST: &str = "/extensions/KHR_lights_punctual/lights";
        self.take(LIST, index, "color", &mut light.color, POSITIVE);
        self.take(LIST, index, "intensity", from_mut(&mut light.intensity), POSITIVE);
        self.take_positive(LIST, index, "range", &mut light.range);
        let spot = &mut light.spot;
        self.take(LIST, index, "spot/outerConeAngle", from_mut(&mut spot.outer_cone_angle), CONES);
        let inner = [0.0, spot.outer_cone_angle];
        self.take(LIST, index, "spot/innerConeAngle", from_mut(&mut spot.inner_cone_angle), inner);
    }

    fn camera(&mut self, index: usize, camera: &mut Camera, warnings: &mut Vec<Warning>) {
        if let Some(camera) = &mut camera.perspective {
            self.take_positive("/cameras", index, "perspective/aspectRatio", &mut camera.aspect_ratio);
        }
        if camera.perspective.is_some() && camera.orthographic.is_some() {
            let detail = "a camera that is perspective and orthographic is taken as perspective";
            warn(warnings, Subject::Assumed, "cameras", format!("/cameras/{index}"), detail);
        }
    }
}

fn check_node(index: usize, node: &Node, warnings: &mut Vec<Warning>) {
    let mut assumed = |what: &'static str, key: &str, detail: &str| {
        warn(warnings, Subject::Assumed, what, format!("/nodes/{index}/{key}"), detail);
    };
    if let Some(matrix) = &node.matrix {
        if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
            assumed(
                "matrix",
                "matrix",
                "of nodes that have a matrix, and a translation, rotation or scale beside it, the matrix counts",
            );
        }
        let off = [matrix[3], matrix[7], matrix[11], matrix[15] - 1.0];
        if off.iter().any(|off| off.abs() > ROUNDING) {
            assumed("last-row", "matrix", "the last row of a node's matrix is taken as 0 0 0 1");
        }
    }
    if node.rotation.is_some_and(|it| (DQuat::from_array(it).length() - 1.0).abs() > TURNED) {
        assumed(
            "rotation",
            "rotation",
            "a rotation whose length is not 1 is scaled to it; one of length 0 turns nothing",
        );
    }
}

#[cfg(test)]
mod tests {
    use super::super::json_read::read;
    use super::*;

    fn warnings(text: &str) -> Vec<String> {
        let text = format!("{{\"asset\": {{\"version\": \"2.0\"}}, {text}}}");
        mend(&mut read(text.as_bytes()).unwrap())
            .iter()
            .map(|warning| format!("{} {warning}", warning.pointer))
            .collect()
    }

    #[test]
    fn numbers_out_of_range_are_named() {
        let pbr = |text: &str| format!("\"materials\": [{{}}, {{\"pbrMetallicRoughness\": {{{text}}}}}]");
        assert!(warnings(&pbr("\"roughnessFactor\": 1, \"baseColorFactor\": [2, 0, 1, 1]")).is_empty());
        assert_eq!(
            warnings(&pbr("\"roughnessFactor\": 3, \"baseColorFactor\": [1, -1, 0, 2], \"metallicFactor\": -0.5")),
            [
                "/materials/1/pbrMetallicRoughness/baseColorFactor/1 assumed: ranges: numbers out of the ranges of glTF: \
              /materials/1/pbrMetallicRoughness/baseColorFactor/1 is -1 and taken as 0, \
              /materials/1/pbrMetallicRoughness/baseColorFactor/3 is 2 and taken as 1, \
              /materials/1/pbrMetallicRoughness/metallicFactor is -0.5 and taken as 0, and 1 more"
            ]
        );
        let extension =
            |text: &str| warnings(&format!("\"materials\": [{{\"extensions\": {{\"KHR_materials_{text}}}}}]"));
        for (text, told) in [
            ("ior\": {\"ior\": 0}", None),
            ("ior\": {\"ior\": 0.5}", Some("is 0.5 and taken as 1")),
            ("volume\": {\"attenuationDistance\": 0}", Some("is 0 and left out")),
            ("transmission\": {\"transmissionFactor\": 2}", Some("is 2 and taken as 1")),
            ("specular\": {\"specularColorFactor\": [5, 5, 5]}", None),
        ] {
            let warnings = extension(text);
            assert_eq!(warnings.len(), usize::from(told.is_some()), "{text}: {warnings:?}");
            assert!(told.is_none_or(|told| warnings[0].ends_with(told)), "{text}: {warnings:?}");
        }
    }

    #[test]
    fn lamps_cameras_and_nodes_are_checked() {
        let light = |text: &str| {
            warnings(&format!(
                "\"extensions\": {{\"KHR_lights_punctual\": {{\"lights\": [{{\"type\": \"spot\", {text}}}]}}}}"
            ))
        };
        assert!(light("\"spot\": {}, \"intensity\": 0").is_empty());
        assert!(light("\"spot\": {\"innerConeAngle\": 1}")[0].contains("/spot/innerConeAngle is 1 and taken as 0.785"));
        assert!(light("\"range\": -1")[0].contains("/range is -1 and left out"));
        let both = warnings("\"cameras\": [{\"perspective\": {\"yfov\": 1}, \"orthographic\": {\"ymag\": 1}}]");
        assert!(both[0].contains("is taken as perspective"), "{both:?}");
        let node = |text: &str| warnings(&format!("\"nodes\": [{{{text}}}]"));
        let matrix = "\"matrix\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]";
        assert!(node(matrix).is_empty() && node("\"rotation\": [0, 0.6, 0, 0.8001]").is_empty());
        assert!(node(&format!("{matrix}, \"scale\": [1, 1, 1]"))[0].contains("the matrix counts"));
        assert!(node(&matrix.replace("1]", "2]"))[0].contains("0 0 0 1"));
        assert!(node("\"rotation\": [0, 0, 0, 2]")[0].contains("scaled to it"));
    }
}
