//! Trees of rays.

use super::*;

/// Glass, mirrors, three lights and a checked floor: all kinds of rays.
fn still_life(camera: Value, render: Value) -> [World; 2] {
    let objects = json!([
        { "plane": { "point": [0, -1, 0], "normal": [0, 1, 0], "material": "floor" } },
        { "sphere": { "center": [-0.8, 0, 0], "radius": 1, "material": "crystal" } },
        { "sphere": { "center": [-0.8, 0, 0], "radius": 0.9, "material": "crystal", "hollow": true } },
        { "box": { "min": [0.6, -1, -1], "max": [1.6, 0.4, 0.2], "material": "chrome" } },
        { "torus": { "center": [0.2, -0.7, 1.2], "major_radius": 0.5, "minor_radius": 0.2, "material": "solid" } },
        { "quad": { "vertices": [[-3, -1, -3], [3, -1, -3], [3, 3, -3], [-3, 3, -3]], "material": "chrome" } }
    ]);
    worlds(
        objects,
        json!({
            "image": { "width": 24, "height": 16 },
            "camera": camera,
            "ambient": 0.2,
            "background": [0.3, 0.5, 0.9],
            "materials": {
                "floor": { "diffuse": { "checker": { "a": 0.9, "b": [0.6, 0.1, 0.1] } }, "reflection": 0.1 },
                "crystal": { "diffuse": 0.05, "specular": 0.6, "shininess": 50, "reflection": 0.15, "transmission": 0.8, "ior": 1.5 },
                "solid": { "diffuse": 0.05, "reflection": 0.1, "transmission": [0.9, 0.6, 0.3], "ior": 2.4 },
                "chrome": { "diffuse": 0.2, "specular": 0.5, "reflection": 0.6 }
            },
            "lights": [
                { "point": { "position": [4, 6, 3], "color": [1, 0.9, 0.8], "falloff": { "linear": { "reach": 30 } } } },
                { "directional": { "direction": [1, -2, -1.5], "intensity": 0.4 } },
                { "spot": { "position": [-3, 5, 4], "direction": [2, -5, -4], "inner_deg": 5, "outer_deg": 30, "falloff": "inverse_square", "intensity": 20 } }
            ],
            "render": render
        }),
    )
}

fn pinhole() -> Value {
    json!({ "pinhole": { "eye": [0.5, 1.2, 5], "look_at": [0, -0.2, 0], "vfov_deg": 40 } })
}

/// The mean of the samples: each the sum of its rays' contributions, added in the tree's order and precision, and the errors of
/// these additions.
fn mean(tree: &Tree) -> [f64; 3] {
    let count = f64::from(tree.samples);
    let mut samples: Vec<usize> = Vec::new();
    let mut all = 0;
    for ray in &tree.rays {
        let own = ray.parent.map_or(all, |parent| samples[parent as usize]);
        all += usize::from(ray.parent.is_none());
        samples.push(own);
    }
    assert_eq!(all, tree.samples as usize);
    std::array::from_fn(|i| {
        let mut sums = vec![(0.0, 0.0); all];
        let parts = tree.rays.iter().zip(&samples).flat_map(|(ray, sample)| {
            let own = |light: [f64; 3]| (light[i] * count, sample);
            [own(ray.fog), own(ray.contribution)]
        });
        // What each adds to its sample.
        for (part, sample) in parts {
            let (sum, errors) = &mut sums[*sample];
            (*sum, *errors) = match tree.precision {
                "single" => {
                    let exact = *sum + part;
                    let rounded = f64::from(exact as f32);
                    (rounded, f64::from((*errors + (exact - rounded)) as f32))
                }
                _ => {
                    let [larger, smaller] = if *sum > part { [*sum, part] } else { [part, *sum] };
                    (*sum + part, *errors + (smaller - ((*sum + part) - larger)))
                }
            };
        }
        let all = |samples: &[(f64, f64)]| samples.iter().map(|(sum, errors)| sum + errors).sum::<f64>();
        // Both halves of a group are summed apart.
        let (early, late) = sums.split_at(sums.len().div_ceil(2));
        (all(early) + all(late)) * (1.0 / count)
    })
}

fn trees_are_pictures(worlds: &[World; 2]) {
    for World { scene, .. } in worlds {
        let whole = Region::whole(scene.width, scene.height);
        let picture = render(scene, whole, &Control::default()).unwrap();
        for ([x, y], pixel) in whole.iter().zip(&picture.film.pixels) {
            let tree = trace_pixel(scene, x, y);
            assert!(!tree.truncated);
            let shown = mean(&tree);
            let shown: [f64; 3] = std::array::from_fn(|i| shown[i] + tree.raised[i]);
            if tree.samples.is_power_of_two() {
                assert_eq!(shown, tree.value, "pixel {x}, {y}: the contributions");
            } else {
                // Contributions that are divided by another number, and multiplied with it, may be off by a bit.
                let off = |i: usize| (shown[i] - tree.value[i]).abs() > 1e-15 * tree.value[i];
                assert!(!(0..3).any(off), "pixel {x}, {y}: {shown:?} {:?}", tree.value);
            }
            assert_eq!(tree.value.map(|c| c as f32), *pixel, "pixel {x}, {y}: the picture");
        }
    }
}

#[test]
fn contributions_add_up_to_the_rendered_pixel_bit_for_bit() {
    trees_are_pictures(&still_life(pinhole(), json!({ "antialias": false, "shadows": "transmissive" })));
}

#[test]
fn so_they_do_with_several_samples() {
    trees_are_pictures(&still_life(pinhole(), json!({ "antialias": false, "samples": 3, "max_depth": 5 })));
}

#[test]
fn so_they_do_where_antialiasing_refines() {
    let worlds = still_life(pinhole(), json!({ "antialias": true, "max_depth": 4 }));
    trees_are_pictures(&worlds);
    let whole = Region::whole(24, 16).iter();
    let samples: Vec<u32> = whole.map(|[x, y]| trace_pixel(&worlds[0].scene, x, y).samples).collect();
    assert!(samples.contains(&1) && samples.contains(&16), "{samples:?}");
}

#[test]
fn so_they_do_outside_the_image_circle_and_inside_glass() {
    let fisheye = json!({ "fisheye": { "eye": [-0.8, 0.1, 0.95], "look_at": [0, 0, 0] } });
    trees_are_pictures(&still_life(fisheye, json!({ "antialias": false, "min_weight": 0.01 })));
}

/// A glass body of unit size, placed and scaled.
fn glass(kind: &str, place: DVec3, scale: f64) -> Value {
    let at = |x: f64, y: f64, z: f64| (place + DVec3::new(x, y, z) * scale).to_array();
    let mut body = match kind {
        "sphere" => json!({ "center": at(0.0, 0.0, 0.0), "radius": scale }),
        "box" => json!({ "min": at(-0.7, -0.5, -0.6), "max": at(0.6, 0.4, 0.7) }),
        "cylinder" => json!({ "base": at(0.3, -0.8, 0.1), "top": at(-0.2, 0.7, 0.3), "radius": 0.5 * scale }),
        "cone" => json!({ "base": at(0.3, -0.8, 0.1), "base_radius": 0.7 * scale, "top": at(-0.2, 0.9, 0.3) }),
        "torus" => json!({ "center": at(0.0, 0.0, 0.0), "axis": [0.3, 0.5, 0.8],
                           "major_radius": 0.8 * scale, "minor_radius": 0.3 * scale }),
        _ => {
            json!({ "vertices": [at(-0.8, -0.7, -0.6), at(0.9, -0.8, -0.5), at(0.1, 0.9, -0.4), at(0.0, 0.0, 0.9)],
                     "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] })
        }
    };
    body["material"] = "crystal".into();
    json!([{ kind: body }])
}

#[test]
fn rays_enter_bodies_from_outside_and_leave_them_from_inside_at_any_scale() {
    let mut random = uniform(7);
    let mut point = move || DVec3::new(2.0 * random() - 1.0, 2.0 * random() - 1.0, 2.0 * random() - 1.0);
    for kind in ["sphere", "box", "cylinder", "cone", "torus", "mesh"] {
        for (scale, away) in [(1e-6, 0.0), (1.0, 0.0), (1.0, 30.0), (1e6, 0.0)] {
            for _ in 0..60 {
                let place = point() * away * scale;
                let (eye, target) = (place + point().normalize() * (4.0 * scale), place + point() * (0.5 * scale));
                let more = json!({
                    "camera": { "orthographic": { "eye": eye.to_array(), "look_at": target.to_array(), "height": scale } },
                    "materials": { "crystal": { "diffuse": 0, "reflection": 0.3, "transmission": 0.7, "ior": 1.5 } },
                    "render": { "max_depth": 6, "min_weight": 0 }
                });
                for World { scene, .. } in &worlds(glass(kind, place, scale), more) {
                    for ray in &trace_pixel(scene, 0, 0).rays {
                        let inside = !ray.media.is_empty();
                        let entering = ray.hit.as_ref().map(|hit| hit.entering);
                        let expected = if inside { entering == Some(false) } else { entering != Some(false) };
                        assert!(expected, "{kind} of size {scale}, inside: {inside}: {ray:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn every_ray_comes_from_the_one_it_names() {
    for &World { ref scene, small } in &still_life(pinhole(), json!({ "antialias": false })) {
        for [x, y] in Region::whole(scene.width, scene.height).iter() {
            let tree = trace_pixel(scene, x, y);
            for ray in &tree.rays {
                let Some(parent) = ray.parent.map(|p| &tree.rays[p as usize]) else {
                    assert_eq!((ray.kind, ray.depth), (NodeKind::Camera, 1));
                    continue;
                };
                assert!(parent.id < ray.id && ray.depth == parent.depth + 1);
                assert!(ray.weight.iter().zip(parent.weight).all(|(w, p)| *w <= p * 1.000_001));
                let from = parent.hit.as_ref().unwrap();
                assert_vector(ray.origin, from.point, 64.0 * small);
                let (d, n) = (DVec3::from(ray.direction), DVec3::from(from.normal));
                let before = DVec3::from(parent.direction).dot(n);
                assert_near(d.length(), 1.0, small);
                match ray.kind {
                    NodeKind::Reflected => assert_near(d.dot(n), -before, small),
                    NodeKind::Transmitted => assert!(d.dot(n) * before > 0.0),
                    NodeKind::Shadow => assert!(d.dot(n) * before < 0.0),
                    NodeKind::Gathered => unreachable!("these scenes gather nothing"),
                    NodeKind::Camera => unreachable!("camera rays have no parent"),
                }
                if let (NodeKind::Transmitted, Some(snell)) = (ray.kind, parent.snell) {
                    let sine = |d: DVec3| d.cross(n).length();
                    assert_near(snell.n2 * sine(d), snell.n1 * sine(parent.direction.into()), 4.0 * small);
                }
            }
        }
    }
}

#[test]
fn so_they_do_where_fog_is_before_what_is_only_partly_there() {
    let objects = json!([
        { "quad": { "vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], "material": "half" } },
        { "plane": { "point": [0, -0.8, 0], "normal": [0, 1, 0], "material": "floor" } }
    ]);
    let worlds = worlds(
        objects,
        json!({
            "image": { "width": 24, "height": 16 },
            "camera": pinhole(),
            "background": [0.5, 0.4, 0.3],
            "ambient": 0.3,
            "fog": { "density": 0.1, "color": [0.2, 0.3, 0.5] },
            "materials": {
                "half": { "pbr": { "base_color": [0.8, 0.3, 0.2], "opacity": { "alpha": 0.5 } } },
                "floor": { "pbr": { "shadow_catcher": true } }
            },
            "lights": [{ "point": { "position": [2, 4, 3] } }],
            "render": { "antialias": false }
        }),
    );
    trees_are_pictures(&worlds);
    let fog = |x, y| trace_pixel(&worlds[0].scene, x, y).rays.iter().map(|ray| ray.fog[0]).sum::<f64>();
    assert!(fog(12, 8) > 0.0);
}
