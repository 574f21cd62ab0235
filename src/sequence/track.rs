//! Numbers over time: a smooth curve through keys.
//!
//! Between keys it is a cubic Hermite curve whose tangents are those of Catmull and Rom (1974) for keys at any times: the slope
//! from the key before to the key after. Single numbers, such as angles, have tangents that are limited as Fritsch and Carlson
//! (1980) do, so that they never leave the range between two keys.

use super::ease::Ease;

/// A key: its time, how it is left, and its numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Knot<const N: usize> {
    pub(super) t: f64,
    pub(super) ease: Ease,
    pub(super) value: [f64; N],
}

/// The numbers at a time, through keys in the order of time. Before the first and after the last they stay, unless the track is
/// closed: then the first key comes again after 1. None without keys.
pub(super) fn at<const N: usize>(knots: &[Knot<N>], closed: bool, t: f64) -> Option<[f64; N]> {
    let (first, last) = (knots.first()?, knots.last()?);
    if knots.len() == 1 {
        return Some(first.value);
    }
    let t = if closed && t < first.t { t + 1.0 } else { t };
    if t <= first.t || (t >= last.t && !closed) {
        return Some(if t <= first.t { first.value } else { last.value });
    }
    let from = knots.partition_point(|knot| knot.t <= t) - 1;
    let (a, b) = (knot(knots, closed, from as isize)?, knot(knots, closed, from as isize + 1)?);
    let length = b.t - a.t;
    let u = a.ease.way((t - a.t) / length);
    let [starts, ends] = [from, from + 1].map(|key| tangent(knots, closed, key as isize));
    let (square, rest) = (u * u, 1.0 - u);
    Some(std::array::from_fn(|i| {
        (1.0 + 2.0 * u) * rest * rest * a.value[i]
            + u * rest * rest * length * starts[i]
            + square * (3.0 - 2.0 * u) * b.value[i]
            - square * rest * length * ends[i]
    }))
}

/// A key by its number; a closed track has one before the first and one after the last.
fn knot<const N: usize>(knots: &[Knot<N>], closed: bool, number: isize) -> Option<Knot<N>> {
    let count = knots.len() as isize;
    if !closed {
        return knots.get(usize::try_from(number).ok()?).copied();
    }
    let turns = number.div_euclid(count);
    let knot = knots[number.rem_euclid(count) as usize];
    Some(Knot { t: knot.t + turns as f64, ..knot })
}

/// The slope of the curve at a key.
fn tangent<const N: usize>(knots: &[Knot<N>], closed: bool, number: isize) -> [f64; N] {
    let [before, here, after] = [number - 1, number, number + 1].map(|number| knot(knots, closed, number));
    let slope = |a: Option<Knot<N>>, b: Option<Knot<N>>| {
        let (a, b) = a.zip(b)?;
        Some(std::array::from_fn(|i| (b.value[i] - a.value[i]) / (b.t - a.t)))
    };
    let (left, right): (Option<[f64; N]>, Option<[f64; N]>) = (slope(before, here), slope(here, after));
    match (left, right) {
        (Some(left), Some(right)) => {
            let middle = slope(before, after).unwrap_or([0.0; N]);
            if N == 1 { middle.map(|m| limited(m, left[0], right[0])) } else { middle }
        }
        (Some(end), None) | (None, Some(end)) => end,
        (None, None) => [0.0; N],
    }
}

/// A tangent with which the curve stays between its keys.
fn limited(tangent: f64, left: f64, right: f64) -> f64 {
    if left * right <= 0.0 {
        return 0.0;
    }
    let most = 3.0 * left.abs().min(right.abs());
    tangent.clamp(-most, most)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knots<const N: usize>(ease: Ease, keys: &[(f64, [f64; N])]) -> Vec<Knot<N>> {
        keys.iter().map(|&(t, value)| Knot { t, ease, value }).collect()
    }

    const EASES: [Ease; 4] = [Ease::Linear, Ease::In, Ease::Out, Ease::InOut];

    #[test]
    fn keys_are_met_exactly_and_nothing_happens_outside_of_them() {
        let keys = [(0.1, [1.0, -2.0, 0.3]), (0.3, [0.1, 7.0, 1e9]), (0.7, [3.3, 1e-9, 5.0])];
        for ease in EASES {
            let track = knots(ease, &keys);
            for (t, value) in keys {
                assert_eq!(at(&track, false, t), Some(value));
                assert_eq!(at(&track, true, t), Some(value));
            }
            assert_eq!((at(&track, false, 0.0), at(&track, false, 1.0)), (Some(keys[0].1), Some(keys[2].1)));
        }
        assert_eq!(at::<3>(&[], false, 0.5), None);
    }

    #[test]
    fn two_keys_make_a_straight_line() {
        let track = knots(Ease::Linear, &[(0.0, [0.0, 8.0]), (1.0, [4.0, 0.0])]);
        for i in 0..=16 {
            let t = f64::from(i) / 16.0;
            let [x, y] = at(&track, false, t).unwrap();
            assert!((x - 4.0 * t).abs() < 1e-14 && (y - 8.0 + 8.0 * t).abs() < 1e-14, "{t}: {x} {y}");
        }
    }

    /// The curve goes on in the same direction on both sides of a key, also where a closed one begins again.
    #[test]
    fn the_path_is_smooth() {
        let keys = [(0.0, [0.0, 0.0]), (0.2, [1.0, 2.0]), (0.5, [4.0, 1.0]), (0.8, [2.0, -3.0])];
        let track = knots(Ease::Linear, &keys);
        let h = 1e-6;
        let speed = |closed, t: f64| {
            let wrapped = |t: f64| at(&track, closed, t.rem_euclid(1.0)).unwrap();
            let (a, b) = (wrapped(t - h), wrapped(t));
            let (c, d) = (wrapped(t), wrapped(t + h));
            [0, 1].map(|i| ((b[i] - a[i]) / h, (d[i] - c[i]) / h))
        };
        for (closed, t) in [(false, 0.2), (false, 0.5), (true, 0.2), (true, 0.8), (true, 0.0)] {
            for (before, after) in speed(closed, t) {
                assert!((before - after).abs() < 1e-3, "{closed} {t}: {before} {after}");
            }
        }
    }

    #[test]
    fn single_numbers_stay_between_their_keys() {
        let keys = [(0.0, [0.0]), (0.1, [0.0]), (0.2, [10.0]), (0.9, [10.0]), (1.0, [3.0])];
        for ease in EASES {
            let track = knots(ease, &keys);
            for pair in keys.windows(2) {
                let [(t, [a]), (end, [b])] = [pair[0], pair[1]];
                for i in 0..=100 {
                    let [value] = at(&track, false, t + (end - t) * f64::from(i) / 100.0).unwrap();
                    assert!((a.min(b) - 1e-9..=a.max(b) + 1e-9).contains(&value), "{value} between {a} and {b}");
                }
            }
        }
    }
}
