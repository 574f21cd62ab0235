//! Everything that can be wrong with a scene of the right shape. Past this check nothing can fail.

use super::check_objects::check_objects;
use super::path::Path;
use crate::camera::Basis;
use crate::scene::description::{
    Accuracy, Area, Bump, Camera, Color, Description, Diffuse, Environment, Falloff, ImageMap, Light, Mapping,
    Material, Proved, Rays, Relief, Statistical, Time, Vec3,
};
use crate::scene::limits::{self, Limit};
use crate::scene::problem::{Code, Problem, Problems};
use glam::DVec3;
use std::fmt::Display;

/// Collects problems.
#[derive(Debug, Default)]
pub(super) struct Findings {
    problems: Vec<Problem>,
}

impl Findings {
    pub(super) fn add(&mut self, at: Path<'_>, code: Code, detail: impl Into<String>) {
        if !self.full() {
            self.problems.push(Problem::new(at.pointer(), code, detail));
        }
    }

    pub(super) fn full(&self) -> bool {
        self.problems.len() as u64 >= limits::PROBLEMS.max
    }

    /// A number inside a range, given as words, which are only put together for a problem, and as a test.
    pub(super) fn number(&mut self, at: Path<'_>, x: f64, range: impl Display, ok: bool) {
        if !x.is_finite() {
            self.add(at, Code::OutOfRange, format!("must be a finite number, is {x}"));
        } else if !ok {
            self.add(at, Code::OutOfRange, format!("must be {range}, is {}", shown(x)));
        }
    }

    /// A length: positive, and neither too small nor too large for single precision.
    pub(super) fn length(&mut self, at: Path<'_>, x: f64) {
        let (min, max) = (limits::SMALLEST_LENGTH, limits::MAGNITUDE);
        self.number(at, x, format_args!("a length between {min:e} and {max:e}"), (min..=max).contains(&x));
    }

    pub(super) fn point(&mut self, at: Path<'_>, p: &Vec3) -> bool {
        let before = self.problems.len();
        for (i, x) in p.iter().enumerate() {
            let max = limits::MAGNITUDE;
            self.number(at.index(i), *x, format_args!("between -{max:e} and {max:e}"), x.abs() <= max);
        }
        self.problems.len() == before
    }

    pub(super) fn direction(&mut self, at: Path<'_>, d: &Vec3) {
        if self.point(at, d) && d.iter().all(|x| x.abs() < limits::SMALLEST_LENGTH) {
            self.add(at, Code::Degenerate, "must not be the zero vector");
        }
    }

    pub(super) fn count(&mut self, at: Path<'_>, what: &str, count: u64, limit: Limit) {
        if count > limit.max {
            let detail = format!("{count} {what} are over the limit of {} ({})", limit.max, limit.name);
            self.add(at, Code::Limit, detail);
        }
    }

    /// A colour of light.
    fn color(&mut self, at: Path<'_>, color: Color) {
        self.channels(at, color, limits::MAGNITUDE);
    }

    /// A coefficient of a material.
    fn coefficient(&mut self, at: Path<'_>, color: Color) {
        self.channels(at, color, limits::COEFFICIENT);
    }

    fn channels(&mut self, at: Path<'_>, color: Color, max: f64) {
        let words = format!("in each channel between 0 and {max:e}");
        if let Some(x) = color.0.to_array().into_iter().find(|x| !(0.0..=max).contains(x)) {
            self.number(at, x, &words, false);
        }
    }

    /// Colour and intensity of a light, and their product.
    fn light(&mut self, at: Path<'_>, color: Color, intensity: f64) {
        self.color(at.key("color"), color);
        let brightest = intensity * color.0.max_element().max(1.0);
        let words = format!("at least 0, and at most {:e} after multiplication with the colour", limits::MAGNITUDE);
        self.number(at.key("intensity"), intensity, &words, (0.0..=limits::MAGNITUDE).contains(&brightest));
    }

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

/// A number as its author may have written it: huge ones with an exponent.
fn shown(x: f64) -> String {
    if x != 0.0 && !(1e-4..1e16).contains(&x.abs()) { format!("{x:e}") } else { x.to_string() }
}

/// Checks a whole description.
pub(super) fn check(description: &Description) -> Result<(), Problems> {
    let mut findings = Findings::default();
    let root = Path::ROOT;
    if description.version != 1 {
        let detail = format!("must be 1, the only version there is, is {}", description.version);
        findings.add(root.key("version"), Code::Unsupported, detail);
    }
    check_image(&mut findings, description);
    check_camera(&mut findings, &description.camera);
    findings.color(root.key("background"), description.background);
    findings.color(root.key("ambient"), description.ambient);
    check_fog(&mut findings, description);
    if let Some(environment) = &description.environment {
        check_environment(&mut findings, root.key("environment"), environment);
    }
    check_lights(&mut findings, &description.lights);
    for (name, material) in description.materials.iter() {
        check_material(&mut findings, root.key("materials").key(name), material);
    }
    check_objects(&mut findings, description);
    check_render(&mut findings, description);
    if findings.problems.is_empty() { Ok(()) } else { Err(Problems(findings.problems)) }
}

/// Whether the settings that may be overridden are in range as they are written.
pub(super) fn settings_are_sound(description: &Description) -> bool {
    let mut findings = Findings::default();
    check_image(&mut findings, description);
    check_render(&mut findings, description);
    findings.problems.is_empty()
}

fn check_image(findings: &mut Findings, description: &Description) {
    let image = Path::ROOT.key("image");
    let side = limits::IMAGE_SIDE;
    for (key, pixels) in [("width", description.image.width), ("height", description.image.height)] {
        if pixels == 0 {
            findings.add(image.key(key), Code::OutOfRange, "must be at least 1, is 0");
        } else if u64::from(pixels) > side.max {
            let detail = format!("{pixels} pixels are over the limit of {} ({})", side.max, side.name);
            findings.add(image.key(key), Code::Limit, detail);
        }
    }
    let pixels = u64::from(description.image.width) * u64::from(description.image.height);
    findings.count(image, "pixels", pixels, limits::PIXELS);
}

fn check_camera(findings: &mut Findings, camera: &Camera) {
    let root = Path::ROOT;
    let at = root.key("camera");
    let at = at.key(camera.kind());
    let view = camera.view();
    let sound = findings.point(at.key("eye"), &view.eye) & findings.point(at.key("look_at"), &view.look_at);
    findings.direction(at.key("up"), &view.up);
    if sound && view.eye == view.look_at {
        findings.add(
            at.key("look_at"),
            Code::Degenerate,
            "must not be the eye point: there is no direction to look in",
        );
    } else if sound && Basis::new(&view).is_none() && view.up.iter().any(|x| x.abs() >= limits::SMALLEST_LENGTH) {
        findings.add(at.key("up"), Code::Degenerate, "must not be parallel to the view: choose another up direction");
    }
    let mut angle = |key: &str, x: f64, open: bool, max: f64| {
        let (words, ok) = if open {
            (format!("above 0 and below {max}"), x > 0.0 && x < max)
        } else {
            (format!("above 0, at most {max}"), x > 0.0 && x <= max)
        };
        findings.number(at.key(key), x, &words, ok);
    };
    match camera {
        Camera::Pinhole(c) => {
            angle("vfov_deg", c.vfov_deg, true, 180.0);
            if c.aperture != 0.0 {
                findings.length(at.key("aperture"), c.aperture);
            }
            if let Some(distance) = c.focus_distance {
                findings.length(at.key("focus_distance"), distance);
            }
        }
        Camera::Orthographic(c) => findings.length(at.key("height"), c.height),
        Camera::Fisheye(c) | Camera::Omnimax(c) => angle("fov_deg", c.fov_deg, false, 360.0),
        Camera::Panorama(c) => {
            angle("hfov_deg", c.hfov_deg, false, 360.0);
            angle("vfov_deg", c.vfov_deg, false, 180.0);
        }
        Camera::Cylinder(c) => {
            angle("hfov_deg", c.hfov_deg, false, 360.0);
            angle("vfov_deg", c.vfov_deg, true, 180.0);
        }
    }
}

fn check_environment(findings: &mut Findings, at: Path<'_>, environment: &Environment) {
    let (angle, intensity) = (environment.rotate_deg, environment.intensity);
    findings.number(at.key("rotate_deg"), angle, "between -360 and 360", angle.abs() <= 360.0);
    let max = limits::MAGNITUDE;
    let words = format_args!("between 0 and {max:e}");
    findings.number(at.key("intensity"), intensity, words, (0.0..=max).contains(&intensity));
}

fn check_lights(findings: &mut Findings, lights: &[Light]) {
    let root = Path::ROOT;
    let list = root.key("lights");
    findings.count(list, "lights", lights.len() as u64, limits::LIGHTS);
    for (i, light) in lights.iter().enumerate() {
        let at = list.index(i);
        match light {
            Light::Point(light) => {
                let at = at.key("point");
                findings.point(at.key("position"), &light.position);
                findings.light(at, light.color, light.intensity);
                check_falloff(findings, at, light.falloff);
                check_area(findings, at, light.area);
            }
            Light::Directional(light) => {
                if let Some(area) = light.area {
                    let (light, angle) = (at.key("directional"), area.angle_deg);
                    let ok = (0.0..=90.0).contains(&angle);
                    findings.number(light.key("area").key("angle_deg"), angle, "between 0 and 90", ok);
                }
                let at = at.key("directional");
                findings.direction(at.key("direction"), &light.direction);
                findings.light(at, light.color, light.intensity);
            }
            Light::Spot(light) => {
                let at = at.key("spot");
                findings.point(at.key("position"), &light.position);
                findings.direction(at.key("direction"), &light.direction);
                findings.light(at, light.color, light.intensity);
                check_falloff(findings, at, light.falloff);
                check_area(findings, at, light.area);
                let (inner, outer) = (light.inner_deg, light.outer_deg);
                findings.number(at.key("inner_deg"), inner, "between 0 and 90", (0.0..=90.0).contains(&inner));
                findings.number(at.key("outer_deg"), outer, "above 0, at most 90", outer > 0.0 && outer <= 90.0);
                if inner > outer {
                    let detail = format!("must not be above outer_deg, {outer}, is {inner}");
                    findings.add(at.key("inner_deg"), Code::OutOfRange, detail);
                }
            }
        }
    }
}

fn check_falloff(findings: &mut Findings, light: Path<'_>, falloff: Falloff) {
    if let Falloff::Linear(linear) = falloff {
        findings.length(light.key("falloff").key("linear").key("reach"), linear.reach);
    }
}

fn check_area(findings: &mut Findings, light: Path<'_>, area: Option<Area>) {
    let at = light.key("area");
    match area {
        Some(Area::Disc(disc)) if disc.radius != 0.0 => findings.length(at.key("disc").key("radius"), disc.radius),
        Some(Area::Parallelogram(area)) => {
            let at = at.key("parallelogram");
            findings.point(at.key("u"), &area.u);
            findings.point(at.key("v"), &area.v);
        }
        _ => {}
    }
}

fn check_fog(findings: &mut Findings, description: &Description) {
    let Some(fog) = &description.fog else { return };
    let root = Path::ROOT;
    let at = root.key("fog");
    let max = limits::MAGNITUDE;
    findings.color(at.key("color"), fog.color);
    let density = fog.density;
    findings.number(at.key("density"), density, format_args!("between 0 and {max:e}"), (0.0..=max).contains(&density));
    if let Some(height) = &fog.height {
        let at = at.key("height");
        let base = height.base;
        findings.number(at.key("base"), base, format_args!("between -{max:e} and {max:e}"), base.abs() <= max);
        findings.length(at.key("falloff"), height.falloff);
    }
}

fn check_material(findings: &mut Findings, at: Path<'_>, material: &Material) {
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

fn check_render(findings: &mut Findings, description: &Description) {
    let root = Path::ROOT;
    let at = root.key("render");
    let render = &description.render;
    for (key, value, limit) in
        [("max_depth", render.max_depth, limits::MAX_DEPTH), ("samples", render.samples, limits::SAMPLES)]
    {
        if value == Some(0) {
            findings.add(at.key(key), Code::OutOfRange, "must be at least 1, is 0");
        } else if let Some(value) = value
            && u64::from(value) > limit.max
        {
            let detail = format!("{value} is over the limit of {} ({})", limit.max, limit.name);
            findings.add(at.key(key), Code::Limit, detail);
        }
    }
    if let Some(weight) = render.min_weight {
        findings.number(at.key("min_weight"), weight, "between 0 and 1", (0.0..=1.0).contains(&weight));
    }
    check_accuracy(findings, &at.key("accuracy"), render.accuracy());
}

fn check_accuracy(findings: &mut Findings, at: &Path<'_>, accuracy: Accuracy) {
    match accuracy {
        Accuracy::Fixed(_) => {}
        Accuracy::Proved(Proved { max_codes }) => {
            let at = at.key("proved");
            findings.number(at.key("max_codes"), f64::from(max_codes), "0, 1 or 2", max_codes <= 2);
        }
        Accuracy::Time(Time { ms }) => {
            let at = at.key("time");
            findings.number(at.key("ms"), ms, "between 1 and 3600000", (1.0..=3.6e6).contains(&ms));
        }
        Accuracy::Rays(Rays { count }) => {
            let at = at.key("rays");
            findings.number(at.key("count"), count as f64, "between 1 and 2^53", (1..=1 << 53).contains(&count));
        }
        Accuracy::Statistical(Statistical { half_width, confidence }) => {
            let at = at.key("statistical");
            let wide = (0.25..=64.0).contains(&half_width);
            findings.number(at.key("half_width"), half_width, "between 0.25 and 64", wide);
            let sure = (0.5..=0.999).contains(&confidence);
            findings.number(at.key("confidence"), confidence, "between 0.5 and 0.999", sure);
        }
    }
}
