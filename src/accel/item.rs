//! The items of a geometry: bodies, surfaces and placed geometries.

use super::extent::Ball;
use super::motion::Motion;
use super::placement::Placement;
use crate::lanes::{Lanes, Mask, Real};
use crate::math::{exponent, scale_by_power};
use crate::ray::Rays;
use crate::shape::{Cuboid, Disc, Frustum, Plane, Sides, Sphere, Torus, is_collapsed};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// An item of a geometry: a body, a surface or a placed geometry.
#[derive(Debug, Clone)]
pub struct Item<R> {
    /// Its geometry.
    pub shape: Shape<R>,
    /// Index of its material.
    pub material: u32,
    /// Sides that rays can hit.
    pub sides: Sides,
    /// Whether the body is turned inside out.
    pub hollow: bool,
    /// Whether it encloses a region, into which light is refracted.
    pub closed: bool,
    /// Whether its surface might touch another one.
    pub may_touch: bool,
    /// Whether it may be only partly there: shadow rays pass it, and what they keep is asked later.
    pub has_holes: bool,
    /// The volume it encloses, in its own coordinates; infinite for half-spaces, 0 for sheets.
    pub volume: f64,
    /// What a shadow ray keeps of each channel at one crossing; 0 blocks it.
    pub transmission: [R; 3],
    /// Index of its source in the scene's table of names.
    pub source: u32,
    /// Expanded index of its first primitive within the geometry.
    pub offset: u64,
    /// Number of its primitives when expanded, with triangles that are but lines.
    pub expanded: u64,
}

impl<R: Real> Item<R> {
    /// Whether it transmits light in some channel. Then shadow rays pass it attenuated, if the scene has transmissive shadows.
    pub fn lets_light_through(&self) -> bool {
        self.transmission.iter().any(|c| *c > R::from_f64(0.0))
    }

    /// What a shadow ray keeps of each channel at one crossing, before it is asked about holes.
    #[inline(always)]
    pub(super) fn passed(&self) -> [R; 3] {
        if self.has_holes { [R::from_f64(1.0); 3] } else { self.transmission }
    }

    /// Whether its facets approximate a curved surface, with interpolated normals.
    pub fn is_smooth(&self) -> bool {
        matches!(&self.shape, Shape::Mesh(mesh) if !mesh.normals.is_empty())
    }
}

/// Kinds of items.
#[derive(Debug, Clone)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Shape<R> {
    Sphere(Sphere<R>),
    Plane(Plane<R>),
    Disc(Disc<R>),
    Cuboid(Cuboid<R>),
    Frustum(Box<Frustum<R>>),
    Torus(Box<Torus<R>>),
    Mesh(Arc<Mesh<R>>),
    Instance(Box<Instance<R>>),
}

/// Triangles over shared vertices.
#[derive(Debug, Clone)]
pub struct Mesh<R> {
    /// Points.
    pub vertices: Vec<[R; 3]>,
    /// Three vertices each, counter-clockwise from the front. A description may have the same list.
    pub faces: Arc<Vec<[u32; 3]>>,
    /// A shading normal for each vertex, or nothing.
    pub normals: Vec<[R; 3]>,
    /// Texture coordinates of each vertex, or nothing; kept only where a texture needs them.
    pub uvs: Vec<[R; 2]>,
    /// What few meshes have.
    pub attributes: Option<Box<Attributes<R>>>,
}

/// What few meshes have, kept only where a material needs it.
#[derive(Debug, Clone)]
pub struct Attributes<R> {
    /// Other texture coordinates of each vertex, or nothing.
    pub uvs: Vec<[R; 2]>,
    /// Red, green, blue and alpha of each vertex, or nothing.
    pub colors: Vec<[R; 4]>,
    /// Tangents of each vertex with the hand of their frame, or nothing.
    pub tangents: Vec<[R; 4]>,
}

impl<R: Real> Mesh<R> {
    /// The corners of a face.
    #[inline(always)]
    pub fn corners(&self, face: usize) -> [[R; 3]; 3] {
        self.faces[face].map(|i| self.vertices[i as usize])
    }

    /// Whether rounding has collapsed a face to a line.
    #[inline(always)]
    pub fn is_collapsed(&self, face: usize) -> bool {
        is_collapsed(&self.corners(face))
    }

    /// [`Self::corners`] in 64 bits.
    pub(super) fn points(&self, face: usize) -> [DVec3; 3] {
        self.corners(face).map(|corner| DVec3::from_array(corner.map(Real::to_f64)))
    }
}

/// A geometry, placed.
#[derive(Debug, Clone)]
pub struct Instance<R> {
    /// Index of the geometry.
    pub geometry: u32,
    /// From the geometry's coordinates to the outer ones.
    pub to_world: Placement<R>,
    /// The inverse.
    pub to_local: Placement<R>,
    /// A power of two: inside, directions are divided by it and ray parameters multiplied. So directions keep a length
    /// around 1 at any scale, and their squares neither vanish nor overflow. It changes no digit.
    pub unit: R,
    /// Ball around the placed geometry, if it has bounds: most rays that pass its box miss it.
    pub ball: Option<Ball<R>>,
    /// How it moves while the shutter is open.
    pub motion: Option<Box<Motion<R>>>,
}

impl<R: Real> Instance<R> {
    /// Places a geometry.
    pub fn new(geometry: u32, to_world: DAffine3) -> Self {
        let to_local = to_world.inverse();
        let columns = [to_local.x_axis, to_local.y_axis, to_local.z_axis];
        let longest = columns.iter().map(|column| column.length()).fold(f64::MIN_POSITIVE, f64::max);
        let unit = scale_by_power(1.0, exponent(longest).clamp(-100, 100));
        Self {
            geometry,
            to_world: Placement::new(to_world),
            to_local: Placement::new(to_local),
            unit: R::from_f64(unit),
            ball: None,
            motion: None,
        }
    }

    /// Rays in the coordinates of the instance's geometry; t is multiplied by the unit. Rays that miss the ball are switched
    /// off.
    #[inline(always)]
    pub(super) fn rays_in<L: Lanes<Real = R>>(&self, s: L::Simd, rays: &Rays<L>, time: Option<&L>) -> Rays<L> {
        let active = match &self.ball {
            Some(ball) => rays.active & ball.near(s, rays),
            None => rays.active,
        };
        if !active.any() {
            return Rays { active, ..*rays };
        }
        let mut moved = *rays;
        if let (Some(motion), Some(time)) = (&self.motion, time) {
            moved = motion.back(s, rays, *time);
        }
        let rays = &moved;
        let unit = L::splat(s, self.unit);
        Rays {
            origin: self.to_local.point(s, rays.origin),
            dir: self.to_local.vector(s, rays.dir) * (L::lit(s, 1.0) / unit),
            t_min: rays.t_min * unit,
            t_max: rays.t_max * unit,
            active,
        }
    }
}

/// A bounded primitive: an item, and for meshes one of its faces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Primitive {
    pub(super) item: u32,
    pub(super) face: u32,
}
