//! Polygons of model files as triangles, in bounded time.

use super::fault::{Fault, Kind};
use crate::shape::ear_clipping::triangulate;

/// Most corners of a polygon.
pub(crate) const MOST_CORNERS: usize = 10_000;
/// Most of the sum of the squares of the corners of polygons, which bounds the time of ear clipping.
pub(crate) const MOST_WORK: u64 = 200_000_000;

/// That a polygon has too many corners.
pub(super) fn too_many_corners() -> Fault {
    Fault::new("", Kind::Limit, format!("a face has more than {MOST_CORNERS} corners (polygon_vertices)"))
}

/// Cuts the polygons of a file.
#[derive(Debug, Default)]
pub(super) struct PolygonCutter {
    work: u64,
}

impl PolygonCutter {
    /// The triangles of a polygon of `count` corners as their numbers, none if it has less than three; `point` says where a corner
    /// is. Polygons that are not flat enough are fans. Fails where one polygon, or all together, have too many corners.
    pub(super) fn cut(&mut self, count: usize, point: impl Fn(usize) -> [f64; 3]) -> Result<Vec<[u32; 3]>, Fault> {
        match count {
            0..3 => return Ok(Vec::new()),
            3 => return Ok(vec![[0, 1, 2]]),
            _ => {}
        }
        if count > MOST_CORNERS {
            return Err(too_many_corners());
        }
        self.work += (count * count) as u64;
        if self.work > MOST_WORK {
            return Err(Fault::new("", Kind::Limit, "the faces have too many corners (polygon_work)"));
        }
        let points: Vec<_> = (0..count).map(point).collect();
        Ok(triangulate(&points).unwrap_or_else(|| (2..count as u32).map(|i| [0, i - 1, i]).collect()))
    }
}
