//! A picture in pieces of about a tenth of a second, so that others have their turns on the pool in between.
//!
//! A piece is byte for byte that crop of the whole, so nobody sees the cuts; where antialiasing compares neighbours, rays
//! of the pixels along a cut are traced for both sides, and count twice.

use super::pool::{Step, Workers};
use std::time::{Duration, Instant};
use strahl::bound::BoundedPixels;
use strahl::camera::Window;
use strahl::film::{Film, Region};
use strahl::render::{Cancelled, Control, Picture, Progressive, RayCounts, Refined, Sampling, Stop, render_window};
use strahl::scene::Scene;

/// How long a piece should take.
const SLICE: Duration = Duration::from_millis(100);
/// Edge of the first piece, and the least height of others.
const EDGE: u32 = 64;
/// Sides are multiples of the edge of the renderer's own tiles.
const STEP: u32 = 32;
/// Pieces are this many times as large as the one before at most: its pixels may have been cheap ones.
const GROWTH: f64 = 8.0;

/// Renders a region of what a window shows, which must fit it; `finish` is done in the turn of the last piece.
pub(crate) fn render_sliced<T: Send>(
    scene: &Scene,
    window: &Window,
    region: Region,
    workers: &Workers,
    control: &Control,
    finish: impl Fn(&Picture) -> T + Sync,
) -> Result<(Picture, T), Cancelled> {
    let render = |piece: Region| render_window(scene, window, piece, control);
    sliced([window.width, window.height], region, workers, render, finish)
}

/// Likewise, with whatever `render` makes of a piece of a picture of some width and height.
pub(crate) fn sliced<T: Send>(
    full_size: [u32; 2],
    region: Region,
    workers: &Workers,
    render: impl Fn(Region) -> Result<Picture, Cancelled> + Sync,
    finish: impl Fn(&Picture) -> T + Sync,
) -> Result<(Picture, T), Cancelled> {
    let mut cut = if workers.is_alone() { Slices::whole(region) } else { Slices::new(region) };
    let mut whole: Option<Picture> = None;
    workers.work_on(|| {
        let piece = cut.next();
        let started = Instant::now();
        let picture = match render(piece) {
            Ok(picture) => picture,
            Err(cancelled) => return Step::Done(Err(cancelled)),
        };
        cut.took(piece, started.elapsed());
        match whole.take() {
            None if piece == region => {
                let finished = finish(&picture);
                Step::Done(Ok((picture, finished)))
            }
            before => {
                let mut joined = before.unwrap_or_else(|| empty(full_size, region));
                join(&mut joined, &picture);
                if !cut.is_done() {
                    whole = Some(joined);
                    return Step::More;
                }
                let finished = finish(&joined);
                Step::Done(Ok((joined, finished)))
            }
        }
    })?
}

/// Renders a region of what a window shows until there is reason to stop, in turns of the same length: what is done stays
/// done in between. `finish` is done in the last turn.
pub(crate) fn render_until<T: Send>(
    scene: &Scene,
    window: &Window,
    region: Region,
    workers: &Workers,
    control: &Control,
    stop: Stop,
    finish: impl Fn(&Picture) -> T + Sync,
) -> Result<(Picture, T), Cancelled> {
    let mut begun: Option<Progressive<'_>> = None;
    workers.work_on(|| {
        let now = Instant::now();
        // Who gives the pool away may get it back late.
        let ends_soon = matches!(stop, Stop::At(end) if end < now + 2 * SLICE);
        let pause = (!workers.is_alone() && !ends_soon).then_some(now + SLICE);
        let mut progressive = begun.take().unwrap_or_else(|| Progressive::new(scene, window, region, control, stop));
        match progressive.go_on(pause) {
            Ok(true) => {
                begun = Some(progressive);
                Step::More
            }
            Ok(false) => {
                let picture = progressive.picture();
                let finished = finish(&picture);
                Step::Done(Ok((picture, finished)))
            }
            Err(cancelled) => Step::Done(Err(cancelled)),
        }
    })?
}

/// A black region of a picture of some width and height, for which no ray was traced.
pub(crate) fn empty([full_width, full_height]: [u32; 2], region: Region) -> Picture {
    let pixels = vec![[0.0; 3]; region.pixels() as usize];
    let film = Film { region, full_width, full_height, pixels };
    let (rays, refined, sampling) = (RayCounts::default(), Refined::default(), Sampling::default());
    Picture {
        film,
        bounded: BoundedPixels::default(),
        sampling,
        rays,
        refined,
        costs: Vec::new(),
        progress: None,
        trace_ms: 0.0,
        refine_ms: 0.0,
    }
}

/// Puts a piece where it belongs, and adds up what they took.
pub(crate) fn join(whole: &mut Picture, piece: &Picture) {
    paste(&mut whole.film, &piece.film);
    whole.bounded.append(piece.bounded.clone());
    whole.sampling += &piece.sampling;
    whole.costs.extend_from_slice(&piece.costs);
    whole.rays = whole.rays + piece.rays;
    whole.refined.pixels += piece.refined.pixels;
    whole.refined.rays = whole.refined.rays + piece.refined.rays;
    whole.trace_ms += piece.trace_ms;
    whole.refine_ms += piece.refine_ms;
}

/// Puts a piece of a film where it belongs.
fn paste(whole: &mut Film, piece: &Film) {
    let (outer, inner) = (whole.region, piece.region);
    let (left, top) = ((inner.x - outer.x) as usize, (inner.y - outer.y) as usize);
    let rows = whole.pixels.chunks_mut(outer.width as usize).skip(top);
    for (row, part) in rows.zip(piece.pixels.chunks(inner.width as usize)) {
        row[left..left + part.len()].copy_from_slice(part);
    }
}

/// Where the next piece is: in bands from the top, and in each from the left.
struct Slices {
    region: Region,
    /// Rows above the band, rows of the band, and columns of it that are done.
    top: u32,
    height: u32,
    left: u32,
    /// Pixels of the next piece.
    pixels: f64,
}

impl Slices {
    fn new(region: Region) -> Self {
        let height = EDGE.min(region.height);
        Self { region, top: 0, height, left: 0, pixels: f64::from(EDGE * EDGE) }
    }

    /// One piece.
    fn whole(region: Region) -> Self {
        Self { height: region.height, pixels: region.pixels() as f64, ..Self::new(region) }
    }

    fn next(&mut self) -> Region {
        let Self { region, top, height, left, .. } = *self;
        let left_over = region.width - left;
        let width = ((self.pixels / f64::from(height)) as u32).max(1).next_multiple_of(STEP).min(left_over);
        self.left += width;
        if self.left == region.width {
            (self.top, self.left) = (top + height, 0);
        }
        Region { x: region.x + left, y: region.y + top, width, height }
    }

    fn took(&mut self, piece: Region, time: Duration) {
        let pixels = piece.pixels() as f64;
        let in_time = pixels * SLICE.as_secs_f64() / time.as_secs_f64().max(1e-9);
        self.pixels = in_time.min(pixels * GROWTH);
        if self.left == 0 {
            // Rounded down, or the piece would not reach from side to side.
            let rows = (self.pixels / f64::from(self.region.width)) as u32 / STEP * STEP;
            self.height = rows.max(EDGE).min(self.region.height - self.top);
        }
    }

    fn is_done(&self) -> bool {
        self.top == self.region.height
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::scheduler::pool::Pool;
    use crate::service::scheduler::task::{Class, Task};
    use std::sync::Arc;

    /// The pieces of a region, of which each pixel takes so long.
    fn pieces(region: Region, pixel: Duration) -> Vec<Region> {
        let mut cut = Slices::new(region);
        let mut pieces = Vec::new();
        while !cut.is_done() {
            let piece = cut.next();
            cut.took(piece, pixel * piece.pixels() as u32);
            pieces.push(piece);
        }
        pieces
    }

    #[test]
    fn pieces_cover_each_pixel_once() {
        for (width, height) in [(1, 1), (64, 64), (65, 1), (1, 200), (300, 200), (1_000, 700)] {
            let region = Region { x: 7, y: 9, width, height };
            for nanoseconds in [1, 1_000, 50_000] {
                let mut seen = vec![0; region.pixels() as usize];
                for piece in pieces(region, Duration::from_nanos(nanoseconds)) {
                    piece.iter().for_each(|[x, y]| seen[((y - 9) * width + x - 7) as usize] += 1);
                }
                assert!(seen.iter().all(|count| *count == 1), "{width} x {height}, {nanoseconds} ns");
            }
        }
    }

    #[test]
    fn cheap_pictures_have_few_pieces_and_dear_ones_short_ones() {
        let region = Region::whole(1_920, 1_080);
        assert!(pieces(region, Duration::from_nanos(20)).len() <= 6);
        let longest = pieces(region, Duration::from_micros(20)).iter().map(Region::pixels).max().unwrap();
        assert!(Duration::from_micros(20 * longest) <= SLICE * 3 / 2, "{longest} pixels");
    }

    #[test]
    fn a_picture_in_pieces_is_the_picture() {
        let text = include_bytes!("../../../scenes/whitted/whitted.json");
        let overrides = strahl::scene::Overrides { width: Some(333), height: Some(190), ..Default::default() };
        let scene = strahl::scene::load(text, strahl::scene::Format::Json, &overrides).unwrap().scene;
        let task = Task::new(Class::Renders, "somebody", 1);
        let workers = Pool::start(Some(2)).unwrap().join(task, Arc::default());
        let control = Control::default();
        let region = Region { x: 3, y: 5, width: 320, height: 181 };
        let window = Window::whole(scene.width, scene.height);
        let count = |picture: &Picture| picture.film.pixels.len();
        let (cut, pixels) = render_sliced(&scene, &window, region, &workers, &control, count).unwrap();
        assert_eq!(pixels, cut.film.pixels.len());
        assert!(cut.film == workers.work(|| strahl::render::render(&scene, region, &control)).unwrap().unwrap().film);
    }
}
