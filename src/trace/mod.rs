//! Whitted's recursion.

pub mod query;
pub mod tree;
