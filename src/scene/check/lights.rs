//! Checks of the lights.

use super::findings::Findings;
use super::path::Path;
use crate::scene::description::{Area, Falloff, Light};
use crate::scene::limits;
use crate::scene::problem::Code;

pub(super) fn check_lights(findings: &mut Findings, lights: &[Light]) {
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
    let at = light.key("falloff");
    match falloff {
        Falloff::Linear(linear) => findings.length(at.key("linear").key("reach"), linear.reach),
        Falloff::Windowed(windowed) => findings.length(at.key("windowed").key("range"), windowed.range),
        Falloff::None | Falloff::InverseSquare => {}
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
