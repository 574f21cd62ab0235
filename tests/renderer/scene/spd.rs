//! The Standard Procedural Databases: ray counts that others published, and pictures that another renderer made.

use crate::common::read;
use strahl::film::{Film, Region};
use strahl::render::{Control, Picture, render};
use strahl::scene::nff::NffOptions;
use strahl::scene::{Format, Loaded, Overrides, load};

fn load_nff(file: &str, overrides: Overrides) -> Loaded {
    load(&read(&format!("tests/inputs/nff/{file}")), Format::Nff, &overrides).unwrap_or_else(|e| panic!("{file}: {e}"))
}

fn picture(file: &str, overrides: Overrides) -> Picture {
    let loaded = load_nff(file, overrides);
    let region = Region::whole(loaded.scene.width, loaded.scene.height);
    render(&loaded.scene, region, &Control::default()).unwrap()
}

/// E. Haines, SPD Readme 3.14, "Database Analysis": hits of eye rays, reflected, refracted and shadow rays.
const PUBLISHED: [(&str, [u64; 4]); 4] = [
    ("balls_s4.nff.gz", [263_169, 175_095, 0, 954_368]),
    ("mount_s6.nff.gz", [173_125, 354_769, 354_769, 412_922]),
    ("teapot_s12.nff.gz", [161_120, 225_248, 0, 407_656]),
    ("tetra_s6.nff.gz", [49_788, 0, 0, 46_112]),
];

fn nff(spd_counts: bool, two_sided: bool) -> Overrides {
    Overrides { nff: NffOptions { two_sided, spd_counts }, ..Overrides::default() }
}

#[test]
fn ray_counts_agree_with_the_published_ones() {
    for (file, published) in PUBLISHED {
        // The SPD's only exception to one-sided surfaces is the teapot, for the gap under its lid.
        let overrides = nff(true, file.starts_with("teapot"));
        let rays = picture(file, overrides).rays;
        let ours = [rays.camera_hits, rays.reflected, rays.transmitted + rays.total_internal_reflections, rays.shadow];
        assert_eq!(rays.camera, 513 * 513);
        for (ours, published) in ours.into_iter().zip(published) {
            let off = ours.abs_diff(published) as f64;
            assert!(off <= 0.005 * published as f64, "{file}: {ours} rays, published {published}");
        }
    }
}

#[test]
fn counts_of_the_gears_agree_with_an_independent_count() {
    // Concave 144-gons of glass; counted by another program, which nobody published.
    let rays = picture("gears_s1.nff", nff(true, false)).rays;
    let near = |ours: u64, other: u64| assert!(ours.abs_diff(other) as f64 <= 0.001 * other as f64, "{ours} {other}");
    near(rays.camera_hits, 238_575);
    near(rays.reflected, 879_325);
    near(rays.transmitted, 570_898);
    near(rays.total_internal_reflections, 8_631);
    near(rays.shadow, 4_079_216);
}

/// Mean of red minus blue in each cell of a 64 x 64 grid: what lies where. NFF leaves the strength of lights open, so
/// brightness is no measure.
fn thumbnail(width: u32, height: u32, at: impl Fn(u32, u32) -> [u8; 3]) -> Vec<f64> {
    const CELLS: u32 = 64;
    let mut sums = vec![(0.0, 0.0); (CELLS * CELLS) as usize];
    for y in 0..height {
        for x in 0..width {
            let cell = &mut sums[(y * CELLS / height * CELLS + x * CELLS / width) as usize];
            let [red, _, blue] = at(x, y);
            cell.0 += f64::from(red) - f64::from(blue);
            cell.1 += 1.0;
        }
    }
    sums.into_iter().map(|(sum, count)| sum / count).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let product =
        |a: &[f64], ma: f64, b: &[f64], mb: f64| a.iter().zip(b).map(|(x, y)| (x - ma) * (y - mb)).sum::<f64>();
    product(a, ma, b, mb) / (product(a, ma, a, ma) * product(b, mb, b, mb)).sqrt()
}

#[test]
fn pictures_are_composed_and_oriented_like_those_of_pov_ray() {
    for (file, image) in [("balls_s2.nff", "povray37_balls_s2.png"), ("teapot_s3.nff", "povray37_teapot_s3.png")] {
        let Film { region, pixels, .. } = picture(file, nff(false, true)).film;
        let other =
            image::load_from_memory(&read(&format!("tests/inputs/reference_images/{image}"))).unwrap().to_rgb8();
        let theirs = thumbnail(other.width(), other.height(), |x, y| other.get_pixel(x, y).0);
        let (w, h) = (region.width, region.height);
        // That scene is for a POV-Ray that knew no gamma: it writes linear values.
        let ours = |x: u32, y: u32| pixels[(y * w + x) as usize].map(|c| (c * 255.0) as u8);
        let upright = correlation(&theirs, &thumbnail(w, h, ours));
        let mirrored = correlation(&theirs, &thumbnail(w, h, |x, y| ours(w - 1 - x, y)));
        let upside_down = correlation(&theirs, &thumbnail(w, h, |x, y| ours(x, h - 1 - y)));
        println!("{file}: correlation {upright:.3}, mirrored {mirrored:.3}, upside down {upside_down:.3}");
        assert!(upright > 0.98, "{file}: {upright}");
        assert!(upright > mirrored + 0.1 && upright > upside_down + 0.1, "{file}: {upright} {mirrored} {upside_down}");
    }
}

#[test]
fn every_file_renders_or_is_refused_with_its_lines() {
    let folder = crate::common::root().join("tests/inputs/nff");
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().file_name().into_string().unwrap();
        if !file.contains(".nff") {
            continue;
        }
        let overrides = Overrides { width: Some(40), height: Some(40), ..Overrides::default() };
        match load(&read(&format!("tests/inputs/nff/{file}")), Format::Nff, &overrides) {
            Ok(loaded) => {
                let picture = crate::common::render_whole(&loaded);
                assert!(picture.pixels.iter().flatten().all(|c| c.is_finite()), "{file}");
                assert!(picture.pixels.iter().any(|p| p != &picture.pixels[0]), "{file} shows nothing");
            }
            Err(problems) => {
                assert!(file.starts_with("assimp_cone"), "{file}: {problems}");
                assert!(problems.0.iter().all(|p| p.line.is_some()), "{file}: {problems}");
            }
        }
    }
}
