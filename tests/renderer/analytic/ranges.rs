//! Ranges of rays.

use super::*;

fn t(world: &World, t_min: f64, t_max: Option<f64>, scale: f64) -> Option<f64> {
    let direction = [0.0, 0.0, -scale];
    answer(&world.scene, &RayQuery { origin: [0.0, 0.0, 5.0], direction, t_min, t_max }).at.map(|hit| hit.t)
}

#[test]
fn hits_lie_between_t_min_and_t_max() {
    for world in &one(json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } })) {
        assert_eq!(t(world, 0.0, None, 1.0), Some(4.0));
        assert_eq!(t(world, 3.9, None, 1.0), Some(4.0));
        assert_eq!(t(world, 4.0, None, 1.0), Some(6.0));
        assert_eq!(t(world, 4.1, Some(5.9), 1.0), None);
        assert_eq!(t(world, 0.0, Some(3.9), 1.0), None);
        assert_eq!(t(world, 0.0, Some(4.1), 1.0), Some(4.0));
        assert_eq!(t(world, 6.0, None, 1.0), None);
    }
}

#[test]
fn t_counts_in_lengths_of_the_direction() {
    for world in &one(json!({ "sphere": { "center": [0, 0, 0], "radius": 1 } })) {
        for scale in [0, -2, 3, 40, -40, 126, -126, 149, -149, 600, -600].map(|n| 2f64.powi(n)) {
            assert_eq!(t(world, 0.0, None, scale), Some(4.0 / scale));
            assert_eq!(t(world, 5.0 / scale, None, scale), Some(6.0 / scale));
            assert_eq!(t(world, 0.0, Some(3.0 / scale), scale), None);
        }
    }
}
