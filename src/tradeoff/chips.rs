//! Places for the numbers of dots, with lines to them that strike nothing through.

use super::labels::Area;

/// Half the height of a number.
const HALF: f64 = 7.5;
/// Directions that are tried about a dot, beginning at its right.
const DIRECTIONS: u32 = 24;
/// A dot reaches as far from its middle.
const DOT: f64 = 7.0;

type Point = (f64, f64);

/// A number beside its dot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chip {
    pub(super) area: Area,
    /// Where the line from the dot ends.
    pub(super) end: Point,
}

/// Numbers that cover neither each other nor dots nor names.
#[derive(Debug)]
pub(super) struct Chips {
    inside: Area,
    dots: Vec<Point>,
    /// Names and numbers.
    taken: Vec<Area>,
    lines: Vec<(Point, Point)>,
}

impl Chips {
    pub(super) fn new(inside: Area, dots: Vec<Point>, names: Vec<Area>) -> Self {
        Self { inside, dots, taken: names, lines: Vec::new() }
    }

    /// Takes the nearest free place for a number of some digits. If there is none without crossing lines, then one with.
    pub(super) fn place(&mut self, dot: Point, digits: usize) -> Option<Chip> {
        let chip = self.nearest(dot, digits, true).or_else(|| self.nearest(dot, digits, false))?;
        self.taken.push(chip.area);
        self.lines.push((dot, chip.end));
        Some(chip)
    }

    fn nearest(&self, (x, y): Point, digits: usize, strict: bool) -> Option<Chip> {
        let wide = 4.5 + 4.0 * digits as f64;
        let far = (self.inside.right - self.inside.left).max(self.inside.bottom - self.inside.top);
        let mut radius = DOT + HALF + 1.0;
        while radius < far {
            for step in 0..DIRECTIONS {
                // Right, left, then more and more to either side.
                let turn = f64::from((step + 2) / 4) * if step % 4 < 2 { 1.0 } else { -1.0 };
                let angle = turn * core::f64::consts::TAU / f64::from(DIRECTIONS);
                let side = if step % 2 == 0 { 1.0 } else { -1.0 };
                let middle = (x + side * (radius + wide - HALF) * libm::cos(angle), y + radius * libm::sin(angle));
                let area = Area {
                    left: middle.0 - wide,
                    top: middle.1 - HALF,
                    right: middle.0 + wide,
                    bottom: middle.1 + HALF,
                };
                let end = (x.clamp(area.left, area.right), y.clamp(area.top, area.bottom));
                if self.is_free(&area, (x, y), end, strict) {
                    return Some(Chip { area, end });
                }
            }
            radius += 3.0;
        }
        None
    }

    fn is_free(&self, area: &Area, dot: Point, end: Point, strict: bool) -> bool {
        let near = |other: &Point| (other.0 - dot.0).abs() < 2.0 * DOT && (other.1 - dot.1).abs() < 2.0 * DOT;
        let covers_dot = || self.dots.iter().any(|&(x, y)| Area::around(x, y, DOT).overlaps(area));
        let crosses_dot =
            || self.dots.iter().any(|other| !near(other) && Area::around(other.0, other.1, 5.0).is_crossed(dot, end));
        let crosses = || self.taken.iter().any(|taken| taken.is_crossed(dot, end));
        let is_crossed = || self.lines.iter().any(|&(a, b)| area.is_crossed(a, b));
        self.inside.contains(area)
            && !self.taken.iter().any(|taken| taken.overlaps(area))
            && !covers_dot()
            && !(strict && (crosses_dot() || crosses() || is_crossed()))
    }
}

impl Area {
    /// Whether a line between two points passes through.
    pub(super) fn is_crossed(&self, (x0, y0): Point, (x1, y1): Point) -> bool {
        // The part of the line that lies within both pairs of sides.
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for (from, to, low, high) in [(x0, x1, self.left, self.right), (y0, y1, self.top, self.bottom)] {
            let along = to - from;
            if along == 0.0 {
                if from <= low || from >= high {
                    return false;
                }
                continue;
            }
            let (a, b) = ((low - from) / along, (high - from) / along);
            (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
        }
        first < last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_cross_what_they_pass_through() {
        let area = Area { left: 10.0, top: 10.0, right: 20.0, bottom: 20.0 };
        for (line, crosses) in [
            (((0.0, 15.0), (30.0, 15.0)), true),
            (((15.0, 0.0), (15.0, 12.0)), true),
            (((0.0, 0.0), (9.0, 9.0)), false),
            (((0.0, 15.0), (10.0, 15.0)), false),
            (((0.0, 25.0), (30.0, 25.0)), false),
            (((0.0, 30.0), (30.0, 0.0)), true),
        ] {
            assert_eq!(area.is_crossed(line.0, line.1), crosses, "{line:?}");
        }
    }

    #[test]
    fn numbers_of_one_place_go_around_it() {
        let inside = Area { left: 0.0, top: 0.0, right: 200.0, bottom: 120.0 };
        let mut chips = Chips::new(inside, vec![(100.0, 60.0); 11], Vec::new());
        let places: Vec<Chip> = (0..11).filter_map(|_| chips.place((100.0, 60.0), 2)).collect();
        assert_eq!(places.len(), 11);
        for (i, chip) in places.iter().enumerate() {
            assert!(places[..i].iter().all(|other| !other.area.overlaps(&chip.area)), "{chip:?}");
        }
    }
}
