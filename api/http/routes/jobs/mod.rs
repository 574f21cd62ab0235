//! `/v1/jobs`: pictures to be fetched later, and everything there is to see of them meanwhile.

mod change;
mod events;
mod look;
mod preview;
mod status;
mod submit;

use crate::http::contract::Route;

/// What paths of jobs say of their parameter.
const ID: &str = "The job's id.";

pub(super) fn routes() -> Vec<Route> {
    let rooms = [submit::routes, status::routes, change::routes, look::routes, preview::routes, events::routes];
    rooms.into_iter().flat_map(|routes: fn() -> Vec<Route>| routes()).collect()
}
