//! One piece of work on a node: its scene, its tiles one after the other, their results, and only then the acknowledgement.

use super::Node;
use super::lease::Lease;
use super::scenes::{Held, NoScene};
use crate::service::error::panic_text;
use crate::service::farm::names;
use crate::service::farm::results::Kept;
use crate::service::farm::work::{Begun, Dead, Death, NotWork, Piece, TilePlace};
use crate::service::pictures::tile_bytes::{Owner, Tile, show_the_same};
use crate::service::scheduler::pool::Pool;
use crate::service::scheduler::task::{Class, Task};
use async_nats::jetstream::{AckKind, Message};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use strahl::render::Cancelled;
use tokio::task::JoinHandle;

/// A piece that has failed at so many deliveries is given up.
const FAILURES: i64 = 3;
/// Time until a node of another version, or one with more memory, may have it.
const FOR_ANOTHER_VERSION: Duration = Duration::from_secs(30);
const FOR_ROOM: Duration = Duration::from_secs(2);
const FOR_OTHERS: Duration = Duration::from_secs(5);
/// The same for a node with more memory, and how long this slot asks for no work: it would get the same again.
const FOR_LARGER: Duration = Duration::from_millis(200);
const REST: Duration = Duration::from_secs(1);
/// How long a piece is held whose scene cannot be had.
const HELD: Duration = Duration::from_secs(120);

/// Why a piece is not rendered.
enum Stopped {
    /// Nobody wants it any more.
    Unwanted,
    /// This node ends.
    Draining,
    /// Later, or elsewhere, it may be.
    NotNow(String),
    /// On a node with more memory it may be.
    TooLarge(String),
    /// It has failed.
    Failed(String),
}

/// Works on a message until the broker knows what has become of it. Keeps the scene for the next piece.
pub(super) async fn work(node: &Arc<Node>, pool: &Arc<Pool>, message: Message, last: &mut Option<Held>) {
    let message = Arc::new(message);
    let delivered = message.info().map_or(1, |info| info.delivered);
    let piece = match Piece::read(&message.payload) {
        Ok(piece) => piece,
        Err(NotWork::OtherVersion(version)) => {
            tracing::warn!(version, "work of another version is left to nodes that know it");
            return answer(&message, AckKind::Nak(Some(FOR_ANOTHER_VERSION))).await;
        }
        Err(NotWork::Broken(why)) => {
            tracing::error!(why, subject = %message.subject, "a piece of work is damaged");
            return answer(&message, AckKind::Term).await;
        }
    };
    if node.cancels.has(&piece.session) {
        return answer(&message, AckKind::Term).await;
    }
    if node.health.avoids(&piece.job) {
        return answer(&message, AckKind::Nak(Some(FOR_OTHERS))).await;
    }
    if node.health.is_too_large(&piece.scene.text) {
        answer(&message, AckKind::Nak(Some(FOR_LARGER))).await;
        return tokio::time::sleep(REST).await;
    }
    let began = Instant::now();
    let _busy = node.busy();
    tell(node, &piece, false).await;
    let lease = Lease::keep(&message, node.lease, Duration::from_secs_f64(piece.limit_s.clamp(1.0, 86_400.0)));
    let place = node.cancels.enter(&piece.session, &lease.control);
    let rendered = render(node, pool, &piece, &lease, delivered > 1, last).await;
    let complaint = lease.complaint();
    drop((place, lease));
    node.counts.busy_ms.fetch_add(began.elapsed().as_millis() as u64, Ordering::Relaxed);
    let kind = match rendered {
        Ok(()) => {
            node.counts.pieces.fetch_add(1, Ordering::Relaxed);
            node.health.succeeded();
            AckKind::Ack
        }
        Err(Stopped::Unwanted) if complaint.is_none() => AckKind::Term,
        Err(Stopped::Draining) => AckKind::Nak(None),
        Err(Stopped::NotNow(why)) => {
            tracing::warn!(job = piece.job, why, "a piece is given back");
            AckKind::Nak(Some(FOR_ROOM))
        }
        Err(Stopped::TooLarge(why)) => {
            tracing::warn!(job = piece.job, why, "a job is left to nodes with more memory");
            node.health.leave(&piece.scene.text);
            node.changed.send_replace(());
            tell(node, &piece, true).await;
            answer(&message, AckKind::Nak(Some(FOR_LARGER))).await;
            return tokio::time::sleep(REST).await;
        }
        Err(Stopped::Failed(why)) => failed(node, &piece, delivered, why).await,
        Err(Stopped::Unwanted) => failed(node, &piece, delivered, complaint.unwrap_or_default().to_owned()).await,
    };
    answer(&message, kind).await;
}

/// Tells the job's front that this node has begun with a piece, or has not after all.
async fn tell(node: &Node, piece: &Piece, refused: bool) {
    let note = Begun { piece: piece.piece, node: node.id.clone(), refused };
    let note = serde_json::to_vec(&note).unwrap_or_default();
    let _ = node.broker.client.publish(names::begun(&piece.job), note.into()).await;
}

/// The scene and the tiles.
async fn render(
    node: &Arc<Node>,
    pool: &Arc<Pool>,
    piece: &Piece,
    lease: &Lease,
    is_again: bool,
    last: &mut Option<Held>,
) -> Result<(), Stopped> {
    lease.loading(true);
    let scene = scene(node, piece, lease).await?;
    lease.loading(false);
    let ready = Arc::clone(&scene.ready);
    *last = Some(scene);
    let owner = Owner::of(&piece.job);
    // A result is on its way while the next tile is rendered.
    let mut on_its_way: Option<JoinHandle<Result<(), String>>> = None;
    for &tile in &piece.tiles {
        // A node that had it before may have rendered some of it.
        if is_again && matches!(node.results.get(&piece.job, tile.0).await, Ok(Some(_))) {
            continue;
        }
        let (pool, scene, control) = (Arc::clone(pool), Arc::clone(&ready), lease.control.clone());
        let paint = node.paint;
        let (owner, window, task) = (owner.clone(), piece.view.into(), Task::new(Class::Jobs, &piece.tenant, 1));
        let render = move || {
            let workers = pool.join(task, control.clone());
            let picture = workers.work(|| paint(&scene.scene, &window, tile.region(), &control))??;
            Ok::<_, Cancelled>(owner.write(&Tile { number: tile.0, picture }))
        };
        let rendered = tokio::task::spawn_blocking(|| catch_unwind(AssertUnwindSafe(render))).await;
        let bytes = match rendered.map_err(|_| stopped(node))? {
            Ok(Ok(Ok(bytes))) => bytes,
            Ok(Ok(Err(error))) => return Err(Stopped::Failed(format!("a tile cannot be written: {error}"))),
            Ok(Err(Cancelled)) => return Err(stopped(node)),
            Err(panic) => return Err(Stopped::Failed(format!("rendering panics: {}", panic_text(&*panic)))),
        };
        arrived(on_its_way.take()).await?;
        on_its_way = Some(tokio::spawn(keep(Arc::clone(node), piece.clone(), tile, bytes)));
    }
    arrived(on_its_way).await
}

/// The scene of a piece. Deliveries are counted, so while the store does not answer the piece is held, not handed back.
async fn scene(node: &Arc<Node>, piece: &Piece, lease: &Lease) -> Result<Held, Stopped> {
    let began = Instant::now();
    loop {
        match node.scenes.find(&piece.scene, &lease.control).await {
            Ok(scene) => return Ok(scene),
            Err(NoScene::NotNow(why)) if began.elapsed() > HELD => return Err(Stopped::NotNow(why)),
            Err(NoScene::NotNow(why)) => tracing::warn!(job = piece.job, why, "a scene is waited for"),
            Err(NoScene::TooLarge(why)) => return Err(Stopped::TooLarge(why)),
            Err(NoScene::Never(why)) => return Err(Stopped::Failed(why)),
            Err(NoScene::Cancelled) => return Err(stopped(node)),
        }
        tokio::time::sleep(FOR_ROOM).await;
        if lease.control.is_cancelled() {
            return Err(stopped(node));
        }
    }
}

/// Waits for a result to be kept.
async fn arrived(result: Option<JoinHandle<Result<(), String>>>) -> Result<(), Stopped> {
    match result {
        None => Ok(()),
        Some(result) => match result.await {
            Ok(kept) => kept.map_err(Stopped::Failed),
            Err(_) => Err(Stopped::NotNow("a result was not sent".into())),
        },
    }
}

/// Sends a result, and compares it with the one that was there before it.
async fn keep(node: Arc<Node>, piece: Piece, tile: TilePlace, bytes: Vec<u8>) -> Result<(), String> {
    let kept = node.results.keep(&piece.job, tile.0, &bytes).await?;
    node.counts.tiles.fetch_add(1, Ordering::Relaxed);
    if let Kept::Second(first) = kept
        && !show_the_same(&first, &bytes)
    {
        let reason = format!("two nodes have made different pixels of tile {}", tile.0);
        tracing::error!(job = piece.job, tile = tile.0, "another node has made other pixels of the same tile");
        report(&node, &piece, Death::Differs, reason, vec![tile.0]).await;
        node.health.request_check();
    }
    Ok(())
}

/// Gives a piece back, or up.
async fn failed(node: &Arc<Node>, piece: &Piece, delivered: i64, why: String) -> AckKind {
    tracing::error!(job = piece.job, piece = piece.piece, delivered, why, "a piece has failed");
    node.counts.failures.fetch_add(1, Ordering::Relaxed);
    node.health.failed(&piece.job, piece.piece);
    if delivered < FAILURES {
        return AckKind::Nak(Some(Duration::from_secs(4_u64.pow(delivered.clamp(1, 3) as u32 - 1))));
    }
    let reason = format!("{why} (on {FAILURES} tries, the last on {})", node.name);
    report(node, piece, Death::Failed, reason, piece.tiles.iter().map(|tile| tile.0).collect()).await;
    AckKind::Term
}

/// Says that work was given up, where it is kept and where the job's front hears it.
async fn report(node: &Node, piece: &Piece, kind: Death, reason: String, tiles: Vec<u32>) {
    let node_id = Some(node.id.clone());
    let dead = Dead { job: piece.job.clone(), tenant: piece.tenant.clone(), kind, reason, tiles, node: node_id };
    let payload = serde_json::to_vec(&dead).unwrap_or_default();
    let sent = node.broker.stream.publish(names::dead(&piece.tenant, &piece.job), payload.into()).await;
    let kept = match sent {
        Ok(ack) => ack.await.map(|_| ()),
        Err(error) => Err(error),
    };
    if let Err(error) = kept {
        tracing::error!(%error, job = piece.job, "a dead letter is not kept");
    }
}

/// Why a render was stopped from outside.
fn stopped(node: &Node) -> Stopped {
    if *node.ending.borrow() { Stopped::Draining } else { Stopped::Unwanted }
}

/// Tells the broker. It is not waited for: if the answer is lost, another node finds the results there.
async fn answer(message: &Message, kind: AckKind) {
    if let Err(error) = message.ack_with(kind).await {
        tracing::debug!(%error, "the broker is not told what has become of a piece");
    }
}
