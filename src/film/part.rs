//! What is shown of pixels that are a part surface and a part transparent background.

use super::display::Display;
use super::srgb;

/// The 8-bit code of an alpha.
pub(crate) fn code_of_alpha(alpha: f32) -> u8 {
    (255.0 * alpha.clamp(0.0, 1.0)).round() as u8
}

/// An alpha with which a file can show so much light, already multiplied by it.
pub(super) fn raised(alpha: f32, light: [f32; 3]) -> f32 {
    light.into_iter().fold(alpha, f32::max).min(1.0)
}

impl Display {
    /// The linear colors, already multiplied by alpha, that are shown of a radiance of which a share `alpha` is not background, and
    /// which is multiplied by it. Up to white it is a surface that fills this share, alpha T(C / alpha) with the curve T. What
    /// is brighter, such as a highlight on clear glass, adds to it as it would over black: with W, the radiance as if its
    /// brightest channel were white, T(C) - T(alpha W) + alpha T(W). Without a curve that is C.
    pub(crate) fn show_part(&self, radiance: [f32; 3], alpha: f32) -> [f32; 3] {
        if self.is_linear() {
            return self.show(radiance);
        }
        if alpha == 0.0 && radiance == [0.0; 3] {
            // As most of a model's picture is.
            return radiance;
        }
        let most = self.brightest(radiance);
        if most <= alpha {
            let shown = self.show(radiance.map(|channel| if alpha > 0.0 { channel / alpha } else { 0.0 }));
            return shown.map(|channel| channel.min(1.0) * alpha);
        }
        let white = radiance.map(|channel| channel / most);
        let [all, of_white, surface] =
            [radiance, white.map(|channel| channel * alpha), white].map(|radiance| self.show(radiance));
        std::array::from_fn(|c| (all[c] - of_white[c] + surface[c].min(1.0) * alpha).max(0.0))
    }

    /// [`Self::show_part`] of many pixels: what is no brighter than its share over lanes, the same bits.
    pub(super) fn show_each_part(&self, radiance: &[[f32; 3]], alpha: &[f32], shown: &mut [[f32; 3]]) {
        if self.is_linear() {
            return self.show_each(radiance, shown);
        }
        let is_surface = |radiance: [f32; 3], alpha: f32| alpha > 0.0 && self.brightest(radiance) <= alpha;
        let surface = |(radiance, alpha): (&[f32; 3], &f32)| match is_surface(*radiance, *alpha) {
            true => radiance.map(|channel| channel / alpha),
            false => [0.0; 3],
        };
        let surfaces: Vec<[f32; 3]> = radiance.iter().zip(alpha).map(surface).collect();
        self.show_each(&surfaces, shown);
        for ((shown, radiance), alpha) in shown.iter_mut().zip(radiance).zip(alpha) {
            *shown = match is_surface(*radiance, *alpha) {
                true => shown.map(|channel| channel.min(1.0) * alpha),
                false => self.show_part(*radiance, *alpha),
            };
        }
    }

    /// The lowest and the highest of [`Self::show_part`] for a radiance between `low` and `high`, and an alpha between `least` and
    /// `alpha`.
    pub(crate) fn ends_of_part(&self, low: [f32; 3], high: [f32; 3], least: f32, alpha: f32) -> [[f32; 2]; 3] {
        if self.is_linear() {
            return self.ends(low, high);
        }
        let (dimmest, brightest) = (self.brightest(low), self.brightest(high));
        // A radiance that is shown as white.
        let white = (1.0 / self.gain()) as f32;
        let part = |radiance: [f32; 3], by: f32| {
            radiance.map(|channel| if channel > 0.0 { (channel / by).min(white) } else { 0.0 })
        };
        let mut hull = [[f32::INFINITY, 0.0]; 3];
        let mut take = |ends: [[f32; 2]; 3]| {
            for (hull, [low, high]) in hull.iter_mut().zip(ends) {
                *hull = [hull[0].min(low.max(0.0)), hull[1].max(high)];
            }
        };
        if dimmest <= alpha {
            let surface = self.ends(part(low, alpha), part(high, least));
            take(surface.map(|[low, high]| [low.min(1.0) * least, high.min(1.0) * alpha]));
        }
        if brightest > least {
            let scaled = |radiance: [f32; 3], by: f32| radiance.map(|channel| channel * by.min(1.0));
            let all = self.ends(low, high);
            let of_white = self.ends(scaled(low, least / brightest), scaled(high, alpha / dimmest.max(least)));
            let surface = self.ends(part(low, brightest.max(alpha)), part(high, dimmest.max(least)));
            take(std::array::from_fn(|c| {
                let [[low, high], [least_white, most_white], [dark, bright]] = [all[c], of_white[c], surface[c]];
                [low - most_white + dark.min(1.0) * least, high - least_white + bright.min(1.0) * alpha]
            }));
        }
        hull
    }

    /// How many codes a pixel is off at most, channel by channel, that shows the radiance `low` with `alpha`, if its radiance is nowhere
    /// above `high`, and its alpha not below `least`: of the picture over the backdrop, or else black, and of the alpha that
    /// files have.
    pub(crate) fn codes_of_part_off(&self, low: [f32; 3], high: [f32; 3], [least, alpha]: [f32; 2]) -> [u8; 3] {
        let shown = self.show_part(low, alpha);
        let ends = self.ends_of_part(low, high, least, alpha);
        let [low, high] = [0, 1].map(|end| ends.map(|ends| ends[end]));
        let of_file = code_of_alpha(raised(alpha, shown));
        let of_alpha = [raised(least, low), raised(alpha, high)].map(|end| code_of_alpha(end).abs_diff(of_file));
        // Files over a backdrop have no alpha.
        let of_alpha = if self.backdrop().is_none() { of_alpha[0].max(of_alpha[1]) } else { 0 };
        let backdrop = self.backdrop().unwrap_or_default();
        std::array::from_fn(|c| {
            let code = |light: f32, alpha: f32| srgb::code8(light + backdrop[c] * (1.0 - alpha));
            let [low, here, high] = [code(low[c], alpha), code(shown[c], alpha), code(high[c], least)];
            high.abs_diff(here).max(low.abs_diff(here)).max(of_alpha)
        })
    }

    /// The brightest channel of a radiance after exposure.
    fn brightest(&self, radiance: [f32; 3]) -> f32 {
        radiance.into_iter().map(|channel| self.expose(channel)).fold(0.0, f64::max) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::display::tests::{CURVES, noise};

    #[test]
    fn no_part_leaves_the_interval_of_its_radiance_and_alpha() {
        for tone in CURVES {
            for stops in [-2.0, 0.0, 1.0] {
                let display = Display::new(stops, tone);
                for case in 0..4_000 {
                    let at = |k: u64| noise(case * 50 + k);
                    // Around alpha, and far above it.
                    let alpha = at(0);
                    let least = alpha * if at(1) < 0.2 { 0.0 } else { 1.0 - at(1) * at(2) };
                    let scale = alpha * crate::math::pow(2.0, f64::from(8.0 * at(3) - 4.0)) as f32;
                    let low: [f32; 3] = std::array::from_fn(|c| scale * at(4 + c as u64));
                    let high: [f32; 3] = low.map(|channel| channel * (1.0 + at(8) * at(9)));
                    let ends = display.ends_of_part(low, high, least, alpha);
                    for inside in 0..10 {
                        let share = |k: u64| {
                            if inside < 4 { (inside >> (k & 1) & 1) as f32 } else { noise(case + 977 * inside + k) }
                        };
                        let light = std::array::from_fn(|c| low[c] + share(c as u64) * (high[c] - low[c]));
                        let part = least + share(3) * (alpha - least);
                        let shown = display.show_part(light, part);
                        for c in 0..3 {
                            let [least, most] = ends[c];
                            let inside = least - 1e-5..=most + 1e-5;
                            assert!(
                                inside.contains(&shown[c]),
                                "{tone:?} {stops} {low:?} {high:?} {light:?} {part} {ends:?} {shown:?}"
                            );
                        }
                    }
                    let ends = display.ends_of_part(low, low, alpha, alpha);
                    let shown = display.show_part(low, alpha);
                    assert!(
                        (0..3).all(|c| ends[c][1] - ends[c][0] < 1e-5 && (ends[c][0] - shown[c]).abs() < 1e-5),
                        "{ends:?} {shown:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn many_parts_are_shown_as_each_alone() {
        for tone in CURVES {
            let display = Display::new(0.5, tone);
            let alpha: Vec<f32> = (0..1_000).map(|i| if i % 7 == 0 { 0.0 } else { noise(i) }).collect();
            let light =
                |i: u64, c: u64| if i.is_multiple_of(14) { 0.0 } else { 1.5 * alpha[i as usize] * noise(3 * i + c) };
            let radiance: Vec<[f32; 3]> = (0..1_000).map(|i| [light(i, 0), light(i, 1), light(i, 2)]).collect();
            let mut shown = vec![[0.0; 3]; 1_000];
            display.show_each_part(&radiance, &alpha, &mut shown);
            for i in 0..1_000 {
                assert_eq!(shown[i], display.show_part(radiance[i], alpha[i]), "{tone:?} {i}");
            }
        }
    }

    /// A surface fills its share; a highlight is as bright as over black, and nothing jumps in between.
    #[test]
    fn parts_are_surfaces_up_to_white_and_light_beyond() {
        for tone in CURVES {
            let display = Display::new(0.0, tone);
            for alpha in [0.1_f32, 0.5, 1.0] {
                let color = [0.8_f32, 0.4, 0.2];
                let shown = display.show_part(color.map(|channel| channel * alpha), alpha);
                assert!((0..3).all(|c| (shown[c] - display.show(color)[c] * alpha).abs() < 1e-6), "{tone:?} {shown:?}");
                let near = |by: f32| display.show_part([alpha * by; 3], alpha)[0];
                assert!((near(0.9999) - near(1.0001)).abs() < 1e-3, "{tone:?} {alpha}");
            }
            let bright = [18.0_f32; 3];
            let (part, whole) = (display.show_part(bright, 0.05), display.show(bright));
            assert!((0..3).all(|c| (part[c] - whole[c]).abs() < 0.05), "{tone:?} {part:?} {whole:?}");
            assert_eq!(display.show_part(bright, 1.0), whole);
            assert_eq!(display.show_part([0.0; 3], 0.0), [0.0; 3]);
        }
    }
}
