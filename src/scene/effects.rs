//! Which effects a scene has: one table, made with the scene. All else follows from it: what the kernels simulate, how many
//! samples a pixel gets where the scene names no number, and what plans, reports and warnings say.
//!
//! Its rows are what each effect is called and which kernels hold it; the rules that decide are in `compile/effects/`.

use schemars::JsonSchema;
use serde::Serialize;
use std::borrow::Cow;

/// Samples of each pixel of scenes with effects that are means over choices, where they name no number.
const SAMPLES_OF_CHOICES: u32 = 64;

/// Most samples of a pixel that antialiasing refines.
pub const REFINED_SAMPLES: u32 = 16;

macro_rules! effects {
    ($($effect:ident $name:literal $part:ident,)*) => {
        /// Every effect the renderer knows, in the order in which plans list them.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[expect(missing_docs, reason = "the names say it")]
        pub enum Effect {
            $($effect,)*
        }

        impl Effect {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$effect,)*];

            /// Its name in plans: a token of letters and `_`.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$effect => $name,)*
                }
            }

            const fn part(self) -> Part {
                match self {
                    $(Self::$effect => Part::$part,)*
                }
            }
        }
    };
}

effects! {
    AmbientLight "ambient_light" Core,
    DiffuseReflection "diffuse_reflection" Core,
    Highlights "highlights" Core,
    Shadows "shadows" Core,
    TransmissiveShadows "transmissive_shadows" Core,
    ColoredShadows "colored_shadows" Details,
    Reflection "reflection" Core,
    Transmission "transmission" Core,
    Absorption "absorption" Details,
    Emission "emission" Details,
    Fog "fog" Details,
    Fresnel "fresnel" Details,
    TotalReflection "total_reflection" Core,
    Refraction "refraction" Core,
    HollowBodies "hollow_bodies" Core,
    CheckerTexture "checker_texture" Core,
    GradientTexture "gradient_texture" Details,
    NoiseTexture "noise_texture" Details,
    ImageTexture "image_texture" Details,
    BumpMapping "bump_mapping" Details,
    NormalMapping "normal_mapping" Details,
    MetallicRoughness "metallic_roughness" Details,
    Opacity "opacity" Details,
    ShadowCatcher "shadow_catcher" Details,
    EnvironmentMap "environment_map" Details,
    EnvironmentLight "environment_light" Details,
    SmoothNormals "smooth_normals" Core,
    SpotLights "spot_lights" Core,
    LightFalloff "light_falloff" Core,
    Instancing "instancing" Core,
    SpecialProjection "special_projection" Core,
    SoftShadows "soft_shadows" Sampled,
    Gloss "gloss" Sampled,
    Dispersion "dispersion" Sampled,
    DepthOfField "depth_of_field" Sampled,
    MotionBlur "motion_blur" Sampled,
    ColorBleeding "color_bleeding" Sampled,
    GlobalIllumination "global_illumination" Sampled,
    EnvironmentSampling "environment_sampling" Sampled,
    EmitterSampling "emitter_sampling" Sampled,
    AlphaChannel "alpha_channel" Details,
    ToneMapping "tone_mapping" Core,
    Antialiasing "antialiasing" Core,
    DoublePrecision "double_precision" Core,
}

/// Which kernels hold an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    /// Every kernel, or those for mirrors, clear bodies and the footprints of rays.
    Core,
    /// Kernels for what surfaces, bodies and the space between them do beyond Whitted's model.
    Details,
    /// The kernel for means over many choices, of which each sample makes one.
    Sampled,
}

impl Effect {
    const fn bit(self) -> u64 {
        1 << self as u32
    }

    const fn of(part: Part) -> u64 {
        let (mut all, mut i) = (0, 0);
        while i < Self::ALL.len() {
            if Self::ALL[i].part() as u8 == part as u8 {
                all |= Self::ALL[i].bit();
            }
            i += 1;
        }
        all
    }
}

/// The effects that are on: what kernels ask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SceneEffects(u64);

impl SceneEffects {
    const DETAILS: u64 = Effect::of(Part::Details);
    const SAMPLED: u64 = Effect::of(Part::Sampled);
    const TEXTURES: u64 = Effect::GradientTexture.bit()
        | Effect::NoiseTexture.bit()
        | Effect::ImageTexture.bit()
        | Effect::BumpMapping.bit()
        | Effect::NormalMapping.bit();

    /// Whether an effect is on.
    #[inline(always)]
    pub const fn has(self, effect: Effect) -> bool {
        self.0 & effect.bit() != 0
    }

    /// Whether light fades on its way, inside of bodies or outside.
    #[inline(always)]
    pub const fn fade(self) -> bool {
        self.0 & (Effect::Absorption.bit() | Effect::Fog.bit()) != 0
    }

    /// Whether any surface has textures beyond the checkerboard, bumps or a normal map.
    #[inline(always)]
    pub const fn has_textures(self) -> bool {
        self.0 & Self::TEXTURES != 0
    }

    /// Whether surfaces, bodies or the space between them do anything beyond Whitted's model.
    pub const fn has_details(self) -> bool {
        self.0 & Self::DETAILS != 0
    }

    /// Whether anything is a mean over choices.
    pub const fn needs_sampling(self) -> bool {
        self.0 & Self::SAMPLED != 0
    }

    /// Samples of a pixel, given the number that the scene names.
    pub(super) fn samples(self, named: Option<u32>) -> u32 {
        named.unwrap_or(if self.needs_sampling() { SAMPLES_OF_CHOICES } else { 1 })
    }
}

impl FromIterator<Effect> for SceneEffects {
    fn from_iter<I: IntoIterator<Item = Effect>>(effects: I) -> Self {
        Self(effects.into_iter().fold(0, |all, effect| all | effect.bit()))
    }
}

/// States of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "EffectState")]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Simulated.
    On,
    /// Asked for, but it cannot show in the picture.
    Removed,
    /// Not asked for.
    Off,
}

/// One row of the table.
#[derive(Debug, Clone)]
pub struct Entry {
    /// The effect.
    pub effect: Effect,
    /// Whether it is simulated.
    pub state: State,
    /// Why, in a sentence.
    pub reason: Cow<'static, str>,
    /// JSON pointers of what asks for it, at most [`MAX_POINTERS`].
    pub because: Vec<String>,
}

/// Most pointers listed for one effect.
pub const MAX_POINTERS: usize = 10;
