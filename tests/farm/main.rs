//! Tests of the farm with a real broker and real processes: `cargo test --release --test farm`. They need `nats-server`, which
//! `.ci/run` fetches; `STRAHL_NATS_SERVER` names another.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod accounts;
mod assets;
mod backends;
mod cleanup;
mod cluster;
#[path = "../service/common/mod.rs"]
#[allow(dead_code, reason = "the tests of the service use all of it")]
mod common;
mod deliveries;
mod failures;
mod fairness;
mod fronts;
mod harness;
mod memory;
mod sequences;
mod versions;
