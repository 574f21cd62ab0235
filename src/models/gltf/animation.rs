//! Animations at a time: key frames between which values step, run evenly, or follow a cubic spline (glTF 2.0, appendix C).

use super::super::fault::{Fault, Kind, Subject, Warning, warn};
use super::buffers::Buffers;
use super::json::{AnimationSampler, Document};
use super::nodes::{Local, unit};
use crate::math;
use glam::{DQuat, DVec3};

/// How values go from one key frame to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// Moves nodes to where an animation has them.
pub(super) fn pose(
    document: &Document,
    buffers: &Buffers<'_>,
    index: usize,
    seconds: f64,
    locals: &mut [Local],
    warnings: &mut Vec<Warning>,
) -> Result<(), Fault> {
    let animation = &document.animations[index];
    for (k, channel) in animation.channels.iter().enumerate() {
        let pointer = format!("/animations/{index}/channels/{k}");
        let target = channel.target.node.map(|node| &mut locals[node]);
        let path = channel.target.path.as_str();
        let (Some(local), "translation" | "rotation" | "scale" | "weights") = (target, path) else {
            // Without a node and without an extension that says what it moves, a channel is to be ignored.
            if channel.target.node.is_none() && path != "pointer" {
                continue;
            }
            if path == "pointer" {
                let detail = "an animation by pointer is left at rest";
                warn(warnings, Subject::NotSimulated, "animation-pointer", pointer, detail);
            } else {
                let detail = "what is animated is none of translation, rotation, scale and weights: it is left at rest";
                warn(warnings, Subject::Skipped, "animation-path", format!("{pointer}/target/path"), detail);
            }
            continue;
        };
        let sampler = &animation.samplers[channel.sampler];
        let frames = Frames::read(document, buffers, sampler, seconds).map_err(|fault| fault.under(&pointer))?;
        match path {
            "translation" => local.trs.translation = DVec3::from_array(frames.value::<3>(&["VEC3"])?),
            "scale" => local.trs.scale = DVec3::from_array(frames.value::<3>(&["VEC3"])?),
            "rotation" => local.trs.rotation = frames.rotation()?,
            _ => local.weights = Some(frames.weights()?),
        }
        local.matrix = if path == "weights" { local.matrix } else { None };
    }
    Ok(())
}

/// The two key frames around a time.
struct Frames<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    output: usize,
    interpolation: Interpolation,
    count: usize,
    /// The frame before.
    before: usize,
    /// How far the time is on the way to the next, 0 to 1.
    part: f64,
    /// Seconds between the two.
    length: f64,
}

impl<'a> Frames<'a> {
    fn read(
        document: &'a Document,
        buffers: &'a Buffers<'a>,
        sampler: &AnimationSampler,
        seconds: f64,
    ) -> Result<Self, Fault> {
        let interpolation = match sampler.interpolation.as_str() {
            "STEP" => Interpolation::Step,
            "LINEAR" => Interpolation::Linear,
            "CUBICSPLINE" => Interpolation::CubicSpline,
            other => {
                let shown: String = other.chars().take(20).collect();
                return Err(Fault::new("", Kind::Unsupported, format!("the interpolation {shown:?} is unknown")));
            }
        };
        let times = buffers.elements::<1>(document, sampler.input, &["SCALAR"])?;
        if let Some(at) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
            let detail = format!("times do not rise after element {at}");
            return Err(Fault::new(format!("/accessors/{}", sampler.input), Kind::OutOfRange, detail));
        }
        // Before the first frame and after the last one nothing moves. A time that is that of a frame but for the rounding of
        // the file, which has single precision, is that frame's: else what is switched is switched one picture late.
        let reached = f64::from(seconds as f32).max(seconds);
        let after = times.iter().position(|[time]| *time > reached).unwrap_or(times.len());
        let before = after.saturating_sub(1);
        let (start, end) = (times[before][0], times.get(before + 1).map_or(times[before][0], |[time]| *time));
        let length = end - start;
        let part = if length > 0.0 { ((seconds - start) / length).clamp(0.0, 1.0) } else { 0.0 };
        Ok(Self { document, buffers, output: sampler.output, interpolation, count: times.len(), before, part, length })
    }

    /// All values, so many for each frame.
    fn values<const N: usize>(&self, widths: &[&str], each: Option<usize>) -> Result<(Vec<[f64; N]>, usize), Fault> {
        let values = self.buffers.elements::<N>(self.document, self.output, widths)?;
        let frames = self.count * if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let per_frame = each.unwrap_or(values.len() / frames.max(1));
        if per_frame == 0 || values.len() != frames * per_frame {
            let detail = format!("{} values do not fit {} key frames", values.len(), self.count);
            return Err(Fault::new(format!("/accessors/{}/count", self.output), Kind::OutOfRange, detail));
        }
        Ok((values, per_frame))
    }

    /// The value of one of the numbers of a frame.
    fn at<const N: usize>(&self, values: &[[f64; N]], per_frame: usize, i: usize) -> [f64; N] {
        let next = (self.before + 1).min(self.count - 1);
        let cubic = self.interpolation == Interpolation::CubicSpline;
        let of = |frame: usize, which: usize| {
            let index = if cubic { (frame * 3 + which) * per_frame } else { frame * per_frame };
            values[index + i]
        };
        let (a, b, t) = (of(self.before, 1), of(next, 1), self.part);
        match self.interpolation {
            Interpolation::Step => a,
            Interpolation::Linear => std::array::from_fn(|c| a[c] + t * (b[c] - a[c])),
            Interpolation::CubicSpline => {
                let (out, into) = (of(self.before, 2), of(next, 0));
                let (t2, t3) = (t * t, t * t * t);
                std::array::from_fn(|c| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a[c]
                        + self.length * (t3 - 2.0 * t2 + t) * out[c]
                        + (3.0 * t2 - 2.0 * t3) * b[c]
                        + self.length * (t3 - t2) * into[c]
                })
            }
        }
    }

    fn value<const N: usize>(&self, widths: &[&str]) -> Result<[f64; N], Fault> {
        let (values, each) = self.values::<N>(widths, Some(1))?;
        Ok(self.at(&values, each, 0))
    }

    fn rotation(&self) -> Result<DQuat, Fault> {
        let (values, each) = self.values::<4>(&["VEC4"], Some(1))?;
        if self.interpolation != Interpolation::Linear {
            return Ok(unit(self.at(&values, each, 0)));
        }
        let next = (self.before + 1).min(self.count - 1);
        Ok(slerp(unit(values[self.before]), unit(values[next]), self.part))
    }

    fn weights(&self) -> Result<Vec<f64>, Fault> {
        let (values, each) = self.values::<1>(&["SCALAR"], None)?;
        Ok((0..each).map(|i| self.at(&values, each, i)[0]).collect())
    }
}

/// The shortest way from one rotation to another (Shoemake 1985), with the same bits on every machine.
fn slerp(a: DQuat, b: DQuat, t: f64) -> DQuat {
    let dot = a.dot(b);
    let (b, dot) = if dot < 0.0 { (-b, -dot) } else { (b, dot) };
    let mixed = if dot > 0.999_999 {
        a * (1.0 - t) + b * t
    } else {
        let angle = math::acos(dot);
        let sine = |x: f64| math::sin_cos(x).0;
        (a * sine((1.0 - t) * angle) + b * sine(t * angle)) / sine(angle)
    };
    unit(mixed.to_array())
}
