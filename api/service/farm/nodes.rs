//! The nodes of the farm, as each says of itself in a bucket, and as fronts see them.

use super::connection::{Broker, RETRY_AFTER, reasons};
use super::names::{NODE_AGE, NODES};
use crate::service::scenes::ids::renderer;
use async_nats::jetstream::kv::{Operation, Store};
use futures_util::StreamExt;
use parking_lot::Mutex;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How often a node says how it is.
pub(crate) const EVERY: Duration = NODE_AGE.checked_div(4).expect("it is not 0");

/// What a node says of itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct NodeRecord {
    /// A UUID of the process: hosts get the names and addresses of others.
    pub(crate) id: String,
    /// What people call it.
    pub(crate) name: String,
    /// The program's version.
    pub(crate) version: String,
    /// Which version of the renderer it has.
    pub(crate) kid: String,
    /// How it is.
    pub(crate) state: NodeState,
    /// Why it is so.
    #[serde(default)]
    pub(crate) reason: Option<String>,
    /// Pieces it renders at one time.
    pub(crate) slots: u32,
    /// Pieces it renders now.
    pub(crate) busy: u32,
    /// Milliseconds since 1970 when it was started.
    pub(crate) started: u64,
    /// Pieces it has done.
    pub(crate) pieces: u64,
    /// Tiles in them.
    pub(crate) tiles: u64,
    /// Milliseconds its slots have rendered.
    pub(crate) busy_ms: u64,
    /// Pieces that failed.
    pub(crate) failures: u64,
    /// Scenes for which it has too little memory, by the names of their texts.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub(crate) too_large: BTreeSet<String>,
}

/// How a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum NodeState {
    /// It takes work.
    Ready,
    /// It finishes what it has, and ends.
    Draining,
    /// It takes no work, since it does not trust itself.
    Excluded,
}

/// The bucket.
pub(crate) async fn bucket(broker: &Broker) -> Result<Store, String> {
    broker.stream.get_key_value(NODES).await.map_err(|error| reasons(&error))
}

/// The nodes as a front sees them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Nodes(Arc<Mutex<BTreeMap<String, (NodeRecord, Instant)>>>);

impl Nodes {
    /// Watches them from now on.
    pub(crate) fn watch(broker: &Broker) -> Self {
        let nodes = Self::default();
        tokio::spawn(nodes.clone().follow(broker.clone()));
        nodes
    }

    async fn follow(self, broker: Broker) {
        loop {
            if let Err(error) = self.follow_once(&broker).await {
                tracing::warn!(error, "the nodes cannot be watched; it is tried again");
            }
            tokio::time::sleep(RETRY_AFTER).await;
        }
    }

    async fn follow_once(&self, broker: &Broker) -> Result<(), String> {
        let mut watch = bucket(broker).await?.watch_with_history(">").await.map_err(|error| reasons(&error))?;
        while let Some(entry) = watch.next().await {
            let entry = entry.map_err(|error| reasons(&error))?;
            match entry.operation {
                Operation::Put => {
                    // Another version may say it in another way.
                    if let Ok(record) = serde_json::from_slice::<NodeRecord>(&entry.value) {
                        self.0.lock().insert(record.id.clone(), (record, Instant::now()));
                    }
                }
                Operation::Delete | Operation::Purge => drop(self.0.lock().remove(&entry.key)),
            }
        }
        Ok(())
    }

    /// All that were heard of lately.
    pub(crate) fn all(&self) -> Vec<NodeRecord> {
        let mut nodes = self.0.lock();
        nodes.retain(|_, (_, heard)| heard.elapsed() < NODE_AGE);
        nodes.values().map(|(record, _)| record.clone()).collect()
    }

    /// Pieces that all can render at one time with this version of the renderer.
    pub(crate) fn slots(&self) -> u32 {
        let nodes = self.0.lock();
        let able = nodes.values().filter(|(node, heard)| {
            node.state == NodeState::Ready && node.kid == renderer() && heard.elapsed() < NODE_AGE
        });
        able.map(|(node, _)| node.slots).sum()
    }

    /// Whether there are nodes with this version, and a scene is too large for each of them.
    pub(crate) fn all_refuse(&self, scene: &str) -> bool {
        let nodes = self.0.lock();
        let mut alive = nodes.values().filter(|(node, heard)| node.kid == renderer() && heard.elapsed() < NODE_AGE);
        let mut refuse = alive.clone().map(|(node, _)| node.too_large.contains(scene));
        alive.next().is_some() && refuse.all(|refuses| refuses)
    }
}
