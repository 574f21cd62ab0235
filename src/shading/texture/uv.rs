//! UV mapping: texture coordinates of a point in object space, and their gradients.
//!
//! A gradient says how fast a coordinate grows along each axis of object space. That is all that filtering and bumps need
//! (Mikkelsen, Surface Gradient-Based Bump Mapping Framework, JCGT 9(3), 2020).

use crate::lanes::{Double, V3, angle};
use glam::DVec3;
use std::f64::consts::PI;

/// A way to lay pictures on surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UvMapping {
    /// By the texture coordinates of a mesh's vertices.
    Uv,
    /// By one of the two sets of texture coordinates of a mesh's vertices, moved: u and v are `rows` times those, and `offset`.
    Moved {
        /// Whether it is the second set.
        second: bool,
        /// Factors on u and v, for the new u and the new v.
        rows: [[f64; 2]; 2],
        /// What is added to them.
        offset: [f64; 2],
    },
    /// u = `right` . p, v = `up` . p.
    Planar {
        /// Gradient of u.
        right: DVec3,
        /// Gradient of v.
        up: DVec3,
    },
    /// Longitude and latitude around a centre.
    Spherical {
        /// The centre.
        center: DVec3,
        /// Unit vectors to longitude 90 degrees, to the north pole, and to longitude and latitude 0.
        frame: [DVec3; 3],
    },
}

/// The faces, with texture coordinates, that rays have hit.
#[derive(Debug, Clone, Copy)]
pub struct Face<W> {
    /// Their corners in object space.
    pub corners: [V3<W>; 3],
    /// u and v at the corners.
    pub uvs: [[W; 2]; 3],
    /// What few meshes have.
    pub attributes: Option<Attributes<W>>,
}

/// Other numbers at the corners of faces.
#[derive(Debug, Clone, Copy)]
pub struct Attributes<W> {
    /// Other u and v.
    pub uvs: [[W; 2]; 3],
    /// Red, green, blue and alpha.
    pub colors: [[W; 4]; 3],
    /// The directions in which u grows, and the hands of their frames, where a mesh says so.
    pub tangents: Option<[[W; 4]; 3]>,
}

/// Points in texture space.
#[derive(Debug, Clone, Copy)]
pub struct TexCoord<W> {
    /// u and v.
    pub uv: [W; 2],
    /// Their gradients in object space.
    pub gradients: [V3<W>; 2],
}

impl UvMapping {
    /// A globe around a centre; `axis` points to the north pole, and has any length but 0.
    pub fn globe(center: DVec3, axis: DVec3) -> Self {
        let north = axis.normalize();
        // The middle of the picture faces +z, unless the pole does.
        let towards = |v: DVec3| v - north * north.dot(v);
        let front = towards(DVec3::Z);
        let front = if front.length_squared() > 1e-12 { front } else { towards(DVec3::NEG_Y) }.normalize();
        Self::Spherical { center, frame: [north.cross(front), north, front] }
    }

    /// The texture coordinates of points in object space; of a mesh without any they are 0.
    #[inline(always)]
    pub fn at<W: Double>(&self, s: W::Simd, p: V3<W>, face: Option<&Face<W>>) -> TexCoord<W> {
        let zero = W::lit(s, 0.0);
        let nothing = V3 { x: zero, y: zero, z: zero };
        match *self {
            Self::Uv => match face {
                Some(face) => face.at(s, p),
                None => TexCoord { uv: [zero; 2], gradients: [nothing; 2] },
            },
            Self::Moved { second, rows, offset } => {
                let Some(face) = face else { return TexCoord { uv: [zero; 2], gradients: [nothing; 2] } };
                let TexCoord { uv: [u, v], gradients: [of_u, of_v] } = match &face.attributes {
                    Some(attributes) if second => face.coordinates(s, p, &attributes.uvs),
                    _ => face.at(s, p),
                };
                let [[a, b], [c, d]] = rows;
                let [a, b, c, d] = [W::lit(s, a), W::lit(s, b), W::lit(s, c), W::lit(s, d)];
                let [right, up] = [W::lit(s, offset[0]), W::lit(s, offset[1])];
                TexCoord {
                    uv: [a * u + b * v + right, c * u + d * v + up],
                    gradients: [of_u * a + of_v * b, of_u * c + of_v * d],
                }
            }
            Self::Planar { right, up } => {
                let gradients = [V3::splat(s, right.to_array()), V3::splat(s, up.to_array())];
                TexCoord { uv: [gradients[0].dot(p), gradients[1].dot(p)], gradients }
            }
            Self::Spherical { center, frame: [east, north, front] } => {
                let [east, north, front] =
                    [V3::splat(s, east.to_array()), V3::splat(s, north.to_array()), V3::splat(s, front.to_array())];
                let q = p - V3::splat(s, center.to_array());
                let (x, y, z) = (q.dot(east), q.dot(north), q.dot(front));
                let around = x * x + z * z;
                let rho = around.sqrt();
                let square = around + y * y;
                // The poles have no longitude, and the centre has no direction.
                let known = around.gt(zero) & square.gt(zero);
                let (half, one) = (W::lit(s, 0.5), W::lit(s, 1.0));
                let u = half + angle(s, x, z) / W::lit(s, 2.0 * PI);
                let v = half + angle(s, y, rho) / W::lit(s, PI);
                let of_u = over(east * z - front * x, W::lit(s, 2.0 * PI) * around);
                let outward = over(east * x + front * z, rho);
                let of_v = over(north * rho - outward * y, W::lit(s, PI) * square);
                let pole = W::select(y.lt(zero), zero, one);
                TexCoord {
                    uv: [W::select(known, u, half), W::select(known, v, pole)],
                    gradients: [V3::select(known, of_u, nothing), V3::select(known, of_v, nothing)],
                }
            }
        }
    }
}

impl<W: Double> Face<W> {
    /// Weighted by barycentric coordinates, which are linear: b1 grows along e2 x n / n^2, b2 along n x e1 / n^2, where
    /// n = e1 x e2.
    #[inline(always)]
    fn at(&self, s: W::Simd, p: V3<W>) -> TexCoord<W> {
        self.coordinates(s, p, &self.uvs)
    }

    /// The colors of points, white where the mesh has none.
    #[inline(always)]
    pub fn colors(&self, s: W::Simd, p: V3<W>) -> Option<[W; 4]> {
        let colors = &self.attributes.as_ref()?.colors;
        let [red, green] = self.two_of(s, p, colors, 0);
        let [blue, alpha] = self.two_of(s, p, colors, 2);
        Some([red, green, blue, alpha])
    }

    /// The tangents of points as the mesh says, and the sides that v grows to: above 0, the cross product of normal and tangent.
    #[inline(always)]
    pub fn tangents(&self, s: W::Simd, p: V3<W>) -> Option<(V3<W>, W)> {
        let tangents = self.attributes.as_ref()?.tangents.as_ref()?;
        let [x, y] = self.two_of(s, p, tangents, 0);
        let [z, hand] = self.two_of(s, p, tangents, 2);
        Some((V3 { x, y, z }, hand))
    }

    /// Two channels of colors at the corners. Not by `map`, which calls so large a closure as a function of its own.
    #[inline(always)]
    fn two_of(&self, s: W::Simd, p: V3<W>, [a, b, c]: &[[W; 4]; 3], i: usize) -> [W; 2] {
        self.coordinates(s, p, &[[a[i], a[i + 1]], [b[i], b[i + 1]], [c[i], c[i + 1]]]).uv
    }

    #[inline(always)]
    fn coordinates(&self, s: W::Simd, p: V3<W>, uvs: &[[W; 2]; 3]) -> TexCoord<W> {
        let [a, b, c] = self.corners;
        let (e1, e2) = (b - a, c - a);
        let n = e1.cross(e2);
        let square = n.dot(n);
        let [first, second, third] = *uvs;
        // A face too thin to have a direction shows its first corner.
        let zero = W::lit(s, 0.0);
        let known = square.gt(zero) & square.lt(W::lit(s, f64::INFINITY));
        let of_bs = [over(e2.cross(n), square), over(n.cross(e1), square)];
        let from_first = p - a;
        let of_u = Self::weighted(s, of_bs, [first[0], second[0], third[0]], known);
        let of_v = Self::weighted(s, of_bs, [first[1], second[1], third[1]], known);
        let u = W::select(known, first[0] + of_u.dot(from_first), first[0]);
        let v = W::select(known, first[1] + of_v.dot(from_first), first[1]);
        TexCoord { uv: [u, v], gradients: [of_u, of_v] }
    }

    /// The gradient of a coordinate with these values at the corners.
    #[inline(always)]
    fn weighted(s: W::Simd, [of_b1, of_b2]: [V3<W>; 2], [a, b, c]: [W; 3], known: W::Mask) -> V3<W> {
        V3::select(known, of_b1 * (b - a) + of_b2 * (c - a), V3::splat(s, [0.0; 3]))
    }
}

#[inline(always)]
fn over<W: Double>(v: V3<W>, k: W) -> V3<W> {
    V3 { x: v.x / k, y: v.y / k, z: v.z / k }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vector(p: DVec3) -> V3<f64> {
        V3 { x: p.x, y: p.y, z: p.z }
    }

    fn at(mapping: &UvMapping, p: DVec3, face: Option<&Face<f64>>) -> TexCoord<f64> {
        mapping.at((), vector(p), face)
    }

    /// The gradients against differences.
    fn check(mapping: UvMapping, face: Option<&Face<f64>>, p: DVec3, directions: &[DVec3]) {
        let here = at(&mapping, p, face);
        for direction in directions {
            let h = 1e-6;
            for i in 0..2 {
                let slope = (at(&mapping, p + *direction * h, face).uv[i]
                    - at(&mapping, p - *direction * h, face).uv[i])
                    / (2.0 * h);
                assert!((slope - here.gradients[i].dot(vector(*direction))).abs() < 1e-8, "{mapping:?} {slope}");
            }
        }
    }

    #[test]
    fn gradients_are_those_of_the_coordinates() {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        for axis in [DVec3::Y, DVec3::Z, DVec3::new(1.0, -2.0, 0.5)] {
            let globe = UvMapping::globe(DVec3::new(1.0, 2.0, 3.0), axis);
            check(globe, None, DVec3::new(1.3, 2.9, 1.1), &axes);
        }
        let corners = [DVec3::ZERO, DVec3::new(2.0, 0.5, 0.0), DVec3::new(0.3, 3.0, 1.0)];
        let face = Face { corners: corners.map(vector), uvs: [[0.1, 0.2], [0.9, 0.3], [0.0, 1.5]], attributes: None };
        let [_, b, c] = corners;
        let turned = UvMapping::Moved { second: false, rows: [[0.0, 2.0], [-3.0, 0.5]], offset: [0.25, 4.0] };
        check(turned, Some(&face), (b + c) / 3.0, &[b.normalize(), c.normalize()]);
        check(UvMapping::Uv, Some(&face), (b + c) / 3.0, &[b.normalize(), c.normalize()]);
        for (corner, uv) in corners.iter().zip(face.uvs) {
            let got = at(&UvMapping::Uv, *corner, Some(&face)).uv;
            assert!((got[0] - uv[0]).abs() + (got[1] - uv[1]).abs() < 1e-14);
        }
    }

    #[test]
    fn a_globe_shows_its_picture_to_the_front() {
        let globe = UvMapping::globe(DVec3::ZERO, DVec3::Y);
        let uv = |p: DVec3| at(&globe, p, None).uv;
        assert_eq!(uv(DVec3::Z), [0.5, 0.5]);
        assert_eq!(uv(DVec3::X), [0.75, 0.5]);
        assert_eq!(uv(DVec3::NEG_X), [0.25, 0.5]);
        assert_eq!((uv(DVec3::Y)[1], uv(DVec3::NEG_Y)[1]), (1.0, 0.0));
    }
}
