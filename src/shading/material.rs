//! Materials, and the coefficients of the material under each ray.

use super::pbr::Pbr;
use super::texture::checker::BaseColor;
use super::texture::pattern::Textures;
use crate::lanes::{Ids, Lanes, Real, V3};

/// A material in the kernel's format: the symbols of L = L_Phong + r_s L_s + r_t L_t.
#[derive(Debug, Clone)]
pub struct Material<R> {
    /// k_a; none if it is k_d.
    pub ambient: Option<BaseColor<R>>,
    /// k_d.
    pub diffuse: BaseColor<R>,
    /// k_s.
    pub specular: [R; 3],
    /// m.
    pub shininess: R,
    /// r_s.
    pub reflection: [R; 3],
    /// r_t.
    pub transmission: [R; 3],
    /// Index of refraction.
    pub ior: R,
    /// Width of the GGX distribution of facets; 0 for a smooth surface.
    pub alpha: R,
    /// n_F - n_C.
    pub dispersion: R,
    /// sigma: what bodies of it absorb per unit of length.
    pub absorption: [R; 3],
    /// Emitted radiance.
    pub emission: [R; 3],
    /// How r_s and r_t depend on the angle of incidence.
    pub fresnel: Fresnel,
    /// Patterns and bumps. `ambient` and `diffuse` are then the means of the patterns that replace them.
    pub textures: Option<Box<Textures>>,
    /// Channels of metallic-roughness. All coefficients above are then the most that they can be.
    pub pbr: Option<Box<Pbr>>,
}

/// How reflection and transmission depend on the angle of incidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fresnel {
    /// Not at all.
    None,
    /// F r_s and (1 - F) r_t, F being the unpolarised reflectance between the media on both sides.
    Dielectric,
    /// Schlick's approximation for metals, whose r_s is that at normal incidence.
    Conductor,
    /// A dielectric with some metal, and with clearcoat over both: [`Pbr`].
    Layered,
}

impl<R: Real> Material<R> {
    /// One that takes all light and gives none.
    pub fn black() -> Self {
        let (zero, one) = (R::from_f64(0.0), R::from_f64(1.0));
        Self {
            ambient: None,
            diffuse: BaseColor::Uniform([zero; 3]),
            specular: [zero; 3],
            shininess: one,
            reflection: [zero; 3],
            transmission: [zero; 3],
            ior: one,
            alpha: zero,
            dispersion: zero,
            absorption: [zero; 3],
            emission: [zero; 3],
            fresnel: Fresnel::None,
            textures: None,
            pbr: None,
        }
    }

    /// Whether it mirrors in some channel, at some angle.
    pub fn mirrors(&self) -> bool {
        self.fresnel == Fresnel::Conductor || self.reflection.iter().any(|c| *c > R::from_f64(0.0))
    }

    /// Whether it transmits light in some channel.
    pub fn transmits(&self) -> bool {
        self.transmission.iter().any(|c| *c > R::from_f64(0.0))
    }

    /// Whether it may be only partly there.
    pub fn has_holes(&self) -> bool {
        self.pbr.as_ref().is_some_and(|pbr| pbr.has_holes())
    }

    /// Whether it shows shadows alone.
    pub fn catches_shadows(&self) -> bool {
        self.pbr.as_ref().is_some_and(|pbr| pbr.catches_shadows)
    }

    /// Whether a surface of this material between equal media is invisible: all light passes, none is added.
    pub fn is_perfectly_clear(&self) -> bool {
        let black = [R::from_f64(0.0); 3];
        let unlit =
            [self.ambient.as_ref(), Some(&self.diffuse)].into_iter().flatten().all(|t| *t == BaseColor::Uniform(black));
        let dark = self.specular == black && self.emission == black;
        // Between equal media a dielectric does not reflect.
        let mirrors = self.fresnel == Fresnel::Conductor || (self.fresnel == Fresnel::None && self.reflection != black);
        self.pbr.is_none() && unlit && dark && !mirrors && self.transmission == [R::from_f64(1.0); 3]
    }
}

/// A color of the material under each ray that is not among the [`Coefficients`].
#[inline(always)]
pub fn look_up<L: Lanes>(
    s: L::Simd,
    materials: &[Material<L::Real>],
    index: L::Ids,
    active: u32,
    color: impl Fn(&Material<L::Real>) -> [L::Real; 3],
) -> V3<L> {
    let mut all = V3::splat(s, [L::Real::from_f64(0.0); 3]);
    let mut left = active;
    while left != 0 {
        let (id, same) = index.same_as_first(s, left);
        left &= !same;
        all = V3::select(L::mask(s, same), V3::splat(s, color(&materials[id as usize])), all);
    }
    all
}

/// The coefficients under each ray.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "as in Material")]
pub struct Coefficients<L: Lanes> {
    pub ambient: V3<L>,
    pub diffuse: V3<L>,
    pub specular: V3<L>,
    pub reflection: V3<L>,
    pub transmission: V3<L>,
    pub shininess: L,
    pub alpha: L,
}

impl<L: Lanes> Coefficients<L> {
    /// Looks up the materials of the lanes of `active`, at least one: once for each distinct material. Other lanes hold
    /// anything. Checkers are averaged over `extents` around the points.
    #[inline(always)]
    pub fn look_up(
        s: L::Simd,
        materials: &[Material<L::Real>],
        index: L::Ids,
        active: u32,
        local: V3<L>,
        extents: Option<&dyn Fn() -> V3<L>>,
    ) -> Self {
        let (first, same) = index.same_as_first(s, active);
        let mut all = Self::of(s, &materials[first as usize], local, extents);
        let mut left = active & !same;
        while left != 0 {
            let (id, same) = index.same_as_first(s, left);
            left &= !same;
            all = Self::select(L::mask(s, same), Self::of(s, &materials[id as usize], local, extents), all);
        }
        all
    }

    /// The coefficients of one material.
    #[inline(always)]
    fn of(s: L::Simd, material: &Material<L::Real>, local: V3<L>, extents: Option<&dyn Fn() -> V3<L>>) -> Self {
        let diffuse = material.diffuse.at(s, local, extents);
        let ambient = if let Some(ambient) = &material.ambient { ambient.at(s, local, extents) } else { diffuse };
        Self {
            ambient,
            diffuse,
            specular: V3::splat(s, material.specular),
            reflection: V3::splat(s, material.reflection),
            transmission: V3::splat(s, material.transmission),
            shininess: L::splat(s, material.shininess),
            alpha: L::splat(s, material.alpha),
        }
    }

    /// `a` where the mask is true, `b` elsewhere.
    #[inline(always)]
    fn select(mask: L::Mask, a: Self, b: Self) -> Self {
        Self {
            ambient: V3::select(mask, a.ambient, b.ambient),
            diffuse: V3::select(mask, a.diffuse, b.diffuse),
            specular: V3::select(mask, a.specular, b.specular),
            reflection: V3::select(mask, a.reflection, b.reflection),
            transmission: V3::select(mask, a.transmission, b.transmission),
            shininess: L::select(mask, a.shininess, b.shininess),
            alpha: L::select(mask, a.alpha, b.alpha),
        }
    }
}
