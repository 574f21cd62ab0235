//! Pictures that are put together of tiles.

use strahl::film::{Film, Region};
use strahl::render::Picture;

/// A black region of a picture of some width and height, for which no ray was traced.
pub(crate) fn empty([full_width, full_height]: [u32; 2], region: Region) -> Picture {
    let pixels = vec![[0.0; 3]; region.pixels() as usize];
    let film = Film { region, full_width, full_height, pixels, ..Film::default() };
    Picture { film, ..Picture::default() }
}

/// Puts a tile where it belongs, and adds up what they took.
pub(crate) fn join(whole: &mut Picture, piece: &Picture) {
    paste(&mut whole.film, &piece.film);
    whole.bounded.append(piece.bounded.clone());
    whole.sampling += &piece.sampling;
    whole.costs.extend_from_slice(&piece.costs);
    whole.rays = whole.rays + piece.rays;
    whole.refined.pixels += piece.refined.pixels;
    whole.refined.rays = whole.refined.rays + piece.refined.rays;
    whole.trace_ms += piece.trace_ms;
    whole.refine_ms += piece.refine_ms;
}

/// Puts a part of a film where it belongs.
pub(crate) fn paste(whole: &mut Film, piece: &Film) {
    let (outer, inner) = (whole.region, piece.region);
    let (left, top) = ((inner.x - outer.x) as usize, (inner.y - outer.y) as usize);
    let rows = whole.pixels.chunks_mut(outer.width as usize).skip(top);
    for (row, part) in rows.zip(piece.pixels.chunks(inner.width as usize)) {
        row[left..left + part.len()].copy_from_slice(part);
    }
    whole.display = piece.display;
    if !piece.alpha.is_empty() {
        whole.alpha.resize(whole.pixels.len(), 0.0);
        let rows = whole.alpha.chunks_mut(outer.width as usize).skip(top);
        for (row, part) in rows.zip(piece.alpha.chunks(inner.width as usize)) {
            row[left..left + part.len()].copy_from_slice(part);
        }
    }
}
