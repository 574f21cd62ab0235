//! What a surface looks like, in the words of glTF, whatever the format.

/// A material. All colors are linear.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelMaterial {
    /// Its name.
    pub name: Option<String>,
    /// Base color: of a metal that of its reflection, else that of its body. The picture is sRGB.
    pub base_color: Channel<[f64; 3]>,
    /// Opacity, which the alpha channel of the base color's picture multiplies.
    pub opacity: f64,
    /// What opacity does.
    pub alpha: Alpha,
    /// 0 is a dielectric, 1 a metal. The blue channel of the picture.
    pub metallic: Channel<f64>,
    /// 0 is smooth, 1 dull. The green channel of the picture.
    pub roughness: Channel<f64>,
    /// Normal map with its strength. The picture's origin is at the top, its green points up.
    pub normal: Option<(Texture, f64)>,
    /// Where light from the surroundings reaches, with its strength. The red channel of the picture.
    pub occlusion: Option<(Texture, f64)>,
    /// Radiance that it emits. The picture is sRGB.
    pub emissive: Channel<[f64; 3]>,
    /// Whether it is seen from behind, too.
    pub double_sided: bool,
    /// Whether it shows its base color without any light.
    pub unlit: bool,
    /// Index of refraction.
    pub ior: f64,
    /// Strength of the reflection of a dielectric. The alpha channel of the picture.
    pub specular: Channel<f64>,
    /// Color of that reflection at normal incidence. The picture is sRGB.
    pub specular_color: Channel<[f64; 3]>,
    /// Part of the light that a dielectric lets through. The red channel of the picture.
    pub transmission: Channel<f64>,
    /// How thick the body behind the surface is, as far as the file knows. Above 0 its surface bends light; else it is thin.
    pub thickness: f64,
    /// What light loses inside.
    pub attenuation: Option<Attenuation>,
    /// 20 / V_d, where V_d is the Abbe number.
    pub dispersion: f64,
    /// A clear layer over all.
    pub clearcoat: Option<Clearcoat>,
}

/// A value, and a picture that multiplies it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel<T> {
    /// The value.
    pub factor: T,
    /// The picture.
    pub texture: Option<Texture>,
}

impl<T> Channel<T> {
    /// The same everywhere.
    pub const fn of(factor: T) -> Self {
        Self { factor, texture: None }
    }
}

/// What opacity does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Alpha {
    /// Nothing.
    Opaque,
    /// Below this there is no surface.
    Mask(f64),
    /// So much of the light behind is covered.
    Blend,
}

/// A color that light has after a distance inside of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attenuation {
    /// The color.
    pub color: [f64; 3],
    /// The distance.
    pub distance: f64,
}

/// A clear coat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearcoat {
    /// How much of it there is. The red channel of the picture.
    pub factor: Channel<f64>,
    /// Its roughness. The green channel of the picture.
    pub roughness: Channel<f64>,
    /// Its own normals, with their strength.
    pub normal: Option<(Texture, f64)>,
}

/// A picture on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Texture {
    /// Index of the picture.
    pub picture: usize,
    /// Which set of texture coordinates.
    pub uv: usize,
    /// What is done to the coordinates first.
    pub transform: Option<UvTransform>,
    /// Beyond the edges, across and down.
    pub wrap: [Wrap; 2],
    /// Whether enlarged pixels keep their edges.
    pub nearest: bool,
}

/// Scaled, then turned counter-clockwise by radians, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub struct UvTransform {
    pub offset: [f64; 2],
    pub rotation: f64,
    pub scale: [f64; 2],
}

/// Largest offset and scale that scenes take. Far below it texture coordinates have no digits left for a place in the picture.
const FARTHEST: f64 = 1e15;

impl UvTransform {
    /// What is wrong with it, if anything is.
    pub(super) fn fault(&self) -> Option<String> {
        let far = self.offset.into_iter().chain(self.scale).find(|number| number.abs() > FARTHEST)?;
        Some(format!(
            "the scale and the offset of a texture lie between -{FARTHEST:e} and {FARTHEST:e}, and {far:e} does not"
        ))
    }
}

/// The texture beyond the edges of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Wrap {
    #[default]
    Repeat,
    Clamp,
    Mirror,
}

impl ModelMaterial {
    /// The material of what has none in glTF: a rough white metal.
    pub fn new() -> Self {
        Self {
            name: None,
            base_color: Channel::of([1.0; 3]),
            opacity: 1.0,
            alpha: Alpha::Opaque,
            metallic: Channel::of(1.0),
            roughness: Channel::of(1.0),
            normal: None,
            occlusion: None,
            emissive: Channel::of([0.0; 3]),
            double_sided: false,
            unlit: false,
            ior: 1.5,
            specular: Channel::of(1.0),
            specular_color: Channel::of([1.0; 3]),
            transmission: Channel::of(0.0),
            thickness: 0.0,
            attenuation: None,
            dispersion: 0.0,
            clearcoat: None,
        }
    }

    /// Whether it is the surface of a body that bends light.
    pub(crate) fn bends_light(&self) -> bool {
        self.thickness > 0.0 && self.transmission.factor > 0.0
    }

    /// A grey, half-rough dielectric, seen from both sides: the material of formats that have none.
    pub fn plain(grey: f64) -> Self {
        Self {
            base_color: Channel::of([grey; 3]),
            metallic: Channel::of(0.0),
            roughness: Channel::of(0.5),
            double_sided: true,
            ..Self::new()
        }
    }

    /// That of its opacity, which is the base color's, if it may be partly there.
    pub fn opacity_texture(&self) -> Option<&Texture> {
        self.base_color.texture.as_ref().filter(|_| self.alpha != Alpha::Opaque)
    }

    /// All its pictures.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        let coat = self.clearcoat.as_ref();
        [
            self.base_color.texture.as_ref(),
            self.metallic.texture.as_ref(),
            self.roughness.texture.as_ref(),
            self.normal.as_ref().map(|(texture, _)| texture),
            self.occlusion.as_ref().map(|(texture, _)| texture),
            self.emissive.texture.as_ref(),
            self.specular.texture.as_ref(),
            self.specular_color.texture.as_ref(),
            self.transmission.texture.as_ref(),
            coat.and_then(|coat| coat.factor.texture.as_ref()),
            coat.and_then(|coat| coat.roughness.texture.as_ref()),
            coat.and_then(|coat| coat.normal.as_ref()).map(|(texture, _)| texture),
        ]
        .into_iter()
        .flatten()
    }
}

impl Default for ModelMaterial {
    fn default() -> Self {
        Self::new()
    }
}
