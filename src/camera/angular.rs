//! Fisheye, Omnimax dome, panorama and cylinder: pictures whose coordinates are angles.
//!
//! Sines are taken in f64 for each lane, with the same function everywhere, so these pictures too are the same on
//! every machine.

use super::{Basis, Primary, Window};
use crate::lanes::{Lanes, MAX_LANES, Real, V3};
use crate::math;
use glam::DVec3;

/// A projection by angles.
#[derive(Debug, Clone, Copy)]
pub struct Angular {
    basis: Basis,
    size: (f64, f64),
    /// Corner and step of the window through which it looks.
    origin: [f64; 2],
    step: [f64; 2],
    projection: Projection,
}

#[derive(Debug, Clone, Copy)]
enum Projection {
    /// Equidistant: theta = r fov/2, with r = 1 on a circle of the given diameter around `center` (pixels).
    Equidistant { half_fov: f64, diameter: f64, center: (f64, f64) },
    /// Longitude and latitude are linear in x and y.
    Equirectangular { hfov: f64, vfov: f64 },
    /// Longitude is linear in x, the tangent of the latitude in y.
    Cylindrical { hfov: f64, half_tan: f64 },
}

impl Angular {
    fn new(basis: &Basis, size: (f64, f64), projection: Projection) -> Self {
        Self { basis: *basis, size, origin: [0.0; 2], step: [1.0; 2], projection }
    }

    pub(super) fn through(self, &Window { origin, step, .. }: &Window) -> Self {
        Self { origin, step, ..self }
    }

    pub(crate) fn fisheye(basis: &Basis, fov: f64, size: (f64, f64)) -> Self {
        let center = (size.0 * 0.5, size.1 * 0.5);
        let projection = Projection::Equidistant { half_fov: fov * 0.5, diameter: size.0.min(size.1), center };
        Self::new(basis, size, projection)
    }

    pub(crate) fn omnimax(basis: &Basis, fov: f64, size: (f64, f64)) -> Self {
        let center = (size.0 * 0.5, size.0 * 0.5);
        let projection = Projection::Equidistant { half_fov: fov * 0.5, diameter: size.0, center };
        Self::new(basis, size, projection)
    }

    pub(crate) fn panorama(basis: &Basis, hfov: f64, vfov: f64, size: (f64, f64)) -> Self {
        Self::new(basis, size, Projection::Equirectangular { hfov, vfov })
    }

    pub(crate) fn cylinder(basis: &Basis, hfov: f64, half_tan: f64, size: (f64, f64)) -> Self {
        Self::new(basis, size, Projection::Cylindrical { hfov, half_tan })
    }

    /// Unit direction through a point of the picture, or `None` outside the image circle.
    pub fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let Basis { right, up, forward, .. } = self.basis;
        let (width, height) = self.size;
        let (x, y) = (self.origin[0] + x * self.step[0], self.origin[1] + y * self.step[1]);
        match self.projection {
            Projection::Equidistant { half_fov, diameter, center } => {
                let px = 2.0 * (x - center.0) / diameter;
                let py = 2.0 * (center.1 - y) / diameter;
                let r = (px * px + py * py).sqrt();
                if r > 1.0 {
                    return None;
                }
                let theta = r * half_fov;
                let (sin, cos) = math::sin_cos(theta);
                // sin(theta)/r tends to fov/2 in the middle.
                let scale = if r > 0.0 { sin / r } else { half_fov };
                Some(forward * cos + (right * px + up * py) * scale)
            }
            Projection::Equirectangular { hfov, vfov } => {
                let (sin_lon, cos_lon) = math::sin_cos((x / width - 0.5) * hfov);
                let (sin_lat, cos_lat) = math::sin_cos((0.5 - y / height) * vfov);
                Some(up * sin_lat + (forward * cos_lon + right * sin_lon) * cos_lat)
            }
            Projection::Cylindrical { hfov, half_tan } => {
                let (sin, cos) = math::sin_cos((x / width - 0.5) * hfov);
                Some((forward * cos + right * sin + up * ((1.0 - 2.0 * y / height) * half_tan)).normalize())
            }
        }
    }

    pub(super) fn eye(&self) -> DVec3 {
        self.basis.eye
    }

    /// The inverse of [`direction`](Self::direction): the middle of the picture for the eye itself, and none for what the
    /// picture's circle or cylinder does not hold.
    pub(super) fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let Basis { eye, right, up, forward } = self.basis;
        let (width, height) = self.size;
        let to = point - eye;
        let (x, y, z) = (to.dot(right), to.dot(up), to.dot(forward));
        let flat = (x * x + z * z).sqrt();
        let [x, y] = match self.projection {
            Projection::Equidistant { half_fov, diameter, center } => {
                let across = (x * x + y * y).sqrt();
                let r = math::atan2(across, z) / half_fov;
                if r > 1.0 {
                    return None;
                }
                let scale = if across > 0.0 { 0.5 * diameter * r / across } else { 0.0 };
                [center.0 + x * scale, center.1 - y * scale]
            }
            Projection::Equirectangular { hfov, vfov } => {
                [(math::atan2(x, z) / hfov + 0.5) * width, (0.5 - math::atan2(y, flat) / vfov) * height]
            }
            Projection::Cylindrical { hfov, half_tan } => {
                if flat == 0.0 && y != 0.0 {
                    return None;
                }
                let slope = if flat > 0.0 { y / flat } else { 0.0 };
                [(math::atan2(x, z) / hfov + 0.5) * width, 0.5 * (1.0 - slope / half_tan) * height]
            }
        };
        Some([(x - self.origin[0]) / self.step[0], (y - self.origin[1]) / self.step[1]])
    }

    /// Angle of a pixel from its upper to its lower edge.
    pub(super) fn spread(&self) -> f64 {
        let spread = match self.projection {
            Projection::Equidistant { half_fov, diameter, .. } => 2.0 * half_fov / diameter,
            Projection::Equirectangular { vfov, .. } => vfov / self.size.1,
            Projection::Cylindrical { half_tan, .. } => 2.0 * half_tan / self.size.1,
        };
        spread * self.step[1]
    }

    #[inline(never)]
    pub(super) fn primary<L: Lanes>(&self, s: L::Simd, x: &L, y: &L) -> Primary<L> {
        L::vectorize(
            s,
            #[inline(always)]
            || self.primary_in(s, *x, *y),
        )
    }

    #[inline(always)]
    fn primary_in<L: Lanes>(&self, s: L::Simd, x: L, y: L) -> Primary<L> {
        let mut dirs = [self.basis.forward; MAX_LANES];
        let mut seen = 0;
        for lane in 0..L::COUNT {
            if let Some(dir) = self.direction(x.lane(lane).to_f64(), y.lane(lane).to_f64()) {
                dirs[lane] = dir;
                seen |= 1 << lane;
            }
        }
        let eye = self.basis.eye.to_array().map(L::Real::from_f64);
        Primary {
            origin: V3::splat(s, eye),
            dir: V3::from_fn(s, |lane| dirs[lane].to_array().map(L::Real::from_f64)),
            seen: L::mask(s, seen),
        }
    }
}
