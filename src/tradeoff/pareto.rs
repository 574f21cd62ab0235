//! Pareto fronts: the compromises that no other beats in both cost and error, and the knee among them.

/// Cost and error of one setting; less of either is better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compromise {
    /// Time or rays, above 0.
    pub cost: f64,
    /// Error, at least 0.
    pub error: f64,
}

/// Indices of the compromises that no other beats, by growing cost. Of equal ones only the first is there.
pub fn front(all: &[Compromise]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|&a, &b| all[a].cost.total_cmp(&all[b].cost).then(all[a].error.total_cmp(&all[b].error)));
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let better = all[i].error < least;
        least = least.min(all[i].error);
        better
    });
    order
}

/// How far below the line a knee lies at least.
const CLEARLY: f64 = 0.1;

/// The knee of a front by growing cost: the point farthest below the straight line between the ends, in logarithms of both
/// axes. After it, more cost gains less and less. None if no point lies clearly below the line.
///
/// Both axes are scaled to 0 to 1 between the ends, and "clearly" is a fixed part of that.
/// An error of 0, which has no logarithm, counts as a tenth of the least other error.
pub fn knee(front: &[Compromise]) -> Option<usize> {
    let least = front.iter().map(|c| c.error).filter(|e| *e > 0.0).fold(f64::INFINITY, f64::min);
    let place = |c: &Compromise| (libm::log(c.cost), libm::log(c.error.max(0.1 * least)));
    let ((x0, y0), (x1, y1)) = (place(front.first()?), place(front.last()?));
    let below = |c: &Compromise| {
        let (x, y) = place(c);
        let (along, down) = ((x - x0) / (x1 - x0), (y0 - y) / (y0 - y1));
        down - along
    };
    let inner = front.iter().enumerate().skip(1).take(front.len().saturating_sub(2));
    inner
        .map(|(i, c)| (i, below(c)))
        .filter(|(_, below)| *below > CLEARLY)
        .max_by(|(_, a), (_, b)| a.total_cmp(b))
        .map(|(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(pairs: &[(f64, f64)]) -> Vec<Compromise> {
        pairs.iter().map(|&(cost, error)| Compromise { cost, error }).collect()
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = all(&[(4.0, 1.0), (1.0, 8.0), (2.0, 8.0), (2.0, 3.0), (3.0, 5.0), (9.0, 0.0), (10.0, 0.0)]);
        assert_eq!(front(&points), [1, 3, 0, 5]);
        assert_eq!(front(&all(&[(1.0, 2.0), (1.0, 2.0)])), [0], "of equals the first");
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn the_knee_is_where_the_curve_bends() {
        let bent = all(&[(1.0, 100.0), (2.0, 10.0), (4.0, 1.0), (40.0, 0.8), (400.0, 0.6)]);
        assert_eq!(knee(&bent), Some(2));
        let straight = all(&[(1.0, 64.0), (2.0, 32.0), (4.0, 16.0)]);
        assert_eq!(knee(&straight), None);
        assert_eq!(knee(&all(&[(1.0, 10.0), (5.0, 9.0), (10.0, 1.0)])), None, "bulges the other way");
        assert_eq!(knee(&all(&[(1.0, 1.0), (2.0, 0.5)])), None);
        assert_eq!(knee(&[]), None);
    }

    #[test]
    fn no_error_at_all_is_ten_times_better_than_the_least() {
        assert_eq!(knee(&all(&[(1.0, 100.0), (2.0, 1.0), (100.0, 0.0)])), Some(1));
    }
}
