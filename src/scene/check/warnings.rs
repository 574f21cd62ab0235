//! Warnings about scenes that render.

use crate::lanes::Real;
use crate::scene::closed_mesh::is_closed;
use crate::scene::description::{Description, Diffuse, Fresnel, Light, Object, Precision};
use crate::scene::effects::Effect;
use crate::scene::limits;
use crate::scene::problem::{Code, Problem, push_token};
use crate::scene::usage::{FAR_AWAY, TINY};
use crate::scene::world::{World, shows};

/// Backgrounds from here on are likely codes.
const WHITE_CODES: f64 = 100.0;
/// Pointer of the warning that there is no light.
const DARK: &str = "/lights";

/// Warnings of a description, as far as can be said before it is built. `known` are those of a scene with the same bodies.
pub(in crate::scene) fn warnings(description: &Description, known: Option<&[Problem]>) -> Vec<Problem> {
    let mut warnings = Vec::new();
    for (name, material) in description.materials.iter() {
        let (r_s, r_t) = (material.reflection.0, material.transmission.0);
        // Dielectrics divide the light: F r_s + (1 - F) r_t.
        let sum = if material.fresnel == Fresnel::Dielectric { r_s.max(r_t) } else { r_s + r_t };
        if sum.max_element() > 1.0 {
            let detail = format!(
                "reflection and transmission add up to {}, above 1: light grows with each surface it meets",
                sum.max_element()
            );
            warnings.push(Problem::new(push_token("/materials", name), Code::OutOfRange, detail));
        }
    }
    warnings.extend(codes_for_colors(description).take(limits::PROBLEMS.max as usize));
    if !description.lights.iter().any(Light::shines) {
        let detail = "there is no light: only the background is visible";
        warnings.push(Problem::new(DARK, Code::Degenerate, detail));
    }
    let transmits = |name: &Option<String>| {
        let material = name.as_ref().and_then(|name| description.materials.get(name));
        material.is_some_and(|m| match &m.pbr {
            Some(pbr) => pbr.transmission.factor() > 0.0 && !pbr.thin,
            None => m.transmission.0.max_element() > 0.0,
        })
    };
    for (name, material) in description.materials.iter() {
        if material.one_sided && material.transmission.0.max_element() > 0.0 {
            let detail = "one_sided and transmission together: light enters such a body and is never seen to leave it";
            let pointer = push_token(&push_token("/materials", name), "one_sided");
            warnings.push(Problem::new(pointer, Code::Degenerate, detail));
        }
    }
    // A full list may lack some.
    if let Some(known) = known.filter(|known| (known.len() as u64) < limits::PROBLEMS.max) {
        // What models say of themselves they say again.
        let is_of_bodies = |warning: &&Problem| {
            let is_of_model =
                matches!(warning.code, Code::NotSimulated | Code::Approximated | Code::Skipped | Code::Assumed);
            !is_of_model && ["/objects", "/definitions"].iter().any(|list| warning.pointer.starts_with(list))
        };
        let without_place = |warning: &Problem| Problem { line: None, column: None, ..warning.clone() };
        warnings.extend(known.iter().filter(is_of_bodies).map(without_place));
        return warnings;
    }
    let mut open = Vec::new();
    find_open_meshes("/objects", &description.objects, &transmits, &mut open);
    for (name, objects) in description.definitions.iter() {
        find_open_meshes(&push_token("/definitions", name), objects, &transmits, &mut open);
    }
    let detail = "the mesh transmits light but is not closed: light that enters may never leave";
    warnings.extend(open.into_iter().map(|pointer| Problem::new(pointer, Code::Degenerate, detail)));
    warnings
}

/// Colors that are likely meant as codes from 0 to 255.
fn codes_for_colors(description: &Description) -> impl Iterator<Item = Problem> {
    let how = "colors are linear, from 0 to 1, or sRGB as \"#rrggbb\"";
    let diffuse = description.materials.iter().filter_map(move |(name, material)| {
        let Diffuse::Uniform(color) = &material.diffuse else { return None };
        let most = Some(color.0.max_element()).filter(|most| *most > 1.0)?;
        let pointer = push_token(&push_token("/materials", name), "diffuse");
        let detail = format!("{most} is above 1: the surface scatters more light than it gets; {how}");
        Some(Problem::new(pointer, Code::OutOfRange, detail))
    });
    let most = description.background.0.max_element();
    let background = (most >= WHITE_CODES).then(|| {
        Problem::new("/background", Code::OutOfRange, format!("{most} is far above white, which is 1; {how}"))
    });
    diffuse.chain(background)
}

/// Keeps the warnings that hold for the world that was built: fog and surfaces may shine, too, and rays may bring surfaces the
/// light of the surroundings.
pub(in crate::scene) fn keep_true<R: Real>(warnings: &mut Vec<Problem>, description: &Description, world: &World<R>) {
    let glows = world.fog.as_ref().is_some_and(|fog| shows(fog.color));
    let lights = [Effect::AmbientLight, Effect::Emission, Effect::EnvironmentLight];
    let shines = lights.iter().any(|effect| world.effects.has(*effect));
    let gathers = [Effect::ColorBleeding, Effect::GlobalIllumination].iter().any(|effect| world.effects.has(*effect));
    let brings = gathers && !world.usage.enclosed && (shows(world.background) || world.environment.is_some());
    if glows || shines || brings {
        warnings.retain(|warning| warning.pointer != DARK);
    }
    warnings.extend(found_by_chance(description, world).take(limits::PROBLEMS.max as usize));
    warnings.extend(black_floor(description, world));
    warnings.extend(too_far_away(description, world));
    warnings.extend(too_small(description, world));
    warnings.extend(of_import(description));
    warnings.truncate(limits::PROBLEMS.max as usize);
}

/// What was said of the model that the scene was made of.
fn of_import(description: &Description) -> impl Iterator<Item = Problem> {
    let fidelity = description.render.fidelity;
    let holds = description.import_warnings.iter().filter(move |warning| warning.holds_for(fidelity));
    // A pointer would be one into another file than the scene's.
    holds.map(|warning| Problem::new("", warning.code.into(), warning.detail.clone()))
}

/// Materials that glow and are not looked for, with global illumination. Small bodies of them are met by so few rays that the estimate
/// may know of none.
fn found_by_chance<R: Real>(description: &Description, world: &World<R>) -> impl Iterator<Item = Problem> {
    let global_illumination = world.effects.has(Effect::GlobalIllumination);
    let materials = description.materials.iter().zip(&world.materials).zip(&world.usage.materials).enumerate();
    let by_chance = materials.filter(move |(i, ((_, material), used))| {
        let glows =
            material.pbr.as_ref().map_or(shows(material.emission), |pbr| !pbr.unlit && pbr.emissive.factor != [0.0; 3]);
        global_illumination
            && used.anywhere
            && glows
            && world.emitters.as_ref().is_none_or(|emitters| emitters.density(*i) == 0.0)
    });
    by_chance.map(|(_, (((name, _), _), _))| {
        let detail = "it glows, and rays find it by chance: small bodies of it bring noise that the estimate of the error may \
                      miss. Triangles, quads, discs, boxes, meshes, and balls that are not in a group with a transform, all of one \
                      light and at rest, are looked for, but in fog";
        Problem::new(push_token("/materials", name), Code::Approximated, detail)
    })
}

/// What shows shadows alone passes light on, which takes a ray.
fn black_floor<R: Real>(description: &Description, world: &World<R>) -> Option<Problem> {
    let mut materials = world.usage.materials.iter().zip(&world.materials);
    let has_floor = materials.any(|(used, material)| used.anywhere && material.catches_shadows());
    (has_floor && description.render.max_depth == Some(1)).then(|| {
        let detail =
            "chains of one ray end at the floor that shows shadows, so it is black: 2 and more show what is behind it";
        Problem::new("/render/max_depth", Code::Degenerate, detail)
    })
}

/// In single precision places are rounded by their distance from the origin.
fn too_far_away<R: Real>(description: &Description, world: &World<R>) -> Option<Problem> {
    let is_single = description.render.precision == Precision::Single;
    (is_single && world.usage.far_away).then(|| {
        let detail = format!(
            "the bodies are over {FAR_AWAY} times as far from the origin as they are large, which single precision rounds to \
             places that show: write \"double\", or move everything to the origin. What is proved does not cover it"
        );
        Problem::new("/render/precision", Code::Approximated, detail)
    })
}

/// In single precision products of tiny lengths underflow.
fn too_small<R: Real>(description: &Description, world: &World<R>) -> Option<Problem> {
    let is_single = description.render.precision == Precision::Single;
    (is_single && world.usage.tiny).then(|| {
        let detail = format!(
            "the bodies together are less than {TINY:e} across, and products of their edges underflow in single precision: write \
             \"double\", or make everything larger. What is proved does not cover it"
        );
        Problem::new("/render/precision", Code::Approximated, detail)
    })
}

fn find_open_meshes(
    list: &str,
    objects: &[Object],
    transmits: &impl Fn(&Option<String>) -> bool,
    open: &mut Vec<String>,
) {
    for (i, object) in objects.iter().enumerate() {
        if open.len() as u64 >= limits::PROBLEMS.max {
            return;
        }
        match object {
            Object::Group(group) => {
                find_open_meshes(&format!("{list}/{i}/group/objects"), &group.objects, transmits, open);
            }
            Object::Mesh(mesh) if transmits(&mesh.material) && !is_closed(&mesh.vertices, &mesh.faces) => {
                open.push(format!("{list}/{i}/mesh"))
            }
            _ => {}
        }
    }
}
