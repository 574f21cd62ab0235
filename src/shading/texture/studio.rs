//! A photographer's studio as a formula: bright walls around five soft panels. White that scatters its light shows 0.70 from the front
//! (+z), 0.94 to 1.00 from the upper front, 1.35 from above, 0.37 from below, 0.68 to 0.82 from the sides and the back.

use super::environment::directions;
use super::mipmap::Mipmap;
use crate::math::sin_cos;
use glam::DVec3;
use std::sync::{Arc, LazyLock};

/// Rows of its picture: the edges of panels are four texels wide.
const ROWS: u32 = 192;

/// A panel: from +z towards +x and upwards in degrees, half of its width and height as tangents, its radiance.
struct Panel {
    azimuth: f64,
    elevation: f64,
    half: [f64; 2],
    radiance: f64,
}

/// The key light from the upper left of who looks along -z, its counterpart, two strips behind that draw the outline, and one above.
const PANELS: [Panel; 5] = [
    Panel { azimuth: -45.0, elevation: 45.0, half: [0.45, 0.35], radiance: 2.6 },
    Panel { azimuth: 65.0, elevation: 20.0, half: [0.3, 0.5], radiance: 1.1 },
    Panel { azimuth: -145.0, elevation: 30.0, half: [0.18, 0.6], radiance: 3.0 },
    Panel { azimuth: 150.0, elevation: 35.0, half: [0.18, 0.6], radiance: 3.0 },
    Panel { azimuth: 0.0, elevation: 90.0, half: [0.5, 0.5], radiance: 2.0 },
];

/// Width of the soft edges of panels, as a tangent.
const EDGE: f64 = 0.08;

/// A panel's direction, and the directions in which its width and its height lie.
type Frame = [DVec3; 3];

impl Panel {
    fn frame(&self) -> Frame {
        let ((sin_a, cos_a), (sin_e, cos_e)) =
            (sin_cos(self.azimuth.to_radians()), sin_cos(self.elevation.to_radians()));
        let towards = DVec3::new(cos_e * sin_a, sin_e, cos_e * cos_a);
        let right = DVec3::new(cos_a, 0.0, -sin_a);
        [towards, right, towards.cross(right)]
    }

    /// How much of it is seen in a direction.
    fn share(&self, [towards, right, up]: &Frame, dir: DVec3) -> f64 {
        let ahead = dir.dot(*towards);
        if ahead <= 0.0 {
            return 0.0;
        }
        let within = |axis: &DVec3, half: f64| {
            let part = ((half - (dir.dot(*axis) / ahead).abs()) / EDGE).clamp(0.0, 1.0);
            part * part * (3.0 - 2.0 * part)
        };
        within(right, self.half[0]) * within(up, self.half[1])
    }
}

/// Radiance of the walls: the floor is darker than the ceiling.
fn walls(height: f64) -> f64 {
    0.5 + if height > 0.0 { 0.3 } else { 0.2 } * height
}

/// The studio as an equirectangular picture, made once.
pub fn studio() -> Arc<Mipmap> {
    static STUDIO: LazyLock<Arc<Mipmap>> = LazyLock::new(|| Arc::new(drawn()));
    Arc::clone(&STUDIO)
}

fn drawn() -> Mipmap {
    let panels = PANELS.each_ref().map(|panel| (panel, panel.frame()));
    let texel = |dir: DVec3| {
        let light = panels
            .iter()
            .fold(walls(dir.y), |light, (panel, frame)| light + (panel.radiance - light) * panel.share(frame, dir));
        [light as f32; 3]
    };
    Mipmap::new(2 * ROWS, ROWS, directions(ROWS).into_iter().map(texel).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// What white shows that faces a direction, by the integral.
    fn white(facing: DVec3) -> f64 {
        let panels = PANELS.each_ref().map(|panel| (panel, panel.frame()));
        let (mut sum, step) = (0.0, PI / 180.0);
        for row in 0..180 {
            let (up, flat) = sin_cos((f64::from(row) + 0.5) * step - PI / 2.0);
            for column in 0..360 {
                let (sin, cos) = sin_cos(f64::from(column) * step);
                let dir = DVec3::new(flat * sin, up, flat * cos);
                let light = panels.iter().fold(walls(up), |l, (p, frame)| l + (p.radiance - l) * p.share(frame, dir));
                sum += light * dir.dot(facing).max(0.0) * flat * step * step;
            }
        }
        sum / PI
    }

    #[test]
    fn white_is_as_bright_as_it_says() {
        for (facing, expected) in [
            (DVec3::Z, 0.70),
            (DVec3::Y, 1.35),
            (DVec3::NEG_Y, 0.37),
            (DVec3::X, 0.68),
            (DVec3::NEG_Z, 0.82),
            (DVec3::new(0.35, 0.5, 0.79).normalize(), 0.94),
        ] {
            let shown = white(facing);
            assert!((shown - expected).abs() < 0.01, "{facing}: {shown}");
        }
    }
}
