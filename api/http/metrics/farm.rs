//! Figures of the farm, of a service that has one. What nodes say of themselves is summed up: they have no metrics of their own.

use super::gauges::{Label, whole};
use crate::service::farm::Farm;
use crate::service::farm::names::Class;
use crate::service::farm::summary::Summary;
use prometheus_client::encoding::text::encode_registry;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::registry::{Registry, Unit};
use std::sync::atomic::{AtomicU64, Ordering};

/// The figures, as they were read last.
#[derive(Debug)]
pub(super) struct FarmFigures {
    registry: Registry,
    nodes: Family<Label, Gauge>,
    slots: Gauge,
    slots_busy: Gauge,
    /// What nodes have done. A gauge: the sum falls when a node goes.
    node_tiles: Gauge,
    node_failures: Gauge,
    node_busy_seconds: Gauge<f64, AtomicU64>,
    backlog: Family<Label, Gauge<f64, AtomicU64>>,
    connected: Gauge,
    counters: [Counter; 8],
}

/// Names and help of the counters, in the order of [`Summary::counters`].
const COUNTERS: [(&str, &str); 8] = [
    ("pieces", "Pieces of work sent to nodes"),
    ("tiles", "Tiles that came back"),
    ("redeliveries", "Pieces that were lost and sent again"),
    ("doubled", "Slow pieces that a second node rendered, too"),
    ("dead_letters", "Pieces that were given up"),
    ("determinism_alarms", "Tiles of which two nodes have made different pixels"),
    ("queue_full", "How often the broker had no room for more work"),
    ("broker_errors", "What the broker has refused, such as missing permissions"),
];

impl Default for FarmFigures {
    fn default() -> Self {
        let mut registry = Registry::with_prefix("strahl_farm");
        let (nodes, slots, slots_busy) = (Family::default(), Gauge::default(), Gauge::default());
        let (node_tiles, node_failures, node_busy_seconds) = (Gauge::default(), Gauge::default(), Gauge::default());
        let (backlog, connected): (Family<_, _>, Gauge) = (Family::default(), Gauge::default());
        let counters: [Counter; 8] = Default::default();
        registry.register("nodes", "Nodes, by how they are", nodes.clone());
        registry.register("slots", "Pieces that nodes can render at one time", slots.clone());
        registry.register("slots_busy", "Pieces that nodes render now", slots_busy.clone());
        registry.register("node_tiles", "Tiles that the nodes there are have made", node_tiles.clone());
        registry.register("node_failures", "Pieces that have failed on the nodes there are", node_failures.clone());
        let help = "Time that slots of the nodes there are have rendered";
        registry.register_with_unit("node_busy", help, Unit::Seconds, node_busy_seconds.clone());
        let help = "Time of one slot that the work takes which this front has for nodes";
        registry.register_with_unit("backlog", help, Unit::Seconds, backlog.clone());
        registry.register("connected", "Whether the broker is connected", connected.clone());
        for ((name, help), counter) in COUNTERS.into_iter().zip(&counters) {
            registry.register(name, help, counter.clone());
        }
        Self {
            registry,
            nodes,
            slots,
            slots_busy,
            node_tiles,
            node_failures,
            node_busy_seconds,
            backlog,
            connected,
            counters,
        }
    }
}

impl FarmFigures {
    /// Reads and writes them.
    pub(super) fn write(&self, farm: &Farm, to: &mut String) {
        let summary = Summary::of(farm);
        for (state, count) in summary.nodes() {
            self.nodes.get_or_create(&[("state", state)]).set(i64::from(count));
        }
        self.slots.set(i64::from(summary.slots));
        self.slots_busy.set(i64::from(summary.busy));
        self.node_tiles.set(whole(summary.tiles));
        self.node_failures.set(whole(summary.failures));
        self.node_busy_seconds.set(summary.busy_ms as f64 / 1e3);
        for class in Class::ALL {
            self.backlog.get_or_create(&[("class", class.name())]).set(farm.backlog.seconds(class));
        }
        self.connected.set(i64::from(summary.connected));
        for (counter, value) in self.counters.iter().zip(summary.counters()) {
            counter.inner().store(value, Ordering::Relaxed);
        }
        // Writing to a String cannot fail.
        let _ = encode_registry(to, &self.registry);
    }
}
