//! Lights in the kernel's format.

use super::materials::narrow_rgb;
use crate::lanes::Real;
use crate::math;
use crate::scene::description::{self as d, Vec3};
use crate::scene::world::shows;
use crate::shading::light::{Area, Falloff, Light, Source};
use glam::DVec3;

pub(super) fn light<R: Real>((number, light): (usize, &d::Light)) -> Light<R> {
    let point = |p: Vec3| p.map(R::from_f64);
    let unit = |v: Vec3| DVec3::from_array(v).normalize();
    let fall = |falloff: d::Falloff| match falloff {
        d::Falloff::None => Falloff::None,
        d::Falloff::Linear(linear) => Falloff::Linear { reach: R::from_f64(linear.reach) },
        d::Falloff::InverseSquare => Falloff::InverseSquare,
        d::Falloff::Windowed(windowed) => Falloff::Windowed { range: R::from_f64(windowed.range) },
    };
    let (source, color, intensity, falloff) = match light {
        d::Light::Point(l) => (Source::Point { position: point(l.position) }, l.color, l.intensity, fall(l.falloff)),
        d::Light::Directional(l) => {
            let to_light = (-unit(l.direction)).to_array().map(R::from_f64);
            (Source::Directional { to_light }, l.color, l.intensity, Falloff::None)
        }
        d::Light::Spot(l) => {
            // 1 - cos(a) = 2 sin^2(a/2).
            let versine = |degrees: f64| R::from_f64(2.0 * math::sin_cos(degrees.to_radians() * 0.5).0.powi(2));
            let source = Source::Spot {
                position: point(l.position),
                axis: unit(l.direction).to_array().map(R::from_f64),
                inner: versine(l.inner_deg),
                outer: versine(l.outer_deg),
            };
            (source, l.color, l.intensity, fall(l.falloff))
        }
    };
    let color = narrow_rgb(color.0 * intensity);
    // Where no light comes from there is no point to choose.
    let area = area(light).filter(|_| shows(color));
    Light { source, color, falloff, area, number: number as u32 }
}

/// The area of a light; none if it is a point after all.
fn area<R: Real>(light: &d::Light) -> Option<Area<R>> {
    let disc = |radius: f64| {
        let radius = R::from_f64(radius);
        (radius > R::from_f64(0.0)).then_some(Area::Disc { radius })
    };
    match light {
        d::Light::Point(d::PointLight { area, .. }) | d::Light::Spot(d::SpotLight { area, .. }) => {
            match area.as_ref()? {
                d::Area::Disc(area) => disc(area.radius),
                d::Area::Parallelogram(area) => {
                    let edge = |v: Vec3| v.map(R::from_f64);
                    let point = [area.u, area.v].as_flattened().iter().all(|x| *x == 0.0);
                    (!point).then(|| Area::Parallelogram { u: edge(area.u), v: edge(area.v) })
                }
            }
        }
        d::Light::Directional(light) => disc(math::tan(light.area?.angle_deg.to_radians() * 0.5)),
    }
}
