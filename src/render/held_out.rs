//! How far pixels of a stopped picture are off, from those that were traced further: what they showed before was held out.
//!
//! Pixels are alike if they had as many samples and as much contrast to their neighbours. What those showed that were traced
//! meanwhile is compared with what they show now, and the others are as likely to be as far off.

/// Groups of pixels by contrast: that of bit length 0 to 8.
const GROUPS: usize = 9;
/// Pixels of a group from which on it speaks for itself.
const ENOUGH: u32 = 32;
/// Quantiles that stand for all pixels of a group.
pub(super) const QUANTILES: usize = 64;

/// Changes of held-out pixels, in codes of the worst channel.
#[derive(Debug, Clone)]
pub(super) struct HeldOut {
    groups: [Group; GROUPS],
}

#[derive(Debug, Clone)]
struct Group {
    /// Pixels by change.
    pixels: [u32; 256],
    all: u32,
}

impl Default for HeldOut {
    fn default() -> Self {
        Self { groups: std::array::from_fn(|_| Group { pixels: [0; 256], all: 0 }) }
    }
}

fn group_of(contrast: u8) -> usize {
    (u8::BITS - contrast.leading_zeros()) as usize
}

impl HeldOut {
    /// A pixel that was held out has changed by so many codes.
    pub(super) fn add(&mut self, contrast: u8, change: u8) {
        let group = &mut self.groups[group_of(contrast)];
        group.pixels[usize::from(change)] += 1;
        group.all += 1;
    }

    /// The likely changes of the other pixels of a contrast: their quantiles. None if too few were held out, also of pixels with
    /// more contrast.
    pub(super) fn changes(&self, contrast: u8) -> Option<[u8; QUANTILES]> {
        let group = self.groups[group_of(contrast)..].iter().find(|group| group.all >= ENOUGH)?;
        let (mut change, mut below) = (0, group.pixels[0]);
        Some(std::array::from_fn(|quantile| {
            let share = (quantile as f64 + 0.5) / QUANTILES as f64;
            while f64::from(below) < share * f64::from(group.all) {
                change += 1;
                below += group.pixels[change];
            }
            change as u8
        }))
    }
}
