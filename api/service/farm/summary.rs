//! The farm in figures, for metrics and for people.

use super::Farm;
use super::nodes::{NodeRecord, NodeState};
use std::sync::atomic::{AtomicU64, Ordering};

/// The farm as a front sees it now.
#[derive(Debug)]
pub(crate) struct Summary {
    /// Whether the broker is connected.
    pub(crate) connected: bool,
    /// The nodes, each by itself.
    pub(crate) each: Vec<NodeRecord>,
    /// Pieces that nodes which take work can render at one time.
    pub(crate) slots: u32,
    /// Pieces that nodes render now.
    pub(crate) busy: u32,
    /// Pieces and tiles that the nodes there are have done, and pieces that failed there.
    pub(crate) pieces: u64,
    pub(crate) tiles: u64,
    pub(crate) failures: u64,
    /// Milliseconds that their slots have rendered.
    pub(crate) busy_ms: u64,
    /// Pieces sent, tiles that came back, pieces lost and sent again, slow ones rendered twice, those given up, tiles with
    /// different pixels, refusals for lack of room, and other refusals, since the start of this front.
    counters: [u64; 8],
}

impl Summary {
    /// That of now.
    pub(crate) fn of(farm: &Farm) -> Self {
        let each = farm.nodes.all();
        let sum = |of: fn(&NodeRecord) -> u64| each.iter().map(of).sum();
        let ready = each.iter().filter(|node| node.state == NodeState::Ready);
        let counts = &farm.counts;
        let read = |count: &AtomicU64| count.load(Ordering::Relaxed);
        let [pieces, tiles, again, doubled] = [&counts.pieces, &counts.tiles, &counts.again, &counts.doubled].map(read);
        let [dead, differing, full] = [&counts.dead, &counts.differing, &counts.full].map(read);
        Self {
            connected: farm.broker.is_connected(),
            slots: ready.map(|node| node.slots).sum(),
            busy: each.iter().map(|node| node.busy).sum(),
            pieces: sum(|node| node.pieces),
            tiles: sum(|node| node.tiles),
            failures: sum(|node| node.failures),
            busy_ms: sum(|node| node.busy_ms),
            counters: [pieces, tiles, again, doubled, dead, differing, full, farm.broker.errors()],
            each,
        }
    }

    /// How many nodes are in each state.
    pub(crate) fn nodes(&self) -> [(&'static str, u32); 3] {
        [("ready", NodeState::Ready), ("draining", NodeState::Draining), ("excluded", NodeState::Excluded)]
            .map(|(name, state)| (name, self.each.iter().filter(|node| node.state == state).count() as u32))
    }

    /// What has happened since the start of this front, in the order of the field's description.
    pub(crate) fn counters(&self) -> [u64; 8] {
        self.counters
    }
}
