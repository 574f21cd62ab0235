//! No ray passes through a closed mesh: aimed exactly at vertices, exactly at edges and at random, from both sides.

use crate::common::watertight::{KINDS, naive_shares, shoot, shoot_naively};
use strahl::scene::description::Precision;

fn check(precision: Precision, count: usize) {
    let start = std::time::Instant::now();
    let shot = shoot(precision, count);
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{precision:?}: {} rays of each kind in {seconds:.1} s, {} leaks; {} rays were aimed beside the mesh or at its outline",
        shot.rays, shot.leaked, shot.beside
    );
    assert!(shot.leaks.is_empty(), "leaks in {precision:?}:\n{}", shot.leaks.join("\n"));
}

#[test]
fn no_ray_passes_through_a_closed_mesh() {
    check(Precision::Single, 500_000);
    check(Precision::Double, 500_000);
}

#[test]
#[ignore = "10^8 rays of each kind take minutes"]
fn none_of_a_hundred_million_rays_passes_through_a_closed_mesh() {
    let count = std::env::var("STRAHL_RAYS").map_or(100_000_000, |n| n.parse().unwrap());
    check(Precision::Single, count / 2);
    check(Precision::Double, count / 2);
}

#[test]
fn the_usual_triangle_tests_leak_so_this_harness_can_see_leaks() {
    for radius in [1.0, 1e-3] {
        let [vertices, edges] = [0, 1].map(|kind| naive_shares(radius, kind, 40_000));
        println!("radius {radius}: f32, f32 with |det| > 1e-7, f64: vertices {vertices:.4?}, edges {edges:.4?}");
        assert!(vertices[0] > 0.05 && edges[0] > 0.05, "f32 leaks at vertices and edges");
        assert!(vertices[2] > 3e-4, "f64 leaks at vertices too: {}", vertices[2]);
        if radius < 1.0 {
            assert!(vertices[1] == 1.0 && edges[1] == 1.0, "small meshes vanish");
        }
    }
    for precision in [Precision::Single, Precision::Double] {
        let leaks = shoot_naively(precision, 5000);
        for (kind, (leaked, rays)) in KINDS.iter().zip(leaks) {
            println!("{precision:?}, naive triangles for the rays above, {kind}: {leaked} of {rays} leak");
        }
        assert!(leaks[0].0 > 0 && leaks[1].0 > 0, "{precision:?}: naive triangles do not leak: {leaks:?}");
    }
}
