//! How deep the recursion can get: the graph of which specular body can see which.
//!
//! Nodes are the two sides of the bodies that reflect or transmit. An edge says that a ray which leaves one may meet the
//! other next. Edges are left out only where geometry forbids them: nothing flat sees its own plane or what is behind it,
//! and light that leaves the outside of an opaque convex body never comes back by itself. If no cycle can be reached from
//! the eye, the longest path bounds the chain: one ray for each body on it, and one that meets none.
//!
//! The bound is that of exact arithmetic, and nothing is cut off by it: beyond it the kernel finds no rays to follow.

use super::specular::{Body, Form, MAX_BODIES, Place, specular_bodies};
use crate::lanes::Real;
use crate::scene::Scene;
use crate::scene::compile::Precise;
use crate::scene::description::Description;
use crate::scene::effects::Effect;
use crate::scene::world::World;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;

/// How long chains of rays get.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Depth {
    /// `render.max_depth`, if the scene names one.
    pub requested: Option<u32>,
    /// A depth at which no chain is cut off: that of any larger `max_depth`. None if there may be none.
    pub proved_sufficient: Option<u32>,
    /// Why, in a sentence.
    pub why: String,
    /// JSON pointers of the bodies the sentence is about.
    pub because: Vec<String>,
}

/// Bounds the depth of a scene.
pub fn depth(description: &Description, scene: &Scene) -> Depth {
    let (beyond, single_eye, roundoff) = match &scene.world {
        Precise::Single(world) => of_world(world),
        Precise::Double(world) => of_world(world),
    };
    let (proved_sufficient, why, because) = if beyond {
        let why = "the scene calls for effects for which nothing is proved".to_owned();
        (None, why, Vec::new())
    } else {
        match specular_bodies(description, roundoff) {
            None => (None, format!("more than {MAX_BODIES} bodies mirror or transmit: not looked at"), Vec::new()),
            Some(bodies) => {
                let eye = single_eye.then(|| DVec3::from_array(description.camera.view().eye));
                Graph { bodies: &bodies, eye }.longest()
            }
        }
    };
    Depth { requested: description.render.max_depth, proved_sufficient, why, because }
}

/// Whether there is more than the lecture's model, whether all camera rays start in one point, and the format's roundoff.
fn of_world<R: Real>(world: &World<R>) -> (bool, bool, f64) {
    let others = [Effect::Fresnel, Effect::Gloss, Effect::Dispersion, Effect::DepthOfField, Effect::MotionBlur];
    let effects = world.effects;
    let elsewhere = others.iter().any(|effect| effects.has(*effect)) || effects.has_textures();
    let beyond = elsewhere || effects.has(Effect::ColorBleeding) || world.rules.spd_counts;
    (beyond, world.camera.has_single_eye(), R::ROUNDOFF)
}

/// A side of a body: its index, and whether it is the back of something flat or the inside of something convex.
type Side = (usize, bool);

struct Graph<'a> {
    bodies: &'a [Body],
    /// Where camera rays start, if that is one point.
    eye: Option<DVec3>,
}

/// What is known of a node's longest path.
#[derive(Clone, Copy)]
enum Known {
    Nothing,
    /// It is on the path that is being followed.
    Open,
    /// Bodies from here to the path's end, and the next one.
    Longest(u32, Option<usize>),
}

impl Graph<'_> {
    fn longest(&self) -> (Option<u32>, String, Vec<String>) {
        let sides: Vec<Side> = (0..self.bodies.len())
            .flat_map(|i| [(i, false), (i, true)])
            .filter(|&(i, back)| match self.bodies[i].form {
                Form::Any => !back,
                _ => self.bodies[i].sides[usize::from(back)],
            })
            .collect();
        let mut known = vec![Known::Nothing; sides.len()];
        let mut longest: Option<(u32, usize)> = None;
        for node in 0..sides.len() {
            if !self.eye_sees(sides[node]) {
                continue;
            }
            match self.follow(node, &sides, &mut known) {
                Ok(length) if longest.is_none_or(|(most, _)| length > most) => longest = Some((length, node)),
                Ok(_) => {}
                Err([a, b]) => return self.endless(a, b),
            }
        }
        let Some((length, mut node)) = longest else {
            return (Some(1), "no body in sight mirrors or lets light through".to_owned(), Vec::new());
        };
        let mut path = vec![self.pointer(sides[node])];
        while let Known::Longest(_, Some(next)) = known[node] {
            node = next;
            path.push(self.pointer(sides[node]));
        }
        let why = match path.len() {
            1 => "no ray that leaves a mirror or a sheet can meet one again".to_owned(),
            n => format!("no chain of rays can meet more than {n} bodies that mirror or transmit"),
        };
        (Some(length + 1), why, path)
    }

    /// Bodies on the longest path from a node, or the two ends of an edge that closes a cycle.
    fn follow(&self, node: usize, sides: &[Side], known: &mut [Known]) -> Result<u32, [Side; 2]> {
        if let Known::Longest(length, _) = known[node] {
            return Ok(length);
        }
        known[node] = Known::Open;
        let (mut most, mut by) = (0, None);
        for next in 0..sides.len() {
            if !self.sees(sides[node], sides[next]) {
                continue;
            }
            if let Known::Open = known[next] {
                return Err([sides[node], sides[next]]);
            }
            let length = self.follow(next, sides, known)?;
            if length > most {
                (most, by) = (length, Some(next));
            }
        }
        known[node] = Known::Longest(most + 1, by);
        Ok(most + 1)
    }

    fn endless(&self, a: Side, b: Side) -> (Option<u32>, String, Vec<String>) {
        let (from, to) = (self.pointer(a), self.pointer(b));
        if a.0 == b.0 {
            let body = &self.bodies[a.0];
            let what =
                if body.transmits { "light inside it may be reflected again and again" } else { "it may see itself" };
            return (None, format!("{from}: {what}"), vec![from]);
        }
        (None, format!("{from} and {to} may see each other, and light goes back and forth"), vec![from, to])
    }

    fn pointer(&self, side: Side) -> String {
        self.bodies[side.0].pointer.clone()
    }

    /// Whether a camera ray may meet a side.
    fn eye_sees(&self, (i, back): Side) -> bool {
        let Some(eye) = self.eye else { return true };
        let eye = Place::Hull(vec![eye]);
        match self.bodies[i].form {
            Form::Flat(flat) => flat.sees(&eye, back),
            Form::Convex => !back || self.bodies[i].place.meets(&eye),
            Form::Any => true,
        }
    }

    /// Whether a ray that has met one side may meet another one next.
    fn sees(&self, (i, from_back): Side, (j, to_back): Side) -> bool {
        let (a, b) = (&self.bodies[i], &self.bodies[j]);
        if i == j {
            return match a.form {
                Form::Flat(_) => false,
                Form::Convex => from_back && to_back,
                Form::Any => true,
            };
        }
        let leaves = match a.form {
            Form::Flat(flat) => {
                a.reflects && flat.sees(&b.place, from_back) || a.transmits && flat.sees(&b.place, !from_back)
            }
            Form::Convex => !from_back || a.place.meets(&b.place),
            Form::Any => true,
        };
        let arrives = match b.form {
            Form::Flat(flat) => flat.sees(&a.place, to_back),
            Form::Convex => !to_back || b.place.meets(&a.place),
            Form::Any => true,
        };
        leaves && arrives
    }
}
