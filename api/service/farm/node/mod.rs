//! A node: takes pieces of work from the broker and renders them, as many at one time as it has slots.

mod cancels;
mod golden;
mod health;
mod lease;
mod piece;
mod queues;
mod scenes;
pub(crate) mod settings;

use self::cancels::Cancels;
use self::health::Health;
use self::queues::Queues;
use self::scenes::NodeScenes;
use self::settings::NodeSettings;
use super::connection::{Broker, reasons};
use super::names::{Class, WORK};
use super::nodes::{self, NodeRecord, NodeState};
use super::results::Results;
use super::settings::FarmSettings;
use crate::service::clock::unix_time;
use crate::service::error::StartError;
use crate::service::memory_budget::MemoryBudget;
use crate::service::scenes::ids::renderer;
use crate::service::scheduler::pool::Pool;
use crate::service::stop_signals::StopSignals;
use crate::service::storage::objects::Objects;
use async_nats::jetstream::consumer::PullConsumer;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::Duration;
use strahl::camera::Window;
use strahl::film::Region;
use strahl::render::{Cancelled, Control, Picture, render_window};
use strahl::scene::Scene;
use tokio::sync::watch;
use tokio::task::JoinSet;
use uuid::Uuid;

/// Threads for the broker. They mostly wait.
const IO_THREADS: usize = 2;
/// Time until it is asked again whether there are queues.
const BETWEEN_LOOKS: Duration = Duration::from_secs(1);
/// Time for pieces that were stopped to be given back.
const LAST_WAIT: Duration = Duration::from_secs(2);

/// Makes the pixels of a tile. The simulation of large farms has another than [`render_window`].
pub(crate) type Paint = fn(&Scene, &Window, Region, &Control) -> Result<Picture, Cancelled>;

/// A node.
#[derive(Debug)]
struct Node {
    id: String,
    name: String,
    slots: u32,
    started: u64,
    /// How long the broker waits for a piece.
    lease: Duration,
    paint: Paint,
    broker: Broker,
    results: Results,
    scenes: Arc<NodeScenes>,
    cancels: Cancels,
    health: Health,
    counts: Counts,
    /// Whether it takes no more work since it will end.
    draining: watch::Sender<bool>,
    /// Whether what is not finished is given back.
    ending: watch::Sender<bool>,
    /// Changes when what it says of itself does.
    changed: watch::Sender<()>,
}

/// What it has done.
#[derive(Debug, Default)]
struct Counts {
    busy: AtomicU32,
    pieces: AtomicU64,
    tiles: AtomicU64,
    busy_ms: AtomicU64,
    failures: AtomicU64,
}

/// Renders until SIGTERM or Ctrl-C.
pub(crate) fn run(settings: &NodeSettings, farm: &FarmSettings) -> Result<(), StartError> {
    let machine = |error: io::Error| StartError::Machine(format!("the node cannot start: {error}"));
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(IO_THREADS).enable_all().build();
    let runtime = runtime.map_err(machine)?;
    let result = runtime.block_on(async {
        let mut signals = StopSignals::watch().map_err(machine)?;
        work(settings, farm, render_window, signals.next()).await
    });
    runtime.shutdown_timeout(LAST_WAIT);
    result
}

/// Connects, and renders until it is told to stop.
pub(crate) async fn work(
    settings: &NodeSettings,
    farm: &FarmSettings,
    paint: Paint,
    stopped: impl Future<Output = &'static str>,
) -> Result<(), StartError> {
    tokio::pin!(stopped);
    let started = tokio::select! {
        node = open(settings, farm, paint) => node?,
        _ = &mut stopped => return Ok(()),
    };
    let machine = |error: io::Error| StartError::Machine(format!("the node cannot go on: {error}"));
    serve(started, settings, stopped).await.map_err(machine)
}

/// Connects, and waits until a front has made the queues.
async fn open(settings: &NodeSettings, farm: &FarmSettings, paint: Paint) -> Result<Arc<Node>, StartError> {
    let name = settings.name();
    let store = farm.store.as_deref().ok_or_else(|| {
        let needed = match farm.farm {
            Some(_) => "--store is needed: the address of the farm's store",
            None => "--farm and --store are needed: the addresses of the farm's NATS servers and of its store",
        };
        StartError::Settings(needed.into())
    })?;
    let store = Objects::open(store).await?;
    let broker = Broker::connect(farm, &format!("strahl node {name}")).await?;
    let results = Results::open(&broker).await.map_err(StartError::Machine)?;
    let slots = settings.slots();
    let pool = Pool::start(Some(u64::from(slots)), None)
        .map_err(|error| StartError::Machine(format!("the rendering threads cannot be started: {error}")))?;
    let memory = MemoryBudget::new(settings.memory_bytes);
    Ok(Arc::new(Node {
        id: Uuid::now_v7().to_string(),
        name,
        slots,
        started: unix_time().as_millis() as u64,
        lease: lease(&broker).await,
        paint,
        broker,
        results,
        scenes: Arc::new(NodeScenes::new(store, &memory, settings.scene_cache_bytes, pool)),
        cancels: Cancels::new(),
        health: Health::new(),
        counts: Counts::default(),
        draining: watch::Sender::new(false),
        ending: watch::Sender::new(false),
        changed: watch::Sender::new(()),
    }))
}

/// How long the broker waits for a piece, as soon as there are queues for this version.
async fn lease(broker: &Broker) -> Duration {
    let mut has_complained = false;
    loop {
        let queue = broker.stream.get_consumer_from_stream(Class::Norm.queue(), WORK).await;
        match queue {
            Ok(queue) => {
                let queue: PullConsumer = queue;
                return queue.cached_info().config.ack_wait;
            }
            Err(error) if !has_complained => {
                has_complained = true;
                let error = reasons(&error);
                tracing::warn!(kid = renderer(), error, "no front of this version was here yet; waiting for one");
            }
            Err(_) => {}
        }
        tokio::time::sleep(BETWEEN_LOOKS).await;
    }
}

/// Works until it is told to stop, then finishes what it has.
async fn serve(
    node: Arc<Node>,
    settings: &NodeSettings,
    stopped: impl Future<Output = &'static str>,
) -> io::Result<()> {
    tokio::spawn(node.cancels.clone().listen(node.broker.clone()));
    node.health.check_golden().await;
    let watched = Arc::clone(&node);
    tokio::spawn(async move { watched.health.run().await });
    let heartbeats = tokio::spawn(Arc::clone(&node).publish_heartbeats());
    let mut slots = JoinSet::new();
    for _ in 0..node.slots {
        let pool = Pool::start(Some(1), None)?;
        slots.spawn(slot(Arc::clone(&node), pool));
    }
    tracing::info!(node = node.id, name = node.name, slots = node.slots, kid = renderer(), "ready for work");
    let signal = stopped.await;
    tracing::info!(signal, timeout = ?settings.drain_timeout, "draining: no more work is taken");
    node.draining.send_replace(true);
    node.changed.send_replace(());
    let all = async { while slots.join_next().await.is_some() {} };
    tokio::pin!(all);
    if tokio::time::timeout(settings.drain_timeout, &mut all).await.is_err() {
        tracing::warn!("giving back what is not finished");
        node.ending.send_replace(true);
        node.cancels.stop_all();
        let _ = tokio::time::timeout(LAST_WAIT, all).await;
    }
    heartbeats.abort();
    let goodbye = async {
        if let Ok(bucket) = nodes::bucket(&node.broker).await {
            let _ = bucket.delete(&node.id).await;
        }
        let _ = node.broker.client.flush().await;
    };
    // Without a broker nobody hears it.
    let _ = tokio::time::timeout(LAST_WAIT, goodbye).await;
    tracing::info!("the node has ended");
    Ok(())
}

/// One slot: a piece after the other.
async fn slot(node: Arc<Node>, pool: Arc<Pool>) {
    let mut queues = Queues::new(&node.broker);
    let mut draining = node.draining.subscribe();
    let mut excluded = node.health.excluded();
    let mut last = None;
    loop {
        tokio::select! {
            _ = draining.wait_for(|draining| *draining) => return,
            _ = excluded.wait_for(Option::is_none) => {}
        }
        if *draining.borrow() {
            return;
        }
        if let Some(message) = queues.next(&mut draining).await {
            piece::work(&node, &pool, message, &mut last).await;
        } else {
            // A node without work gives its memory to others.
            last = None;
        }
    }
}

impl Node {
    /// Counts a busy slot until the guard is dropped.
    fn busy(self: &Arc<Self>) -> Busy {
        self.counts.busy.fetch_add(1, Ordering::Relaxed);
        Busy(Arc::clone(self))
    }

    /// Says how it is, every few seconds and when that changes.
    async fn publish_heartbeats(self: Arc<Self>) {
        let (mut changed, mut excluded) = (self.changed.subscribe(), self.health.excluded());
        loop {
            if let Ok(bucket) = nodes::bucket(&self.broker).await {
                let record = serde_json::to_vec(&self.record()).unwrap_or_default();
                if let Err(error) = bucket.put(&self.id, record.into()).await {
                    tracing::debug!(%error, "the node is not heard");
                }
            }
            tokio::select! {
                () = tokio::time::sleep(nodes::EVERY) => {}
                _ = changed.changed() => {}
                _ = excluded.changed() => {}
            }
        }
    }

    fn record(&self) -> NodeRecord {
        let reason = self.health.excluded().borrow().as_ref().map(|(why, _)| why.clone());
        let state = match (*self.draining.borrow(), &reason) {
            (true, _) => NodeState::Draining,
            (false, Some(_)) => NodeState::Excluded,
            (false, None) => NodeState::Ready,
        };
        let count = |count: &AtomicU64| count.load(Ordering::Relaxed);
        NodeRecord {
            id: self.id.clone(),
            name: self.name.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            kid: renderer().to_owned(),
            state,
            reason,
            slots: self.slots,
            busy: self.counts.busy.load(Ordering::Relaxed),
            started: self.started,
            pieces: count(&self.counts.pieces),
            tiles: count(&self.counts.tiles),
            busy_ms: count(&self.counts.busy_ms),
            failures: count(&self.counts.failures),
            too_large: self.health.too_large(),
        }
    }
}

/// A slot that renders.
struct Busy(Arc<Node>);

impl Drop for Busy {
    fn drop(&mut self) {
        self.0.counts.busy.fetch_sub(1, Ordering::Relaxed);
    }
}
