//! A farm of tests, and what the broker hears.

pub(crate) use crate::common::farm::{Broker, LEASE, Node, free_port, wait_until};
use crate::common::service::{Answer, PROGRAM, Service};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::thread;

/// A farm without nodes: a broker, a store, and a front.
pub(crate) struct Farm {
    pub(crate) front: Service,
    pub(crate) store: tempfile::TempDir,
    pub(crate) broker: Broker,
}

impl Farm {
    /// Starts it; none where there is no server.
    pub(crate) fn start(flags: &[&str]) -> Option<Self> {
        let broker = Broker::start()?;
        let store = tempfile::tempdir().unwrap();
        let (url, folder) = (broker.url(), store.path().to_str().unwrap().to_owned());
        let farm = ["--farm", &url, "--store", &folder, "--farm-lease", LEASE, "--threads", "1"];
        let front = Service::start(&[&farm, flags].concat());
        Some(Self { front, store, broker })
    }

    /// A node with one slot.
    pub(crate) fn node(&self, name: &str) -> Node {
        Node::start(&self.broker.url(), self.store.path().to_str().unwrap(), name, &[])
    }

    /// What nodes say of themselves.
    pub(crate) fn nodes(&self) -> Vec<String> {
        self.broker.ask(async |broker| {
            let bucket = broker.get_key_value("farm_nodes").await.unwrap();
            futures_util::TryStreamExt::try_collect(bucket.keys().await.unwrap()).await.unwrap()
        })
    }

    /// Submits a job of a scene, with other members of its JSON; its id.
    pub(crate) fn submit(&self, members: &str, scene: &str) -> String {
        let answer = self.front.post_json("/v1/jobs", &job(members, scene));
        assert_eq!(answer.status, 202, "{}", answer.text());
        answer.json()["id"].as_str().expect("an id").to_owned()
    }

    pub(crate) fn job(&self, id: &str) -> Value {
        self.front.get(&format!("/v1/jobs/{id}")).json()
    }

    /// Waits until a part of a job's tiles is done.
    pub(crate) fn wait_for_share(&self, id: &str, share: f64) {
        wait_until(&format!("{share} of {id} is done"), || {
            let job = self.job(id);
            assert!(!["failed", "canceled"].contains(&job["state"].as_str().unwrap()), "{job}");
            let progress = &job["progress"];
            let [done, total] = ["tiles_done", "tiles_total"].map(|key| progress[key].as_f64().unwrap_or(0.0));
            job["state"] == "succeeded" || (total > 0.0 && done / total >= share)
        });
    }

    /// Waits until it has ended; how.
    pub(crate) fn wait(&self, id: &str) -> String {
        let mut state = String::new();
        wait_until(&format!("{id} ends"), || {
            state = self.job(id)["state"].as_str().unwrap().to_owned();
            !["queued", "running"].contains(&state.as_str())
        });
        state
    }

    /// The picture of a job that succeeds.
    pub(crate) fn picture(&self, id: &str) -> Answer {
        assert_eq!(self.wait(id), "succeeded", "{}\n{}", self.job(id), self.front.log());
        let answer = self.front.get(&format!("/v1/jobs/{id}/image"));
        assert_eq!(answer.status, 200, "{}", answer.text());
        answer
    }
}

/// A job as JSON.
pub(crate) fn job(members: &str, scene: &str) -> String {
    let comma = if members.is_empty() { "" } else { ", " };
    format!("{{ \"scene\": {scene}{comma}{members} }}")
}

/// A new key of a tenant in a file of keys, as a header says it.
pub(crate) fn new_key(file: &Path, tenant: &str) -> String {
    let new = Command::new(PROGRAM).args(["key", "new", "--tenant", tenant, "--file"]).arg(file).output().unwrap();
    let said = String::from_utf8(new.stdout).unwrap();
    format!("Bearer {}", said.lines().find(|line| line.starts_with("rk_")).expect("a key"))
}

/// Hears what is published on a subject, from now on.
pub(crate) struct Ear {
    heard: Arc<Mutex<Vec<async_nats::Message>>>,
}

impl Ear {
    pub(crate) fn at(broker: &Broker, subject: &str) -> Self {
        let heard = Arc::<Mutex<Vec<_>>>::default();
        let (sink, url, subject) = (Arc::clone(&heard), broker.url(), subject.to_owned());
        let (ready, is_ready) = std::sync::mpsc::channel();
        thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let client = async_nats::connect(url).await.unwrap();
                let mut messages = client.subscribe(subject).await.unwrap();
                client.flush().await.unwrap();
                ready.send(()).unwrap();
                while let Some(message) = futures_util::StreamExt::next(&mut messages).await {
                    sink.lock().unwrap().push(message);
                }
            });
        });
        is_ready.recv().unwrap();
        Self { heard }
    }

    pub(crate) fn heard(&self) -> Vec<async_nats::Message> {
        self.heard.lock().unwrap().clone()
    }

    /// Waits until so many messages were heard.
    pub(crate) fn wait_for(&self, count: usize) {
        wait_until(&format!("{count} messages are heard"), || self.heard.lock().unwrap().len() >= count);
    }
}
