//! Checks of materials and their textures.

use super::findings::Findings;
use super::path::Path;
use super::pbr::check_pbr;
use crate::scene::description::{Bump, Diffuse, ImageMap, Mapping, Material, Relief};
use crate::scene::limits;
use crate::scene::problem::Code;
use glam::DVec3;

pub(super) fn check_material(findings: &mut Findings, at: Path<'_>, material: &Material) {
    if let Some(pbr) = &material.pbr {
        check_pbr(findings, at, material, pbr);
    }
    if let Some(ambient) = &material.ambient {
        findings.texture(at.key("ambient"), ambient);
    }
    findings.texture(at.key("diffuse"), &material.diffuse);
    if let Some(bump) = &material.bump {
        findings.bump(at.key("bump"), bump);
    }
    if let Some(normals) = &material.normal_map {
        findings.image(at.key("normal_map").key("image"), &normals.image);
        if material.bump.is_some() {
            let detail = "a material has bump or normal_map, not both: remove one of them";
            findings.add(at.key("normal_map"), Code::Unsupported, detail);
        }
    }
    findings.coefficient(at.key("specular"), material.specular);
    findings.coefficient(at.key("reflection"), material.reflection);
    findings.coefficient(at.key("transmission"), material.transmission);
    findings.color(at.key("absorption"), material.absorption);
    findings.color(at.key("emission"), material.emission);
    let (m, ior) = (material.shininess, material.ior);
    findings.number(at.key("shininess"), m, "between 0 and 1000000", (0.0..=1e6).contains(&m));
    let (roughness, dispersion) = (material.roughness, material.dispersion);
    findings.number(at.key("roughness"), roughness, "between 0 and 1", (0.0..=1.0).contains(&roughness));
    let ok = (0.0..=0.2).contains(&dispersion) && dispersion <= ior.abs();
    findings.number(at.key("dispersion"), dispersion, "between 0 and 0.2, and not above ior", ok);
    findings.number(at.key("ior"), ior, "between 0.01 and 100", (0.01..=100.0).contains(&ior));
}

impl Findings {
    fn image(&mut self, at: Path<'_>, image: &ImageMap) {
        let at = at.key("mapping");
        match &image.mapping {
            Mapping::Uv => {}
            Mapping::Planar(planar) => self.length(at.key("planar").key("size"), planar.size),
            Mapping::Spherical(globe) => {
                self.point(at.key("spherical").key("center"), &globe.center);
                self.direction(at.key("spherical").key("axis"), &globe.axis);
            }
        }
    }

    fn noise(&mut self, at: Path<'_>, size: f64, octaves: u32) {
        self.length(at.key("size"), size);
        let ok = (1..=12).contains(&octaves);
        self.number(at.key("octaves"), octaves.into(), "between 1 and 12", ok);
    }

    fn bump(&mut self, at: Path<'_>, bump: &Bump) {
        let max = limits::MAGNITUDE;
        let words = format_args!("between 0 and {max:e}");
        self.number(at.key("height"), bump.height, words, (0.0..=max).contains(&bump.height));
        let at = at.key("texture");
        match &bump.texture {
            Relief::Noise(grain) => self.noise(at.key("noise"), grain.size, grain.octaves),
            Relief::Image(image) => self.image(at.key("image"), image),
        }
    }

    fn texture(&mut self, at: Path<'_>, texture: &Diffuse) {
        match texture {
            Diffuse::Uniform(color) => self.coefficient(at, *color),
            Diffuse::Checker(checker) => {
                let at = at.key("checker");
                self.coefficient(at.key("a"), checker.a);
                self.coefficient(at.key("b"), checker.b);
                self.length(at.key("size"), checker.size);
            }
            Diffuse::Gradient(gradient) => {
                let at = at.key("gradient");
                self.coefficient(at.key("a"), gradient.a);
                self.coefficient(at.key("b"), gradient.b);
                let sound = self.point(at.key("from"), &gradient.from) & self.point(at.key("to"), &gradient.to);
                let length = DVec3::from_array(gradient.from).distance(DVec3::from_array(gradient.to));
                if sound && length < limits::SMALLEST_LENGTH {
                    self.add(at.key("to"), Code::Degenerate, "must not be the point from: there is no way to go");
                }
            }
            Diffuse::Image(image) => self.image(at.key("image"), image),
            Diffuse::Noise(noise) => {
                let at = at.key("noise");
                self.coefficient(at.key("a"), noise.a);
                self.coefficient(at.key("b"), noise.b);
                self.noise(at, noise.size, noise.octaves);
            }
        }
    }
}
