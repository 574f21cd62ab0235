//! Extents of items, from their numbers as rounded to the kernel's format.

use crate::accel::{Bounds, Extent, Geometry, Instance};
use crate::lanes::Real;
use crate::scene::description::{self as d, Object, Vec3};
use glam::{DAffine3, DMat3, DVec3};

/// Extent of an object that is neither mesh nor instance; `None` if it has no bounds.
pub(super) fn of_object<R: Real>(object: &Object) -> Option<Extent> {
    let round = |x: f64| R::from_f64(x).to_f64();
    let point = |p: Vec3| DVec3::from_array(p.map(round));
    let bounds = match object {
        Object::Sphere(d::Sphere { center, radius, .. }) => Bounds::around([point(*center)]).grown(round(*radius)),
        Object::Disc(o) => ring(point(o.center), point(o.normal), o.radius),
        Object::Box(o) => Bounds::around([point(o.min), point(o.max)]),
        Object::Cylinder(o) => {
            let axis = point(o.top) - point(o.base);
            ring(point(o.base), axis, o.radius).union(ring(point(o.top), axis, o.radius))
        }
        Object::Cone(o) => {
            let axis = point(o.top) - point(o.base);
            ring(point(o.base), axis, o.base_radius).union(ring(point(o.top), axis, o.top_radius))
        }
        Object::Torus(o) => ring(point(o.center), point(o.axis), o.major_radius).grown(o.minor_radius),
        _ => return None,
    };
    let mut extent = Extent::of_box(padded::<R>(bounds));
    if let Object::Sphere(sphere) = object {
        extent.radius = 0.5 * (extent.bounds.max - extent.bounds.min).max_element();
        debug_assert!(extent.radius >= sphere.radius);
    }
    Some(extent)
}

/// Box around a circle.
fn ring(center: DVec3, axis: DVec3, radius: f64) -> Bounds {
    let axis = axis.normalize();
    let reach = (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt) * radius;
    Bounds { min: center - reach, max: center + reach }
}

/// A box enlarged by the roundings of the intersection code in its own coordinates.
fn padded<R: Real>(bounds: Bounds) -> Bounds {
    let size = bounds.min.abs().max(bounds.max.abs()).max_element();
    bounds.grown(32.0 * R::ROUNDOFF * size)
}

/// Extent of a placed geometry; `None` if it has no bounds.
pub(super) fn of_instance<R: Real>(instance: &Instance<R>, geometry: &Geometry<R>) -> Option<Extent> {
    if geometry.is_unbounded() {
        return None;
    }
    let Extent { bounds, center, radius } = geometry.extent;
    if radius < 0.0 {
        return Some(Extent::EMPTY);
    }
    let vector = |v: [R; 3]| DVec3::from_array(v.map(Real::to_f64));
    let [x, y, z] = instance.to_world.columns.map(vector);
    let map = DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation: vector(instance.to_world.translation) };
    // The map and its inverse round relative to their summands, not to the result.
    let span = bounds.min.abs().max(bounds.max.abs());
    let sums = x.abs() * span.x + y.abs() * span.y + z.abs() * span.z + map.translation.abs();
    let slack = 32.0 * R::ROUNDOFF * sums.max_element();
    Some(Extent {
        bounds: Bounds::around(bounds.corners().map(|p| map.transform_point3(p))).grown(slack),
        center: map.transform_point3(center),
        radius: radius * instance.to_world.largest_stretch() + slack,
    })
}
