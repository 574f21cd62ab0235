//! Brokers, nodes and fronts as processes of their own.

use crate::common::service::{Answer, Service};
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(90);

/// The NATS servers that there are, the oldest version first. `.ci/run` fetches them.
fn servers() -> Vec<PathBuf> {
    if let Some(path) = std::env::var_os("STRAHL_NATS_SERVER") {
        return vec![path.into()];
    }
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/external");
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|file| file.path());
    let is_server =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("nats-server-"));
    let mut found: Vec<_> = files.filter(is_server).collect();
    found.sort();
    found
}

/// A NATS server with a folder of its own.
pub(crate) struct Broker {
    program: PathBuf,
    folder: tempfile::TempDir,
    child: Option<Child>,
    pub(crate) port: u16,
    flags: Vec<String>,
}

impl Broker {
    /// Starts one; none, with the reason printed, where there is no server.
    pub(crate) fn start() -> Option<Self> {
        Self::start_with(&[])
    }

    #[expect(clippy::print_stdout, reason = "whoever runs the tests should know")]
    pub(crate) fn start_with(flags: &[&str]) -> Option<Self> {
        let Some(program) = servers().first().cloned() else {
            println!("SKIPPED: no nats-server; name one with STRAHL_NATS_SERVER, or let .ci/run fetch it");
            return None;
        };
        let port = free_port();
        let flags = flags.iter().map(|flag| (*flag).to_owned()).collect();
        let mut broker = Self { program, folder: tempfile::tempdir().unwrap(), child: None, port, flags };
        broker.restart();
        Some(broker)
    }

    /// Starts it on what it has kept.
    pub(crate) fn restart(&mut self) {
        let child = Command::new(&self.program)
            .args(["-a", "127.0.0.1", "-p", &self.port.to_string(), "-js", "-sd"])
            .arg(self.folder.path())
            .args(&self.flags)
            .stderr(Stdio::null())
            .spawn()
            .expect("nats-server starts");
        self.child = Some(child);
        wait_until("the broker listens", || TcpStream::connect(("127.0.0.1", self.port)).is_ok());
    }

    /// Ends it like a power cut of its machine, as far as a process can.
    pub(crate) fn kill(&mut self) {
        if let Some(mut child) = self.child.take() {
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }

    pub(crate) fn url(&self) -> String {
        format!("nats://127.0.0.1:{}", self.port)
    }

    /// What a test asks the broker itself.
    pub(crate) fn ask<T>(&self, question: impl AsyncFnOnce(async_nats::jetstream::Context) -> T) -> T {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let client = async_nats::connect(self.url()).await.expect("the broker answers");
            question(async_nats::jetstream::new(client)).await
        })
    }

    /// Messages that a stream has.
    pub(crate) fn messages(&self, stream: &str) -> u64 {
        self.ask(async |broker| broker.get_stream(stream).await.unwrap().cached_info().state.messages)
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        self.kill();
    }
}

/// A farm without nodes: a broker, a store, and a front.
pub(crate) struct Farm {
    pub(crate) front: Service,
    pub(crate) store: tempfile::TempDir,
    pub(crate) broker: Broker,
}

/// How long brokers of tests wait for a piece.
pub(crate) const LEASE: &str = "2";

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

/// A node.
pub(crate) struct Node {
    child: Child,
    log: Arc<Mutex<String>>,
}

impl Node {
    pub(crate) fn start(url: &str, store: &str, name: &str, flags: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_strahl"))
            .args(["node", "--farm", url, "--store", store, "--slots", "1", "--name", name])
            .args(flags)
            .env_remove("STRAHL_LOG")
            .stderr(Stdio::piped())
            .spawn()
            .expect("the node starts");
        let lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
        let log = Arc::new(Mutex::new(String::new()));
        let sink = Arc::clone(&log);
        thread::spawn(move || lines.for_each(|line| sink.lock().unwrap().push_str(&(line + "\n"))));
        let node = Self { child, log };
        wait_until("a node is ready", || node.log().contains("ready for work"));
        node
    }

    pub(crate) fn log(&self) -> String {
        self.log.lock().unwrap().clone()
    }

    /// Sends a signal, as `kill` names it.
    pub(crate) fn signal(&self, signal: &str) {
        assert!(Command::new("kill").args([signal, &self.child.id().to_string()]).status().unwrap().success());
    }

    /// Ends it at once.
    pub(crate) fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Waits for it to end by itself; the exit code.
    pub(crate) fn ended(&mut self) -> Option<i32> {
        let mut code = None;
        wait_until("a node ends", || match self.child.try_wait().unwrap() {
            Some(status) => {
                code = status.code();
                true
            }
            None => false,
        });
        code
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Waits until something is so.
pub(crate) fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let began = Instant::now();
    while !is_so() {
        assert!(began.elapsed() < PATIENCE, "it takes too long until {what}");
        thread::sleep(Duration::from_millis(10));
    }
}

/// A port that nobody has now.
pub(crate) fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
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
