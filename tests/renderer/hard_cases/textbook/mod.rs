//! A tracer as textbooks write it: recursion, absolute epsilons, a bare stack of media, bounds without care. It is
//! run beside strahl, in the case's precision, to show that the cases are hard and that the harness can see failures.

pub mod cameras;
pub mod tree;

use crate::common::naive;
use crate::hard_cases::lab::Lab;
use glam::DVec3;
use std::cell::Cell;

/// What a textbook's tracer knows.
#[derive(Clone, Copy)]
pub enum Shape {
    Sphere(DVec3, f64),
    Plane(DVec3, DVec3),
    Cuboid(DVec3, DVec3),
    Triangle([DVec3; 3]),
}

impl Shape {
    /// The first t beyond `epsilon`.
    pub fn meet(&self, lab: &Lab, o: DVec3, d: DVec3, epsilon: f64) -> Option<f64> {
        match *self {
            Self::Sphere(center, radius) => naive::sphere(lab, o, d, center, radius, epsilon),
            Self::Plane(point, normal) => Some(naive::plane(lab, o, d, point, normal)).filter(|t| *t > epsilon),
            Self::Cuboid(low, high) => naive::cuboid(lab, o, d, low, high, epsilon),
            Self::Triangle(corners) => naive::triangle(lab, o, d, corners, 0.0).map(|h| h[0]).filter(|t| *t > epsilon),
        }
    }

    fn normal(&self, lab: &Lab, p: DVec3) -> DVec3 {
        match *self {
            Self::Sphere(center, _) => naive::normalize(lab, p - center),
            Self::Plane(_, normal) => naive::normalize(lab, normal),
            Self::Triangle([a, b, c]) => naive::normalize(lab, (b - a).cross(c - a)),
            Self::Cuboid(low, high) => {
                let k = (p - (low + high) / 2.0) / ((high - low) / 2.0);
                let axis = k.abs().max_position();
                DVec3::AXES[axis] * k[axis].signum()
            }
        }
    }
}

/// A shape and what it is made of.
#[derive(Clone, Copy)]
pub struct Object {
    pub shape: Shape,
    pub glow: f64,
    pub diffuse: f64,
    pub mirror: f64,
    pub clear: f64,
    pub ior: f64,
}

impl Object {
    /// Matt and of one color: what is seen.
    pub fn seen(shape: Shape, glow: f64) -> Self {
        Self { shape, glow, diffuse: 0.0, mirror: 0.0, clear: 0.0, ior: 1.0 }
    }

    pub fn matt(shape: Shape) -> Self {
        Self { diffuse: 0.8, ..Self::seen(shape, 0.0) }
    }

    pub fn glass(shape: Shape, ior: f64) -> Self {
        Self { clear: 1.0, ior, ..Self::seen(shape, 0.0) }
    }
}

/// One of a chain of transmitted rays.
#[derive(Debug)]
pub struct Step {
    pub origin: DVec3,
    pub direction: DVec3,
    /// Indices on both sides of the surface it ends at.
    pub indices: [f64; 2],
    /// How many media the stack holds in front of it.
    pub media: usize,
}

/// A scene and the textbook's constants.
pub struct Tracer<'a> {
    pub lab: &'a Lab,
    pub objects: Vec<Object>,
    pub lights: Vec<(DVec3, f64)>,
    pub background: f64,
    /// Hits count beyond this t.
    pub epsilon: f64,
    /// Hits closer together than this are taken for one.
    pub same: f64,
    /// Secondary rays start this far along the normal.
    pub offset: f64,
    /// Rays so far, and how many there may be before the test gives up.
    pub rays: Cell<u64>,
    pub patience: u64,
}

impl<'a> Tracer<'a> {
    pub fn new(lab: &'a Lab, objects: Vec<Object>) -> Self {
        let (rays, patience) = (Cell::new(0), u64::MAX);
        Self {
            lab,
            objects,
            lights: Vec::new(),
            background: 0.0,
            epsilon: 1e-4,
            same: 0.0,
            offset: 0.0,
            rays,
            patience,
        }
    }

    /// The nearest hit: of equal ones that written first.
    pub fn nearest(&self, o: DVec3, d: DVec3) -> Option<(f64, usize)> {
        let mut best = None;
        for (i, object) in self.objects.iter().enumerate() {
            if let Some(t) = object.shape.meet(self.lab, o, d, self.epsilon)
                && best.is_none_or(|(nearest, _)| t < nearest - self.same)
            {
                best = Some((t, i));
            }
        }
        best
    }

    /// Whether something stands between a point and a light, the way's end left out like its start.
    pub fn shadowed(&self, p: DVec3, light: DVec3) -> bool {
        let d = self.lab.round3(light - p);
        let between = |object: &Object| object.shape.meet(self.lab, p, d, self.epsilon);
        self.objects.iter().filter_map(between).any(|t| t < 1.0 - self.epsilon)
    }

    /// Light along a ray.
    pub fn radiance(&self, o: DVec3, d: DVec3, depth: u32) -> f64 {
        let round = |x: f64| self.lab.round(x);
        self.rays.set(self.rays.get() + 1);
        if self.rays.get() > self.patience {
            return 0.0;
        }
        let Some((t, i)) = self.nearest(o, d) else { return self.background };
        let object = &self.objects[i];
        let p = naive::point(self.lab, o, d, t);
        let n = object.shape.normal(self.lab, p);
        let facing = if n.dot(d) < 0.0 { n } else { -n };
        let start = naive::add(self.lab, p, facing * self.offset);
        let mut sum = object.glow;
        for (light, strength) in &self.lights {
            if object.diffuse > 0.0 && !self.shadowed(start, *light) {
                let l = self.lab.round3(*light - p);
                let cosine = naive::normalize(self.lab, l).dot(facing);
                sum = round(sum + round(round(object.diffuse * strength) * round(cosine.max(0.0) / l.dot(l))));
            }
        }
        if depth == 0 {
            return sum;
        }
        if object.mirror > 0.0 {
            let mirrored = self.lab.round3(d - 2.0 * d.dot(facing) * facing);
            sum = round(sum + round(object.mirror * self.radiance(start, mirrored, depth - 1)));
        }
        if object.clear > 0.0 {
            let eta = if n.dot(d) < 0.0 { 1.0 / object.ior } else { object.ior };
            let bent = naive::refract(self.lab, d, facing, eta);
            if !bent.is_nan() {
                let start = naive::add(self.lab, p, -facing * self.offset);
                sum = round(sum + round(object.clear * self.radiance(start, bent, depth - 1)));
            }
        }
        sum
    }

    /// The chain of transmitted rays: entering a body pushes the index outside, leaving it pops one.
    pub fn through(&self, o: DVec3, d: DVec3, most: usize) -> Vec<Step> {
        let (mut o, mut d, mut stack) = (o, naive::normalize(self.lab, d), Vec::new());
        let mut current = 1.0;
        let mut steps = Vec::new();
        while steps.len() < most {
            let mut step = Step { origin: o, direction: d, indices: [current; 2], media: stack.len() };
            let Some((t, i)) = self.nearest(o, d) else {
                steps.push(step);
                break;
            };
            let object = &self.objects[i];
            let p = naive::point(self.lab, o, d, t);
            let n = object.shape.normal(self.lab, p);
            let (facing, inside, outside) = if n.dot(d) < 0.0 {
                stack.push(current);
                (n, current, object.ior)
            } else {
                (-n, object.ior, stack.pop().unwrap_or(1.0))
            };
            step.indices = [inside, outside];
            steps.push(step);
            let bent = naive::refract(self.lab, d, facing, self.lab.round(inside / outside));
            if bent.is_nan() {
                d = self.lab.round3(d - 2.0 * d.dot(facing) * facing);
                o = naive::add(self.lab, p, facing * self.offset);
                continue;
            }
            (o, d, current) = (naive::add(self.lab, p, -facing * self.offset), bent, outside);
        }
        steps
    }
}
