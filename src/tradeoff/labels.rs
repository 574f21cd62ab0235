//! Places for the labels of a plot where they cover neither each other nor what they are for.

/// A part of the drawing, in its units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Area {
    /// A square around a point.
    pub(super) fn around(x: f64, y: f64, half: f64) -> Self {
        Self { left: x - half, top: y - half, right: x + half, bottom: y + half }
    }

    /// What a text takes whose baseline begins at a point.
    pub(super) fn of_text(x: f64, y: f64, text: &str, size: f64) -> Self {
        Self { left: x, top: y - 0.85 * size, right: x + width(text, size), bottom: y + 0.25 * size }
    }

    pub(super) fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }

    pub(super) fn contains(&self, other: &Self) -> bool {
        self.left <= other.left && other.right <= self.right && self.top <= other.top && other.bottom <= self.bottom
    }
}

/// How wide a text is. Fonts differ, so plots tell it to the browser as `textLength`.
pub(super) fn width(text: &str, size: f64) -> f64 {
    0.56 * size * text.chars().count() as f64
}

/// The parts of a plot that are taken.
#[derive(Debug)]
pub(super) struct Labels {
    inside: Area,
    taken: Vec<Area>,
    size: f64,
}

impl Labels {
    /// Labels of a font size inside a part of a drawing, some of which is taken.
    pub(super) fn new(inside: Area, taken: Vec<Area>, size: f64) -> Self {
        Self { inside, taken, size }
    }

    /// Takes the nearest free place for a text about a point. It is nearer to it than `far`.
    pub(super) fn place(&mut self, (x, y): (f64, f64), text: &str, far: f64) -> Option<Area> {
        let (wide, high) = (width(text, self.size), self.size);
        let mut gap = 7.0;
        while gap < far {
            let (right, left, middle) = (x + gap, x - gap - wide, x - 0.5 * wide);
            let (above, below, level) = (y - gap, y + gap + 0.75 * high, y + 0.33 * high);
            let around = [(right, level), (left, level), (middle, above), (middle, below)];
            // Then all the way along both sides.
            let steps = (0..=libm::floor(gap / 4.0) as i32).map(|step| 4.0 * f64::from(step));
            let sides =
                steps.flat_map(|d| [(right, level - d), (right, level + d), (left, level - d), (left, level + d)]);
            for (x, y) in around.into_iter().chain(sides) {
                let area = Area::of_text(x, y, text, self.size);
                if self.inside.contains(&area) && !self.taken.iter().any(|taken| taken.overlaps(&area)) {
                    self.taken.push(area);
                    return Some(area);
                }
            }
            gap += 4.0;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_one_point_go_around_it_and_stay_inside() {
        let inside = Area { left: 0.0, top: 0.0, right: 300.0, bottom: 200.0 };
        let mut labels = Labels::new(inside, vec![Area::around(150.0, 100.0, 5.0)], 12.0);
        let places: Vec<Area> = (0..12).filter_map(|_| labels.place((150.0, 100.0), "depth 10", 150.0)).collect();
        assert_eq!(places.len(), 12);
        for (i, place) in places.iter().enumerate() {
            assert!(inside.contains(place), "{place:?}");
            assert!(places[..i].iter().all(|other| !other.overlaps(place)), "{place:?}");
        }
        let mut narrow = Labels::new(Area::around(10.0, 10.0, 10.0), Vec::new(), 12.0);
        assert_eq!(narrow.place((10.0, 10.0), "depth 10", 100.0), None);
    }
}
