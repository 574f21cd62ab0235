//! What samples tell about themselves: estimates held against pictures of very many samples.

use crate::common::load_scene;
use strahl::camera::Window;
use strahl::film::Region;
use strahl::render::{Control, Picture, Stop, render, render_until};
use strahl::scene::description::{Accuracy, Statistical};
use strahl::scene::{Loaded, Overrides};

/// Scenes with edges, small details, soft shadows, blur, rough mirrors and many colors, and how wide they are rendered.
const SCENES: [(&str, u32); 9] = [
    ("whitted/whitted", 96),
    ("shapes/all", 96),
    ("mirrors/hall", 64),
    ("effects/soft_shadows", 64),
    ("effects/depth_of_field", 64),
    ("effects/motion_blur", 64),
    ("effects/gloss", 48),
    ("effects/textures", 64),
    ("effects/dispersion", 48),
];

fn picture(loaded: &Loaded) -> Picture {
    let region = Region::whole(loaded.scene.width, loaded.scene.height);
    render(&loaded.scene, region, &Control::default()).unwrap()
}

/// A picture of as many samples as a scene may ask for.
fn reference(name: &str, width: u32) -> Picture {
    let overrides = Overrides { samples: Some(1_024), antialias: Some(false), ..Overrides::default() };
    picture(&load_scene(name, width, overrides))
}

fn statistical(name: &str, width: u32, half_width: f64, confidence: f64) -> Picture {
    let accuracy = Some(Accuracy::Statistical(Statistical { half_width, confidence }));
    picture(&load_scene(name, width, Overrides { accuracy, ..Overrides::default() }))
}

/// 8-bit codes, not rounded, that the worst channel of each pixel is off.
fn errors(picture: &Picture, reference: &Picture) -> Vec<f64> {
    let code = |linear: f32| 255.0 * strahl::math::linear_to_srgb(f64::from(linear).clamp(0.0, 1.0));
    let worst = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (code(a[c]) - code(b[c])).abs()).fold(0.0, f64::max);
    picture.film.pixels.iter().zip(&reference.film.pixels).map(worst).collect()
}

fn share_within(errors: &[f64], codes: f64) -> f64 {
    errors.iter().filter(|error| **error <= codes).count() as f64 / errors.len() as f64
}

/// Both pictures may be one code off by recursion, and so may their difference be.
const RECURSION: f64 = 1.0;

#[test]
fn pixels_are_as_sure_as_they_say() {
    for (name, width) in SCENES {
        let reference = reference(name, width);
        for (half_width, confidence) in [(4.0, 0.95), (1.5, 0.8)] {
            let picture = statistical(name, width, half_width, confidence);
            let errors = errors(&picture, &reference);
            let (within, narrow) =
                (share_within(&errors, half_width + RECURSION), share_within(&errors, half_width / 20.0));
            let reached = picture.sampling.reached;
            println!(
                "{name:<26} {half_width} codes at {confidence}: {within:.4} within, {:.1} samples, {} of {} sure",
                reached.samples as f64 / reached.pixels as f64,
                reached.sure,
                reached.pixels
            );
            assert_eq!(reached.pixels, errors.len() as u64);
            assert!(within >= confidence, "{name}: {within} of the pixels are within {half_width} codes");
            assert!(narrow < confidence, "{name}: the test would not notice a wrong width");
        }
    }
}

#[test]
fn what_pictures_say_about_their_samples_holds_for_most_pixels() {
    for (name, width) in SCENES {
        let reference = reference(name, width);
        let picture = picture(&load_scene(name, width, Overrides::default()));
        let half_width = f64::from(picture.sampling.widths.at_share(0.95).unwrap()) / 2.0;
        let mut errors = errors(&picture, &reference);
        errors.sort_unstable_by(f64::total_cmp);
        let measured = errors[errors.len() * 95 / 100];
        println!("{name:<26} 95 % of the pixels within {measured:.2} codes, estimated {half_width:.1}");
        // A code for roundings of widths, and for recursion.
        assert!(measured <= half_width + RECURSION + 0.5, "{name}: {measured} codes, estimated {half_width}");
        // Pixels that ask for samples are estimated as if these were independent, and are better.
        let most = if picture.sampling.reached.pixels > 0 { 3.0 } else { 2.5 };
        assert!(half_width <= most * measured, "{name}: {measured} codes, estimated {half_width}");
    }
}

/// 19 of 20 pixels are within the estimate, wherever the picture had to stop.
#[test]
fn so_do_pictures_that_had_to_stop() {
    let (mut all_within, mut all) = (0.0, 0);
    for (name, width) in SCENES {
        let reference = reference(name, width);
        let loaded = load_scene(name, width, Overrides::default());
        let whole = picture(&loaded).rays.total();
        let (mut scene_within, mut pictures) = (0.0, 0);
        for share in [0.005, 0.02, 0.05, 0.1, 0.2, 0.33, 0.5, 0.75] {
            let scene = &loaded.scene;
            let (window, region) = (Window::whole(scene.width, scene.height), Region::whole(scene.width, scene.height));
            let stop = Stop::Rays((whole as f64 * share) as u64);
            let picture = render_until(scene, &window, region, &Control::default(), stop).unwrap();
            let half_width = f64::from(picture.sampling.widths.at_share(0.95).unwrap()) / 2.0;
            let mut errors = errors(&picture, &reference);
            errors.sort_unstable_by(f64::total_cmp);
            let measured = errors[errors.len() * 95 / 100];
            // A code for roundings of widths, and for recursion.
            let within = share_within(&errors, half_width + RECURSION + 0.5);
            println!(
                "{name:<26} {share:5.3} of the rays: 95 % of the pixels within {measured:5.1}, estimated {half_width:5.1}: {within:.3}"
            );
            assert_eq!(picture.sampling.widths.pixels(), region.pixels());
            scene_within += within;
            pictures += 1;
            let all_traced = picture.progress.unwrap().traced_pixels == region.pixels();
            assert!(!all_traced || half_width <= 3.0 * measured, "{name}: {measured} codes, estimated {half_width}");
        }
        assert!(scene_within >= 0.9 * f64::from(pictures), "{name}: {}", scene_within / f64::from(pictures));
        (all_within, all) = (all_within + scene_within, all + pictures);
    }
    assert!(all_within >= 0.95 * f64::from(all), "{}", all_within / f64::from(all));
}

#[test]
fn a_part_of_a_sure_picture_is_its_crop() {
    let accuracy = Some(Accuracy::Statistical(Statistical { half_width: 2.0, confidence: 0.9 }));
    let scene = load_scene("effects/soft_shadows", 64, Overrides { accuracy, ..Overrides::default() }).scene;
    let whole = render(&scene, Region::whole(scene.width, scene.height), &Control::default()).unwrap();
    let region = Region { x: 13, y: 7, width: 29, height: 17 };
    let part = render(&scene, region, &Control::default()).unwrap();
    let crop: Vec<[f32; 3]> = region.iter().map(|at| whole.film.pixels[whole.film.region.index(at)]).collect();
    assert!(part.film.pixels == crop);
}

#[test]
fn one_sample_of_each_pixel_tells_nothing_about_others() {
    let overrides = Overrides { antialias: Some(false), ..Overrides::default() };
    let picture = picture(&load_scene("whitted/whitted", 64, overrides));
    assert_eq!(picture.sampling.widths.at_share(0.95), None);
}
