//! Reflection, refraction and media.

use super::*;

fn degrees(angle: f64) -> [f64; 3] {
    [angle.to_radians().sin(), -angle.to_radians().cos(), 0.0]
}

/// From one unit away onto the middle of a surface, `angle` degrees from its normal, which is y.
#[track_caller]
fn onto_floor(world: &World, angle: f64) -> RayHit {
    let d = degrees(angle);
    query(world, minus(d), d).unwrap()
}

fn floor(material: &str) -> [World; 2] {
    one(json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": material } }))
}

#[test]
fn the_mirror_direction_has_the_same_angle_on_the_other_side() {
    for world in &floor("mirror") {
        let hit = query(world, [-3.0, 4.0, 0.0], [6.0, -8.0, 0.0]).unwrap();
        assert_vector(hit.reflected, [0.6, 0.8, 0.0], world.small);
        assert_eq!(hit.transmitted, None);
        assert!(!hit.tir);
        let below = query(world, [0.0, -2.0, 0.0], [1.0, 1.0, 0.0]).unwrap();
        assert_vector(below.reflected, [0.5f64.sqrt(), -0.5f64.sqrt(), 0.0], world.small);
    }
}

#[test]
fn snells_law_holds_into_glass_and_out_of_it() {
    for world in &floor("glass") {
        for angle in [0.0, 1.0, 30.0, 60.0, 89.0] {
            let hit = onto_floor(world, angle);
            let sine = angle.to_radians().sin() / 1.5;
            let inside = hit.transmitted.unwrap();
            assert_vector(inside, [sine, -(1.0 - sine * sine).sqrt(), 0.0], world.small);
            let back = query(world, [inside[0] * 2.0, inside[1] * 2.0, 0.0], minus(inside)).unwrap();
            assert!(!back.entering);
            // Close to the critical angle a rounding of the sine counts more than once.
            let steep = 1.0 / angle.to_radians().cos();
            assert_vector(back.transmitted.unwrap(), minus(degrees(angle)), world.small * steep);
        }
    }
}

#[test]
fn fresnels_reflectance_at_normal_incidence_at_brewsters_angle_and_at_grazing() {
    for world in &floor("glass") {
        assert_near(onto_floor(world, 0.0).reflectance, 0.04, world.small);
        let brewster = onto_floor(world, 1.5f64.atan().to_degrees());
        assert_near(brewster.reflectance, (1.25f64 / 3.25).powi(2) / 2.0, world.small);
        // There the two directions are perpendicular.
        let dot = DVec3::from(brewster.reflected).dot(brewster.transmitted.unwrap().into());
        assert_near(dot, 0.0, world.small);
        assert!(onto_floor(world, 89.999).reflectance > 0.99);
        let out = query(world, [0.0, -1.0, 0.0], Y).unwrap();
        assert_near(out.reflectance, 0.04, world.small);
    }
}

#[test]
fn opaque_bodies_have_a_reflectance_but_transmit_nothing() {
    let pool = json!({ "materials": { "ink": { "ior": 3 } } });
    for world in &worlds(json!([{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "ink" } }]), pool) {
        let hit = query(world, [0.0, 4.0, 0.0], minus(Y)).unwrap();
        assert_near(hit.reflectance, 0.25, world.small);
        assert_eq!(hit.transmitted, None);
        assert!(!hit.tir);
    }
}

#[test]
fn total_reflection_begins_at_the_critical_angle() {
    let critical = (1.0f64 / 1.5).asin().to_degrees();
    for world in &floor("glass") {
        for (angle, total) in
            [(0.0, false), (critical - 0.01, false), (critical + 0.01, true), (45.0, true), (89.0, true)]
        {
            let [x, y, _] = degrees(angle);
            let hit = query(world, [-x, y, 0.0], [x, -y, 0.0]).unwrap();
            assert_eq!(hit.tir, total, "{angle}");
            assert_eq!(hit.transmitted.is_none(), total);
            assert_eq!(hit.reflectance == 1.0, total);
            assert_vector(hit.reflected, [x, y, 0.0], world.small);
        }
        for angle in [80.0, 89.99] {
            assert!(!onto_floor(world, angle).tir, "never into the denser medium");
        }
    }
}

#[test]
fn matched_indices_are_invisible() {
    for world in &floor("nothing") {
        for angle in [0.0, 45.0, 89.9] {
            let hit = onto_floor(world, angle);
            assert_eq!(hit.reflectance, 0.0);
            assert_vector(hit.transmitted.unwrap(), degrees(angle), 0.25 * world.small);
        }
    }
}

#[test]
fn thin_surfaces_do_not_bend_light() {
    for surface in [
        json!({ "disc": { "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 1, "material": "glass" } }),
        json!({ "quad": { "vertices": [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], "material": "glass" } }),
        json!({ "polygon": { "vertices": [[-1, 0, 1], [1, 0, 1], [0, 0, -1]], "material": "glass" } }),
    ] {
        for world in &one(surface) {
            let hit = onto_floor(world, 50.0);
            assert_vector(hit.transmitted.unwrap(), degrees(50.0), world.small);
            assert_eq!(hit.reflectance, 0.0);
        }
    }
}

/// Sine of the angle behind an interface of a ray that comes `sine` in from a normal along z.
fn sine_behind(world: &World, origin: [f64; 3], direction: [f64; 3]) -> Option<f64> {
    let hit = query(world, origin, direction).unwrap();
    let normal = DVec3::from(hit.normal);
    hit.transmitted.map(|d| DVec3::from(d).cross(normal).length())
}

#[test]
fn rays_know_the_media_they_start_in() {
    // Glass in water, both around the origin; 0.6 off the axis the sine on the glass ball is 0.6.
    let glass_in_water = json!([
        { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "glass" } },
        { "sphere": { "center": [0, 0, 0], "radius": 5, "material": "water" } }
    ]);
    for world in &bodies(glass_in_water) {
        let into_water = sine_behind(world, [3.0, 0.0, 9.0], minus(Z)).unwrap();
        assert_near(into_water, 0.6 / 1.33, world.small);
        let into_glass = sine_behind(world, [0.6, 0.0, 3.0], minus(Z)).unwrap();
        assert_near(into_glass, 0.6 * 1.33 / 1.5, world.small);
        let out_of_glass = sine_behind(world, [0.6, 0.0, 0.0], minus(Z)).unwrap();
        assert_near(out_of_glass, 0.6 * 1.5 / 1.33, world.small);
        let out_of_water = sine_behind(world, [3.0, 0.0, 2.0], Z).unwrap();
        assert_near(out_of_water, 0.6 * 1.33, world.small);
        assert!(sine_behind(world, [0.0, 4.0, 0.1], Z).is_none(), "0.8 * 1.33 > 1");
    }
}

#[test]
fn an_air_bubble_in_glass_bends_away() {
    let bubble = json!([
        { "sphere": { "center": [0, 0, 0], "radius": 4, "material": "glass" } },
        { "sphere": { "center": [0, 0, 0], "radius": 1, "material": "glass", "hollow": true, "name": "bubble" } }
    ]);
    for world in &bodies(bubble) {
        let into_air = query(world, [0.6, 0.0, 3.0], minus(Z)).unwrap();
        assert_eq!((into_air.name.as_deref(), into_air.entering), (Some("bubble"), false));
        assert_near(sine_behind(world, [0.6, 0.0, 3.0], minus(Z)).unwrap(), 0.9, world.small);
        assert!(query(world, [0.7, 0.0, 3.0], minus(Z)).unwrap().tir, "0.7 * 1.5 > 1");
        let into_glass = query(world, [0.6, 0.0, 0.0], Z).unwrap();
        assert!(into_glass.entering);
        assert_near(sine_behind(world, [0.6, 0.0, 0.0], Z).unwrap(), 0.4, world.small);
        assert_near(query(world, [0.0, 0.0, 0.0], Z).unwrap().reflectance, 0.04, world.small);
    }
}

#[test]
fn overlapping_bodies_are_left_in_any_order() {
    // Along z: glass from -2 to 1, water from -1 to 2. The one entered last decides.
    let overlap = json!([
        { "box": { "min": [-9, -9, -2], "max": [9, 9, 1], "material": "glass" } },
        { "box": { "min": [-9, -9, -1], "max": [9, 9, 2], "material": "water" } }
    ]);
    let camera = json!({ "orthographic": { "eye": [-2.4, 0, -5], "look_at": [-1.8, 0, -4.2], "height": 1 } });
    for world in &worlds(overlap, json!({ "camera": camera })) {
        let tree = trace_pixel(&world.scene, 0, 0);
        let steps: Vec<(f64, f64)> = tree.rays.iter().filter_map(|r| r.snell).map(|s| (s.n1, s.n2)).collect();
        let expected = [(1.0, 1.5), (1.5, 1.33), (1.33, 1.33), (1.33, 1.0)];
        assert_eq!(steps.len(), expected.len());
        for (step, expected) in steps.iter().zip(expected) {
            assert_near(step.0, expected.0, world.small);
            assert_near(step.1, expected.1, world.small);
        }
        let last = tree.rays.last().unwrap();
        assert_vector(last.direction, [0.6, 0.0, 0.8], world.small);
        assert!(last.media.is_empty() && last.hit.is_none());
    }
}

/// Fermat: light takes the way of least time. From A above the water the tracer finds the ray to B below it; the
/// way over any other point of the surface is longer.
#[test]
fn refracted_light_takes_the_way_of_least_time() {
    let mut random = uniform(1);
    let [_, world] = floor("water");
    for _ in 0..200 {
        let a = DVec3::new(4.0 * random() - 2.0, 0.1 + 3.0 * random(), 4.0 * random() - 2.0);
        let b = DVec3::new(4.0 * random() - 2.0, -0.1 - 3.0 * random(), 4.0 * random() - 2.0);
        // Where the ray from a through x arrives at the depth of b, seen along the line from a to b.
        let along = DVec3::new(b.x - a.x, 0.0, b.z - a.z).normalize();
        let crossing = |s: f64| DVec3::new(a.x, 0.0, a.z) + along * s;
        let arrival = |s: f64| {
            let hit = query(&world, a.into(), (crossing(s) - a).into()).unwrap();
            let (p, d) = (DVec3::from(hit.point), DVec3::from(hit.transmitted.unwrap()));
            (p, p + d * ((b.y - p.y) / d.y))
        };
        let reach = (b - a).dot(along);
        let (mut low, mut high) = (0.0, reach);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if (arrival(middle).1 - a).dot(along) < reach { low = middle } else { high = middle }
        }
        let (p, end) = arrival(low);
        assert!(end.distance(b) < 1e-12, "the ray arrives at {end} instead of {b}");
        let time = |x: DVec3| a.distance(x) + 1.33 * x.distance(b);
        for h in [1e-1, 1e-3, 1e-5] {
            for step in [along, -along, along.cross(DVec3::Y), -along.cross(DVec3::Y)] {
                assert!(time(p + step * h) > time(p) - 1e-15, "a step of {h} is shorter");
            }
        }
        // Stationary: the derivative is sin(theta1) - n sin(theta2).
        assert_near((time(p + along * 1e-6) - time(p - along * 1e-6)) / 2e-6, 0.0, 1e-8);
    }
}
