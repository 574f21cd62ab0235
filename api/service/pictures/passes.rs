//! Coarse pictures before a picture is finished, for a client that looks on.
//!
//! Nobody waits for the client: a pass that it has no room for is left out.

use super::render::RenderSpec;
use crate::service::memory_budget::{MemoryBudget, MeteredBytes};
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::pool::Workers;
use parking_lot::Mutex;
use std::collections::HashMap;
use std::sync::{Arc, Weak};
use strahl::camera::Window;
use strahl::film::{FileFormat, Film, Region, encode};
use strahl::plan::pilot::Effort;
use strahl::render::{Cancelled, Control, render_window};
use tokio::sync::broadcast;

/// Levels of the passes: their pixels are 2^level times as wide and high as the picture's.
const LEVELS: [u32; 3] = [3, 2, 1];
/// Pixels of the smallest pass.
const FEWEST: u64 = 1_024;

/// A coarse picture of a region.
#[derive(Debug, Clone)]
pub(crate) struct Pass {
    /// Each of its pixels stands for so many across and down.
    pub(crate) scale: u32,
    /// The region.
    pub(crate) region: Region,
    /// Milliseconds that the picture should take from now on; none if it ends by a clock or a count.
    pub(crate) eta_ms: Option<f64>,
    /// The picture.
    pub(crate) png: Arc<MeteredBytes>,
}

/// Passes that wait for a client.
const WAITING: usize = 2;

/// The newest pass, and those that will come.
pub(crate) type Passes = (Option<Pass>, broadcast::Receiver<Pass>);

/// The passes of a picture that several clients wait for.
#[derive(Debug)]
pub(crate) struct PassChannel {
    /// The newest, for who comes later.
    last: Mutex<Option<Pass>>,
    sender: broadcast::Sender<Pass>,
}

impl PassChannel {
    /// Shows a pass to all. A client that has not read the last ones misses it.
    pub(crate) fn show(&self, pass: Pass) {
        let mut last = self.last.lock();
        *last = Some(pass.clone());
        // Whether anybody is there does not matter.
        let _ = self.sender.send(pass);
    }

    /// The newest pass so far, and those that will come.
    pub(crate) fn subscribe(&self) -> Passes {
        let last = self.last.lock();
        (last.clone(), self.sender.subscribe())
    }
}

/// The channels of the pictures that are made, by the name of the work.
#[derive(Debug, Default)]
pub(crate) struct PassChannels(Mutex<HashMap<String, Weak<PassChannel>>>);

impl PassChannels {
    /// The channel of a picture, which is there for as long as anybody has it.
    pub(crate) fn join(&self, name: &str) -> Arc<PassChannel> {
        let mut channels = self.0.lock();
        if let Some(channel) = channels.get(name).and_then(Weak::upgrade) {
            return channel;
        }
        channels.retain(|_, channel| channel.strong_count() > 0);
        let channel = Arc::new(PassChannel { last: Mutex::default(), sender: broadcast::Sender::new(WAITING) });
        channels.insert(name.to_owned(), Arc::downgrade(&channel));
        channel
    }
}

/// Whom passes are shown.
pub(crate) type Show<'a> = &'a (dyn Fn(Pass) + Sync);

/// Shows the passes of a whole picture that comes next: with one sample in a pixel, since nobody looks at the edges of large
/// pixels.
pub(crate) fn passes(
    ready: &PreparedScene,
    spec: &RenderSpec,
    budget: &MemoryBudget,
    workers: &Workers,
    control: &Control,
    show: Show<'_>,
) -> Result<(), Cancelled> {
    let mut scene = ready.scene.through(&Window::whole(ready.scene.width, ready.scene.height));
    (scene.samples, scene.adaptive, scene.antialias, scene.statistical) = (1, false, false, None);
    let &RenderSpec { window: Window { width, height, .. }, region, .. } = spec;
    let mut plan = ready.outline.plan(&ready.scene);
    workers.work(|| plan.estimate(&ready.scene, region, control, Effort::BESIDE))??;
    let eta_ms = plan.estimate.map(|estimate| estimate.ms);
    // Where a pixel has one sample, half the width costs a quarter of the picture.
    let is_cheap = !ready.scene.refines() && !ready.scene.adaptive && ready.scene.samples == 1;
    for level in LEVELS.into_iter().filter(|level| *level > u32::from(is_cheap)) {
        let Some(coarse) = Window::level(width, height, level as i32) else { continue };
        if u64::from(coarse.width) * u64::from(coarse.height) < FEWEST {
            continue;
        }
        let whole = Region::whole(coarse.width, coarse.height);
        let pass = workers.work(|| {
            let film = render_window(&scene, &coarse, whole, control)?.film;
            Ok(pass_of(&film, 1 << level, region, eta_ms, budget))
        })??;
        pass.into_iter().for_each(show);
    }
    Ok(())
}

/// Shows what is known so far of a picture that ends by itself: of its pixels those at a distance, between which the others
/// are interpolated.
pub(crate) fn show_thinned(film: &Film, distance: u32, budget: &MemoryBudget, show: Show<'_>) {
    if distance > 1 {
        pass_of(&thinned(film, distance), distance, film.region, None, budget).into_iter().for_each(show);
    }
}

/// A pass as a file. Without memory for it there is none.
fn pass_of(film: &Film, scale: u32, region: Region, eta_ms: Option<f64>, budget: &MemoryBudget) -> Option<Pass> {
    let png = budget.metered(encode(film, FileFormat::Png8)).ok()?;
    Some(Pass { scale, region, eta_ms, png: Arc::new(png) })
}

fn thinned(film: &Film, distance: u32) -> Film {
    let Region { width, height, .. } = film.region;
    let [across, down] = [width, height].map(|length| length.div_ceil(distance));
    let places = || {
        let row = move |y: u32| {
            (0..across).map(move |x| ((y * distance) as usize * width as usize) + (x * distance) as usize)
        };
        (0..down).flat_map(row)
    };
    Film {
        region: Region::whole(across, down),
        full_width: across,
        full_height: down,
        pixels: places().map(|place| film.pixels[place]).collect(),
        alpha: if film.alpha.is_empty() { Vec::new() } else { places().map(|place| film.alpha[place]).collect() },
        display: film.display,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_comes_later_gets_the_newest_pass() {
        let (channels, budget) = (PassChannels::default(), MemoryBudget::new(1 << 30));
        let first = channels.join("a");
        assert!(first.subscribe().0.is_none());
        for scale in [8, 4] {
            let png = Arc::new(budget.metered(vec![0]).unwrap());
            first.show(Pass { scale, region: Region::whole(1, 1), eta_ms: None, png });
        }
        let (newest, mut coming) = channels.join("a").subscribe();
        assert_eq!(newest.map(|pass| pass.scale), Some(4));
        assert!(coming.try_recv().is_err(), "it has come already");
        assert!(channels.join("b").subscribe().0.is_none(), "another picture");
        drop(first);
        assert!(channels.join("a").subscribe().0.is_none(), "nobody has it any more");
    }
}
