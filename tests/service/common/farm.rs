//! Brokers and nodes as processes of their own. Tests of the service run against a farm of one node each if `STRAHL_TEST_FARM` is
//! set: what is promised of jobs holds whoever renders their tiles.

use super::service::PROGRAM;
use std::fs;
use std::io::{BufRead, BufReader};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(90);

/// The oldest NATS server that there is. `.ci/run` fetches some.
fn server() -> Option<PathBuf> {
    std::env::var_os("STRAHL_NATS_SERVER").map(PathBuf::from).or_else(|| fetched("nats-server-"))
}

/// The first program whose name begins like this.
fn fetched(name: &str) -> Option<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/external");
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|file| file.path());
    let is_it = |path: &PathBuf| path.file_name().is_some_and(|file| file.to_string_lossy().starts_with(name));
    files.filter(is_it).min()
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

    pub(crate) fn start_with(flags: &[&str]) -> Option<Self> {
        Self::start_program(server(), flags)
    }

    /// Starts one that is too old.
    pub(crate) fn start_old() -> Option<Self> {
        Self::start_program(fetched("refused-nats-server-"), &[])
    }

    #[expect(clippy::print_stdout, reason = "whoever runs the tests should know")]
    fn start_program(program: Option<PathBuf>, flags: &[&str]) -> Option<Self> {
        let Some(program) = program else {
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

    /// Messages that a stream has. A cluster that chooses a leader answers a moment later.
    pub(crate) fn messages(&self, stream: &str) -> u64 {
        self.ask(async |broker| {
            let started = Instant::now();
            loop {
                match broker.get_stream(stream).await {
                    Ok(stream) => break stream.cached_info().state.messages,
                    Err(error) => assert!(started.elapsed() < Duration::from_secs(60), "{stream}: {error}"),
                }
                tokio::time::sleep(Duration::from_millis(100)).await;
            }
        })
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        self.kill();
    }
}

/// How long brokers of tests wait for a piece.
pub(crate) const LEASE: &str = "2";

/// A node.
pub(crate) struct Node {
    child: Child,
    log: Arc<Mutex<String>>,
}

impl Node {
    pub(crate) fn start(url: &str, store: &str, name: &str, flags: &[&str]) -> Self {
        Self::start_program(Path::new(PROGRAM), url, store, name, flags)
    }

    pub(crate) fn start_program(program: &Path, url: &str, store: &str, name: &str, flags: &[&str]) -> Self {
        let mut child = Command::new(program)
            .args(["node", "--farm", url, "--store", store, "--name", name])
            .args(if flags.contains(&"--slots") { &[][..] } else { &["--slots", "1"] })
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

/// A farm of one node for one service.
pub(crate) struct TestFarm {
    node: Option<Node>,
    store: tempfile::TempDir,
    broker: Broker,
}

impl TestFarm {
    /// Whether services of tests have farms, unless their flags say otherwise.
    pub(crate) fn is_wanted() -> bool {
        std::env::var_os("STRAHL_TEST_FARM").is_some()
    }

    /// One, if whoever runs the tests wants it and the flags do not say otherwise.
    pub(crate) fn wanted(flags: &[&str]) -> Option<Self> {
        let others = ["--farm", "--data", "--keep-images"];
        if !Self::is_wanted() || flags.iter().any(|flag| others.contains(flag)) {
            return None;
        }
        Some(Self { node: None, store: tempfile::tempdir().unwrap(), broker: Broker::start()? })
    }

    pub(crate) fn flags(&self) -> Vec<String> {
        let store = self.store.path().to_str().unwrap().to_owned();
        ["--farm", &self.broker.url(), "--store", &store, "--farm-lease", LEASE].map(str::to_owned).into()
    }

    /// With its node, which may join when the front has set the broker up.
    pub(crate) fn with_node(mut self) -> Self {
        self.node = Some(Node::start(&self.broker.url(), self.store.path().to_str().unwrap(), "node", &[]));
        self
    }
}
