//! From where the whole area of a light is free, and from where it is hidden: cells of space that shafts to the light tell apart.
//!
//! A shaft from one point takes as long as a shadow ray, so a cell is asked once for all points in it, when the first of them is
//! lit. What it says follows from the scene alone, so neither threads nor the order of pixels change anything.

use crate::accel::{Bounds, Met, Obstacle, Shaft};
use crate::lanes::{Lanes, MAX_LANES, Mask, Real, V3, lanes_of};
use crate::shading::light::{Area, Light, Source};
use glam::DVec3;
use std::sync::atomic::{AtomicU8, Ordering};

/// Cells along an edge of each cube.
const EDGE: usize = 32;
/// Cubes around the bodies, each twice as large as the one before.
const CUBES: usize = 6;
/// Most lights with an area, and most items of a scene. A cell looks through all of them.
const MOST_LIGHTS: usize = 8;
pub(super) const MOST_OBSTACLES: usize = 256;
/// A cell is larger than its place by this share of its edge, and by so many roundings of its coordinates: shadow rays leave
/// beside the point that was found.
const MORE: f64 = 1.0 / 64.0;
const ROUNDINGS: f64 = 64.0;

/// What cells say of lights, and what they know that from.
#[derive(Debug)]
pub struct LightCells {
    obstacles: Vec<Obstacle>,
    center: DVec3,
    /// Half the edge of the smallest cube.
    half: f64,
    roundoff: f64,
    lights: Vec<Option<Known>>,
}

/// What is known of one light.
#[derive(Debug)]
struct Known {
    target: Target,
    /// Cube by cube, a byte each.
    cells: Vec<AtomicU8>,
}

#[derive(Debug, Clone, Copy)]
enum Target {
    Place(Bounds),
    Sky(Bounds),
}

/// What a cell says. Nothing is known at first.
const NEW: u8 = 0;
const OPEN: u8 = 1;
const BLOCKED: u8 = 2;
const MIXED: u8 = 3;

impl LightCells {
    /// Those of a scene; none if it has no light with an area, or too many of them, or too many items. `obstacles` are all items of
    /// the scene.
    pub fn new<R: Real>(obstacles: Vec<Obstacle>, lights: &[Light<R>]) -> Option<Self> {
        let count = lights.iter().filter(|light| light.area.is_some()).count();
        let around = obstacles.iter().filter_map(Obstacle::bounds).fold(Bounds::EMPTY, Bounds::union);
        let half = 0.5 * (around.max - around.min).max_element();
        if !(1..=MOST_LIGHTS).contains(&count) || obstacles.len() > MOST_OBSTACLES || !(half > 0.0 && half < f64::MAX) {
            return None;
        }
        let known = |light: &Light<R>| {
            let cells = (0..CUBES * EDGE.pow(3)).map(|_| AtomicU8::new(NEW)).collect();
            light.area.as_ref().map(|area| Known { target: target(light, area), cells })
        };
        let lights = lights.iter().map(known).collect();
        Some(Self { obstacles, center: around.center(), half, roundoff: R::ROUNDOFF, lights })
    }

    /// Bytes of memory that it takes at most.
    pub fn bytes(&self) -> usize {
        let cells: usize = self.lights.iter().flatten().map(|known| known.cells.len()).sum();
        size_of::<Self>() + cells + size_of_val(&self.obstacles[..]) + size_of_val(&self.lights[..])
    }

    /// The lanes of `among` whose points see the whole area of a light, or are hidden from all of it by something else than the
    /// surface that they are on.
    #[inline(never)]
    pub fn known<L: Lanes>(&self, s: L::Simd, light: usize, points: V3<L>, among: u32) -> [u32; 2] {
        L::vectorize(
            s,
            #[inline(always)]
            || self.known_in(s, light, points, among),
        )
    }

    #[inline(always)]
    fn known_in<L: Lanes>(&self, s: L::Simd, light: usize, points: V3<L>, among: u32) -> [u32; 2] {
        let Some(Some(known)) = self.lights.get(light) else { return [0; 2] };
        let mut numbers = [L::Real::default(); MAX_LANES];
        let (number, inside) = self.number(s, points);
        number.store(&mut numbers);
        let [mut open, mut blocked] = [0; 2];
        for lane in lanes_of(among & inside) {
            let number = numbers[lane].to_f64() as usize;
            let state = match known.cells[number].load(Ordering::Relaxed) {
                NEW => self.ask(known, number),
                state => state,
            };
            open |= u32::from(state == OPEN) << lane;
            blocked |= u32::from(state == BLOCKED) << lane;
        }
        [open, blocked]
    }

    /// The number of each point's cell, and the lanes whose point lies in the largest cube.
    #[inline(always)]
    fn number<L: Lanes>(&self, s: L::Simd, points: V3<L>) -> (L, u32) {
        let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
        let center = self.center.to_array().map(L::Real::from_f64);
        let offset = (points - V3::splat(s, center)) * L::lit(s, 1.0 / self.half);
        let size = offset.abs();
        let cube = (size.x.max(size.y).max(size.z).exponent() + one).max(zero);
        let inside = cube.lt(L::lit(s, CUBES as f64));
        let scale = (-cube).power_of_two();
        let cells = L::lit(s, EDGE as f64);
        let row = (cube * cells + column(s, offset.z * scale)) * cells + column(s, offset.y * scale);
        (row * cells + column(s, offset.x * scale), inside.bits())
    }

    /// Asks what a cell sees. Another thread may do so, too, and is told the same.
    #[cold]
    #[inline(never)]
    fn ask(&self, known: &Known, number: usize) -> u8 {
        let place = [number, number / EDGE, number / EDGE.pow(2)].map(|place| (place % EDGE) as f64);
        let half = self.half * (1u64 << (number / EDGE.pow(3))) as f64;
        let edge = 2.0 * half / EDGE as f64;
        let corner = self.center + (DVec3::from_array(place) * edge - half);
        let cell = Bounds { min: corner, max: corner + edge };
        let size = cell.min.abs().max(cell.max.abs()).max_element();
        let cell = cell.grown(MORE * edge + ROUNDINGS * self.roundoff * size);
        let shaft = match known.target {
            Target::Place(place) => Shaft::between(cell, place),
            Target::Sky(directions) => Shaft::towards(cell, directions),
        };
        let state = match Obstacle::met(&self.obstacles, &shaft) {
            Met::Open => OPEN,
            Met::Blocked => BLOCKED,
            Met::Mixed => MIXED,
        };
        known.cells[number].store(state, Ordering::Relaxed);
        state
    }
}

/// The number of a cell along an axis of its cube, which reaches from -1 to 1.
#[inline(always)]
fn column<L: Lanes>(s: L::Simd, x: L) -> L {
    let column = ((x + L::lit(s, 1.0)) * L::lit(s, 0.5 * EDGE as f64)).floor();
    column.max(L::lit(s, 0.0)).min(L::lit(s, (EDGE - 1) as f64))
}

/// Where the rays to a light end.
fn target<R: Real>(light: &Light<R>, area: &Area<R>) -> Target {
    let vector = |v: [R; 3]| DVec3::from_array(v.map(Real::to_f64));
    let reach = match area {
        Area::Disc { radius } => DVec3::splat(radius.to_f64()),
        Area::Parallelogram { u, v } => (vector(*u).abs() + vector(*v).abs()) * 0.5,
    };
    let around = |middle: DVec3| {
        let room = ROUNDINGS * R::ROUNDOFF * (middle.abs().max_element() + reach.max_element());
        Bounds { min: middle - reach - room, max: middle + reach + room }
    };
    match light.source {
        Source::Point { position } | Source::Spot { position, .. } => Target::Place(around(vector(position))),
        // Directions are brought to length 1, which no condition on shares of ways asks for.
        Source::Directional { to_light } => Target::Sky(around(vector(to_light))),
    }
}
