//! Asking for work: the most urgent first, one piece for each free slot and none in advance, since leases run from delivery.

use crate::service::farm::connection::Broker;
use crate::service::farm::names::{Class, WORK};
use async_nats::client::Request;
use async_nats::jetstream::{AckKind, Message};
use async_nats::{StatusCode, Subscriber};
use futures_util::StreamExt;
use serde_json::json;
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// How long the broker keeps a request for work that is not there.
const WAIT: Duration = Duration::from_secs(3);
/// How much later than that an answer may come.
const LATE: Duration = Duration::from_secs(2);
/// Time until it is looked again whether there is a broker.
const UNCONNECTED: Duration = Duration::from_millis(200);
/// Every so many pieces the least urgent queue is asked first, so that it cannot starve.
const TURN: u64 = 8;

/// The queues of this version of the renderer.
#[derive(Debug, Clone)]
pub(super) struct Queues {
    broker: Broker,
    /// Where to ask, the most urgent first.
    subjects: [String; 3],
    asked: u64,
}

impl Queues {
    pub(super) fn new(broker: &Broker) -> Self {
        let subjects = Class::ALL.map(|class| format!("$JS.API.CONSUMER.MSG.NEXT.{WORK}.{}", class.queue()));
        Self { broker: broker.clone(), subjects, asked: 0 }
    }

    /// The next piece of work. None if there was none for a while, or once `stop` is true.
    pub(super) async fn next(&mut self, stop: &mut watch::Receiver<bool>) -> Option<Message> {
        if !self.broker.is_connected() {
            // Requests would wait for the connection, and their answers would come to nobody.
            tokio::time::sleep(UNCONNECTED).await;
            return None;
        }
        self.asked += 1;
        let mut order = [0, 1, 2];
        if self.asked.is_multiple_of(TURN) {
            order.rotate_right(1);
        }
        for queue in order {
            if let Some(message) = self.now(queue).await {
                return Some(message);
            }
        }
        let began = Instant::now();
        let found = self.wait(stop).await;
        // A broker that refuses at once is not asked at once again.
        if found.is_none() && !*stop.borrow() && began.elapsed() < WAIT / 2 {
            tokio::time::sleep(WAIT / 2).await;
        }
        found
    }

    /// A piece that is there.
    async fn now(&self, queue: usize) -> Option<Message> {
        let ask = json!({ "batch": 1, "no_wait": true }).to_string();
        // Work arrives under its own subject, so the client does not find whose answer it is unless the inbox is for it alone.
        let inbox = self.broker.client.new_inbox();
        let request = Request::new().payload(ask.into()).timeout(Some(LATE)).inbox(inbox);
        let answer = self.broker.client.send_request(self.subjects[queue].clone(), request).await.ok()?;
        self.work_in(answer)
    }

    /// A piece as soon as there is one in any queue.
    async fn wait(&self, stop: &mut watch::Receiver<bool>) -> Option<Message> {
        let client = &self.broker.client;
        let inbox = client.new_inbox();
        let mut answers = client.subscribe(inbox.clone()).await.ok()?;
        let ask = json!({ "batch": 1, "expires": WAIT.as_nanos() as u64 }).to_string();
        for subject in &self.subjects {
            client.publish_with_reply(subject.clone(), inbox.clone(), ask.clone().into()).await.ok()?;
        }
        let end = tokio::time::Instant::now() + WAIT + LATE;
        let mut open = self.subjects.len();
        let mut found = None;
        while open > 0 && found.is_none() {
            let answer = tokio::select! {
                answer = tokio::time::timeout_at(end, answers.next()) => answer.ok().flatten(),
                _ = stop.wait_for(|stop| *stop) => None,
            };
            let Some(answer) = answer else { break };
            open -= 1;
            found = self.work_in(answer);
        }
        self.give_back(answers).await;
        found
    }

    /// Takes back the requests that are left. What was on its way goes to another node at once.
    async fn give_back(&self, mut answers: Subscriber) {
        if answers.drain().await.is_err() {
            return;
        }
        let queues = self.clone();
        tokio::spawn(async move {
            while let Ok(Some(answer)) = tokio::time::timeout(LATE, answers.next()).await {
                if let Some(message) = queues.work_in(answer) {
                    // If this is lost, too, the lease ends.
                    let _ = message.ack_with(AckKind::Nak(None)).await;
                }
            }
        });
    }

    /// The piece in an answer, if it is not a note that there is none.
    fn work_in(&self, answer: async_nats::Message) -> Option<Message> {
        let is_work = answer.status.is_none_or(|status| status == StatusCode::OK) && answer.reply.is_some();
        is_work.then(|| Message { message: answer, context: self.broker.stream.clone() })
    }
}
