//! The service as clients see it: the real binary over real sockets.

mod access;
mod answer_sizes;
mod contract;
mod embed;
mod fairness;
mod flood;
mod folders;
mod hosts;
mod job_events;
mod job_pictures;
mod job_storage;
mod jobs;
mod lifecycle;
mod memory;
mod neighbours;
mod operations;
mod owners;
mod pictures;
mod refusals;
mod renders;
mod scene_cache;
mod schemas;
mod tiles;
mod tradeoff;
mod trees;
