//! `GET /v1/farm`: the nodes that render for the service, what waits for them, and what goes wrong.

use crate::http::prelude::*;
use crate::service::clock::unix_time;
use crate::service::farm::Farm;
use crate::service::farm::names::Class;
use crate::service::farm::nodes::{NodeRecord, NodeState};
use crate::service::farm::summary::Summary;
use crate::service::scenes::ids::renderer;
use axum::http::Extensions;

pub(super) fn routes() -> Vec<Route> {
    let about = "The farm that renders for the service: nodes, slots, backlog, throughput, failures. Null if it renders itself. \
                 Single nodes are for keys with the scope `admin`.";
    vec![Route::get("/v1/farm", farm, ["farm", "service", about]).answer(
        200,
        "The farm",
        &[Content::json::<FarmStatus>()],
    )]
}

/// The farm, if there is one.
#[derive(Debug, Serialize, JsonSchema)]
struct FarmStatus {
    /// Null: the service renders itself.
    farm: Option<FarmFigures>,
}

/// The farm in figures.
#[derive(Debug, Serialize, JsonSchema)]
struct FarmFigures {
    /// Whether the service reaches the broker now.
    connected: bool,
    /// Pieces that nodes which take work can render at one time.
    slots: u32,
    /// Pieces that nodes render now.
    busy: u32,
    /// Nodes by how they are.
    nodes: FarmNodeCounts,
    /// Seconds of one slot that the work takes which this front has for nodes, by how urgent it is.
    backlog_seconds: FarmBacklog,
    /// What the nodes there are have done.
    done: FarmWorkDone,
    /// What has gone wrong since this front was started.
    trouble: FarmFaults,
    /// Each node. Null without the scope `admin`.
    each: Option<Vec<FarmNode>>,
}

/// Nodes by how they are.
#[derive(Debug, Serialize, JsonSchema)]
struct FarmNodeCounts {
    /// They take work.
    ready: u32,
    /// They finish what they have, and end.
    draining: u32,
    /// They take no work, since they do not trust themselves.
    excluded: u32,
}

/// Seconds of one slot.
#[derive(Debug, Serialize, JsonSchema)]
struct FarmBacklog {
    /// Renders that somebody waits for.
    hi: f64,
    /// Jobs.
    norm: f64,
    /// Jobs of low priority.
    bulk: f64,
}

/// What nodes have done since they were started.
#[derive(Debug, Serialize, JsonSchema)]
struct FarmWorkDone {
    /// Pieces of work.
    pieces: u64,
    /// Tiles in them.
    tiles: u64,
    /// Pieces that failed.
    failures: u64,
    /// Seconds that slots have rendered.
    busy_seconds: f64,
}

/// What has gone wrong.
#[derive(Debug, Serialize, JsonSchema)]
struct FarmFaults {
    /// Pieces that were lost, as when a node ends, and were sent again.
    sent_again: u64,
    /// Slow pieces that a second node rendered, too.
    rendered_twice: u64,
    /// Pieces that were given up; their jobs have failed.
    dead_letters: u64,
    /// Tiles of which two nodes have made different pixels.
    determinism_alarms: u64,
    /// How often the broker had no room for more work.
    queue_full: u64,
    /// What the broker has refused, such as missing permissions.
    broker_errors: u64,
}

/// A node.
#[derive(Debug, Serialize, JsonSchema)]
struct FarmNode {
    /// Id of its process.
    id: String,
    /// What people call it.
    name: String,
    /// The program's version.
    version: String,
    /// Whether it renders the same pixels as this front. Only then it gets work of this front.
    same_renderer: bool,
    /// How it is.
    state: NodeState,
    /// Why it is so.
    reason: Option<String>,
    /// Pieces it renders at one time.
    slots: u32,
    /// Pieces it renders now.
    busy: u32,
    /// Seconds since it was started.
    started_s: u64,
    /// Pieces it has done.
    pieces: u64,
    /// Tiles in them.
    tiles: u64,
    /// Pieces that failed.
    failures: u64,
}

async fn farm(State(app): State<App>, extensions: Extensions) -> Result<Response, Problem> {
    let tenant = Tenant::required(&extensions)?;
    let may_see_nodes = !app.access.needs_keys() || tenant.may(Scope::Admin);
    let answer = FarmStatus { farm: app.service.farm.as_deref().map(|farm| FarmFigures::of(farm, may_see_nodes)) };
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(answer)).into_response())
}

impl FarmFigures {
    fn of(farm: &Farm, may_see_nodes: bool) -> Self {
        let summary = Summary::of(farm);
        let [ready, draining, excluded] = summary.nodes().map(|(_, count)| count);
        let [hi, norm, bulk] = Class::ALL.map(|class| farm.backlog.seconds(class));
        let [_, _, sent_again, rendered_twice, dead_letters, determinism_alarms, queue_full, broker_errors] =
            summary.counters();
        let Summary { connected, slots, busy, pieces, tiles, failures, busy_ms, .. } = summary;
        Self {
            connected,
            slots,
            busy,
            nodes: FarmNodeCounts { ready, draining, excluded },
            backlog_seconds: FarmBacklog { hi, norm, bulk },
            done: FarmWorkDone { pieces, tiles, failures, busy_seconds: busy_ms as f64 / 1e3 },
            trouble: FarmFaults {
                sent_again,
                rendered_twice,
                dead_letters,
                determinism_alarms,
                queue_full,
                broker_errors,
            },
            each: may_see_nodes.then(|| each(summary.each)),
        }
    }
}

fn each(nodes: Vec<NodeRecord>) -> Vec<FarmNode> {
    let now = unix_time().as_millis() as u64;
    let node = |node: NodeRecord| FarmNode {
        same_renderer: node.kid == renderer(),
        state: node.state,
        started_s: now.saturating_sub(node.started) / 1_000,
        id: node.id,
        name: node.name,
        version: node.version,
        reason: node.reason,
        slots: node.slots,
        busy: node.busy,
        pieces: node.pieces,
        tiles: node.tiles,
        failures: node.failures,
    };
    nodes.into_iter().map(node).collect()
}
