//! `/v1/jobs`: renders in the background, with their events and previews.

mod change;
mod events;
mod frames;
mod look;
mod preview;
mod status;
mod submit;

use crate::http::contract::Route;

/// Description of the id in paths of jobs.
const ID: &str = "The job's id.";

pub(super) fn routes() -> Vec<Route> {
    let rooms = [
        submit::routes,
        status::routes,
        change::routes,
        look::routes,
        frames::routes,
        preview::routes,
        events::routes,
    ];
    rooms.into_iter().flat_map(|routes: fn() -> Vec<Route>| routes()).collect()
}
