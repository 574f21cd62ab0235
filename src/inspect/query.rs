//! Single rays: what `strahl rays` and `POST /v1/rays` answer.

use crate::accel::Coherence;
use crate::lanes::{Ids, Lanes, Mask, Real, V3};
use crate::math::{exponent, scale_by_power};
use crate::ray::Rays;
use crate::scene::compile::Precise;
use crate::scene::limits::MAGNITUDE;
use crate::scene::locate::locate;
use crate::scene::problem::Code;
use crate::scene::read::read_as;
use crate::scene::world::World;
use crate::scene::{Problem, Problems, Scene};
use crate::shading::media::Media;
use crate::shading::optics::{fresnel_dielectric, reflect, refract};
use crate::trace::eye_media::media_at;
use crate::trace::hits::Hits;
use crate::trace::interface::interface;
use crate::trace::kernel::first;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// The shortest direction: in its units all of a scene is less than the largest number away.
const SHORTEST: f64 = 1e-290;

/// A ray; `t` counts in units of `direction`, which is taken as given.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RayQuery {
    /// Start.
    pub origin: [f64; 3],
    /// Direction, any length but 0 and what is next to it: one coordinate is 1e-290 or more.
    pub direction: [f64; 3],
    /// Hits at or below this t do not count. Default 0.
    #[serde(default)]
    pub t_min: f64,
    /// Hits beyond this t do not count. Default: none is too far.
    #[serde(default)]
    pub t_max: Option<f64>,
}

/// From JSON; each problem has its pointer, line and column.
impl FromStr for RayQuery {
    type Err = Problems;

    fn from_str(json: &str) -> Result<Self, Problems> {
        let ray: Self = read_as(json.as_bytes(), "ray")?;
        let Some((pointer, detail)) = ray.fault() else { return Ok(ray) };
        let mut problem = [Problem::new(pointer, Code::OutOfRange, detail)];
        locate(json.as_bytes(), &mut problem);
        Err(Problems(problem.into()))
    }
}

impl RayQuery {
    /// What is wrong with its numbers, and where.
    fn fault(&self) -> Option<(&'static str, String)> {
        if self.direction == [0.0; 3] {
            return Some(("/direction", "the direction has length 0; any other length will do".into()));
        }
        if self.direction.iter().all(|x| x.abs() < SHORTEST) {
            let detail =
                format!("the direction is too short for t in its units: one coordinate must be {SHORTEST:e} or more");
            return Some(("/direction", detail));
        }
        if self.origin.iter().any(|x| x.abs() > MAGNITUDE) {
            let detail = format!("the origin must have coordinates between -{MAGNITUDE:e} and {MAGNITUDE:e}");
            return Some(("/origin", detail));
        }
        let is_empty = self.t_max.is_some_and(|t_max| t_max < self.t_min);
        is_empty.then(|| ("/t_max", "t_max is below t_min, so no hit could count".into()))
    }
}

/// What a ray hits.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RayAnswer {
    /// Whether it hits anything; the other keys are there only if it does.
    pub hit: bool,
    /// The hit.
    #[serde(flatten)]
    pub at: Option<RayHit>,
}

/// Where and what. Numbers are those of the scene's precision, written so that they read back exactly.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RayHit {
    /// Ray parameter, in units of the direction.
    pub t: f64,
    /// The point on the surface.
    pub point: [f64; 3],
    /// Unit geometric normal, pointing out of the body's material.
    pub normal: [f64; 3],
    /// JSON pointer of the object in `objects`.
    pub object: String,
    /// JSON pointer of the body itself, if it stands in a group or definition.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// Name of the body.
    pub name: Option<String>,
    /// Whether the ray goes into the body's material.
    pub entering: bool,
    /// Unit mirror direction.
    pub reflected: [f64; 3],
    /// Unit direction of the transmitted ray; `None` if the body is opaque or all is reflected.
    pub transmitted: Option<[f64; 3]>,
    /// Whether there is total internal reflection.
    pub tir: bool,
    /// Unpolarised Fresnel reflectance between the media at the surface, whether or not the body transmits.
    pub reflectance: f64,
}

/// Follows one ray to its first hit.
pub fn answer(scene: &Scene, ray: &RayQuery) -> RayAnswer {
    let at = match &scene.world {
        Precise::Single(world) => hit::<f32>(scene, world, ray),
        Precise::Double(world) => hit::<f64>(scene, world, ray),
    };
    RayAnswer { hit: at.is_some(), at }
}

fn hit<L>(scene: &Scene, world: &World<L::Real>, ray: &RayQuery) -> Option<RayHit>
where
    L: Lanes<Simd = ()>,
{
    let s = ();
    let narrow = |v: [f64; 3]| v.map(L::Real::from_f64);
    // A ray without a direction or with NaN would visit every primitive for nothing.
    let sound = ray.origin.iter().chain(&ray.direction).all(|x| x.is_finite());
    let goes = ray.direction != [0.0; 3] && ray.t_max.is_none_or(|t_max| ray.t_min < t_max);
    if !sound || !goes {
        return None;
    }
    // A power of 2 brings the direction to a length around 1, where squares neither vanish nor overflow. It changes no
    // digit of the answer.
    let longest = ray.direction.iter().fold(0.0f64, |longest, x| longest.max(x.abs()));
    let power = exponent(longest);
    let mut rays = Rays {
        origin: V3::<L>::splat(s, narrow(ray.origin)),
        dir: V3::splat(s, narrow(ray.direction.map(|x| scale_by_power(x, -power)))),
        t_min: L::lit(s, scale_by_power(ray.t_min, power)),
        t_max: L::lit(s, scale_by_power(ray.t_max.unwrap_or(f64::INFINITY), power)),
        active: L::mask(s, 1),
    };
    let mut hits = Hits::none(s);
    hits.find(s, world, &mut rays, Coherence::Coherent);
    hits.leave_eye(s, world, &rays, Coherence::Coherent);
    if hits.found == 0 {
        return None;
    }
    let wide = |v: V3<L>| v.lane(0).map(Real::to_f64);
    let (object, body, name) = name_of(scene, world, hits.expanded.lane(0));
    let dir = rays.dir.normalized(s);

    let mut media = Media::default();
    let around = if hits.closed != 0 { media_at::<L>(s, world, narrow(ray.origin), None) } else { Vec::new() };
    let list = L::Ids::splat(s, u64::from(media.list(&around)));
    let sides = interface(s, world, &mut media, &hits, list, hits.closed);
    let eta = sides.n1 / sides.n2;
    let refraction = refract(s, dir, hits.ng, eta);
    let total = refraction.total.any();
    let clear = hits.transmissive != 0;
    Some(RayHit {
        t: scale_by_power(first(hits.t), -power),
        point: wide(hits.surface.point),
        normal: wide(hits.surface.ng),
        object,
        body,
        name,
        entering: hits.entering != 0,
        reflected: wide(reflect(s, dir, hits.ng).normalized(s)),
        transmitted: (clear && !total).then(|| wide(refraction.dir.normalized(s))),
        tir: total,
        reflectance: first(fresnel_dielectric(s, eta, &refraction)),
    })
}

/// JSON pointers of the object in `objects` and of the body if that is another, and the nearest name.
pub(super) fn name_of<R: Real>(
    scene: &Scene,
    world: &World<R>,
    expanded: u64,
) -> (String, Option<String>, Option<String>) {
    let owner = world.owner(expanded);
    let body = scene.sources.pointer(owner.item.source);
    let outermost = owner.instances.first().map_or_else(|| body.clone(), |i| scene.sources.pointer(i.source));
    // "/objects/3" of "/objects/3/group/objects/0".
    let top = outermost.match_indices('/').nth(2).map_or(outermost.as_str(), |(end, _)| &outermost[..end]).to_owned();
    let name = std::iter::once(owner.item)
        .chain(owner.instances.iter().rev().copied())
        .find_map(|item| scene.sources.name(item.source))
        .map(str::to_owned);
    let body = (body != top).then_some(body);
    (top, body, name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_need_a_direction() {
        let read = |json: &str| json.parse::<RayQuery>();
        assert!(read(r#"{"origin":[0,0,0],"direction":[0,0,-2]}"#).is_ok());
        assert!(read(r#"{"origin":[0,0,0],"direction":[0,-0,0]}"#).is_err());
        assert!(read(r#"{"origin":[0,0,0],"direction":[0,0,1e999]}"#).is_err());
        assert!(read(r#"{"origin":[0,0,0],"direction":[0,0,1e-320]}"#).is_err());
        assert!(read(r#"{"origin":[0,0,0],"direction":[0,1e-320,-1e-290]}"#).is_ok());
        assert!(read(r#"{"origin":[0,0,0],"direction":[0,0,1],"t_min":2,"t_max":1}"#).is_err());
        assert!(read(r#"{"origin":[0,0,0],"dir":[0,0,1]}"#).is_err());
    }

    #[test]
    fn rays_are_objects() {
        let told = |json: &str| json.parse::<RayQuery>().unwrap_err().to_string();
        assert_eq!(told("[[0,0,0],[0,0,1]]"), "line 1, column 1: must be an object, is an array of 2 elements");
        let short = told("{\"origin\":[0,0,0],\n\"direction\":[0,0,0]}");
        assert!(short.starts_with("line 2, column 13: /direction: "), "{short}");
    }
}
