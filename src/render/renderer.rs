//! The renderer of one picture: its tiles on the current rayon pool, and antialiasing.

use super::antialiasing::{Uneven, refined_samples};
use super::contrast::{CONTRAST, contrasts_of};
use super::packets::{KernelFormat, TraceJob, Traced};
use crate::control::{Cancelled, Control, Stopwatch};
use crate::trace::pixel::Samples;

use super::confidence::{Histogram, Sampling};
use super::tiles::{edge_of_tiles, near, split};
use super::{Picture, Refined, RenderOptions, statistical_sampling};
use crate::camera::Window;
use crate::film::{Film, Region};
use crate::lanes::MAX_LANES;
use crate::scene::Scene;
use crate::scene::world::World;
use crate::trace::variants::KernelVariant;
use rayon::prelude::*;

/// Renders pictures of one scene.
pub(crate) struct Renderer<'a, R> {
    pub(super) scene: &'a Scene,
    pub(super) control: &'a Control,
    pub(super) options: RenderOptions,
    /// Size of the whole picture.
    pub(super) size: [u32; 2],
    pub(super) job: TraceJob<'a, R>,
}

impl<'a, R: KernelFormat> Renderer<'a, R> {
    pub(super) fn new(scene: &'a Scene, world: &'a World<R>, control: &'a Control, options: RenderOptions) -> Self {
        let kernel = if options.specialised { KernelVariant::of(world) } else { KernelVariant::General };
        let (camera, eye, pruning) = (world.camera, R::eye_media(world), world.rules.pruning);
        let job = TraceJob {
            world,
            camera,
            eye,
            control,
            kernel,
            pruning,
            low: false,
            sums: false,
            watched: false,
            measured: false,
        };
        Self { scene, control, options, size: [scene.width, scene.height], job }
    }

    /// The renderer of a window of the picture.
    pub(super) fn through(mut self, window: &Window) -> Self {
        self.size = [window.width, window.height];
        self.job.camera = self.job.camera.through(window);
        self
    }

    /// The renderer that records the cost of each packet.
    pub(super) fn watched(mut self) -> Self {
        self.job.watched = true;
        self
    }

    /// The renderer that records the cost of each pixel: its rays, and its time if that is asked for.
    pub(super) fn measured(mut self, timed: bool) -> Self {
        (self.job.watched, self.job.measured) = (timed, true);
        self
    }

    pub(super) fn picture(&self, region: Region) -> Result<Picture, Cancelled> {
        let [full_width, full_height] = self.size;
        if self.scene.adaptive {
            return Ok(self.picture_of(region, self.doubled(region)?, Refined::default()));
        }
        if !self.scene.refines() {
            self.control.add_total(region.pixels());
            return Ok(self.picture_of(region, self.grid(region)?, Refined::default()));
        }
        // Antialiasing compares with neighbours beyond the region's edge, so that a tile is a crop of the whole.
        let around = region.with_border(full_width, full_height);
        self.control.add_total(around.pixels());
        let mut traced = self.grid(around)?;
        let refining = Stopwatch::start();
        let contrasts = contrasts_of(&self.job.world.display, &traced, around.width);
        let contrast = |at: [u32; 2]| contrasts[around.index(at)];
        let is_uneven = |at: [u32; 2]| contrast(at) >= CONTRAST;
        let uneven = near(region, is_uneven);
        self.control.add_total(uneven.len() as u64);
        let uneven_pixel = |at: &[u32; 2]| Uneven { at: *at, contrast: contrast(*at) };
        let refined = self.refine(&uneven.iter().map(uneven_pixel).collect::<Vec<_>>())?;
        if around != region {
            traced.pixels = region.iter().map(|at| traced.pixels[around.index(at)]).collect();
            let alpha = |at: [u32; 2]| traced.alpha.get(around.index(at)).copied();
            traced.alpha = region.iter().filter_map(alpha).collect();
        }
        for (&at, pixel) in uneven.iter().zip(refined.pixels) {
            traced.pixels[region.index(at)] = pixel;
        }
        for (&at, alpha) in uneven.iter().zip(refined.alpha) {
            traced.alpha[region.index(at)] = alpha;
        }
        traced.bounded.retain(|bounded| region.contains(bounded.at) && !is_uneven(bounded.at));
        traced.bounded.append(refined.bounded);
        traced.rays = traced.rays + refined.rays;
        traced.costs.retain(|cost| region.contains(cost.at));
        traced.costs.extend(refined.costs);
        // The error of a pixel that is not refined is likely at most half of its contrast.
        let even = region.iter().map(contrast).filter(|contrast| *contrast < CONTRAST);
        traced.widths = even.chain(refined.widths).collect();
        if around.pixels() == 1 {
            // A single pixel has no neighbours.
            traced.widths.clear();
        }
        let picture = self.picture_of(region, traced, Refined { pixels: uneven.len() as u64, rays: refined.rays });
        Ok(Picture { refine_ms: refining.milliseconds(), ..picture })
    }

    pub(super) fn picture_of(&self, region: Region, traced: Traced, refined: Refined) -> Picture {
        let Traced { pixels, alpha, bounded, rays, widths, reached, costs, .. } = traced;
        let film = Film { alpha, ..self.film(region, pixels) };
        let sampling = Sampling { widths: Histogram::of(&widths), reached };
        Picture { film, bounded, sampling, rays, refined, costs, ..Picture::default() }
    }

    /// Pixels of a region, row by row, as a film.
    pub(super) fn film(&self, region: Region, pixels: Vec<[f32; 3]>) -> Film {
        let [full_width, full_height] = self.size;
        Film { region, full_width, full_height, pixels, display: self.job.world.display, ..Film::default() }
    }

    /// The base samples of a region, row by row.
    fn grid(&self, region: Region) -> Result<Traced, Cancelled> {
        let mut pixels = vec![[0.0; 3]; region.pixels() as usize];
        let edge = edge_of_tiles(region, self.options.tile, rayon::current_num_threads());
        let mut alpha = vec![0.0; if self.job.world.transparent { pixels.len() } else { 0 }];
        let tiles = split(region, edge, &mut pixels).into_par_iter().zip(split(region, edge, &mut alpha));
        let parts: Result<Vec<Traced>, Cancelled> = tiles
            // Tiles differ in cost: each may go to another thread until the last.
            .with_max_len(1)
            .map(|(mut pixels, mut alpha)| {
                let mut traced = self.trace(&pixels.blocks(), self.scene.samples)?;
                pixels.put(&std::mem::take(&mut traced.pixels));
                alpha.put(&std::mem::take(&mut traced.alpha));
                Ok(traced)
            })
            .collect();
        Ok(Traced { pixels, alpha, ..Traced::joined(parts?) })
    }

    /// Pixels at any places, in the order given.
    pub(super) fn list(&self, at: &[[u32; 2]], samples: u32) -> Result<Traced, Cancelled> {
        let parts: Result<Vec<Traced>, Cancelled> =
            at.par_chunks(16 * MAX_LANES).with_max_len(1).map(|part| self.trace(part, samples)).collect();
        Ok(Traced::joined(parts?))
    }

    /// The same of another job, without a statistical target.
    pub(super) fn list_of(
        &self,
        job: &TraceJob<'_, R>,
        at: &[[u32; 2]],
        samples: Samples,
    ) -> Result<Traced, Cancelled> {
        let part = |part: &[[u32; 2]]| {
            let mut traced = Traced::default();
            R::trace(self.options.level, job, part, samples, &mut traced);
            self.settled(traced, part.len())
        };
        let parts: Result<Vec<Traced>, Cancelled> = at.par_chunks(16 * MAX_LANES).with_max_len(1).map(part).collect();
        Ok(Traced::joined(parts?))
    }

    fn trace(&self, at: &[[u32; 2]], samples: u32) -> Result<Traced, Cancelled> {
        let mut traced = Traced { pixels: Vec::with_capacity(at.len()), ..Traced::default() };
        self.trace_pixels(at, samples, &mut traced);
        self.settled(traced, at.len())
    }

    fn settled(&self, traced: Traced, pixels: usize) -> Result<Traced, Cancelled> {
        self.control.add_rays(traced.rays.total());
        if self.control.stops() {
            return Err(Cancelled);
        }
        self.control.add_done(pixels as u64);
        Ok(traced)
    }

    /// Pixels with `samples` samples, or with as many as the statistical target needs.
    pub(super) fn trace_pixels(&self, at: &[[u32; 2]], samples: u32, traced: &mut Traced) {
        match &self.scene.statistical {
            Some(target) => statistical_sampling::trace(self.options.level, &self.job, target, at, traced),
            None => R::trace(self.options.level, &self.job, at, Samples::of_picture(samples), traced),
        }
    }

    /// The samples of one pixel in the statistical mode.
    pub(super) fn sure_samples_of(&self, at: [u32; 2]) -> Result<u32, Cancelled> {
        let traced = self.trace(&[at], self.scene.samples)?;
        Ok(traced.reached.most_samples)
    }

    /// The samples of one pixel of a picture that is refined.
    pub(super) fn refined_samples_of(&self, at: [u32; 2]) -> Result<u32, Cancelled> {
        let [width, height] = self.size;
        let around = Region { x: at[0], y: at[1], width: 1, height: 1 }.with_border(width, height);
        let contrasts = contrasts_of(&self.job.world.display, &self.grid(around)?, around.width);
        Ok(refined_samples(contrasts[around.index(at)], self.scene.samples))
    }
}
