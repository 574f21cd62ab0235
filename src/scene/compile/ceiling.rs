//! The radiance ceiling of a world.
//!
//! A surface adds at most A = emission + k_a I_a + sum E_l (k_d + k_s), E_l being the most that a light can bring there, and
//! sends on at most g = r_s + r_t of what comes. So with the background B (fog and surroundings included)
//!
//! U = max(B, max over materials of A / (1 - g)),
//!
//! where a material with g = 1 and A = 0 asks for nothing: if U bounds what arrives, A + g U <= U bounds what leaves. Where
//! some g is too large for that, U of a chain of n rays is max(B, max A + g U of n - 1 rays), and that of none is 0.

use crate::accel::nearness;
use crate::bound::ceiling::Ceiling;
use crate::lanes::Real;
use crate::math::Rgb;
use crate::scene::description::{Accuracy, DEFAULT_MAX_DEPTH, Description};
use crate::scene::limits::MAX_DEPTH;
use crate::scene::problem::push_token;
use crate::scene::world::World;
use crate::shading::light::{Area, Falloff, Light, Source};
use crate::shading::material::{Fresnel, Material};
use crate::shading::texture::checker::BaseColor;
use crate::shading::texture::pattern::Pattern;

/// Chains whose ceilings are listed one by one.
const LEVELS: u32 = 4_096;

/// What a material may send on so that pictures are held against recursion without end:
/// [`ENDLESS`](crate::scene::world::ENDLESS) rays are as good as that then.
const MOST_SENT: f64 = 0.99;

/// What one material adds and sends on at most.
struct Surface {
    pointer: Option<String>,
    adds: Rgb,
    sends: Rgb,
}

/// The ceiling of a world that lacks nothing else.
pub(super) fn ceiling<R: Real>(description: &Description, world: &World<R>) -> Ceiling {
    let (used, irradiance) = lit(world);
    if let Some((light, _)) = irradiance.iter().enumerate().find(|(_, at)| at.iter().any(|e| !e.is_finite())) {
        let pointer = format!("/lights/{light}");
        let why =
            "a light with inverse-square falloff lies on a surface, or too near to it to say how near: what it adds \
                   there has no bound. Move it, or choose another falloff"
                .to_owned();
        return Ceiling::by_depth(vec![[f64::INFINITY; 3]], depth(description), why, vec![pointer]);
    }
    let surfaces: Vec<Surface> =
        (0..world.materials.len()).filter(|&m| used[m]).map(|m| surface(description, world, m, &irradiance)).collect();
    let beyond = background(world);
    // A point of the scene is no brighter than the light that it scatters for others.
    let gathered = surfaces.iter().fold(beyond, |most, s| most.max(s.adds));
    let surfaces: Vec<Surface> = surfaces
        .into_iter()
        .map(|s| if world.called.bleeding { Surface { adds: s.adds + gathered * reflected(world), ..s } } else { s })
        .collect();
    let split = split(world);
    endless(description, beyond, &surfaces, split)
        .unwrap_or_else(|why| by_depth(description, beyond, &surfaces, split, why))
}

/// What chains are held against where recursion without end has no bound.
fn depth(description: &Description) -> u32 {
    description.render.max_depth.unwrap_or(DEFAULT_MAX_DEPTH)
}

/// The bound on recursion without end, or the material that has none.
fn endless(
    description: &Description,
    beyond: Rgb,
    surfaces: &[Surface],
    split: Rgb,
) -> Result<Ceiling, (String, Vec<String>)> {
    let named = |s: &Surface| s.pointer.iter().cloned().collect::<Vec<_>>();
    if let Some(depth) = description.render.max_depth
        && !matches!(description.render.accuracy(), Accuracy::Fixed(_))
    {
        let why = format!("max_depth is {depth}: the picture of that depth is what it is held against");
        return Err((why, vec!["/render/max_depth".to_owned()]));
    }
    let (mut most, mut by) = (beyond, None);
    for surface in surfaces {
        for c in 0..3 {
            let (adds, sends) = (surface.adds[c], surface.sends[c]);
            let least = match () {
                () if adds == 0.0 && sends <= 1.0 => 0.0,
                () if sends <= MOST_SENT => adds / (1.0 - sends),
                () => {
                    let why = "a material sends on nearly all light that it gets, or more, and adds some: recursion \
                               without end has no bound, or none that would be of use"
                        .to_owned();
                    return Err((why, named(surface)));
                }
            };
            if least > most[c] {
                most[c] = least;
                by = Some(surface);
            }
        }
    }
    let why = match by {
        Some(_) => "of what a material adds, and of what it sends on again and again: A/(1 - g)",
        None => "nothing is brighter than the background",
    };
    Ok(Ceiling::endless((most * split).to_array(), why.to_owned(), by.map(named).unwrap_or_default()))
}

fn by_depth(
    description: &Description,
    beyond: Rgb,
    surfaces: &[Surface],
    split: Rgb,
    (why, because): (String, Vec<String>),
) -> Ceiling {
    let depth = depth(description);
    let mut levels = vec![[0.0; 3]];
    let mut below = Rgb::ZERO;
    for _ in 0..depth.min(LEVELS) {
        below = surfaces.iter().fold(beyond, |most, s| most.max(s.adds + s.sends * below));
        levels.push((below * split).to_array());
    }
    if depth > LEVELS && levels[LEVELS as usize] != levels[LEVELS as usize - 1] {
        levels.push([f64::INFINITY; 3]);
    }
    debug_assert!(u64::from(depth) <= MAX_DEPTH.max);
    Ceiling::by_depth(levels, depth, why, because)
}

/// Which materials bodies have, and the most that each light brings to each of them.
fn lit<R: Real>(world: &World<R>) -> (Vec<bool>, Vec<Vec<f64>>) {
    let mut used = vec![false; world.materials.len()];
    for item in world.geometries.iter().flat_map(|geometry| &geometry.items).filter(|item| !item.is_placed()) {
        used[item.material as usize] = true;
    }
    let irradiance = world.lights.iter().map(|light| of_light(world, light)).collect();
    (used, irradiance)
}

/// The largest factor on a light's colour at surfaces of each material.
fn of_light<R: Real>(world: &World<R>, light: &Light<R>) -> Vec<f64> {
    let dark = light.color.iter().all(|c| *c <= R::from_f64(0.0));
    let everywhere = |strength: f64| vec![strength; world.materials.len()];
    match (light.falloff, light.source) {
        _ if dark => everywhere(0.0),
        (Falloff::InverseSquare, Source::Point { position } | Source::Spot { position, .. }) => {
            let reach = match light.area {
                None => 0.0,
                Some(Area::Disc { radius }) => radius.to_f64(),
                Some(Area::Parallelogram { u, v }) => {
                    let length = |e: [R; 3]| e.map(Real::to_f64).iter().map(|x| x * x).sum::<f64>().sqrt();
                    0.5 * (length(u) + length(v))
                }
            };
            let nearest = nearness(&world.geometries, world.root, position.map(Real::to_f64), world.materials.len());
            let strength = |distance: f64| {
                let distance = (distance - reach) * (1.0 - 1e-6);
                if distance > 0.0 { 1.0 / (distance * distance) } else { f64::INFINITY }
            };
            nearest.into_iter().map(strength).collect()
        }
        _ => everywhere(1.0),
    }
}

fn surface<R: Real>(description: &Description, world: &World<R>, m: usize, irradiance: &[Vec<f64>]) -> Surface {
    let material = &world.materials[m];
    let name = (m < description.materials.len()).then(|| description.materials.at(m).0);
    let (ambient, diffuse) = colors(material);
    let specular = wide(material.specular);
    let mut adds = wide(material.emission) + ambient * wide(world.ambient);
    for (light, strength) in world.lights.iter().zip(irradiance) {
        adds += wide(light.color) * strength[m] * (diffuse + specular);
    }
    let (r_s, r_t) = (wide(material.reflection), wide(material.transmission));
    let sends = match material.fresnel {
        Fresnel::None => r_s + r_t,
        Fresnel::Dielectric => r_s.max(r_t),
        // Grazing light is mirrored completely, and what is mirrored is not transmitted.
        Fresnel::Conductor => (r_s + r_t).max(Rgb::ONE),
    };
    Surface { pointer: name.map(|name| push_token("/materials", name)), adds, sends }
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
    let mut most = wide(world.background);
    if let Some(environment) = &world.environment {
        most = most.max(Rgb::from_array(environment.mipmap.brightest()) * environment.intensity);
    }
    if let Some(fog) = &world.fog {
        most = most.max(wide(fog.color));
    }
    most
}

/// The largest k_d of all: the share that scattered light keeps.
fn reflected<R: Real>(world: &World<R>) -> Rgb {
    world.materials.iter().map(|material| colors(material).1).fold(Rgb::ZERO, Rgb::max)
}

/// The largest factor of a single wavelength on a ray's light, which is split once.
fn split<R: Real>(world: &World<R>) -> Rgb {
    match &world.spectrum {
        Some(spectrum) => spectrum.colors.iter().map(|color| wide(*color)).fold(Rgb::ONE, Rgb::max),
        None => Rgb::ONE,
    }
}

fn wide<R: Real>(color: [R; 3]) -> Rgb {
    Rgb::from_array(color.map(Real::to_f64))
}
