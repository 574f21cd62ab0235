//! One picture over many nodes: its coordinator cuts the tiles into pieces, keeps a window of them at the broker, and takes the
//! results. It forgets nothing that it needs: whoever comes after it finds the results, and renders what is missing.

mod costs;
mod in_flight;
mod sweep;

use self::costs::Costs;
use self::in_flight::InFlight;
use super::Farm;
use super::connection::reasons;
use super::names::{self, Class};
use super::results::is_full;
use super::work::{Begun, Dead, Death, Piece, SceneSource, TilePlace};
use crate::service::pictures::tile_bytes::{Owner, Tile};
use async_nats::jetstream::message::PublishMessage;
use async_nats::{Message, Subscriber};
use futures_util::StreamExt;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use strahl::camera::Window;
use strahl::film::Region;
use strahl::render::Control;

/// Time between two looks at whether it was cancelled, and whether the window has grown.
const LOOK: Duration = Duration::from_millis(50);
/// Time until what the broker did not take is offered again.
const RESEND_AFTER: Duration = Duration::from_millis(500);
/// Pieces in the queue and on nodes for each slot: while one is rendered another waits.
const FOR_EACH_SLOT: f64 = 2.0;

/// A picture that nodes render.
#[derive(Debug)]
pub(crate) struct Order<'a> {
    /// The job, or another name that no other picture has.
    pub(crate) name: &'a str,
    /// Its tenant.
    pub(crate) tenant: &'a str,
    /// How urgent it is.
    pub(crate) class: Class,
    /// Its scene, which is in the store.
    pub(crate) scene: SceneSource,
    /// The grid of pixels.
    pub(crate) window: Window,
    /// Estimated milliseconds of a pixel on one slot.
    pub(crate) pixel_ms: f64,
    /// How long a piece may take.
    pub(crate) limit: Duration,
    /// Stops it.
    pub(crate) control: &'a Control,
}

/// Where tiles come from and go to.
pub(crate) trait Tiles {
    /// The next tile that nobody has.
    fn next(&mut self) -> Option<(u32, Region)>;
    /// Pixels of those that are left.
    fn pixels_left(&self) -> u64;
    /// The part of the farm's slots that the picture may have, from 0 to 1.
    fn share(&self) -> f64;
    /// A tile is there. False stops it all.
    fn finished(&mut self, tile: Tile) -> bool;
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Stopped {
    /// It was cancelled, or its tiles were not taken.
    Cancelled,
    /// Work was given up.
    Dead(Death, String),
    /// No node has the memory for the scene.
    TooLarge(String),
    /// The broker does not do what it has to.
    Broker(String),
}

impl Farm {
    /// Renders all tiles that are left. It waits on this thread, which is none of a runtime.
    pub(crate) fn render(&self, order: &Order<'_>, tiles: &mut dyn Tiles) -> Result<(), Stopped> {
        self.runtime.block_on(async {
            let mut coordinator = Coordinator::new(self, order, tiles).await?;
            let ended = coordinator.run().await;
            coordinator.clear(ended.is_ok()).await;
            ended
        })
    }
}

struct Coordinator<'a> {
    farm: &'a Farm,
    order: &'a Order<'a>,
    tiles: &'a mut dyn Tiles,
    owner: Owner,
    in_flight: InFlight,
    costs: Costs,
    /// Pieces that the broker has not taken yet.
    unsent: Vec<u64>,
    /// When it is asked again.
    not_before: Instant,
    /// Whether there are no more tiles.
    is_cut: bool,
    subscriptions: Subscriptions,
    window: SendWindow,
    swept: Instant,
    /// Since when its scene is too large for all nodes.
    refused: Option<Instant>,
    /// Begins the ids of messages. Another coordinator of the same job has another: the broker would take its pieces for these,
    /// and nodes would drop them after this one has ended.
    session: String,
}

/// How many pieces may be sent before results come back: a sliding window over the slots of the farm.
struct SendWindow {
    /// Slots of all nodes.
    slots: u32,
    /// Pieces of the job in the queue and on nodes.
    pieces: usize,
    measured: Option<Instant>,
}

/// The subjects on which nodes and the broker speak about the job.
struct Subscriptions {
    results: Subscriber,
    begun: Subscriber,
    dead: Subscriber,
    too_often: Subscriber,
}

impl<'a> Coordinator<'a> {
    async fn new(farm: &'a Farm, order: &'a Order<'a>, tiles: &'a mut dyn Tiles) -> Result<Self, Stopped> {
        let hear = async |subject: String| {
            let heard = farm.broker.client.subscribe(subject).await;
            heard.map_err(|error| Stopped::Broker(reasons(&error)))
        };
        // Before the first piece is sent, so that nothing is missed.
        let subscriptions = Subscriptions {
            results: hear(names::results(order.name)).await?,
            begun: hear(names::begun(order.name)).await?,
            dead: hear(names::dead(order.tenant, order.name)).await?,
            too_often: hear(names::TOO_OFTEN.to_owned()).await?,
        };
        let coordinator = Self {
            farm,
            order,
            tiles,
            owner: Owner::of(order.name),
            in_flight: InFlight::default(),
            costs: Costs::new(order.pixel_ms),
            unsent: Vec::new(),
            not_before: Instant::now(),
            is_cut: false,
            subscriptions,
            window: SendWindow { slots: 0, pieces: 0, measured: None },
            swept: Instant::now(),
            refused: None,
            session: uuid::Uuid::now_v7().simple().to_string(),
        };
        // Pieces of a coordinator before this one: nodes may go on with those that they have.
        coordinator.purge().await;
        Ok(coordinator)
    }

    async fn run(&mut self) -> Result<(), Stopped> {
        let mut connections = self.farm.broker.connections();
        self.note_backlog();
        loop {
            if self.order.control.is_cancelled() {
                return Err(Stopped::Cancelled);
            }
            self.fill().await;
            if self.in_flight.pieces.is_empty() && self.is_cut {
                return Ok(());
            }
            tokio::select! {
                Some(message) = self.subscriptions.results.next() => self.take(&message).await?,
                Some(message) = self.subscriptions.begun.next() => self.note_begun(&message),
                Some(message) = self.subscriptions.dead.next() => self.on_dead_letter(&message)?,
                Some(message) = self.subscriptions.too_often.next() => self.delivered_too_often(&message).await?,
                // Nothing was heard while there was no connection.
                Ok(()) = connections.changed() => self.look_for_results(Duration::ZERO).await?,
                () = tokio::time::sleep(LOOK) => {}
            }
            if self.swept.elapsed() >= self.farm.lease / 5 {
                self.sweep().await?;
                self.note_backlog();
                self.swept = Instant::now();
            }
        }
    }

    fn note_backlog(&self) {
        let left = self.costs.of(self.in_flight.pixels + self.tiles.pixels_left());
        self.farm.backlog.note(self.order.name, self.order.class, left);
    }

    /// Sends pieces until the window is full.
    async fn fill(&mut self) {
        if Instant::now() < self.not_before || !self.farm.broker.is_connected() {
            return;
        }
        if self.window.measured.is_none_or(|measured| measured.elapsed() >= LOOK) {
            let slots = self.farm.nodes.slots();
            let pieces = (FOR_EACH_SLOT * f64::from(slots) * self.tiles.share()).ceil().max(1.0) as usize;
            self.window = SendWindow { slots, pieces, measured: Some(Instant::now()) };
        }
        let SendWindow { slots, pieces: window, .. } = self.window;
        while !self.order.control.is_cancelled() {
            let number = match self.unsent.pop() {
                Some(number) => number,
                None if self.in_flight.pieces.len() < window && !self.is_cut => {
                    let target = self.costs.target(self.order.class, self.tiles.pixels_left(), slots);
                    let tiles = self.costs.cut(target, || self.tiles.next());
                    self.is_cut = tiles.is_empty();
                    if tiles.is_empty() {
                        return;
                    }
                    self.add(tiles.into_iter().map(|(number, region)| TilePlace::new(number, region)).collect())
                }
                None => return,
            };
            if let Err(error) = self.send(number).await {
                tracing::warn!(job = self.order.name, error, "a piece is not taken; it is offered again");
                self.unsent.push(number);
                self.not_before = Instant::now() + RESEND_AFTER;
                return;
            }
        }
    }

    /// A new piece of some tiles, which is to be sent.
    fn add(&mut self, tiles: Vec<TilePlace>) -> u64 {
        let predicted = self.costs.of(tiles.iter().map(|tile| tile.region().pixels()).sum());
        self.in_flight.add(tiles, predicted)
    }

    /// Gives a piece to the broker. If it has it already, since only its answer was lost, it says so.
    async fn send(&mut self, number: u64) -> Result<(), String> {
        let Some(piece_in_flight) = self.in_flight.pieces.get_mut(&number) else { return Ok(()) };
        let &Order { name, tenant, class, ref scene, window, limit, .. } = self.order;
        let tiles = piece_in_flight.tiles.clone();
        let piece = Piece::new([name, tenant, &self.session], number, scene, window.into(), tiles, limit.as_secs_f64());
        let message =
            PublishMessage::build().payload(piece.write().into()).message_id(format!("{}.{number}", self.session));
        let counts = &self.farm.counts;
        let sent = self.farm.broker.stream.send_publish(names::work(class, tenant, name), message).await;
        let acknowledged = match sent {
            Ok(ack) => ack.await,
            Err(error) => Err(error),
        };
        let acknowledged = acknowledged.map_err(|error| {
            if is_full(&error) {
                counts.full.fetch_add(1, Ordering::Relaxed);
            }
            reasons(&error)
        })?;
        counts.pieces.fetch_add(1, Ordering::Relaxed);
        piece_in_flight.sequence = Some(acknowledged.sequence);
        Ok(())
    }

    /// A result, as the node has published it.
    async fn take(&mut self, message: &Message) -> Result<(), Stopped> {
        let number = message.subject.rsplit('.').next().and_then(|number| number.parse().ok());
        match number {
            Some(number) => self.take_bytes(number, &message.payload).await,
            None => Ok(()),
        }
    }

    async fn take_bytes(&mut self, number: u32, bytes: &[u8]) -> Result<(), Stopped> {
        // A second result, or a late one.
        let Some(place) = self.in_flight.place(number) else { return Ok(()) };
        let size = [self.order.window.width, self.order.window.height];
        let region = |found| (found == number).then(|| place.region());
        let tile = self.owner.read(&mut &*bytes, size, region).ok().flatten();
        let Some((tile, _)) = tile else {
            tracing::error!(job = self.order.name, tile = number, "a result is damaged; the tile is rendered again");
            // As long as it is there, it is the first.
            let deleted = self.farm.results.delete(self.order.name, number).await;
            deleted.map_err(Stopped::Broker)?;
            self.resend(number);
            return Ok(());
        };
        self.costs.learn(place.region(), tile.picture.trace_ms);
        self.farm.counts.tiles.fetch_add(1, Ordering::Relaxed);
        // They count for the tenant's quota, wherever they were traced.
        self.order.control.add_rays(tile.picture.rays.total());
        for piece in self.in_flight.finish(number) {
            if let (Some(begun), false) = (piece.begun, piece.is_doubled) {
                self.costs.piece_took(piece.predicted_ms, begun.elapsed().as_secs_f64() * 1e3);
            }
        }
        if self.tiles.finished(tile) { Ok(()) } else { Err(Stopped::Cancelled) }
    }

    /// Sends a tile in a piece of its own.
    fn resend(&mut self, tile: u32) {
        if let Some(place) = self.in_flight.place(tile) {
            let number = self.add(vec![place]);
            self.unsent.push(number);
        }
    }

    fn note_begun(&mut self, message: &Message) {
        let Ok(begun) = serde_json::from_slice::<Begun>(&message.payload) else { return };
        if let Some(piece) = self.in_flight.pieces.get_mut(&begun.piece) {
            let now = Instant::now();
            if piece.begun.is_some() && !begun.refused {
                // The broker has given it to another node, since the first one was not heard of any more.
                self.farm.counts.again.fetch_add(1, Ordering::Relaxed);
            }
            (piece.begun, piece.heard) = (Some(now), now);
            if begun.refused {
                piece.tried.1 = (piece.tried.1 - 1).max(0);
                piece.begun = piece.begun.filter(|_| piece.tried.1 > 0);
                return;
            }
            let first = piece.tiles.first().map(|tile| tile.0);
            piece.tried = (first, if piece.tried.0 == first { piece.tried.1 + 1 } else { 1 });
        }
    }

    /// A node has given up some work of the job.
    fn on_dead_letter(&mut self, message: &Message) -> Result<(), Stopped> {
        let Ok(dead) = serde_json::from_slice::<Dead>(&message.payload) else { return Ok(()) };
        if dead.kind == Death::Differs {
            self.farm.counts.differing.fetch_add(1, Ordering::Relaxed);
            tracing::error!(job = dead.job, reason = dead.reason, node = dead.node, "DETERMINISM: pixels differ");
            return Ok(());
        }
        self.farm.counts.dead.fetch_add(1, Ordering::Relaxed);
        // Another node may have rendered its tiles.
        let is_missing = |tile: &u32| self.in_flight.place(*tile).is_some();
        if dead.tiles.iter().any(is_missing) { Err(Stopped::Dead(dead.kind, dead.reason)) } else { Ok(()) }
    }

    /// Takes back what nobody needs any more: pieces that wait, and those that nodes render.
    async fn clear(&mut self, is_done: bool) {
        self.farm.backlog.forget(self.order.name);
        // A job that is not done may go on, and its next coordinator begins with this.
        if !self.purge().await && is_done {
            self.farm.purge_later(self.order.tenant, self.order.name);
        }
        // After the last tile only stragglers, whose tiles others have rendered, may go on.
        if !is_done || self.farm.counts.doubled.load(Ordering::Relaxed) > 0 {
            let _ = self.farm.broker.client.publish(names::cancel(self.order.name), self.session.clone().into()).await;
        }
    }

    /// Whether all pieces that wait were taken back.
    async fn purge(&self) -> bool {
        let purged = self.farm.purge(self.order.tenant, self.order.name).await;
        if let Err(error) = &purged {
            tracing::warn!(job = self.order.name, error, "waiting pieces are not taken back");
        }
        purged.is_ok()
    }
}
