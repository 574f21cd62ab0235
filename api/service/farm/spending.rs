//! What tenants spend at one front, told to all others, so that a rate limit is one of the farm. Nothing of it is kept: a front lets
//! a little more pass, for as long as a message takes.

use super::connection::{Broker, RETRY_AFTER, reasons};
use super::names::SPENT;
use futures_util::StreamExt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval, sleep};
use uuid::Uuid;

/// Version of the messages.
const VERSION: u32 = 1;
/// Time between two messages of a front.
const BETWEEN: Duration = Duration::from_millis(200);

#[derive(Debug, Serialize, Deserialize)]
struct Spent {
    v: u32,
    front: String,
    /// Units by tenant.
    units: BTreeMap<String, f64>,
}

/// Tells others what was `spent` here since it was asked before, and calls `hear` with what a tenant has spent elsewhere, for ever.
pub(crate) async fn exchange(
    broker: Broker,
    spent: impl Fn() -> BTreeMap<String, f64> + Send,
    hear: impl Fn(&str, f64) + Send,
) {
    let front = Uuid::now_v7().to_string();
    let mut ticks = interval(BETWEEN);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        match broker.client.subscribe(SPENT).await {
            Ok(mut others) => loop {
                tokio::select! {
                    message = others.next() => {
                        let Some(message) = message else { break };
                        match serde_json::from_slice::<Spent>(&message.payload) {
                            Ok(other) if other.v == VERSION && other.front != front => {
                                other.units.iter().for_each(|(tenant, units)| hear(tenant, *units));
                            }
                            // Its own, or one of another version.
                            _ => {}
                        }
                    }
                    _ = ticks.tick() => {
                        let units = spent();
                        if units.is_empty() {
                            continue;
                        }
                        let json = serde_json::to_vec(&Spent { v: VERSION, front: front.clone(), units }).unwrap_or_default();
                        if let Err(error) = broker.client.publish(SPENT, json.into()).await {
                            tracing::debug!(error = reasons(&error), "other fronts do not hear what was spent");
                        }
                    }
                }
            },
            Err(error) => tracing::debug!(error = reasons(&error), "what other fronts spend is not heard"),
        }
        sleep(RETRY_AFTER).await;
    }
}
