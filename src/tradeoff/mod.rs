//! What accuracy costs: a scene's trade-off between error and time or rays, its Pareto fronts, plots, page and advice.

mod advice;
mod findings;
pub mod page;
pub mod pareto;
pub mod plot;
pub mod sweep;

pub use advice::advice;
pub use findings::{Circumstances, Cost, Finer, Front, HOW_TIMES_ARE_MEASURED, Reference, Source, Tradeoff};
pub use sweep::{Errors, Point, Settings, Times};
