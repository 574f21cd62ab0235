//! One pixel of each block of a picture, exactly as the picture has it: for coarse maps.

use super::antialiasing::Uneven;
use super::contrast::{CONTRAST, codes_over_both, contrast_in};
use super::packets::{KernelFormat, Traced};
use super::renderer::Renderer;
use super::{Picture, Refined};
use crate::bound::BoundedPixel;
use crate::control::Cancelled;
use crate::film::Region;
use std::collections::HashMap;

/// Blocks from which on one pixel with its neighbours takes less than all pixels do.
const LEAST: u32 = 4;

impl<R: KernelFormat> Renderer<'_, R> {
    /// The pixels in the middle of blocks of `step` x `step` as a picture of their own.
    pub(super) fn sparse(&self, step: u32) -> Result<Picture, Cancelled> {
        let (width, height) = (self.scene.width, self.scene.height);
        let region = Region::whole(width.div_ceil(step), height.div_ceil(step));
        let middle = |[x, y]: [u32; 2]| [(x * step + step / 2).min(width - 1), (y * step + step / 2).min(height - 1)];
        let middles: Vec<[u32; 2]> = region.iter().map(middle).collect();
        let traced = if step < LEAST {
            self.of_whole(&middles)?
        } else if self.scene.adaptive {
            self.doubled_list(&middles)?
        } else if self.scene.refines() {
            self.with_neighbours(&middles)?
        } else {
            self.list(&middles, self.scene.samples)?
        };
        let block = |at: [u32; 2]| [at[0] / step, at[1] / step];
        let bounded: Vec<BoundedPixel> =
            traced.bounded.iter().map(|pixel| BoundedPixel { at: block(pixel.at), ..*pixel }).collect();
        let mut traced = Traced { bounded: Default::default(), ..traced };
        traced.bounded.add(bounded);
        traced.costs.iter_mut().for_each(|cost| cost.at = block(cost.at));
        Ok(self.picture_of(region, traced, Refined::default()))
    }

    /// Pixels of the whole picture.
    fn of_whole(&self, at: &[[u32; 2]]) -> Result<Traced, Cancelled> {
        let whole = Region::whole(self.scene.width, self.scene.height);
        let mut wanted = vec![false; whole.pixels() as usize];
        at.iter().for_each(|at| wanted[whole.index(*at)] = true);
        let Picture { film, mut bounded, rays, mut costs, .. } = self.picture(whole)?;
        bounded.retain(|pixel| wanted[whole.index(pixel.at)]);
        costs.retain(|cost| wanted[whole.index(cost.at)]);
        let pixels = at.iter().map(|at| film.pixels[whole.index(*at)]).collect();
        let alpha = at.iter().filter_map(|at| film.alpha.get(whole.index(*at)).copied()).collect();
        Ok(Traced { pixels, alpha, bounded, rays, costs, ..Traced::default() })
    }

    /// Pixels that antialiasing refines where they differ from a neighbour. What the neighbours take is not theirs.
    fn with_neighbours(&self, at: &[[u32; 2]]) -> Result<Traced, Cancelled> {
        let around: Vec<Region> = at
            .iter()
            .map(|[x, y]| Region { x: *x, y: *y, width: 1, height: 1 }.with_border(self.scene.width, self.scene.height))
            .collect();
        let all: Vec<[u32; 2]> = around.iter().flat_map(|around| around.iter()).collect();
        let mut traced = self.list(&all, self.scene.samples)?;
        let codes = codes_over_both(&self.job.world.display, &traced.pixels, &traced.alpha);
        let (mut first, mut middles, mut uneven) = (0, Vec::with_capacity(at.len()), Vec::new());
        for (&[x, y], around) in at.iter().zip(&around) {
            let end = first + around.pixels() as usize;
            let (middle, contrast) = (first + around.index([x, y]), contrast_in(&codes[first..end], *around, [x, y]));
            if contrast >= CONTRAST {
                uneven.push((middles.len(), Uneven { at: [x, y], contrast }));
            }
            middles.push(middle);
            first = end;
        }
        let (uneven, pixels): (Vec<usize>, Vec<Uneven>) = uneven.into_iter().unzip();
        let refined = self.refine(&pixels)?;
        let mut pixels: Vec<[f32; 3]> = middles.iter().map(|index| traced.pixels[*index]).collect();
        uneven.iter().zip(refined.pixels).for_each(|(index, pixel)| pixels[*index] = pixel);
        let mut alpha: Vec<f32> = middles.iter().filter_map(|index| traced.alpha.get(*index).copied()).collect();
        uneven.iter().zip(refined.alpha).for_each(|(index, of_pixel)| alpha[*index] = of_pixel);
        // Base samples of a refined pixel bound nothing, but are a part of its cost.
        let kept: HashMap<[u32; 2], usize> = at.iter().copied().zip(0..).collect();
        traced.bounded.retain(|pixel| kept.get(&pixel.at).is_some_and(|index| uneven.binary_search(index).is_err()));
        traced.bounded.append(refined.bounded);
        let costs =
            if traced.costs.is_empty() { Vec::new() } else { middles.iter().map(|at| traced.costs[*at]).collect() };
        Ok(Traced {
            pixels,
            alpha,
            bounded: traced.bounded,
            costs: costs.into_iter().chain(refined.costs).collect(),
            rays: traced.rays + refined.rays,
            ..Traced::default()
        })
    }
}
