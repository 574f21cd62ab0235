//! Pictures that stop after a number of rays or at a time.

use super::random_scenes::{loaded, proved, scene};
use crate::common::load_scene;
use std::sync::atomic::{AtomicBool, Ordering};
use strahl::camera::Window;
use strahl::film::Region;
use strahl::render::{Control, Stop, render_until};
use strahl::scene::Overrides;

/// A number of rays makes the same picture on any number of threads, and what a clock has stopped can be made again.
#[test]
fn a_number_of_rays_makes_the_same_picture_on_any_number_of_threads() {
    let text = scene(3);
    let scene =
        loaded(&text, Overrides { width: Some(120), height: Some(90), antialias: Some(true), ..proved(1) }).scene;
    let whole = Region::whole(120, 90);
    let run = |threads: usize, stop: Stop| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render_until(&scene, &Window::whole(120, 90), whole, &Control::default(), stop)).unwrap()
    };
    let all = run(1, Stop::Rays(1 << 53));
    assert!(all.progress.unwrap().finished);
    for part in [1, 500, all.rays.total() / 3, all.rays.total() * 2 / 3, all.rays.total() - 1] {
        let pictures = [1, 2, 3].map(|threads| run(threads, Stop::Rays(part)));
        for picture in &pictures {
            assert_eq!(picture.film, pictures[0].film, "{part} rays");
            assert_eq!((picture.rays, picture.highest() == pictures[0].highest()), (pictures[0].rays, true));
        }
        let count = pictures[0].progress.unwrap().count;
        assert!(count >= part, "{count} {part}");
        assert_eq!(run(2, Stop::Rays(count)).film, pictures[0].film, "the count that it names");
    }
    for ms in [0, 1, 4, 12] {
        let end = std::time::Instant::now() + std::time::Duration::from_millis(ms);
        let stopped = run(2, Stop::At(end));
        let count = stopped.progress.unwrap().count;
        assert_eq!(run(1, Stop::Rays(count)).film, stopped.film, "{ms} ms, {count} rays");
    }
    // However often it is paused.
    let (control, over) = (Control::default(), AtomicBool::new(false));
    let paused = std::thread::scope(|scope| {
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                control.pause();
                std::thread::sleep(std::time::Duration::from_millis(1));
                control.resume();
                std::thread::yield_now();
            }
        });
        let window = Window::whole(120, 90);
        let paused = render_until(&scene, &window, whole, &control, Stop::Rays(1 << 53)).unwrap();
        over.store(true, Ordering::Relaxed);
        paused
    });
    assert!(paused.film == all.film && paused.rays == all.rays && paused.highest() == all.highest());
}

/// However little time there is, every pixel shows something, and is said to be unsure.
#[test]
fn a_picture_without_time_shows_something_everywhere() {
    let scene = load_scene("whitted/whitted", 200, Overrides::default()).scene;
    let (window, region) = (Window::whole(scene.width, scene.height), Region::whole(scene.width, scene.height));
    for stop in [Stop::At(std::time::Instant::now()), Stop::Rays(0)] {
        let picture = render_until(&scene, &window, region, &Control::default(), stop).unwrap();
        let colors: std::collections::HashSet<[u32; 3]> =
            picture.film.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect();
        assert!(picture.film.pixels.iter().all(|pixel| *pixel != [0.0; 3]) && colors.len() >= 8, "{colors:?}");
        assert!(picture.sampling.widths.at_share(0.95).unwrap() > 40);
        assert_eq!(picture.progress.unwrap().traced_pixels, 28);
    }
}

/// Threads look at the clock themselves: with more of them than processors, a watcher among them sees the end far too late.
#[test]
fn no_thread_goes_on_once_the_time_is_up() {
    let scene = load_scene("whitted/whitted", 200, Overrides { antialias: Some(false), ..Overrides::default() }).scene;
    let (window, region) = (Window::whole(scene.width, scene.height), Region::whole(scene.width, scene.height));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(16).build().unwrap();
    for _ in 0..100 {
        let stop = Stop::At(std::time::Instant::now());
        let picture = pool.install(|| render_until(&scene, &window, region, &Control::default(), stop)).unwrap();
        assert_eq!(picture.progress.unwrap().traced_pixels, 28);
    }
}
