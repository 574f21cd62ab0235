//! What each material of a world adds and sends on at most, for the world's radiance [`Ceiling`].
//!
//! A surface adds at most A = emission + k_a I_a + sum E_l (k_d + k_s), E_l being the most that a light can bring there, and
//! sends on at most g = r_s + r_t of what comes.

use crate::accel::{Item, Shape, least_distances};
use crate::bound::ceiling::{Ceiling, MaterialBound, brightest};
use crate::lanes::Real;
use crate::math::Rgb;
use crate::scene::description::{Accuracy, DEFAULT_MAX_DEPTH, Description, Fidelity};
use crate::scene::problem::push_token;
use crate::scene::world::World;
use crate::shading::light::{Falloff, Light, Source};
use crate::shading::lobes::BRIGHTEST;
use crate::shading::material::{Fresnel, Material};
use crate::shading::texture::checker::BaseColor;
use crate::shading::texture::pattern::Pattern;

/// The ceiling of a world that lacks nothing else.
pub(super) fn ceiling<R: Real>(description: &Description, world: &World<R>) -> Ceiling {
    radiance_ceiling(description, world).with_clear(clear(world))
}

/// The largest factor on the light of a background seen through bodies. Splitting by wavelength adds to a channel, and materials
/// may be described that transmit more than comes.
fn clear<R: Real>(world: &World<R>) -> f64 {
    let amplifies = |material: &Material<R>| wide(material.transmission).max_element() > 1.0;
    if world.materials.iter().any(amplifies) { f64::INFINITY } else { split(world).max_element() }
}

fn radiance_ceiling<R: Real>(description: &Description, world: &World<R>) -> Ceiling {
    let (used, irradiance) = lit(world);
    if let Some((light, _)) = irradiance.iter().enumerate().find(|(_, at)| at.iter().any(|e| !e.is_finite())) {
        let pointer = format!("/lights/{light}");
        let why =
            "a light with inverse-square falloff lies on a surface, too near to it to say how near, or in the ball around \
                   the path of what moves: what it adds there has no bound. Move it, or choose another falloff"
                .to_owned();
        return Ceiling::unbounded(depth(description), why, vec![pointer]);
    }
    let surfaces: Vec<MaterialBound> =
        (0..world.materials.len()).filter(|&m| used[m]).map(|m| surface(description, world, m, &irradiance)).collect();
    let beyond = background(world);
    let surfaces = if world.rules.gathers() { with_gathered(description, world, beyond, surfaces) } else { surfaces };
    let split = split(world);
    if let Some(light) = light_without_rays(description, world) {
        // With other light in its place it is another picture, brighter or darker.
        let why = format!(
            "a max_depth of 1 leaves no ray for {light}: surfaces have ambient light, and the picture is held against itself"
        );
        return Ceiling::by_depth(beyond, &surfaces, split, 1, why, vec!["/render/max_depth".to_owned()]);
    }
    match chosen_depth(description) {
        Some(depth) => {
            let why = format!("max_depth is {depth}: the picture of that depth is what it is held against");
            Ceiling::by_depth(beyond, &surfaces, split, depth, why, vec!["/render/max_depth".to_owned()])
        }
        None => Ceiling::endless(beyond, &surfaces, split, depth(description)),
    }
}

/// The light that is asked for by rays, if none of them may be followed.
fn light_without_rays<R: Real>(description: &Description, world: &World<R>) -> Option<&'static str> {
    if description.render.fidelity == Fidelity::Faithful && !world.rules.global_illumination {
        Some("fidelity \"faithful\"")
    } else {
        (world.rules.color_bleeding && !world.rules.gathers()).then_some("color_bleeding")
    }
}

/// The same surfaces with the light that they gather. What gathered rays meet has ambient light, so they bring at most the
/// ceiling G of the scene without gathering, and a surface adds k_d G more.
fn with_gathered<R: Real>(
    description: &Description,
    world: &World<R>,
    beyond: Rgb,
    surfaces: Vec<MaterialBound>,
) -> Vec<MaterialBound> {
    let depth = chosen_depth(description).unwrap_or_else(|| depth(description));
    let more = brightest(beyond, &surfaces, depth) * reflected(world);
    surfaces.into_iter().map(|s| MaterialBound { adds: s.adds + more, ..s }).collect()
}

/// The depth that a scene asks its pictures to be held against.
fn chosen_depth(description: &Description) -> Option<u32> {
    let fixed = matches!(description.render.accuracy(), Accuracy::Fixed(_));
    description.render.max_depth.filter(|_| !fixed)
}

/// What chains are held against where recursion without end has no bound.
fn depth(description: &Description) -> u32 {
    description.render.max_depth.unwrap_or(DEFAULT_MAX_DEPTH)
}

/// Which materials bodies have, and the most that each light brings to each of them.
fn lit<R: Real>(world: &World<R>) -> (Vec<bool>, Vec<Vec<f64>>) {
    let used = world.usage.materials.iter().map(|used| used.anywhere).collect();
    let measured = can_measure_reach(world);
    let irradiance = world.lights.iter().map(|light| of_light(world, light, measured)).collect();
    (used, irradiance)
}

/// Most distances between lights that end somewhere and bodies or triangles: a tenth of a second for one thread.
const MOST_DISTANCES: usize = 1 << 22;

/// Whether there are so few lights that end somewhere, and bodies, that it is measured what each of them reaches.
pub(super) fn can_measure_reach<R: Real>(world: &World<R>) -> bool {
    let ends = |light: &&Light<R>| matches!(light.falloff, Falloff::Linear { .. } | Falloff::Windowed { .. });
    let lights = world.lights.iter().filter(ends).count();
    let size = |item: &Item<R>| if let Shape::Mesh(mesh) = &item.shape { mesh.faces.len() } else { 1 };
    let bodies = || world.geometries.iter().flat_map(|geometry| &geometry.items).map(size).sum::<usize>();
    lights > 0 && lights.saturating_mul(bodies()) <= MOST_DISTANCES
}

/// The largest factor on a light's color at surfaces of each material. `measured`: whether linear falloff counts.
pub(super) fn of_light<R: Real>(world: &World<R>, light: &Light<R>, measured: bool) -> Vec<f64> {
    let dark = light.color.iter().all(|c| *c <= R::from_f64(0.0));
    let everywhere = |strength: f64| vec![strength; world.materials.len()];
    match (light.falloff, light.source) {
        _ if dark => everywhere(0.0),
        (Falloff::Linear { .. }, _) if !measured => everywhere(1.0),
        (
            Falloff::Linear { .. } | Falloff::InverseSquare | Falloff::Windowed { .. },
            Source::Point { position } | Source::Spot { position, .. },
        ) => {
            let reach = light.area.map_or(0.0, |area| area.reach());
            let nearest =
                least_distances(&world.geometries, world.root, position.map(Real::to_f64), world.materials.len());
            let strength = |distance: f64| {
                let distance = ((distance - reach) * (1.0 - 1e-6)).max(0.0);
                let square = if distance > 0.0 { 1.0 / (distance * distance) } else { f64::INFINITY };
                match light.falloff {
                    Falloff::None => 1.0,
                    Falloff::Linear { reach } => (1.0 - distance / reach.to_f64()).max(0.0),
                    Falloff::InverseSquare => square,
                    Falloff::Windowed { range } if distance >= range.to_f64() => 0.0,
                    Falloff::Windowed { range } => square * (1.0 - (distance / range.to_f64()).powi(4)).min(1.0),
                }
            };
            nearest.into_iter().map(strength).collect()
        }
        _ => everywhere(1.0),
    }
}

fn surface<R: Real>(description: &Description, world: &World<R>, m: usize, irradiance: &[Vec<f64>]) -> MaterialBound {
    let material = &world.materials[m];
    if material.pbr.is_some() {
        return layered(description, world, m, irradiance);
    }
    let name = description.materials.get_index(m).map(|(name, _)| name);
    let (ambient, diffuse) = colors(material);
    let specular = wide(material.specular);
    let mut adds = wide(material.emission) + ambient * wide(world.ambient) + diffuse * around(world);
    adds += diffuse * looked_for(world);
    for (light, strength) in world.lights.iter().zip(irradiance) {
        adds += wide(light.color) * strength[m] * (diffuse + specular);
    }
    let (r_s, r_t) = (wide(material.reflection), wide(material.transmission));
    let sends = match material.fresnel {
        Fresnel::None => r_s + r_t,
        Fresnel::Dielectric => r_s.max(r_t),
        // Grazing light is mirrored completely, and what is mirrored is not transmitted.
        Fresnel::Conductor | Fresnel::Layered => (r_s + r_t).max(Rgb::ONE),
    };
    // Scattered light is gathered by a ray.
    let sends = if world.rules.has_global_illumination() { sends + diffuse } else { sends };
    // A ray that stands for others weighs as much as its parent (`roulette.rs`).
    let is_drawn = world.rules.has_global_illumination() && world.has_material(|material, _| material.pbr.is_some());
    let sends = if is_drawn { sends.max(Rgb::ONE) } else { sends };
    MaterialBound { pointer: name.map(|name| push_token("/materials", name)), adds, sends }
}

/// The most that light from the surroundings is.
fn around<R: Real>(world: &World<R>) -> Rgb {
    world.surroundings.as_ref().map_or(Rgb::ZERO, |surroundings| Rgb::from_array(surroundings.most()))
}

/// The most that light is which is looked for, on one lobe: no sample of it is more than the brightest of it on the lobe's whole
/// share.
fn looked_for<R: Real>(world: &World<R>) -> Rgb {
    let bright = world.bright_directions.as_ref().map_or(Rgb::ZERO, |bright| Rgb::from_array(bright.most()));
    bright + world.emitters.as_ref().map_or(Rgb::ZERO, |emitters| Rgb::from_array(emitters.most()))
}

/// Lobes reflect at most as much of light from all around as arrives, and send on at most as much. Of a light they reflect any
/// amount to the camera, whose rays are always followed, and a limited one to others. What is only partly there lets the rest of
/// the light pass, which is no more than the larger of what the surface sends and what comes.
fn layered<R: Real>(description: &Description, world: &World<R>, m: usize, irradiance: &[Vec<f64>]) -> MaterialBound {
    let material = &world.materials[m];
    let name = description.materials.get_index(m).map(|(name, _)| name);
    let mut adds = wide(material.emission);
    if material.pbr.as_ref().is_some_and(|pbr| !pbr.unlit) {
        // A sample of it may be where the surface and what is below it both reflect most. Clearcoat leaves to them what it does not.
        adds += wide(world.ambient) + around(world) + looked_for(world) * 2.0;
        for (light, strength) in world.lights.iter().zip(irradiance) {
            adds += wide(light.color) * strength[m] * BRIGHTEST;
        }
    }
    let sends = if material.mirrors() || material.transmits() { Rgb::ONE } else { Rgb::ZERO };
    // A facet whose color is brighter than its index of refraction lets what is below have its mean share; and where it has a color of its
    // own, what it sends and what is below may be most in other channels, so a ray may have two children that stand for others.
    let is_bright = material.pbr.as_ref().is_some_and(|pbr| {
        let of = &pbr.specular_color;
        of.texel.is_some() || of.factor.iter().any(|c| *c > 1.0 || *c != of.factor[0])
    });
    let sends = if is_bright && world.rules.has_global_illumination() { sends * 2.0 } else { sends };
    MaterialBound { pointer: name.map(|name| push_token("/materials", name)), adds, sends }
}

/// The brightest k_a and k_d anywhere on a material.
fn colors<R: Real>(material: &Material<R>) -> (Rgb, Rgb) {
    let brightest = |texture: &BaseColor<R>| match texture {
        BaseColor::Uniform(color) => wide(*color),
        BaseColor::Checker { a, b, .. } => wide(*a).max(wide(*b)),
    };
    let mut diffuse = brightest(&material.diffuse);
    let mut ambient = material.ambient.as_ref().map_or(diffuse, brightest);
    if let Some(textures) = &material.textures {
        diffuse = textures.diffuse.as_ref().map_or(diffuse, pattern);
        ambient = match &textures.ambient {
            Some(of_ambient) => pattern(of_ambient),
            None if textures.own_ambient => ambient,
            None => diffuse,
        };
    }
    (ambient, diffuse)
}

fn pattern(pattern: &Pattern) -> Rgb {
    match pattern {
        Pattern::Gradient { colors: [a, b], .. } | Pattern::Noise { colors: [a, b], .. } => {
            Rgb::from_array(*a).max(Rgb::from_array(*b))
        }
        Pattern::Image(picture) => Rgb::from_array(picture.mipmap.brightest()),
    }
}

/// The most that rays see which hit nothing, and the fog in between.
fn background<R: Real>(world: &World<R>) -> Rgb {
    // An environment stands in place of the background.
    let mut most = world.environment.as_ref().map_or(wide(world.background), |environment| {
        Rgb::from_array(environment.mipmap.brightest()) * environment.intensity
    });
    if let Some(fog) = &world.fog {
        most = most.max(wide(fog.color));
    }
    if let Some(behind) = world.behind {
        most = most.max(wide(behind));
    }
    if world.rules.has_global_illumination() {
        most += world.lights.iter().filter_map(Light::disc_radiance).map(Rgb::from_array).sum::<Rgb>();
    }
    most
}

/// The largest k_d of the bodies, and at least that of the default material: the share that scattered light keeps.
fn reflected<R: Real>(world: &World<R>) -> Rgb {
    let default = world.materials.len() - 1;
    let used = world.usage.materials.iter().enumerate().filter(|(m, used)| used.anywhere || *m == default);
    used.map(|(m, _)| colors(&world.materials[m]).1).fold(Rgb::ZERO, Rgb::max)
}

/// The largest factor of a single wavelength on a ray's light, which is split once.
fn split<R: Real>(world: &World<R>) -> Rgb {
    match &world.spectrum {
        Some(spectrum) => spectrum.strongest().max(Rgb::ONE),
        None => Rgb::ONE,
    }
}

fn wide<R: Real>(color: [R; 3]) -> Rgb {
    Rgb::from_array(color.map(Real::to_f64))
}
