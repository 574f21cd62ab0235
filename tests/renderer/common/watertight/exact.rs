//! Whether a ray meets a mesh, in numbers long enough to be sure: the judge of rays that seem to have leaked.

use crate::common::meshes::Closed;
use crate::common::wide::{Wide, Wide3};
use glam::DVec3;
use strahl::inspect::query::RayQuery;

/// Whether the ray, as it was cast, meets some face, borders included.
///
/// Rays are aimed at points that rounding has moved, far away by much of an edge, so that some of them miss the mesh. The
/// volumes that the line spans with the edges of a face (Pluecker) have one sign where it passes between them. They are
/// triple products of differences of numbers of 24 bits, which 106 bits hold exactly; of numbers of 53 bits the sign is
/// known but for a part in 2^96, and what is nearer counts as met.
fn meets(mesh: &Closed, ray: &RayQuery) -> bool {
    let (o, d) = (Wide3::of(ray.origin.into()), Wide3::of(ray.direction.into()));
    mesh.faces.iter().any(|face| {
        let corners = face.map(|i| mesh.vertices[i]);
        if !is_near(&corners, ray) {
            return false;
        }
        let [a, b, c] = corners.map(|v| Wide3::of(v) - o);
        let volume = |p: Wide3, q: Wide3| d.dot(cross(p, q));
        let volumes = [volume(b, c), volume(c, a), volume(a, b)].map(Wide::value);
        let size = a.value().length() * b.value().length() * c.value().length().max(1e-300);
        let doubt = size * strahl::math::scale_by_power(1.0, -96);
        let one_sign = volumes.iter().all(|v| *v >= -doubt) || volumes.iter().all(|v| *v <= doubt);
        one_sign && [a, b, c].iter().any(|v| d.dot(*v).value() > 0.0)
    })
}

/// Whether the ray and eight around it, `reach` away, all meet the mesh: the ray passes inside its outline, not along it,
/// where a rounded mesh may end a little earlier.
pub fn meets_inside(mesh: &Closed, ray: &RayQuery, reach: f64) -> bool {
    let d = DVec3::from(ray.direction).normalize();
    let (side, up) = d.any_orthonormal_pair();
    let around = (0..8).map(|i| {
        let (sin, cos) = strahl::math::sin_cos(f64::from(i) * std::f64::consts::FRAC_PI_4);
        (side * cos + up * sin) * reach
    });
    meets(mesh, ray)
        && around.into_iter().all(|shift| {
            let origin = (DVec3::from(ray.origin) + shift).into();
            meets(mesh, &RayQuery { origin, ..*ray })
        })
}

/// Whether the line passes a ball around the face, generously: all others need no long numbers.
fn is_near(corners: &[DVec3; 3], ray: &RayQuery) -> bool {
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let radius = corners.iter().map(|v| v.distance(middle)).fold(0.0, f64::max);
    let to = middle - DVec3::from(ray.origin);
    let d = DVec3::from(ray.direction).normalize();
    (to - d * to.dot(d)).length() <= 2.0 * radius + 1e-9 * to.length()
}

fn cross(a: Wide3, b: Wide3) -> Wide3 {
    let ([ax, ay, az], [bx, by, bz]) = (a.0, b.0);
    Wide3([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
}
