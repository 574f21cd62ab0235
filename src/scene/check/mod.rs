//! Checks of everything that can be wrong with a scene of the right shape. Compiling cannot fail afterwards, but for a limit
//! on the expanded scene.

mod camera;
mod findings;
mod lights;
mod materials;
mod objects;
mod path;
mod pbr;
mod warnings;

pub(super) use warnings::{keep_true, warnings};

use super::description::{Accuracy, Description, Environment, FilmBackground, Proved, Rays, Statistical, Time};
use super::limits;
use super::problem::{Code, Problems};
use camera::check_camera;
use findings::Findings;
use lights::check_lights;
use materials::check_material;
use objects::check_objects;
use path::Path;

/// Checks a description completely, without building a scene.
pub fn check(description: &Description) -> Result<(), Problems> {
    check_with(description, check_objects)
}

/// Checks all but objects, definitions, and the materials that they name.
pub(in crate::scene) fn check_around_bodies(description: &Description) -> Result<(), Problems> {
    check_with(description, |_, _| ())
}

fn check_with(description: &Description, check_objects: fn(&mut Findings, &Description)) -> Result<(), Problems> {
    let mut findings = Findings::default();
    let root = Path::ROOT;
    if description.version != 1 {
        let detail = format!("must be 1, the only version there is, is {}", description.version);
        findings.add(root.key("version"), Code::Unsupported, detail);
    }
    if let Some(name) = &description.name {
        findings.name(root.key("name"), name);
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
        if findings.full() {
            break;
        }
        // Problems inside of it would each repeat the name.
        if findings.name(root.key("materials").key(name), name) {
            check_material(&mut findings, root.key("materials").key(name), material);
        }
    }
    check_objects(&mut findings, description);
    check_render(&mut findings, description);
    let stops = description.film.exposure;
    let at = root.key("film");
    if let FilmBackground::Color(color) = description.film.background {
        let is_shown = (0.0..=1.0).contains(&color.0.min_element()) && color.0.max_element() <= 1.0;
        findings.number(at.key("background"), color.0.max_element(), "a color of channels between 0 and 1", is_shown);
    }
    findings.number(at.key("exposure"), stops, "between -32 and 32", stops.abs() <= 32.0);
    check_import_warnings(&mut findings, description);
    if findings.problems.is_empty() { Ok(()) } else { Err(Problems(findings.problems)) }
}

/// Whether the settings that may be overridden are in range in the scene itself.
pub(in crate::scene) fn settings_are_sound(description: &Description) -> bool {
    let mut findings = Findings::default();
    check_image(&mut findings, description);
    check_render(&mut findings, description);
    findings.problems.is_empty()
}

fn check_image(findings: &mut Findings, description: &Description) {
    let image = Path::ROOT.key("image");
    for (key, pixels) in [("width", description.image.width), ("height", description.image.height)] {
        if pixels == 0 {
            findings.add(image.key(key), Code::OutOfRange, "must be at least 1, is 0");
        } else {
            findings.count(image.key(key), "pixels", pixels.into(), limits::IMAGE_SIDE);
        }
    }
    let [width, height] = [description.image.width, description.image.height];
    // The size may be that of a request.
    let what = format!("pixels ({width} x {height})");
    findings.count(image, &what, u64::from(width) * u64::from(height), limits::PIXELS);
}

fn check_import_warnings(findings: &mut Findings, description: &Description) {
    let at = Path::ROOT.key("import_warnings");
    let warnings = &description.import_warnings;
    findings.count(at, "warnings", warnings.len() as u64, limits::IMPORT_WARNINGS);
    for (i, warning) in warnings.iter().enumerate().take(limits::IMPORT_WARNINGS.max as usize) {
        let characters = warning.detail.chars().count() as u64;
        findings.count(at.index(i).key("detail"), "characters", characters, limits::IMPORT_WARNING_CHARACTERS);
    }
}

fn check_environment(findings: &mut Findings, at: Path<'_>, environment: &Environment) {
    let Environment { image, sky, studio, .. } = environment;
    let kinds = [("image", image.is_some()), ("sky", sky.is_some()), ("studio", studio.is_some())];
    let mut named = kinds.iter().filter(|(_, named)| *named);
    match (named.next(), named.next()) {
        (Some(_), Some((second, _))) => {
            let detail = "an environment is an \"image\", a \"sky\" or a \"studio\": remove all but one of them";
            findings.add(at.key(second), Code::Unsupported, detail);
        }
        (None, _) => {
            let detail = "an environment needs an \"image\", or \"sky\": {} for a clear sky, or \"studio\": {}";
            findings.add(at, Code::MissingKey, detail);
        }
        _ => {}
    }
    if let Some(sky) = sky.filter(|_| image.is_none()) {
        for (key, color) in [("zenith", sky.zenith), ("horizon", sky.horizon), ("ground", sky.ground)] {
            findings.color(at.key("sky").key(key), color);
        }
    }
    let (angle, intensity) = (environment.rotate_deg, environment.intensity);
    findings.number(at.key("rotate_deg"), angle, "between -360 and 360", angle.abs() <= 360.0);
    let max = limits::MAGNITUDE;
    let words = format_args!("between 0 and {max:e}");
    findings.number(at.key("intensity"), intensity, words, (0.0..=max).contains(&intensity));
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
            findings.number(at.key("ms"), ms, "between 1 and 3600000", Accuracy::MILLISECONDS.contains(&ms));
        }
        Accuracy::Rays(Rays { count }) => {
            let at = at.key("rays");
            findings.number(at.key("count"), count as f64, "between 1 and 2^53", Accuracy::RAYS.contains(&count));
        }
        Accuracy::Statistical(Statistical { half_width, confidence }) => {
            let at = at.key("statistical");
            let wide = Accuracy::HALF_WIDTH.contains(&half_width);
            findings.number(at.key("half_width"), half_width, "between 0.25 and 64", wide);
            let sure = Accuracy::CONFIDENCE.contains(&confidence);
            findings.number(at.key("confidence"), confidence, "between 0.5 and 0.999", sure);
        }
    }
}
