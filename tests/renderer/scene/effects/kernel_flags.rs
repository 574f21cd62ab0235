//! What the table says is on is what the kernels read.

use super::{all_scenes, judge, loaded};
use strahl::accel::{Blockers, Item, Shape};
use strahl::lanes::Real;
use strahl::scene::compile::Precise;
use strahl::scene::effects::{Effect, State};
use strahl::scene::usage::Used;
use strahl::scene::world::{Pruning, World};
use strahl::shading::light::{Falloff, Light, Source};
use strahl::shading::material::{Fresnel, Material};
use strahl::shading::texture::bump::BumpMap;
use strahl::shading::texture::checker::BaseColor;
use strahl::shading::texture::pattern::Pattern;
use strahl::trace::variants::KernelVariant;

/// What the kernels read, item by item.
struct Told<'a, R> {
    world: &'a World<R>,
}

impl<R: Real> Told<'_, R> {
    fn any(&self, test: impl Fn(&Material<R>, Used) -> bool) -> bool {
        let items = self.world.geometries.iter().flat_map(|geometry| &geometry.items);
        let mut bodies = items.filter(|item| !matches!(item.shape, Shape::Instance(_)));
        // Not by bodies that nobody can see, whose effects leave no trace.
        let used = |item: &Item<R>| self.world.usage.materials[item.material as usize];
        bodies.any(|item| {
            let used = used(item);
            let filled = item.closed && !item.hollow && used.filled;
            used.anywhere && test(&self.world.materials[item.material as usize], Used { filled, ..used })
        })
    }

    fn item(&self, test: impl Fn(&Item<R>) -> bool) -> bool {
        self.world.geometries.iter().flat_map(|geometry| &geometry.items).any(test)
    }

    fn light(&self, test: impl Fn(&Light<R>) -> bool) -> bool {
        self.world.lights.iter().any(|light| bright(light.color) && test(light))
    }

    /// Whether a ray may be followed that leaves a surface, from the rules alone.
    fn follows(&self) -> bool {
        let most = |material: &Material<R>| {
            let channel = |c: usize| {
                let (r_s, r_t) = (material.reflection[c].to_f64(), material.transmission[c].to_f64());
                let all_along = matches!(material.fresnel, Fresnel::Conductor | Fresnel::Layered);
                if all_along { 1.0 } else { r_s + r_t }
            };
            channel(0).max(channel(1)).max(channel(2))
        };
        let split = self.world.spectrum.as_ref().map_or(1.0, |spectrum| spectrum.strongest().max_element());
        let heavy = |least: f64| self.any(|material, _| most(material) * split >= least * (1.0 - 1e-6));
        self.world.rules.max_depth > 1 && !matches!(self.world.rules.pruning, Pruning::Weight(least) if !heavy(least))
    }

    fn has_pattern(&self, test: fn(&Pattern) -> bool) -> bool {
        self.any(|material, _| {
            let textures = material.textures.as_ref();
            textures.is_some_and(|all| [&all.diffuse, &all.ambient].into_iter().flatten().any(test))
        })
    }

    fn has_bump(&self, test: fn(&BumpMap) -> bool) -> bool {
        self.any(|material, _| material.textures.as_ref().and_then(|textures| textures.bump.as_ref()).is_some_and(test))
    }

    fn of(&self, effect: Effect) -> Option<bool> {
        let (world, zero) = (self.world, R::from_f64(0.0));
        let gathers = world.rules.color_bleeding && world.rules.max_depth > 1;
        let traces = world.rules.global_illumination && world.rules.max_depth > 1;
        let transmissive = world.rules.shadows == Some(Blockers::Transmissive);
        let absorbs = |m: &Material<R>, used: Used| {
            used.filled && bright(m.absorption) && (bright(m.transmission) || used.around_eye)
        };
        let mirrors = |m: &Material<R>| bright(m.reflection) || m.fresnel == Fresnel::Conductor;
        let checks = |color: &BaseColor<R>| matches!(color, BaseColor::Checker { .. });
        let shines = |color: &BaseColor<R>| match *color {
            BaseColor::Uniform(color) => bright(color),
            BaseColor::Checker { a, b, .. } => bright(a) || bright(b),
        };
        let takes_part = |m: &Material<R>| shines(&m.diffuse) || m.pbr.as_ref().is_some_and(|pbr| !pbr.unlit);
        let traced = || traces && self.any(|m, _| takes_part(m));
        Some(match effect {
            Effect::AmbientLight => bright(world.ambient),
            Effect::DiffuseReflection => {
                (self.light(|_| true) || gathers || traces) && self.any(|m, _| shines(&m.diffuse))
            }
            Effect::Highlights => self.light(|_| true) && self.any(|m, _| bright(m.specular)),
            Effect::Shadows => world.rules.shadows.is_some(),
            Effect::TransmissiveShadows => transmissive && self.any(|m, _| bright(m.transmission)),
            Effect::ColoredShadows => transmissive && self.any(|m, used| absorbs(m, used) && bright(m.transmission)),
            Effect::Reflection => self.follows() && self.any(|m, _| mirrors(m)),
            Effect::Transmission => self.follows() && self.any(|m, _| bright(m.transmission)),
            Effect::Absorption => self.any(absorbs),
            Effect::Emission => self.any(|m, _| bright(m.emission)),
            Effect::Fog => world.fog.is_some(),
            Effect::Fresnel => {
                let shows = |m: &Material<R>| bright(m.reflection) || bright(m.transmission);
                let layered = |m: &Material<R>| matches!(m.fresnel, Fresnel::Dielectric | Fresnel::Layered);
                let dielectric = |m: &Material<R>| layered(m) && shows(m);
                self.follows() && self.any(|m, _| dielectric(m) || m.fresnel == Fresnel::Conductor)
            }
            Effect::TotalReflection | Effect::Refraction => {
                let bends = |m: &Material<R>, used: Used| {
                    let bends = m.ior != R::from_f64(1.0) || m.dispersion != R::from_f64(0.0);
                    used.filled && bright(m.transmission) && bends
                };
                self.follows() && self.any(bends)
            }
            Effect::HollowBodies => self.item(|item| item.hollow),
            Effect::CheckerTexture => self.any(|m, _| checks(&m.diffuse) || m.ambient.as_ref().is_some_and(checks)),
            Effect::GradientTexture => self.has_pattern(|pattern| matches!(pattern, Pattern::Gradient { .. })),
            Effect::NoiseTexture => self.has_pattern(|pattern| matches!(pattern, Pattern::Noise { .. })),
            Effect::ImageTexture => {
                let on_channels = |m: &Material<R>| m.pbr.as_ref().is_some_and(|pbr| !pbr.pictures.is_empty());
                self.has_pattern(|pattern| matches!(pattern, Pattern::Image(_))) || self.any(|m, _| on_channels(m))
            }
            Effect::BumpMapping => self.has_bump(|bump| !matches!(bump, BumpMap::Normals { .. })),
            Effect::NormalMapping => self.has_bump(|bump| matches!(bump, BumpMap::Normals { .. })),
            Effect::EnvironmentMap => world.environment.is_some(),
            Effect::EnvironmentLight => world.surroundings.is_some() && !world.rules.global_illumination,
            Effect::MetallicRoughness => self.any(|m, _| m.pbr.is_some()),
            Effect::ShadowCatcher => {
                world.rules.shadows.is_some() && self.light(|_| true) && self.any(|m, _| m.catches_shadows())
            }
            Effect::Opacity => self.item(|item| item.has_holes) && self.any(|m, _| m.has_holes()),
            Effect::SmoothNormals => self.item(|item| item.is_smooth()),
            Effect::SpotLights => self.light(|light| matches!(light.source, Source::Spot { .. })),
            Effect::LightFalloff => self.light(|light| !matches!(light.falloff, Falloff::None)),
            Effect::Instancing => self.item(|item| matches!(item.shape, Shape::Instance(_))),
            Effect::SoftShadows => world.lights.iter().any(|light| light.area.is_some()),
            Effect::Gloss => {
                self.follows() && self.any(|m, _| m.alpha > zero && (mirrors(m) || bright(m.transmission)))
            }
            Effect::Dispersion => {
                self.follows()
                    && self.any(|m, used| {
                        let varnished = m.fresnel == Fresnel::Dielectric && (mirrors(m) || bright(m.transmission));
                        m.dispersion > zero && (used.filled && bright(m.transmission) || varnished)
                    })
            }
            Effect::DepthOfField => world.camera.lens().is_some(),
            Effect::ColorBleeding => gathers,
            Effect::GlobalIllumination => traced(),
            // The kernel looks for light only where it is traced.
            Effect::EnvironmentSampling => traced() && world.bright_directions.is_some(),
            Effect::EmitterSampling => traced() && world.emitters.is_some(),
            _ => return None,
        })
    }
}

fn bright<R: Real>(color: [R; 3]) -> bool {
    color.iter().any(|channel| *channel > R::from_f64(0.0))
}

#[test]
fn what_the_plan_says_is_on_is_what_the_kernel_was_told() {
    judge(all_scenes(1_000), |description| {
        let scene = loaded(description).scene;
        let state = |effect: Effect| scene.effects.iter().find(|entry| entry.effect == effect).unwrap().state;
        let (effects, axes, filters, told): (_, _, _, Vec<(Effect, Option<bool>)>) = match &scene.world {
            Precise::Single(world) => (
                world.effects,
                KernelVariant::of(world).axes(),
                world.rules.filter_checkers && world.effects.has(Effect::CheckerTexture),
                Effect::ALL.iter().map(|effect| (*effect, Told { world }.of(*effect))).collect(),
            ),
            Precise::Double(world) => (
                world.effects,
                KernelVariant::of(world).axes(),
                world.rules.filter_checkers && world.effects.has(Effect::CheckerTexture),
                Effect::ALL.iter().map(|effect| (*effect, Told { world }.of(*effect))).collect(),
            ),
        };
        let mut wrong = Vec::new();
        for (effect, told) in told {
            let on = state(effect) == State::On;
            let told = told.unwrap_or_else(|| match effect {
                Effect::Antialiasing => scene.refines(),
                Effect::AlphaChannel => description["film"]["background"] == "transparent",
                Effect::ToneMapping => {
                    let film = &description["film"];
                    film["exposure"].as_f64().is_some_and(|stops| stops != 0.0)
                        || film["tone"].as_str().is_some_and(|tone| tone != "none")
                }
                Effect::DoublePrecision => matches!(scene.world, Precise::Double(_)),
                Effect::SpecialProjection => description["camera"].get("pinhole").is_none(),
                _ => effects.has(effect),
            });
            let flagged = effects.has(effect) || effect == Effect::Antialiasing && on;
            if (on, on) != (told, flagged) {
                wrong.push(format!(
                    "{} is {:?}, the kernel was told {told}, its flag is {flagged}",
                    effect.name(),
                    state(effect)
                ));
            }
        }
        // Kernels hold what is on.
        let named = description["render"]["samples"].as_u64();
        let default = if effects.needs_sampling() { 64 } else { 1 };
        if u64::from(scene.samples) != named.unwrap_or(default) || effects.needs_sampling() && !axes[4] {
            wrong.push(format!("{} samples, kernel {axes:?}", scene.samples));
        }
        let reflects = effects.has(Effect::Reflection) || effects.has(Effect::TotalReflection);
        let lacks = reflects && !axes[0] || effects.has(Effect::Transmission) && !axes[1];
        if lacks || filters && !axes[2] || effects.has_details() && !axes[3] {
            wrong.push(format!("the kernel {axes:?} lacks what is on"));
        }
        wrong
    });
}
