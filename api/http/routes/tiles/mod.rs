//! Deep zoom into known images by three protocols: IIIF Image API 3, DZI and XYZ.
//!
//! A ray tracer needs no pyramid of images: each tile is rendered at its own size, and is byte for byte that crop of the
//! whole image at that size.

mod dzi;
mod grid;
mod iiif;
mod iiif_parse;
mod xyz;

use crate::http::contract::Route;

pub(super) fn routes() -> Vec<Route> {
    [iiif::routes, dzi::routes, xyz::routes].into_iter().flat_map(|routes: fn() -> Vec<Route>| routes()).collect()
}
