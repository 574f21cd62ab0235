//! Effects that are means over choices: against closed forms, and how fast they come near them.

use super::{picture, pixels, scene};
use serde_json::{Value, json};
use std::f64::consts::PI;
use strahl::shading::spectrum::{Spectrum, WAVELENGTHS};

const BOTH: [&str; 2] = ["single", "double"];

/// Root of the mean square of differences.
fn rms(differences: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = differences.fold((0.0, 0.0), |(sum, count), d| (sum + d * d, count + 1.0));
    (sum / count).sqrt()
}

/// Slope of log(error) over log(samples), by least squares.
fn slope(errors: &[(u32, f64)]) -> f64 {
    let points: Vec<(f64, f64)> = errors.iter().map(|(n, e)| (f64::from(*n).ln(), e.ln())).collect();
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    points.iter().map(|(x, y)| (x - mx) * (y - my)).sum::<f64>()
        / points.iter().map(|(x, _)| (x - mx).powi(2)).sum::<f64>()
}

/// A row of pixels that looks down from below an edge: pixel i sees the floor at x = (i + 1/2 - 64) / 32.
fn row(height: f64, more: Value) -> Value {
    let mut description = json!({
        "version": 1,
        "image": { "width": 128, "height": 1 },
        "camera": { "orthographic": { "eye": [0, height, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 4.0 / 128.0 } },
        "ambient": 0,
        "lights": [],
        "materials": { "matt": { "diffuse": 1 }, "black": { "diffuse": 0 } },
        "objects": [{ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "matt" } }],
        "render": { "antialias": false }
    });
    for (key, value) in more.as_object().unwrap() {
        description[key] = value.clone();
    }
    description
}

fn place(i: usize) -> f64 {
    (i as f64 + 0.5 - 64.0) / 32.0
}

/// A floor below an edge at height 1 over x = 0, lit by a window of width 1 at height 5: the closed form of its penumbra,
/// with the cosine of each point of the light, by the midpoint rule.
fn penumbra(x: f64) -> f64 {
    let (height, width) = (5.0, 1.0);
    let steps = 4000;
    let mut sum = 0.0;
    for k in 0..steps {
        let light = ((f64::from(k) + 0.5) / f64::from(steps) - 0.5) * width;
        let at_edge = x + (light - x) / height;
        if at_edge > 0.0 {
            sum += height / (height * height + (light - x).powi(2)).sqrt();
        }
    }
    sum / f64::from(steps)
}

fn window(samples: u32) -> Value {
    row(
        0.5,
        json!({
            "lights": [{ "point": { "position": [0, 5, 0], "area": { "parallelogram": { "u": [1, 0, 0], "v": [0, 0, 0.001] } } } }],
            "objects": [
                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "matt" } },
                { "quad": { "vertices": [[-50, 1, -50], [0, 1, -50], [0, 1, 50], [-50, 1, 50]], "material": "black" } }
            ],
            "render": { "antialias": false, "samples": samples, "accuracy": { "fixed": {} } }
        }),
    )
}

#[test]
fn penumbras_are_as_wide_and_as_soft_as_geometry_says() {
    for precision in BOTH {
        let got = pixels(window(256), precision);
        for (i, pixel) in got.iter().enumerate() {
            let error = (f64::from(pixel[0]) - penumbra(place(i))).abs();
            assert!(error < 0.01, "{precision}, x = {}: off by {error}", place(i));
        }
        let lit = got.iter().filter(|p| p[0] > 0.01).count();
        assert!((30..120).contains(&lit), "the row must see light, penumbra and shadow");
    }
}

/// The same edge under square lights that are turned by any angle: the edge then crosses the choices aslant.
#[test]
fn penumbras_under_turned_lights_are_as_exact_as_the_documents_say() {
    let (height, cells) = (5.0, 300);
    let mut errors = Vec::new();
    for turn in (0..12).map(|k| f64::from(k) * 7.5) {
        let (sin, cos) = turn.to_radians().sin_cos();
        let mut description = window(256);
        description["lights"][0]["point"]["area"]["parallelogram"] = json!({ "u": [cos, 0, sin], "v": [-sin, 0, cos] });
        for (i, pixel) in pixels(description, "single").iter().enumerate() {
            let mut sum = 0.0;
            for k in 0..cells * cells {
                let along = |k: i32| (f64::from(k) + 0.5) / f64::from(cells) - 0.5;
                let (u, v) = (along(k % cells), along(k / cells));
                let (x, z) = (u * cos - v * sin - place(i), u * sin + v * cos);
                if place(i) + x / height > 0.0 {
                    sum += height / (height * height + x * x + z * z).sqrt();
                }
            }
            errors.push((f64::from(pixel[0]) - sum / f64::from(cells * cells)).abs());
        }
    }
    // Those of pixels in the penumbra.
    errors.retain(|error| *error > 1e-4);
    let (worst, rms) = (errors.iter().copied().fold(0.0, f64::max), rms(errors.iter().copied()));
    let beyond = errors.iter().filter(|error| **error > 0.01).count() as f64 / errors.len() as f64;
    println!("{} pixels: at most {worst:.4}, rms {rms:.4}, {beyond:.3} beyond 0.01", errors.len());
    assert!(worst < 0.03 && rms < 0.008 && beyond < 0.2, "at most {worst}, rms {rms}, {beyond} beyond 0.01");
}

/// Points that are spread evenly err like n^-1 at an edge that runs along an axis of the choices, and like n^(-3/4) at
/// others; random ones like n^(-1/2).
#[test]
fn soft_shadows_converge_faster_than_chance() {
    let mut errors = Vec::new();
    for samples in [4, 16, 64, 256, 1024] {
        let got = pixels(window(samples), "double");
        // Only where part of the light is hidden.
        let hidden = |i: &usize| (0.03..0.97).contains(&penumbra(place(*i)));
        let differences = (0..128).filter(hidden).map(|i| f64::from(got[i][0]) - penumbra(place(i)));
        errors.push((samples, rms(differences)));
    }
    let slope = slope(&errors);
    assert!(slope < -0.7, "errors {errors:?} fall with n^{slope}");
}

#[test]
fn a_disc_light_is_a_point_from_afar_and_a_point_when_it_has_no_size() {
    let lit = |area: Value| {
        let mut light = json!({ "position": [1, 3, 0.5] });
        if !area.is_null() {
            light["area"] = area;
        }
        row(0.5, json!({ "lights": [{ "point": light }], "render": { "antialias": false, "samples": 4 } }))
    };
    for precision in BOTH {
        let point = pixels(lit(Value::Null), precision);
        assert_eq!(point, pixels(lit(json!({ "disc": { "radius": 0 } })), precision));
        let tiny = pixels(lit(json!({ "disc": { "radius": 1e-4 } })), precision);
        assert!(point.iter().zip(&tiny).all(|(a, b)| (a[0] - b[0]).abs() < 1e-4));
    }
}

/// A sky lit by a sun of angular diameter a: behind a half-plane's edge the visible part of the disc is a segment.
#[test]
fn the_sun_behind_an_edge_is_a_segment_of_a_disc() {
    let description = row(
        0.5,
        json!({
            "lights": [{ "directional": { "direction": [0, -1, 0], "area": { "angle_deg": 40 } } }],
            "objects": [
                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "matt" } },
                { "quad": { "vertices": [[-90, 1, -90], [0, 1, -90], [0, 1, 90], [-90, 1, 90]], "material": "black" } }
            ],
            "render": { "antialias": false, "samples": 1024 }
        }),
    );
    let reach = (20f64.to_radians()).tan();
    for (i, pixel) in pixels(description, "double").iter().enumerate() {
        // Directions (x, 1, z) with x^2 + z^2 < reach^2, seen if place + x > 0, weighted by their cosine.
        let (mut sum, mut all) = (0.0, 0.0);
        for k in 0..400 {
            for l in 0..100 {
                let (angle, r) =
                    ((f64::from(k) + 0.5) / 400.0 * 2.0 * PI, ((f64::from(l) + 0.5) / 100.0).sqrt() * reach);
                all += 1.0;
                if place(i) + r * angle.cos() > 0.0 {
                    sum += 1.0 / (1.0 + r * r).sqrt();
                }
            }
        }
        assert!((f64::from(pixel[0]) - sum / all).abs() < 0.006, "x = {}: {} {}", place(i), pixel[0], sum / all);
    }
}

/// An edge at distance 2 before a white background, the lens focused at 4: from the point x of the lens the ray towards the
/// point f in focus passes the edge's plane at x/2 + f/2.
#[test]
fn an_edge_out_of_focus_shows_the_lens() {
    let radius = 0.3;
    for precision in BOTH {
        let description = json!({
            "version": 1,
            "image": { "width": 64, "height": 1 },
            "camera": { "pinhole": { "eye": [0, 0, 0], "look_at": [0, 0, -1], "vfov_deg": 0.2, "aperture": 2.0 * radius, "focus_distance": 4 } },
            "ambient": 0, "lights": [], "background": 1,
            "objects": [{ "quad": { "vertices": [[-9, -9, -2], [0, -9, -2], [0, 9, -2], [-9, 9, -2]] } }],
            "render": { "antialias": false, "samples": 1024 }
        });
        let half = (0.1f64).to_radians().tan();
        for (i, pixel) in pixels(description, precision).iter().enumerate() {
            let focus = 4.0 * half * (2.0 * (i as f64 + 0.5) - 64.0);
            // Seen where x > -f: the part of the disc beyond a chord.
            let c = (-focus / radius).clamp(-1.0, 1.0);
            let part = (c.acos() - c * (1.0 - c * c).sqrt()) / PI;
            assert!((f64::from(pixel[0]) - part).abs() < 0.01, "{precision}, {i}: {} {part}", pixel[0]);
        }
    }
}

#[test]
fn a_lens_leaves_what_is_in_focus_sharp_and_no_aperture_leaves_no_trace() {
    let camera = |more: Value| {
        let mut pinhole = json!({ "eye": [0, 0, 5], "look_at": [0, 0, 0] });
        for (key, value) in more.as_object().unwrap() {
            pinhole[key] = value.clone();
        }
        json!({
            "version": 1, "image": { "width": 48, "height": 32 }, "camera": { "pinhole": pinhole },
            "objects": [{ "quad": { "vertices": [[-1, -1, 0], [0.7, -1, 0], [0.7, 1, 0], [-1, 1, 0]] } }],
            "render": { "antialias": false, "samples": 16 }
        })
    };
    for precision in BOTH {
        let pinhole = pixels(camera(json!({})), precision);
        assert_eq!(pinhole, pixels(camera(json!({ "aperture": 0, "focus_distance": 2 })), precision));
        let lens = pixels(camera(json!({ "aperture": 0.5 })), precision);
        let differing = pinhole.iter().zip(&lens).filter(|(a, b)| (a[0] - b[0]).abs() > 1e-3).count();
        assert!(differing <= 4, "{differing} pixels of a quad in focus differ");
    }
}

/// What rough mirrors send on under a white sky: G1(v) G1(l) D(m) / (4 n.v) over all l, by the midpoint rule.
fn albedo(cos: f64, alpha: f64) -> f64 {
    let sine = (1.0 - cos * cos).sqrt();
    let g1 = |c: f64| 2.0 * c / (c + (c * c + alpha * alpha * (1.0 - c * c)).sqrt());
    let (rows, columns) = (1000, 300);
    let mut sum = 0.0;
    for row in 0..rows {
        let z = (f64::from(row) + 0.5) / f64::from(rows);
        for column in 0..columns {
            let angle = (f64::from(column) + 0.5) / f64::from(columns) * PI;
            let r = (1.0 - z * z).sqrt();
            let m = [sine + r * angle.cos(), r * angle.sin(), cos + z];
            let mz = m[2] / m.iter().map(|x| x * x).sum::<f64>().sqrt();
            let d = mz * mz * (alpha * alpha - 1.0) + 1.0;
            sum += alpha * alpha / (PI * d * d) * g1(cos) * g1(z) / (4.0 * cos);
        }
    }
    sum * 2.0 * PI / f64::from(rows * columns)
}

#[test]
fn rough_mirrors_keep_the_light_that_their_facets_do_not_hide() {
    for (degrees, roughness) in [(0.0f64, 0.5f64), (60.0, 0.5), (75.0, 0.8), (45.0, 0.3)] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let description = |roughness: f64| {
            json!({
                "version": 1, "image": { "width": 8, "height": 8 },
                "camera": { "orthographic": { "eye": [-sine, cosine, 0], "look_at": [0, 0, 0], "up": [0, 0, 1], "height": 0.1 } },
                "ambient": 0, "lights": [], "background": 1,
                "materials": { "rough": { "diffuse": 0, "reflection": 1, "roughness": roughness } },
                "objects": [{ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "rough" } }],
                "render": { "antialias": false, "samples": 256 }
            })
        };
        for precision in BOTH {
            let got = pixels(description(roughness), precision);
            let mean = got.iter().map(|p| f64::from(p[0])).sum::<f64>() / 64.0;
            let expected = albedo(cosine, roughness * roughness);
            assert!((mean - expected).abs() < 2e-3, "{precision}, {degrees}, {roughness}: {mean} {expected}");
            assert!(pixels(description(0.0), precision).iter().all(|p| p[0] == 1.0));
        }
    }
}

/// From inside glass the edge of a sky is seen at another angle for each wavelength. With 64 samples each is taken once.
#[test]
fn each_wavelength_is_bent_by_its_own_index() {
    let spectrum = Spectrum::<f64>::visible();
    let (ior, dispersion) = (1.6, 0.1);
    // Looking down at 45 degrees through the flat top of a block, onto a line at depth 1 below: x = tan(theta2).
    let description = |dispersion: f64, height: f64, at: f64| {
        json!({
            "version": 1, "image": { "width": 64, "height": 1 },
            "camera": { "orthographic": { "eye": [at - 2.0, 2, 0], "look_at": [at, 0, 0], "up": [0, 0, -1], "height": height } },
            "ambient": 1, "lights": [],
            "materials": {
                "glass": { "ambient": 0, "diffuse": 0, "transmission": 1, "ior": ior, "dispersion": dispersion },
                "white": { "ambient": 1, "diffuse": 0 }
            },
            "objects": [
                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "glass" } },
                { "quad": { "vertices": [[0, -1, -9], [9, -1, -9], [9, -1, 9], [0, -1, 9]], "material": "white" } }
            ],
            "render": { "antialias": false, "max_depth": 3, "samples": 64 }
        })
    };
    let sine = 0.5f64.sqrt();
    let shift = |n: f64| (sine / n) / (1.0 - (sine / n).powi(2)).sqrt();
    // A pixel's rays are so close together that they meet the top in one point.
    for step in 0..24 {
        let at = -shift(ior) + 0.05 * (f64::from(step) / 12.0 - 1.0);
        let got = pixels(description(dispersion, 1e-9, at), "double")[32];
        for c in 0..3 {
            let seen = |k: usize| at + shift(ior + dispersion * spectrum.bend[k]) > 0.0;
            let expected = (0..64).filter(|k| seen(*k)).map(|k| spectrum.colors[k][c]).sum::<f64>() / 64.0;
            assert!((f64::from(got[c]) - expected).abs() < 1e-5, "at {at}, channel {c}: {} {expected}", got[c]);
        }
    }
    for precision in BOTH {
        // White stays white, and no dispersion leaves no trace.
        let white = pixels(description(dispersion, 1e-3, 3.0), precision);
        assert!(white.iter().flatten().all(|x| (x - 1.0).abs() < 1e-5), "{:?}", white[0]);
        let plain = scene(description(0.0, 1e-3, 3.0), precision);
        assert_eq!(picture(&plain).film.pixels, vec![[1.0; 3]; 64]);
    }
}

/// A floor under a disc of height h and radius r that glows with radiance A sees it with the form factor r^2/(r^2 + h^2).
#[test]
fn surfaces_gather_what_their_form_factors_say() {
    let description = |samples: u32| {
        json!({
            "version": 1, "image": { "width": 16, "height": 16 },
            "camera": { "orthographic": { "eye": [0, 0.5, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "height": 1e-3 } },
            "ambient": 0.5, "lights": [],
            "materials": { "floor": { "ambient": 1, "diffuse": [0.8, 0.4, 0.2] }, "lamp": { "ambient": 1, "diffuse": 0 } },
            "objects": [
                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } },
                { "disc": { "center": [0, 1, 0], "normal": [0, -1, 0], "radius": 0.75, "material": "lamp" } }
            ],
            "render": { "antialias": false, "samples": samples, "color_bleeding": true }
        })
    };
    let form_factor = 0.75f64.powi(2) / (1.0 + 0.75f64.powi(2));
    for precision in BOTH {
        let got = picture(&scene(description(64), precision));
        for (c, kd) in [0.8, 0.4, 0.2].into_iter().enumerate() {
            let mean = got.film.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / 256.0;
            let expected = kd * 0.5 * form_factor;
            assert!((mean / expected - 1.0).abs() < 0.005, "{precision}, {c}: {mean} {expected}");
        }
        assert_eq!(got.rays.gathered, 256 * 64);
    }
    let mut errors = Vec::new();
    for samples in [4, 16, 64, 256] {
        let off = |p: &[f32; 3]| f64::from(p[0]) - 0.4 * form_factor;
        errors.push((samples, rms(pixels(description(samples), "double").iter().map(off))));
    }
    let slope = slope(&errors);
    assert!(slope < -0.7, "errors {errors:?} fall with n^{slope}");
}

/// A surface that sees nothing but a sky of radiance 1 scatters k_d of it, in every single sample.
#[test]
fn a_convex_body_under_a_white_sky_is_as_bright_as_it_is_white() {
    for precision in BOTH {
        let got = pixels(
            json!({
                "version": 1, "image": { "width": 8, "height": 8 },
                "camera": { "orthographic": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "height": 1 } },
                "ambient": 0, "lights": [], "background": 1,
                "materials": { "grey": { "diffuse": 0.5 } },
                "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "grey" } }],
                "render": { "color_bleeding": true, "samples": 16 }
            }),
            precision,
        );
        assert!(got.iter().flatten().all(|x| (x - 0.5).abs() < 1e-6));
    }
}

/// Where all that can be gathered has radiance 1, directly, by way of mirrors and through glass, each sample brings 1.
#[test]
fn light_is_gathered_by_way_of_mirrors_and_through_glass() {
    for precision in BOTH {
        let description = json!({
            "version": 1, "image": { "width": 48, "height": 32 },
            "camera": { "pinhole": { "eye": [0, 3, 7], "look_at": [0, 0.6, 0], "vfov_deg": 40 } },
            "ambient": 1, "lights": [], "background": 1,
            "materials": {
                "floor": { "ambient": 1, "diffuse": 0.5 },
                "mirror": { "ambient": 0, "diffuse": 0, "reflection": 1 },
                "glass": { "ambient": 0, "diffuse": 0, "reflection": 0.125, "transmission": 0.875, "ior": 1.5 }
            },
            "objects": [
                { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } },
                { "sphere": { "center": [-1, 0.8, 0], "radius": 0.8, "material": "mirror" } },
                { "sphere": { "center": [1, 0.8, 0], "radius": 0.8, "material": "glass" } },
                { "quad": { "vertices": [[-2, 0, -1], [2, 0, -1], [2, 2, -1], [-2, 2, -1]], "material": "mirror" } }
            ],
            "render": {
                "color_bleeding": true, "samples": 4, "antialias": false, "accuracy": { "fixed": {} }, "max_depth": 60,
                "min_weight": 1e-5
            }
        });
        let got = pixels(description, precision);
        let floor = |x: f32| (x - 0.5).abs() < 1e-3;
        // The floor is half as bright as the sky, and mirrors and glass show mixtures of both.
        assert!(got.iter().flatten().all(|x| (0.499..1.001).contains(x)), "{precision}");
        let corner = &got[31 * 48..];
        assert!(corner.iter().all(|pixel| floor(pixel[0])), "{precision}: {corner:?}");
    }
}

#[test]
fn effects_of_size_zero_and_of_unused_materials_are_removed() {
    let description = json!({
        "version": 1, "image": { "width": 16, "height": 9 },
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "aperture": 0 } },
        "lights": [{ "directional": { "direction": [0, -1, -1], "area": { "angle_deg": 0 } } }],
        "materials": {
            "used": { "roughness": 0.5, "dispersion": 0.01 },
            "unused": { "reflection": 0.5, "transmission": 0.5, "roughness": 0.5, "dispersion": 0.02 }
        },
        "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "used" } }]
    });
    for precision in BOTH {
        assert_eq!(scene(description.clone(), precision).samples, 1, "nothing calls for choices");
    }
}

#[test]
fn what_is_out_of_range_is_named() {
    let description = json!({
        "version": 1, "image": { "width": 16, "height": 9 },
        "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0], "aperture": -1, "focus_distance": 0 } },
        "lights": [
            { "directional": { "direction": [0, -1, -1], "area": { "angle_deg": 91 } } },
            { "point": { "position": [0, 9, 0], "area": { "disc": { "radius": -2 } } } },
            { "spot": { "position": [0, 9, 0], "direction": [0, -1, 0], "area": { "parallelogram": { "u": [1e20, 0, 0], "v": [0, 0, 1] } } } }
        ],
        "materials": { "m": { "roughness": 1.5, "dispersion": 0.3 } },
        "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "m" } }]
    });
    let mut pointers = super::problems(&description);
    pointers.sort();
    assert_eq!(
        pointers,
        [
            "/camera/pinhole/aperture",
            "/camera/pinhole/focus_distance",
            "/lights/0/directional/area/angle_deg",
            "/lights/1/point/area/disc/radius",
            "/lights/2/spot/area/parallelogram/u/0",
            "/materials/m/dispersion",
            "/materials/m/roughness"
        ]
    );
}

/// Index-matched and clear: no facet of it bends or adds anything.
#[test]
fn roughness_between_equal_media_cannot_be_seen() {
    let description = |objects: Value| {
        json!({
            "version": 1, "image": { "width": 32, "height": 32 },
            "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 1, 0] } }, "ambient": 0.5, "lights": [],
            "background": [0.2, 0.4, 0.8],
            "materials": {
                "ghost": { "diffuse": 0, "transmission": 1, "ior": 1, "roughness": 0.8 },
                "floor": { "diffuse": { "checker": { "a": 1, "b": 0.1 } } }
            },
            "objects": objects,
            "render": { "antialias": false, "samples": 16 }
        })
    };
    let floor = json!({ "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } });
    let ghost = json!({ "sphere": { "center": [0, 1, 0], "radius": 1, "material": "ghost" } });
    for precision in BOTH {
        assert_eq!(
            pixels(description(json!([floor, ghost])), precision),
            pixels(description(json!([floor])), precision)
        );
    }
}

#[test]
fn explanations_know_the_samples_that_choices_bring_and_what_cannot_show() {
    let state = |description: &Value, name: &str| {
        let effects = strahl::plan::explain::explain(&scene(description.clone(), "single")).effects;
        effects.into_iter().find(|effect| effect.effect == name).map(|effect| (effect.state, effect.reason)).unwrap()
    };
    use strahl::plan::explain::State;
    let mut description = json!({
        "version": 1, "camera": { "pinhole": { "eye": [0, 0, 5], "look_at": [0, 0, 0] } },
        "materials": {
            "m": { "reflection": 0.5, "roughness": 0.5, "diffuse": { "checker": { "a": 0.5, "b": 0.5 } } }
        },
        "objects": [{ "sphere": { "center": [0, 0, 0], "radius": 1, "material": "m" } }]
    });
    assert_eq!(state(&description, "gloss").0, State::On);
    assert_eq!(
        state(&description, "antialiasing"),
        (State::Removed, "each pixel gets as many samples as its error asks for".into())
    );
    assert_eq!(state(&description, "checker_texture").0, State::Removed);
    description["render"]["max_depth"] = json!(1);
    assert_eq!(state(&description, "gloss").0, State::Removed);
    assert_eq!(state(&description, "antialiasing").0, State::On);
    assert_eq!(scene(description, "single").samples, 1);
}

/// A varnish under a white sky reflects ((n - 1)/(n + 1))^2 of each wavelength, and 64 samples take each of them once.
#[test]
fn a_varnish_reflects_each_wavelength_by_its_own_index() {
    let spectrum = Spectrum::<f64>::visible();
    let expected: [f64; 3] = std::array::from_fn(|c| {
        let one = |i: usize| {
            let n = 1.5 + 0.2 * spectrum.bend[i];
            spectrum.colors[i][c] * ((n - 1.0) / (n + 1.0)).powi(2)
        };
        (0..WAVELENGTHS).map(one).sum::<f64>() / WAVELENGTHS as f64
    });
    assert!(expected[2] > 1.05 * expected[0], "blue is reflected more: {expected:?}");
    let varnish = json!({ "diffuse": 0, "reflection": 1, "fresnel": "dielectric", "ior": 1.5, "dispersion": 0.2 });
    for precision in BOTH {
        let floor = row(0.5, json!({ "background": 1, "materials": { "matt": varnish } }));
        for pixel in pixels(floor, precision) {
            // Rays of a wavelength that is hardly seen are put aside.
            let error = |c: usize| (f64::from(pixel[c]) - expected[c]).abs();
            assert!((0..3).all(|c| error(c) < 2e-4), "{precision}: {pixel:?}, not {expected:?}");
        }
    }
}
