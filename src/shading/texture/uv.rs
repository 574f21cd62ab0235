//! UV mapping: texture coordinates of a point in object space, and their gradients.
//!
//! A gradient says how fast a coordinate grows along each axis of object space. That is all that filtering and bumps need
//! (Mikkelsen, Surface Gradient-Based Bump Mapping Framework, JCGT 9(3), 2020).

use crate::math;
use glam::DVec3;
use std::f64::consts::PI;

/// A way to lay pictures on surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UvMapping {
    /// By the texture coordinates of a mesh's vertices.
    Uv,
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

/// The face, with texture coordinates, that a ray has hit.
#[derive(Debug, Clone, Copy)]
pub struct Face {
    /// Its corners in object space.
    pub corners: [DVec3; 3],
    /// u and v at the corners.
    pub uvs: [[f64; 2]; 3],
}

/// A point in texture space.
#[derive(Debug, Clone, Copy)]
pub struct TexCoord {
    /// u and v.
    pub uv: [f64; 2],
    /// Their gradients in object space.
    pub gradients: [DVec3; 2],
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

    /// The texture coordinates of a point in object space; of a mesh without any they are 0.
    pub fn at(&self, p: DVec3, face: Option<&Face>) -> TexCoord {
        match *self {
            Self::Uv => face.map_or(TexCoord { uv: [0.0; 2], gradients: [DVec3::ZERO; 2] }, |face| face.at(p)),
            Self::Planar { right, up } => TexCoord { uv: [right.dot(p), up.dot(p)], gradients: [right, up] },
            Self::Spherical { center, frame: [east, north, front] } => {
                let q = p - center;
                let (x, y, z) = (q.dot(east), q.dot(north), q.dot(front));
                let around = x * x + z * z;
                let rho = around.sqrt();
                let square = around + y * y;
                // The poles have no longitude, and the centre has no direction.
                if !(around > 0.0 && square > 0.0) {
                    let v = if y < 0.0 { 0.0 } else { 1.0 };
                    return TexCoord { uv: [0.5, v], gradients: [DVec3::ZERO; 2] };
                }
                let uv = [0.5 + math::atan2(x, z) / (2.0 * PI), 0.5 + math::atan2(y, rho) / PI];
                let of_u = (east * z - front * x) / (2.0 * PI * around);
                let outward = (east * x + front * z) / rho;
                let of_v = (north * rho - outward * y) / (PI * square);
                TexCoord { uv, gradients: [of_u, of_v] }
            }
        }
    }
}

impl Face {
    /// Weighted by barycentric coordinates, which are linear: b1 grows along e2 x n / n^2, b2 along n x e1 / n^2, where
    /// n = e1 x e2.
    fn at(&self, p: DVec3) -> TexCoord {
        let [a, b, c] = self.corners;
        let (e1, e2) = (b - a, c - a);
        let n = e1.cross(e2);
        let square = n.length_squared();
        let [first, second, third] = self.uvs;
        // A face too thin to have a direction shows its first corner.
        if !(square > 0.0 && square.is_finite()) {
            return TexCoord { uv: first, gradients: [DVec3::ZERO; 2] };
        }
        let (of_b1, of_b2) = (e2.cross(n) / square, n.cross(e1) / square);
        let gradients = [0, 1].map(|i| of_b1 * (second[i] - first[i]) + of_b2 * (third[i] - first[i]));
        TexCoord { uv: [0, 1].map(|i| first[i] + gradients[i].dot(p - a)), gradients }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gradients against differences.
    fn check(mapping: UvMapping, face: Option<&Face>, p: DVec3, directions: &[DVec3]) {
        let here = mapping.at(p, face);
        for direction in directions {
            let h = 1e-6;
            for i in 0..2 {
                let slope = (mapping.at(p + *direction * h, face).uv[i] - mapping.at(p - *direction * h, face).uv[i])
                    / (2.0 * h);
                assert!((slope - here.gradients[i].dot(*direction)).abs() < 1e-8, "{mapping:?} {slope}");
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
        let face = Face {
            corners: [DVec3::ZERO, DVec3::new(2.0, 0.5, 0.0), DVec3::new(0.3, 3.0, 1.0)],
            uvs: [[0.1, 0.2], [0.9, 0.3], [0.0, 1.5]],
        };
        let [_, b, c] = face.corners;
        check(UvMapping::Uv, Some(&face), (b + c) / 3.0, &[b.normalize(), c.normalize()]);
        for (corner, uv) in face.corners.iter().zip(face.uvs) {
            let got = UvMapping::Uv.at(*corner, Some(&face)).uv;
            assert!((got[0] - uv[0]).abs() + (got[1] - uv[1]).abs() < 1e-14);
        }
    }

    #[test]
    fn a_globe_shows_its_picture_to_the_front() {
        let globe = UvMapping::globe(DVec3::ZERO, DVec3::Y);
        let uv = |p: DVec3| globe.at(p, None).uv;
        assert_eq!(uv(DVec3::Z), [0.5, 0.5]);
        assert_eq!(uv(DVec3::X), [0.75, 0.5]);
        assert_eq!(uv(DVec3::NEG_X), [0.25, 0.5]);
        assert_eq!((uv(DVec3::Y)[1], uv(DVec3::NEG_Y)[1]), (1.0, 0.0));
    }
}
