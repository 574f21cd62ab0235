//! The recursion: L = L_Phong + r_s L_s + r_t L_t (Whitted, CACM 23(6), 1980).

use super::Reference;
use super::optics::{self, Media};
use super::phong::{self, Incident};
use super::ray::Ray;
use super::way;
use super::world::Intersection;
use crate::math::{Rgb, sin_cos};
use crate::scene::description::{Fresnel, Shadows};
use glam::DVec3;

/// A ray on its way, with unit direction.
#[derive(Debug, Clone)]
struct Path {
    ray: Ray,
    /// Hits at or below this t are the surface the ray starts on.
    near: f64,
    media: Media,
    /// Product of the coefficients on the way here.
    weight: Rgb,
    /// The primary ray's is 1.
    depth: u32,
}

/// A hit as the rays that leave it need it.
struct Vertex<'a> {
    hit: Intersection<'a>,
    point: DVec3,
    /// Geometric and shading normal, on the side the ray comes from.
    ng: DVec3,
    ns: DVec3,
    /// Below this t a ray from here may meet the surface it starts on, by rounding.
    near: f64,
}

impl<'a> Vertex<'a> {
    fn new(ray: &Ray, hit: Intersection<'a>) -> Self {
        let point = ray.at(hit.t);
        let near = 1e-9 * (point.abs().max_element() + hit.t);
        let ng = if ray.dir.dot(hit.ng) > 0.0 { -hit.ng } else { hit.ng };
        let ns = if hit.ns.dot(ng) < 0.0 { -hit.ns } else { hit.ns };
        Self { hit, point, ng, ns, near }
    }

    /// The normal by which light from `d` is bent: it leans at most 15 degrees from the facet. One that faces away from the ray has
    /// no angle of incidence.
    fn bending(&self, d: DVec3) -> DVec3 {
        let (sin, cos) = sin_cos(15.0_f64.to_radians());
        let along = self.ns.dot(self.ng);
        let leaning =
            if along >= cos { self.ns } else { self.ng * cos + (self.ns - self.ng * along).normalize() * sin };
        if d.dot(leaning) < 0.0 { leaning } else { self.ng }
    }
}

/// The radiance a primary ray brings.
pub(super) fn primary_radiance(reference: &Reference, ray: Ray) -> Rgb {
    let media = Media::around_eye(reference.world.containers(&ray));
    radiance(reference, &Path { ray, near: 0.0, media, weight: Rgb::ONE, depth: 1 })
}

fn radiance(reference: &Reference, path: &Path) -> Rgb {
    let hit = reference.world.closest_hit(&path.ray, path.near);
    let distance = hit.as_ref().map_or(f64::INFINITY, |hit| hit.t);
    let (passed, added) = way::along(reference.fog.as_ref(), &path.media, &path.ray, distance);
    let path = &Path { weight: path.weight * passed, ..path.clone() };
    added + passed * hit.map_or(reference.background, |hit| radiance_of(reference, path, hit))
}

/// The radiance that leaves a surface against the ray.
fn radiance_of(reference: &Reference, path: &Path, hit: Intersection<'_>) -> Rgb {
    let vertex = Vertex::new(&path.ray, hit);
    let material = &vertex.hit.body.material;
    let mut sum = material.emission.0 + local_radiance(reference, path, &vertex);

    let [mut reflection, transmission] = coefficients(path, &vertex);
    if vertex.hit.body.transmits() {
        if let Some((dir, media)) = transmitted(path, &vertex) {
            sum += transmission * followed(reference, path, &vertex, dir, media, transmission);
        } else {
            reflection += transmission;
        }
    }
    sum + reflection
        * followed(reference, path, &vertex, reflected(path.ray.dir, &vertex), path.media.clone(), reflection)
}

/// The radiance of a child ray, or nothing if it is not worth following.
fn followed(
    reference: &Reference,
    parent: &Path,
    vertex: &Vertex<'_>,
    dir: DVec3,
    media: Media,
    coefficient: Rgb,
) -> Rgb {
    let weight = (parent.weight * coefficient).max_element();
    if parent.depth >= reference.max_depth || weight <= 0.0 || weight < reference.min_weight {
        return Rgb::ZERO;
    }
    radiance(
        reference,
        &Path {
            ray: Ray { origin: vertex.point, dir },
            near: vertex.near,
            media,
            weight: parent.weight * coefficient,
            depth: parent.depth + 1,
        },
    )
}

/// By the shading normal, unless that would lead through the surface.
fn reflected(d: DVec3, vertex: &Vertex<'_>) -> DVec3 {
    let dir = optics::reflect(d, vertex.ns);
    if dir.dot(vertex.ng) > 0.0 { dir } else { optics::reflect(d, vertex.ng) }
}

/// r_s and r_t at the angle at which the ray comes.
fn coefficients(path: &Path, vertex: &Vertex<'_>) -> [Rgb; 2] {
    let body = vertex.hit.body;
    let material = &body.material;
    let (r_s, r_t) = (material.reflection.0, material.transmission.0);
    let d = path.ray.dir;
    let n = if d.dot(vertex.ns) < 0.0 { vertex.ns } else { vertex.ng };
    let bending = vertex.bending(d);
    match material.fresnel {
        Fresnel::None => [r_s, r_t],
        Fresnel::Dielectric => {
            let (n1, n2) = match body.inner_ior().filter(|_| body.transmits()) {
                Some(inner_ior) => {
                    let (n1, n2, _) = path.media.pass(&vertex.hit, inner_ior);
                    (n1, n2)
                }
                None => (path.media.ior(), material.ior),
            };
            let through = |n: DVec3| optics::refract(d, n, n1 / n2).filter(|dir| dir.dot(vertex.ng) < 0.0);
            let n = if body.transmits() && body.inner_ior().is_some() { bending } else { n };
            let n = if body.transmits() && through(n).is_none() { vertex.ng } else { n };
            let share = optics::reflectance(-d.dot(n), n1, n2);
            [r_s * share, r_t * (1.0 - share)]
        }
        Fresnel::Conductor => {
            let grazing = (1.0 + d.dot(n)).powi(5);
            [r_s + (Rgb::ONE - r_s) * grazing, r_t * (1.0 - grazing)]
        }
    }
}

/// Direction and media behind the surface; none under total internal reflection.
fn transmitted(path: &Path, vertex: &Vertex<'_>) -> Option<(DVec3, Media)> {
    let d = path.ray.dir;
    let Some(inner_ior) = vertex.hit.body.inner_ior() else {
        return Some((d, path.media.clone()));
    };
    let (n1, n2, media) = path.media.pass(&vertex.hit, inner_ior);
    let n = vertex.bending(d);
    // Of one that keeps the ray on its side the geometric normal decides, also about total reflection.
    let smooth = optics::refract(d, n, n1 / n2).filter(|dir| dir.dot(vertex.ng) < 0.0);
    let dir = smooth.or_else(|| optics::refract(d, vertex.ng, n1 / n2))?;
    Some((dir, media))
}

/// L_Phong, shadows included.
fn local_radiance(reference: &Reference, path: &Path, vertex: &Vertex<'_>) -> Rgb {
    let d = path.ray.dir;
    let Vertex { hit, point, ng, ns, .. } = vertex;
    let mut sum = phong::ambient(&hit.body.material, hit.object_point, reference.ambient);
    for light in &reference.lights {
        let Some(incident) = phong::incident(light, *point) else { continue };
        let facet = (!hit.smooth).then_some(*ng);
        let unshadowed = phong::phong(&hit.body.material, hit.object_point, facet, *ns, -d, &incident);
        // Light that could add less than a quarter of the smallest weight, as a share of itself or of 1, is left out.
        let least = 0.25 * reference.min_weight * incident.radiance.max_element().min(1.0);
        if unshadowed != Rgb::ZERO && (path.weight * unshadowed).max_element() >= least {
            sum += unshadowed * visibility(reference, path, vertex, &incident);
        }
    }
    sum
}

/// The share of a light that reaches the vertex.
fn visibility(reference: &Reference, path: &Path, vertex: &Vertex<'_>, light: &Incident) -> Rgb {
    let mut share = Rgb::ONE;
    let shadows = reference.settings.shadows;
    if shadows == Shadows::None {
        return share;
    }
    // Where light grazes the facets of a curved surface, its shadow rays start on that surface.
    let lifted = (1.0 - vertex.ng.dot(light.to_light) / 0.1).clamp(0.0, 1.0);
    let origin = vertex.point + vertex.hit.lift * lifted;
    let end = vertex.point + light.to_light * light.distance;
    let (dir, distance) = if light.distance < f64::INFINITY {
        ((end - origin).normalize(), end.distance(origin))
    } else {
        (light.to_light, light.distance)
    };
    let ray = Ray { origin, dir };
    let far = distance * (1.0 - 1e-9);
    reference.world.each_intersection(&ray, vertex.near, far, |blocker| {
        share *= match shadows {
            Shadows::Transmissive => blocker.body.material.transmission.0,
            Shadows::Opaque | Shadows::None => Rgb::ZERO,
        };
        if share == Rgb::ZERO { f64::NEG_INFINITY } else { far }
    });
    if shadows == Shadows::Transmissive && share != Rgb::ZERO {
        share *= way::colored_shadow(&reference.world, &path.media, &ray, vertex.near, far);
    }
    share
}
