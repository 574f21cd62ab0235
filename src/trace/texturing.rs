//! Textures and bumps of the surfaces that a packet hits. They are looked up lane by lane: each lane needs other texels, and
//! few scenes have textures.
//!
//! The footprint of a ray is the section of its cone (Akenine-Möller et al., Texture Level of Detail Strategies for
//! Real-Time Ray Tracing, Ray Tracing Gems, 2019) with the surface: an ellipse 1/cos longer than wide (Akenine-Möller et
//! al., JCGT 10(1), 2021). Reflection and refraction do not change cones here; curved surfaces would widen them.

use super::hits::Hits;
use super::ray_packet::RayPacket;
use crate::accel::{Owner, Shape};
use crate::lanes::{Ids, Lanes, MAX_LANES, Real, V3, lanes_of};
use crate::scene::world::World;
use crate::shading::material::Coefficients;
use crate::shading::texture::image::Lookup;
use crate::shading::texture::pattern::Textures;
use crate::shading::texture::uv::Face;
use glam::DVec3;

/// Smallest cosine for the length of a footprint; longer ones are blurred anyway.
const GRAZING: f64 = 1e-3;

/// Cosine that replaces that of slopes which face away from the ray.
const EDGE_ON: f64 = 1e-3;

/// Applies textures to the coefficients and bumps to the shading normals; `widths` are those of the cones at the hits.
/// Returns the lanes whose normals are tilted.
pub(super) fn apply_textures<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    rays: &RayPacket<L>,
    widths: L,
    hits: &mut Hits<L>,
    coefficients: &mut Coefficients<L>,
) -> u32 {
    L::vectorize(
        s,
        #[inline(always)]
        || apply_in(s, world, rays, widths, hits, coefficients),
    )
}

#[inline(always)]
fn apply_in<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    rays: &RayPacket<L>,
    widths: L,
    hits: &mut Hits<L>,
    coefficients: &mut Coefficients<L>,
) -> u32 {
    let mut tilted = 0;
    let mut colors = [Columns::of(coefficients.ambient), Columns::of(coefficients.diffuse)];
    let mut normals = Columns::of(hits.ns);
    let mut textured = false;
    for lane in lanes_of(hits.found) {
        let Some(textures) = &world.materials[hits.material.lane(lane) as usize].textures else { continue };
        let owner = world.owner(hits.expanded.lane(lane));
        let seen = Seen {
            dir: point(rays.dir.lane(lane)),
            facing: point(hits.ng.lane(lane)),
            point: point(hits.surface.local.lane(lane)),
            width: widths.lane(lane).to_f64(),
        };
        let lookup = seen.lookup(&owner, hits.expanded.lane(lane));
        textured |= put_colors(textures, &lookup, lane, &mut colors);
        let entering = hits.entering & (1 << lane) != 0;
        if let Some(normal) = seen.tilt(textures, &owner, &lookup, point(hits.ns.lane(lane)), entering) {
            normals.put(lane, normal.to_array());
            tilted |= 1 << lane;
        }
    }
    if textured {
        let [ambient, diffuse] = &colors;
        (coefficients.ambient, coefficients.diffuse) = (ambient.lanes(s), diffuse.lanes(s));
    }
    if tilted != 0 {
        hits.ns = normals.lanes(s);
    }
    tilted
}

fn put_colors<R: Real>(
    textures: &Textures,
    lookup: &Lookup,
    lane: usize,
    [ambient, diffuse]: &mut [Columns<R>; 2],
) -> bool {
    if let Some(pattern) = &textures.diffuse {
        diffuse.put(lane, pattern.at(lookup));
    }
    if let Some(pattern) = &textures.ambient {
        ambient.put(lane, pattern.at(lookup));
    } else if textures.diffuse.is_some() && !textures.own_ambient {
        ambient.copy(lane, diffuse);
    }
    textures.diffuse.is_some() || textures.ambient.is_some()
}

/// A ray and its hit.
struct Seen {
    dir: DVec3,
    /// The geometric normal on the ray's side.
    facing: DVec3,
    /// In object space.
    point: DVec3,
    /// Width of the ray's cone.
    width: f64,
}

impl Seen {
    /// The texture lookup, in object space.
    fn lookup<R: Real>(&self, owner: &Owner<'_, R>, expanded: u64) -> Lookup {
        let cosine = -self.dir.dot(self.facing);
        let across = self.dir + self.facing * cosine;
        let along = across.try_normalize().unwrap_or_else(|| self.facing.any_orthonormal_vector());
        let side = self.facing.cross(along);
        let footprint = [along * (self.width / cosine.max(GRAZING)), side * self.width];
        Lookup {
            point: self.point,
            footprint: footprint.map(|axis| owner.into_object(axis)),
            face: face(owner, expanded),
        }
    }

    /// The unit normal of a surface with bumps, on the ray's side as `normal` is; none where it does not change.
    fn tilt<R: Real>(
        &self,
        textures: &Textures,
        owner: &Owner<'_, R>,
        lookup: &Lookup,
        normal: DVec3,
        entering: bool,
    ) -> Option<DVec3> {
        let bump = textures.bump.as_ref()?;
        let outwards = if entering { 1.0 } else { -1.0 };
        let flat = owner.normal_into_object(normal * outwards);
        let raised = bump.tilt(lookup, flat);
        if raised == flat {
            return None;
        }
        let tilted = owner.normal_out_of_object(raised) * outwards;
        // A slope that faces away from the ray is turned until the ray sees it edge on.
        let away = tilted.dot(self.dir);
        let seen = if away < 0.0 { tilted } else { (tilted - self.dir * (away + EDGE_ON)).normalize_or_zero() };
        (seen != DVec3::ZERO && seen.is_finite()).then_some(seen)
    }
}

/// The face of a primitive, with texture coordinates.
fn face<R: Real>(owner: &Owner<'_, R>, expanded: u64) -> Option<Face> {
    let Shape::Mesh(mesh) = &owner.item.shape else { return None };
    if mesh.uvs.is_empty() {
        return None;
    }
    let index = (expanded - owner.body) as usize;
    let uvs = mesh.faces[index].map(|i| mesh.uvs[i as usize].map(Real::to_f64));
    Some(Face { corners: mesh.corners(index).map(point), uvs })
}

fn point<R: Real>(p: [R; 3]) -> DVec3 {
    DVec3::from_array(p.map(Real::to_f64))
}

/// Three numbers for each lane.
struct Columns<R>([[R; MAX_LANES]; 3]);

impl<R: Real> Columns<R> {
    #[inline(always)]
    fn of<L: Lanes<Real = R>>(v: V3<L>) -> Self {
        let mut columns = [[R::default(); MAX_LANES]; 3];
        v.x.store(&mut columns[0]);
        v.y.store(&mut columns[1]);
        v.z.store(&mut columns[2]);
        Self(columns)
    }

    fn put(&mut self, lane: usize, numbers: [f64; 3]) {
        for (column, number) in self.0.iter_mut().zip(numbers) {
            column[lane] = R::from_f64(number);
        }
    }

    fn copy(&mut self, lane: usize, from: &Self) {
        for (column, other) in self.0.iter_mut().zip(&from.0) {
            column[lane] = other[lane];
        }
    }

    #[inline(always)]
    fn lanes<L: Lanes<Real = R>>(&self, s: L::Simd) -> V3<L> {
        let [x, y, z] = &self.0;
        V3 { x: L::load(s, x), y: L::load(s, y), z: L::load(s, z) }
    }
}
