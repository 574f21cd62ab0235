//! What accuracy costs: a scene's trade-off between error and time or rays, its Pareto fronts, plots, page and advice.

mod advice;
mod answer;
mod chips;
pub mod choice_plot;
pub mod choices;
mod findings;
mod labels;
mod left_out;
pub mod page;
pub mod pareto;
pub mod plot;
mod remarks;
pub mod sweep;

pub use advice::advice;
pub use answer::duration;
pub use findings::{Circumstances, Cost, Finer, Front, HOW_TIMES_ARE_MEASURED, Reference, Source, Tradeoff};
pub use left_out::LeftOut;
pub use sweep::{Errors, Point, Settings, Times};
