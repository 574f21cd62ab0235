//! Textures and bumps of the surfaces that a packet hits, body by body, in double precision: pictures are larger than single
//! precision can address.
//!
//! The footprint of a ray is the section of its cone (Akenine-Möller et al., Texture Level of Detail Strategies for
//! Real-Time Ray Tracing, Ray Tracing Gems, 2019) with the surface: an ellipse 1/cos longer than wide (Akenine-Möller et
//! al., JCGT 10(1), 2021). Curved mirrors and lenses widen cones (`footprint.rs`).

use super::hits::Hits;
use super::ray_packet::RayPacket;
use crate::accel::{self, Owner, Shape};
use crate::lanes::{Column, Columns, Double, Ids, Lanes, MAX_LANES, Mask, Real, V3, lanes_of, parts};
use crate::scene::world::World;
use crate::shading::material::Coefficients;
use crate::shading::texture::bump::BumpMap;
use crate::shading::texture::image::Lookup;
use crate::shading::texture::uv::{Attributes, Face};
use glam::DVec3;

/// Smallest cosine for the length of a footprint; longer ones are blurred anyway.
const LEAST_COSINE: f64 = 1e-3;

/// Cosine that replaces that of slopes which face away from the ray.
const EDGE_ON: f64 = 1e-3;

/// Applies textures to the coefficients and bumps to the shading normals, and those of clearcoat to `clearcoat`, its normals; `widths`
/// are those of the cones at the hits. Returns the lanes whose shading normals are tilted.
#[inline(never)]
pub(super) fn apply_textures<L: Lanes>(
    s: L::Simd,
    world: &World<L::Real>,
    rays: &RayPacket<L>,
    widths: L,
    hits: &mut Hits<L>,
    coefficients: &mut Coefficients<L>,
    clearcoat: &mut V3<L>,
) -> u32 {
    L::vectorize(
        s,
        #[inline(always)]
        || apply_in(s, world, rays, widths, hits, coefficients, clearcoat),
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
    clearcoat: &mut V3<L>,
) -> u32 {
    let (mut tilted, mut textured) = (0, false);
    let seen = Seen::new(rays.dir, hits, widths);
    let (mut ambient, mut diffuse) = (Columns::of(coefficients.ambient), Columns::of(coefficients.diffuse));
    let mut normals = Columns::of(hits.ns);
    let mut normals_of_clearcoat: Option<Columns> = None;
    let mut left = hits.found;
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        let (material, alike) = hits.material.same_as_first(s, left);
        let Some(textures) = &world.materials[material as usize].textures else {
            left &= !alike;
            continue;
        };
        let owner = world.owner(hits.expanded.lane(lane));
        let same = owner.lanes::<L>(s, hits.expanded, alike);
        left &= !same;
        textured |= textures.diffuse.is_some() || textures.ambient.is_some();
        for (first, lanes) in parts::<L>(same) {
            let mask = L::Double::mask(s, lanes);
            let seen = seen.part::<L::Double>(s, first);
            let lookup = seen.lookup::<L>(s, &owner, hits, first, lanes);
            if let Some(pattern) = &textures.diffuse {
                let color = pattern.at(s, &lookup);
                diffuse.put(s, first, mask, color);
                if textures.ambient.is_none() && !textures.own_ambient {
                    ambient.put(s, first, mask, color);
                }
            }
            if let Some(pattern) = &textures.ambient {
                ambient.put(s, first, mask, pattern.at(s, &lookup));
            }
            let outside = L::Double::mask(s, hits.entering >> first);
            if let Some(bump) = &textures.clearcoat {
                let normals = match &mut normals_of_clearcoat {
                    Some(normals) => normals,
                    none => none.insert(Columns::of(*clearcoat)),
                };
                let (normal, changed) = seen.tilt(s, bump, &owner, &lookup, normals.part(s, first), outside);
                normals.put(s, first, mask & changed, normal);
            }
            if let Some(bump) = &textures.bump {
                let (normal, changed) = seen.tilt(s, bump, &owner, &lookup, normals.part(s, first), outside);
                normals.put(s, first, mask & changed, normal);
                tilted |= (mask & changed).bits() << first;
            }
        }
    }
    if textured {
        (coefficients.ambient, coefficients.diffuse) = (ambient.lanes(s), diffuse.lanes(s));
    }
    if tilted != 0 {
        hits.ns = normals.lanes(s);
    }
    if let Some(normals) = &normals_of_clearcoat {
        *clearcoat = normals.lanes(s);
    }
    tilted
}

/// The rays and their hits.
pub(super) struct Seen {
    dir: Columns,
    /// The geometric normals on the rays' side.
    facing: Columns,
    /// In object space.
    point: Columns,
    /// Widths of the rays' cones.
    width: Column,
    /// Times of the rays, if bodies move.
    time: Option<Column>,
}

/// Some of them.
pub(super) struct Part<W> {
    dir: V3<W>,
    facing: V3<W>,
    pub(super) point: V3<W>,
    width: W,
    time: Option<W>,
}

impl Seen {
    /// Rays in directions `dir`, whose cones have these widths at the hits.
    #[inline(always)]
    pub(super) fn new<L: Lanes>(dir: V3<L>, hits: &Hits<L>, widths: L) -> Self {
        Self {
            dir: Columns::of(dir),
            facing: Columns::of(hits.ng),
            point: Columns::of(hits.surface.local),
            width: Column::of(widths),
            time: hits.time.map(Column::of),
        }
    }

    #[inline(always)]
    pub(super) fn part<W: Double>(&self, s: W::Simd, first: usize) -> Part<W> {
        Part {
            dir: self.dir.part(s, first),
            facing: self.facing.part(s, first),
            point: self.point.part(s, first),
            width: self.width.part(s, first),
            time: self.time.as_ref().map(
                #[inline(always)]
                |time| time.part(s, first),
            ),
        }
    }
}

impl<W: Double> Part<W> {
    /// What is looked up where some lanes have hit a body, the first of the part being `first`.
    #[inline(always)]
    pub(super) fn lookup<L: Lanes<Double = W, Simd = W::Simd>>(
        &self,
        s: W::Simd,
        owner: &Owner<'_, L::Real>,
        hits: &Hits<L>,
        first: usize,
        lanes: u32,
    ) -> Lookup<W> {
        let [long, short] = self.footprint(s, lanes);
        Lookup {
            lanes,
            point: self.point,
            footprint: [
                owner.directions_into_object(s, long, self.time),
                owner.directions_into_object(s, short, self.time),
            ],
            face: faces::<L>(s, owner, hits.expanded, first, lanes),
        }
    }

    /// The axes of the footprints, the longer one first.
    #[inline(always)]
    fn footprint(&self, s: W::Simd, lanes: u32) -> [V3<W>; 2] {
        let cosine = -self.dir.dot(self.facing);
        let along = (self.dir + self.facing * cosine).unit_or(s, V3::splat(s, [0.0; 3]));
        let head_on = along.eq(V3::splat(s, [0.0; 3])).bits() & lanes;
        let along = if head_on == 0 { along } else { self.head_on(s, head_on, along) };
        let side = self.facing.cross(along);
        [along * (self.width / cosine.max(W::lit(s, LEAST_COSINE))), side * self.width]
    }

    /// Any unit vectors across the normals in some lanes, and `along` in the others.
    #[inline(always)]
    fn head_on(&self, s: W::Simd, lanes: u32, along: V3<W>) -> V3<W> {
        V3::from_fn(s, |lane| {
            if lanes >> lane & 1 != 0 {
                DVec3::from_array(self.facing.lane(lane)).any_orthonormal_vector().to_array()
            } else {
                along.lane(lane)
            }
        })
    }

    /// The unit normals of a surface with bumps, on the rays' side as `normals` are, and where they have changed.
    #[inline(always)]
    fn tilt<R: Real>(
        &self,
        s: W::Simd,
        bump: &BumpMap,
        owner: &Owner<'_, R>,
        lookup: &Lookup<W>,
        normals: V3<W>,
        outside: W::Mask,
    ) -> (V3<W>, W::Mask) {
        let outwards = W::select(outside, W::lit(s, 1.0), W::lit(s, -1.0));
        let outer = normals * outwards;
        let flat = owner.normals_into_object(s, outer, self.time);
        let (raised, changed) = match bump {
            BumpMap::Normals { picture, strength, by_tangents, reframed: true } if !owner.instances.is_empty() => {
                let slopes = picture.slopes(s, lookup, flat, *strength, *by_tangents);
                let [of_u, of_v] = slopes.axes;
                let axes = [
                    owner.directions_out_of_object(s, of_u, self.time),
                    owner.directions_out_of_object(s, of_v, self.time),
                ];
                let raised = slopes.tilt_placed(s, outer, axes);
                (raised, !raised.eq(outer))
            }
            _ => {
                let raised = bump.tilt(s, lookup, flat);
                (owner.normals_out_of_object(s, raised, self.time), !raised.eq(flat))
            }
        };
        let tilted = raised * outwards;
        // A slope that faces away from the ray is turned until the ray sees it edge on.
        let (zero, nothing) = (W::lit(s, 0.0), V3::splat(s, [0.0; 3]));
        let away = tilted.dot(self.dir);
        let beyond = !away.lt(zero);
        let mut seen = tilted;
        if beyond.bits() & lookup.lanes != 0 {
            let edge_on = (tilted - self.dir * (away + W::lit(s, EDGE_ON))).unit_or(s, nothing);
            seen = V3::select(beyond, edge_on, tilted);
        }
        (seen, changed & !seen.eq(nothing) & seen.is_finite(s))
    }
}

/// The faces of a mesh with texture coordinates that some lanes have hit.
#[inline(always)]
fn faces<L: Lanes>(
    s: L::Simd,
    owner: &Owner<'_, L::Real>,
    expanded: L::Ids,
    first: usize,
    lanes: u32,
) -> Option<Face<L::Double>> {
    let Shape::Mesh(mesh) = &owner.item.shape else { return None };
    if mesh.uvs.is_empty() && mesh.attributes.is_none() {
        return None;
    }
    let (mut corners, mut uvs) = ([[[0.0; MAX_LANES]; 3]; 3], [[[0.0; MAX_LANES]; 2]; 3]);
    for lane in lanes_of(lanes) {
        let index = (expanded.lane(first + lane) - owner.body) as usize;
        let (points, face) = (mesh.corners(index), mesh.faces[index]);
        for corner in 0..3 {
            for axis in 0..3 {
                corners[corner][axis][lane] = points[corner][axis].to_f64();
            }
            if let Some(uv) = mesh.uvs.get(face[corner] as usize) {
                for axis in 0..2 {
                    uvs[corner][axis][lane] = uv[axis].to_f64();
                }
            }
        }
    }
    let load = |numbers: &[f64]| L::Double::load(s, numbers);
    let point = |[x, y, z]: &[[f64; MAX_LANES]; 3]| V3 { x: load(x), y: load(y), z: load(z) };
    let pair = |[u, v]: &[[f64; MAX_LANES]; 2]| [load(u), load(v)];
    Some(Face {
        corners: [point(&corners[0]), point(&corners[1]), point(&corners[2])],
        uvs: [pair(&uvs[0]), pair(&uvs[1]), pair(&uvs[2])],
        attributes: mesh.attributes.as_ref().map(
            #[inline(always)]
            |more| attributes::<L>(s, owner, more, expanded, first, lanes),
        ),
    })
}

/// What else their corners have; 0 and white where the mesh says nothing.
fn attributes<L: Lanes>(
    s: L::Simd,
    owner: &Owner<'_, L::Real>,
    more: &accel::Attributes<L::Real>,
    expanded: L::Ids,
    first: usize,
    lanes: u32,
) -> Attributes<L::Double> {
    L::vectorize(
        s,
        #[inline(always)]
        || {
            let (mut uvs, mut colors) = ([[[0.0; MAX_LANES]; 2]; 3], [[[1.0; MAX_LANES]; 4]; 3]);
            if let Shape::Mesh(mesh) = &owner.item.shape {
                for lane in lanes_of(lanes) {
                    let face = mesh.faces[(expanded.lane(first + lane) - owner.body) as usize];
                    for corner in 0..3 {
                        let vertex = face[corner] as usize;
                        for (axis, x) in more.uvs.get(vertex).iter().copied().flatten().enumerate() {
                            uvs[corner][axis][lane] = x.to_f64();
                        }
                        for (channel, x) in more.colors.get(vertex).iter().copied().flatten().enumerate() {
                            colors[corner][channel][lane] = x.to_f64();
                        }
                    }
                }
            }
            let load = |numbers: &[f64]| L::Double::load(s, numbers);
            let pair = |i: usize| [load(&uvs[i][0]), load(&uvs[i][1])];
            let color = |i: usize| {
                let [r, g, b, a] = &colors[i];
                [load(r), load(g), load(b), load(a)]
            };
            let tangents = if more.tangents.is_empty() {
                None
            } else {
                Some(tangents::<L>(s, owner, more, expanded, first, lanes))
            };
            Attributes { uvs: [pair(0), pair(1), pair(2)], colors: [color(0), color(1), color(2)], tangents }
        },
    )
}

/// The tangents at their corners.
#[inline(always)]
fn tangents<L: Lanes>(
    s: L::Simd,
    owner: &Owner<'_, L::Real>,
    more: &accel::Attributes<L::Real>,
    expanded: L::Ids,
    first: usize,
    lanes: u32,
) -> [[L::Double; 4]; 3] {
    let mut numbers = [[[0.0; MAX_LANES]; 4]; 3];
    if let Shape::Mesh(mesh) = &owner.item.shape {
        for lane in lanes_of(lanes) {
            let face = mesh.faces[(expanded.lane(first + lane) - owner.body) as usize];
            for corner in 0..3 {
                let tangent = more.tangents.get(face[corner] as usize);
                for (axis, x) in tangent.iter().copied().flatten().enumerate() {
                    numbers[corner][axis][lane] = x.to_f64();
                }
            }
        }
    }
    let mut tangents = [[L::Double::lit(s, 0.0); 4]; 3];
    for corner in 0..3 {
        for axis in 0..4 {
            tangents[corner][axis] = L::Double::load(s, &numbers[corner][axis]);
        }
    }
    tangents
}
