//! Other formats, turned into a [`Description`](super::Description).

pub mod nff;
