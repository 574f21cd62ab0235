//! Looking after pieces of which nothing is heard: results that were published unheard, pieces that the broker has lost, pieces
//! on slow nodes, and those that end every node that takes them.

use super::{Coordinator, Stopped};
use crate::service::farm::connection::reasons;
use crate::service::farm::names::{self, DELIVERIES, WORK};
use crate::service::farm::work::{Dead, Death, Piece};
use async_nats::Message;
use async_nats::jetstream::consumer::PullConsumer;
use async_nats::jetstream::stream::DirectGetErrorKind;
use serde::Deserialize;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// A piece is slow beyond this many times what 95 of 100 take.
const SLOW: f64 = 4.0;
/// And after this time, since copies cost more than they save before.
const SLOW_MS: f64 = 1_000.0;
/// Leases for which all nodes refuse a scene until its job is given up.
const REFUSED: f64 = 3.0;
/// Pieces that are looked after in one sweep.
const AT_ONCE: usize = 64;

/// What the broker says of a message.
#[derive(Debug, PartialEq, Eq)]
enum Place {
    /// It waits, or a node has it.
    There,
    /// It was acknowledged, taken back or lost.
    Gone,
}

impl Coordinator<'_> {
    /// Looks after all pieces that were silent for long.
    pub(super) async fn sweep(&mut self) -> Result<(), Stopped> {
        let lease = self.farm.lease;
        self.check_memory()?;
        self.look_for_results(lease / 2).await?;
        let silent = |wait: Duration| {
            move |(number, piece): (&u64, &super::in_flight::InFlightPiece)| {
                (piece.heard.elapsed() >= wait && piece.looked.elapsed() >= wait).then_some(*number)
            }
        };
        let old: Vec<u64> = self.in_flight.pieces.iter().filter_map(silent(lease)).take(AT_ONCE).collect();
        let mut is_stranded = None;
        for number in old {
            let Some(piece) = self.in_flight.pieces.get_mut(&number) else { continue };
            piece.looked = Instant::now();
            let Some(sequence) = piece.sequence else { continue };
            let very_old = piece.heard.elapsed() >= 4 * lease;
            match self.place_of(sequence, number).await {
                Ok(Place::Gone) => self.send_again(number, "it is lost"),
                Ok(Place::There) if very_old => {
                    let stranded = match is_stranded {
                        Some(known) => known,
                        None => *is_stranded.insert(self.is_queue_idle().await),
                    };
                    if stranded {
                        self.delete(sequence).await;
                        self.send_again(number, "the broker does not deliver it");
                    }
                }
                _ => {}
            }
        }
        self.double_stragglers();
        Ok(())
    }

    /// Gives the job up once its scene has been too large for all nodes for some time: a larger one may only be starting again.
    fn check_memory(&mut self) -> Result<(), Stopped> {
        if !self.farm.nodes.all_refuse(&self.order.scene.text) {
            self.refused = None;
            return Ok(());
        }
        if self.refused.get_or_insert_with(Instant::now).elapsed() < self.farm.lease.mul_f64(REFUSED) {
            return Ok(());
        }
        Err(Stopped::TooLarge("its scene takes more memory than any node has (memory_bytes)".into()))
    }

    /// Fetches results of pieces that nodes have, and of which nothing was heard for some time.
    pub(super) async fn look_for_results(&mut self, silence: Duration) -> Result<(), Stopped> {
        let silent: Vec<u64> = (self.in_flight.pieces.iter())
            .filter(|(_, piece)| piece.sequence.is_some() && piece.heard.elapsed() >= silence)
            .filter(|(_, piece)| silence.is_zero() || (piece.begun.is_some() && piece.looked.elapsed() >= silence))
            .map(|(number, _)| *number)
            .collect();
        for number in silent {
            let Some(piece) = self.in_flight.pieces.get(&number) else { continue };
            for tile in piece.tiles.clone() {
                match self.farm.results.get(self.order.name, tile.0).await {
                    Ok(Some(bytes)) => self.take_bytes(tile.0, &bytes).await?,
                    // They are rendered one after the other.
                    Ok(None) => break,
                    Err(error) => {
                        tracing::debug!(error, "a result cannot be looked for");
                        return Ok(());
                    }
                }
            }
        }
        Ok(())
    }

    /// Sends the missing tiles of a piece once more, in place of it.
    fn send_again(&mut self, number: u64, why: &str) {
        let tiles = self.in_flight.forget(number);
        if tiles.is_empty() {
            return;
        }
        tracing::warn!(job = self.order.name, piece = number, tiles = tiles.len(), why, "a piece is sent again");
        self.farm.counts.again.fetch_add(1, Ordering::Relaxed);
        let number = self.add(tiles);
        self.unsent.push(number);
    }

    /// When there is nothing else to do, tiles of slow pieces are given to other nodes, too. The first result counts.
    fn double_stragglers(&mut self) {
        if !self.is_cut || !self.unsent.is_empty() {
            return;
        }
        let slots = self.farm.nodes.slots() as usize;
        let mut free = slots.saturating_sub(self.in_flight.pieces.len());
        let slow_ratio = self.costs.slow_ratio().unwrap_or(2.0);
        let slow = |piece: &super::in_flight::InFlightPiece| {
            let ran = piece.begun.map_or(0.0, |begun| begun.elapsed().as_secs_f64() * 1e3);
            !piece.is_doubled && ran > (SLOW * slow_ratio * piece.predicted_ms).max(SLOW_MS)
        };
        let stragglers: Vec<u64> =
            self.in_flight.pieces.iter().filter(|(_, piece)| slow(piece)).map(|(number, _)| *number).collect();
        for number in stragglers {
            let Some(piece) = self.in_flight.pieces.get_mut(&number).filter(|_| free > 0) else { return };
            piece.is_doubled = true;
            let (tiles, mut copies) = (piece.tiles.clone(), Vec::new());
            let each = tiles.len().div_ceil(free);
            for part in tiles.chunks(each) {
                copies.push(part.to_vec());
                free -= 1;
            }
            tracing::info!(
                job = self.order.name,
                piece = number,
                copies = copies.len(),
                "a slow piece is rendered twice"
            );
            self.farm.counts.doubled.fetch_add(1, Ordering::Relaxed);
            for copy in copies {
                let number = self.add(copy);
                self.unsent.push(number);
            }
        }
    }

    /// The broker's note that a piece was delivered as often as it may be: it stays where it is, and nobody gets it any more.
    pub(super) async fn delivered_too_often(&mut self, message: &Message) -> Result<(), Stopped> {
        #[derive(Deserialize)]
        struct Note {
            stream_seq: u64,
        }
        let Ok(note) = serde_json::from_slice::<Note>(&message.payload) else { return Ok(()) };
        let Some(number) = self.in_flight.of_sequence(note.stream_seq) else { return Ok(()) };
        self.look_for_results(Duration::ZERO).await?;
        self.delete(note.stream_seq).await;
        let Some(piece) = self.in_flight.pieces.get(&number) else { return Ok(()) };
        if piece.begun.is_none() {
            // Nodes have handed it back, or were never heard of: none has tried.
            self.send_again(number, "it was handed back too often");
            return Ok(());
        }
        if piece.tried.1 < DELIVERIES {
            // Nodes have ended, but one got on with it before: they did not end because of one tile.
            self.send_again(number, "nodes ended with it too often");
            return Ok(());
        }
        let culprit = piece.tiles.first().map(|tile| tile.0);
        let reason = format!(
            "{DELIVERIES} nodes that began with tile {} of the picture ended or did not get on with it",
            culprit.unwrap_or_default()
        );
        self.report(Death::Killed, &reason, culprit.into_iter().collect()).await;
        self.farm.counts.dead.fetch_add(1, Ordering::Relaxed);
        Err(Stopped::Dead(Death::Killed, reason))
    }

    async fn report(&self, kind: Death, reason: &str, tiles: Vec<u32>) {
        let [job, tenant] = [self.order.name, self.order.tenant].map(str::to_owned);
        let dead = Dead { job, tenant, kind, reason: reason.to_owned(), tiles, node: None };
        let payload = serde_json::to_vec(&dead).unwrap_or_default();
        let subject = names::dead(self.order.tenant, self.order.name);
        if let Err(error) = self.farm.broker.stream.publish(subject, payload.into()).await {
            tracing::error!(error = reasons(&error), job = self.order.name, "a dead letter is not kept");
        }
    }

    /// Whether the message of a piece is still at the broker. After a power cut its number may be that of another.
    async fn place_of(&self, sequence: u64, number: u64) -> Result<Place, String> {
        let found = self.farm.work.direct_get(sequence).await;
        match found {
            Ok(message) => {
                let piece = Piece::read(&message.payload);
                let is_it = piece.is_ok_and(|piece| piece.session == self.session && piece.piece == number);
                Ok(if is_it { Place::There } else { Place::Gone })
            }
            Err(error) if error.kind() == DirectGetErrorKind::NotFound => Ok(Place::Gone),
            Err(error) => Err(reasons(&error)),
        }
    }

    /// Whether the broker has nothing for nodes, and no node has anything: what is there then is stranded.
    async fn is_queue_idle(&self) -> bool {
        let queue = self.farm.broker.stream.get_consumer_from_stream(self.order.class.queue(), WORK).await;
        let Ok(queue): Result<PullConsumer, _> = queue else { return false };
        let info = queue.cached_info();
        info.num_pending == 0 && info.num_ack_pending == 0
    }

    async fn delete(&self, sequence: u64) {
        // If it is not deleted, it is rendered twice at worst.
        let _ = self.farm.work.delete_message(sequence).await;
    }
}
