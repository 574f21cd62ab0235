//! A picture that is rendered now: that of a job, or one frame of a sequence.

use super::canvas::Canvas;
use super::files::frame_name;
use super::record::Record;
use super::tile_order::{TileOrder, overlap};
use parking_lot::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use strahl::film::{Film, Region};

/// One picture.
#[derive(Debug)]
pub(super) struct Rendering {
    /// Its number in a sequence.
    pub(super) frame: Option<u32>,
    /// The name of its files and of messages about it.
    pub(super) name: String,
    /// Its tiles, and whether each is finished.
    pub(super) tiles: Box<[(Region, AtomicBool)]>,
    /// Which of them are to come.
    pub(super) order: Mutex<Option<TileOrder>>,
    /// The picture so far.
    pub(super) canvas: Mutex<Option<Canvas>>,
    /// The preview that was shown before the canvas was there, or before it was taken.
    pub(super) last_preview: Mutex<Option<Film>>,
}

impl Rendering {
    /// That of a job, or of a frame of it. Nothing of it is done.
    pub(super) fn of(record: &Record, frame: Option<u32>) -> Self {
        let picture = Region::whole(record.width, record.height);
        let tiles = picture.tiles(edge(record)).map(|region| (region, AtomicBool::new(false))).collect();
        let name = frame.map_or_else(|| record.id.clone(), |frame| frame_name(&record.id, frame));
        Self { frame, name, tiles, order: Mutex::default(), canvas: Mutex::default(), last_preview: Mutex::default() }
    }

    /// A region, if all of it is finished.
    pub(super) fn finished_part(&self, region: Region) -> Option<Film> {
        let is_done = |(tile, done): &(Region, AtomicBool)| !overlap(*tile, region) || done.load(Ordering::Acquire);
        let canvas = self.canvas.lock();
        canvas.as_ref().filter(|_| self.tiles.iter().all(is_done)).map(|canvas| canvas.crop(region))
    }

    /// The small picture of it: while it is encoded that which was shown last, and before anything is painted that of the frame before.
    pub(super) fn preview(&self) -> Option<Film> {
        let painted = self.canvas.lock().as_ref().and_then(Canvas::painted).cloned();
        painted.or_else(|| self.last_preview.lock().clone())
    }

    /// Whether there is a small picture.
    pub(super) fn has_preview(&self) -> bool {
        self.canvas.lock().as_ref().is_some_and(|canvas| canvas.painted().is_some())
            || self.last_preview.lock().is_some()
    }

    /// Takes the picture, once it is whole.
    pub(super) fn take(&self) -> Option<Canvas> {
        *self.last_preview.lock() = self.preview();
        self.canvas.lock().take()
    }

    /// Takes the next tile.
    pub(super) fn next(&self) -> Option<(u32, Region)> {
        let next = self.order.lock().as_mut().and_then(TileOrder::next);
        next.map(|(number, region)| (number as u32, region))
    }

    /// Pixels of the tiles to come.
    pub(super) fn pixels_left(&self) -> u64 {
        self.order.lock().as_ref().map_or(0, TileOrder::pixels_left)
    }
}

/// Number of the tiles of a job's picture, or of one frame.
pub(super) fn tiles_of(record: &Record) -> usize {
    let edge = edge(record);
    record.width.div_ceil(edge) as usize * record.height.div_ceil(edge) as usize
}

/// The edge of its tiles: there is one tile if the picture has none.
fn edge(record: &Record) -> u32 {
    if record.edge == 0 { record.width.max(record.height).max(1) } else { record.edge }
}
