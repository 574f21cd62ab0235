//! An upper bound on how many primitives can lie around one point: what a ray's search may take without finding anything.
//!
//! Instances of instances double it with each level, while the text of the scene grows by a line. It is found from the
//! boxes alone, level by level of each hierarchy, so it counts what lies close together, too.

use super::geometry::Geometry;
use super::item::Shape;
use super::wide_bvh::{Child, WideBvh, WideNode};
use crate::lanes::{Double, MAX_LANES, Real, dispatch};
use fearless_simd::{Level, f64x8};
use std::ops::Range;

/// The bound for the scene whose root is `geometries[root]`. Geometries come after those they place.
pub(crate) fn overlap<R: Real>(geometries: &[Geometry<R>], root: usize) -> f64 {
    dispatch!(Level::new(), over_lanes::<f64x8, f64>(geometries, root))
}

fn over_lanes<W: Double>(s: W::Simd, geometries: &[Geometry<impl Real>], root: usize) -> f64 {
    let mut known: Vec<f64> = Vec::with_capacity(geometries.len());
    for geometry in geometries {
        let weight = |item: u32| match &geometry.items[item as usize].shape {
            Shape::Instance(instance) => known[instance.geometry as usize],
            _ => 1.0,
        };
        let unbounded: f64 = geometry.unbounded.iter().map(|item| weight(*item)).sum();
        let places_any = geometry.items.iter().any(|item| matches!(item.shape, Shape::Instance(_)));
        let leaf = |places: Range<usize>| match places_any {
            true => geometry.primitives[places].iter().map(|primitive| weight(primitive.item)).sum(),
            false => places.len() as f64,
        };
        let bounded = geometry.wide.as_ref().map_or(0.0, |wide| below::<W, _>(s, wide, wide.root, &leaf));
        known.push(unbounded + bounded);
    }
    known.get(root).copied().unwrap_or_default()
}

/// The bound below a node or a leaf.
fn below<W: Double, R: Real>(
    s: W::Simd,
    wide: &WideBvh<R>,
    child: Child,
    of_leaf: &impl Fn(Range<usize>) -> f64,
) -> f64 {
    match child.index() {
        Ok(node) => {
            let node = &wide.nodes[node];
            let mut weights = [0.0; MAX_LANES];
            for (weight, child) in weights.iter_mut().zip(&node.children[..node.count as usize]) {
                *weight = below::<W, R>(s, wide, *child, of_leaf);
            }
            W::vectorize(
                s,
                #[inline(always)]
                || densest::<W, R>(s, node, &weights),
            )
        }
        Err(first) => wide.leaves_of_box(first).iter().map(|leaf| of_leaf(leaf.places())).sum(),
    }
}

/// The largest sum of weights of boxes that hold one point: at most that of intervals along each axis, which is largest where
/// one of them begins.
#[inline(always)]
fn densest<W: Double, R: Real>(s: W::Simd, node: &WideNode<R>, weights: &[f64; MAX_LANES]) -> f64 {
    let count = node.count as usize;
    let mut least = f64::INFINITY;
    for axis in 0..3 {
        let [min, max] = [&node.min[axis], &node.max[axis]].map(|ends| ends.map(R::to_f64));
        let mut most = 0.0f64;
        for first in (0..count).step_by(W::COUNT) {
            // What each beginning is in.
            let points = W::load(s, &min[first..]);
            let (zero, mut sums) = (W::lit(s, 0.0), W::lit(s, 0.0));
            for ((low, high), weight) in min.iter().zip(&max).zip(weights).take(count) {
                let inside = W::splat(s, *low).le(points) & points.le(W::splat(s, *high));
                sums = sums + W::select(inside, W::splat(s, *weight), zero);
            }
            for lane in 0..W::COUNT.min(count - first) {
                most = most.max(sums.lane(lane));
            }
        }
        least = least.min(most);
    }
    least
}

#[cfg(test)]
mod tests {
    use crate::scene::compile::Precise;
    use crate::scene::{Format, Overrides, load};

    fn scene(objects: &str, definitions: &str) -> String {
        format!(
            r#"{{ "version": 1, "camera": {{ "pinhole": {{ "eye": [0, 0, 5], "look_at": [0, 0, 0] }} }},
                "definitions": {{ {definitions} }}, "objects": [ {objects} ] }}"#
        )
    }

    fn overlap(objects: &str, definitions: &str) -> f64 {
        let text = scene(objects, definitions);
        match load(text.as_bytes(), Format::Json, &Overrides::default()).unwrap().scene.world {
            Precise::Single(world) => super::overlap(&world.geometries, world.root),
            Precise::Double(world) => super::overlap(&world.geometries, world.root),
        }
    }

    fn ball(x: f64) -> String {
        format!(r#"{{ "sphere": {{ "center": [{x}, 0, 0], "radius": 1 }} }}"#)
    }

    /// The slow twin has one lane.
    #[test]
    fn lanes_do_not_count() {
        let balls: Vec<_> = (0..500).map(|i| ball(f64::from(i * i % 331) * 0.7)).collect();
        let text = scene(&balls.join(", "), "");
        let Precise::Single(world) = load(text.as_bytes(), Format::Json, &Overrides::default()).unwrap().scene.world
        else {
            panic!("single precision is the default")
        };
        let found = super::overlap(&world.geometries, world.root);
        assert!(found > 10.0, "{found}");
        assert_eq!(found, super::over_lanes::<f64>((), &world.geometries, world.root));
    }

    #[test]
    fn bodies_at_one_place_are_counted_and_those_apart_are_not() {
        assert_eq!(overlap(&ball(0.0), ""), 1.0);
        assert_eq!(overlap(&vec![ball(0.0); 100].join(", "), ""), 100.0);
        let apart: Vec<_> = (0..100).map(|i| ball(f64::from(i) * 3.0)).collect();
        // At most those of a leaf, which count as if they lay at one place.
        assert!(overlap(&apart.join(", "), "") <= crate::lanes::MAX_LANES as f64);
    }

    /// A leaf with bodies of two kinds is one for each.
    #[test]
    fn bodies_of_several_kinds_at_one_place_are_all_counted() {
        let triangle = r#"{ "triangle": { "vertices": [[-1, -1, 0], [1, -1, 0], [0, 1, 1]] } }"#;
        let mut bodies = vec![triangle.to_owned(); 12];
        bodies.push(ball(0.0));
        assert_eq!(overlap(&bodies.join(", "), ""), 13.0);
    }

    #[test]
    fn instances_of_instances_double_it() {
        let mut definitions = vec![format!(r#""d0": [ {} ]"#, ball(0.0))];
        for level in 1..=20 {
            let instance = format!(r#"{{ "instance": {{ "of": "d{}" }} }}"#, level - 1);
            definitions.push(format!(r#""d{level}": [ {instance}, {instance} ]"#));
        }
        assert_eq!(overlap(r#"{ "instance": { "of": "d20" } }"#, &definitions.join(", ")), f64::from(1 << 20));
    }
}
