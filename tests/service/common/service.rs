//! The real binary on a free port, and a client of plain sockets that sees every byte.

use super::farm::TestFarm;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// The program that is tested.
pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_strahl");

/// How long tests wait for what should come to pass: only what never comes may fail, also on a machine that does much else.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);
/// Flag of services whose requests end by themselves long after that, so that what was not cancelled is seen.
pub(crate) const NO_TIMEOUT: [&str; 2] = ["--timeout", "600"];

/// A running service; it ends with its owner.
pub(crate) struct Service {
    child: Child,
    pub(crate) address: SocketAddr,
    log: Arc<Mutex<String>>,
    first: String,
    /// Who renders for it, if the tests want it.
    farm: Option<TestFarm>,
}

impl Service {
    pub(crate) fn start(flags: &[&str]) -> Self {
        Self::start_in(Path::new("."), flags)
    }

    /// Starts it in a folder, from which it sees files.
    pub(crate) fn start_in(folder: &Path, flags: &[&str]) -> Self {
        Self::try_start_in(folder, flags).unwrap_or_else(|(code, said)| panic!("it ends with {code:?}:\n{said}"))
    }

    /// Starts it, or gives the exit code with which it ends and what it says.
    pub(crate) fn try_start(flags: &[&str]) -> Result<Self, (Option<i32>, String)> {
        Self::try_start_in(Path::new("."), flags)
    }

    fn try_start_in(folder: &Path, flags: &[&str]) -> Result<Self, (Option<i32>, String)> {
        let Some(farm) = TestFarm::wanted(flags) else {
            return Self::try_start_program(Path::new(PROGRAM), folder, flags);
        };
        let of_farm = farm.flags();
        let all: Vec<&str> = flags.iter().copied().chain(of_farm.iter().map(String::as_str)).collect();
        let mut service = Self::try_start_program(Path::new(PROGRAM), folder, &all)?;
        service.farm = Some(farm.with_node());
        Ok(service)
    }

    /// Starts it with a folder for temporary files.
    pub(crate) fn start_with_temporary(folder: &Path, flags: &[&str]) -> Self {
        let mut program = Command::new(PROGRAM);
        program.env("TMPDIR", folder);
        Self::try_start_command(program, flags).unwrap_or_else(|(code, said)| panic!("it ends with {code:?}:\n{said}"))
    }

    /// Starts another program, or gives the exit code with which it ends and what it says.
    pub(crate) fn try_start_program(
        program: &Path,
        folder: &Path,
        flags: &[&str],
    ) -> Result<Self, (Option<i32>, String)> {
        let mut program = Command::new(program);
        program.current_dir(folder);
        Self::try_start_command(program, flags)
    }

    /// Starts a program with the environment that it was given, or gives the exit code with which it ends and what it says.
    pub(crate) fn try_start_command(mut program: Command, flags: &[&str]) -> Result<Self, (Option<i32>, String)> {
        // What is slow on a slow machine is not wrong.
        let has_own = flags.iter().any(|flag| ["--timeout", "--config"].contains(flag));
        let patient = if has_own { &[][..] } else { &NO_TIMEOUT[..] };
        let mut child = program
            .args(["serve", "--listen", "127.0.0.1:0"])
            .args(patient)
            .args(flags)
            .env_remove("STRAHL_LOG")
            .stdin(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary starts");
        let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines().map_while(Result::ok);
        let (mut said, mut listeners) = (String::new(), Vec::<String>::new());
        // Operators' listener is announced before that for clients.
        while listeners.last().is_none_or(|line| line.contains("admin")) {
            let Some(line) = lines.next() else { return Err((child.wait().expect("it ends").code(), said)) };
            said += &format!("{line}\n");
            if line.contains("listening on http://") {
                listeners.push(line);
            }
        }
        let address = address_in(&listeners[listeners.len() - 1]).expect("an address");
        let log = Arc::new(Mutex::new(said));
        let sink = Arc::clone(&log);
        thread::spawn(move || {
            for line in lines {
                sink.lock().unwrap().push_str(&(line + "\n"));
            }
        });
        Ok(Self { child, address, log, first: listeners.swap_remove(0), farm: None })
    }

    pub(crate) fn pid(&self) -> u32 {
        self.child.id()
    }

    /// The first line about a listener.
    pub(crate) fn said_first(&self) -> &str {
        &self.first
    }

    pub(crate) fn log(&self) -> String {
        self.log.lock().unwrap().clone()
    }

    /// Waits for a line of the log, which comes through a pipe and may be a little later than the answer.
    pub(crate) fn wait_for_log(&self, part: &str) {
        let started = Instant::now();
        while !self.log().contains(part) {
            assert!(started.elapsed() < PATIENCE, "{part} is not in the log:\n{}", self.log());
            thread::sleep(Duration::from_millis(2));
        }
    }

    pub(crate) fn terminate(&self) {
        self.signal("-TERM");
    }

    /// Sends a signal, as `kill` names it.
    pub(crate) fn signal(&self, signal: &str) {
        let sent = Command::new("kill").args([signal, &self.child.id().to_string()]).status().expect("kill runs");
        assert!(sent.success());
    }

    /// Waits for the process to end by itself.
    pub(crate) fn ended(&mut self) -> ExitStatus {
        let started = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("it can be waited for") {
                return status;
            }
            assert!(started.elapsed() < PATIENCE, "the service does not end; its log:\n{}", self.log());
            thread::sleep(Duration::from_millis(10));
        }
    }

    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).expect("it accepts connections");
        stream.set_read_timeout(Some(2 * PATIENCE)).unwrap();
        stream
    }

    pub(crate) fn get(&self, path: &str) -> Answer {
        self.send("GET", path, &[], b"")
    }

    pub(crate) fn post_json(&self, path: &str, json: &str) -> Answer {
        self.send("POST", path, &[("Content-Type", "application/json")], json.as_bytes())
    }

    pub(crate) fn send(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
        let mut stream = self.connect();
        stream.write_all(&request(method, path, headers, body)).expect("the request is taken");
        Answer::read(stream)
    }

    /// Starts a request and does not wait for its answer.
    pub(crate) fn begin(&self, path: &str, json: &str) -> TcpStream {
        self.begin_with(path, &[], json)
    }

    /// The same with headers.
    pub(crate) fn begin_with(&self, path: &str, headers: &[(&str, &str)], json: &str) -> TcpStream {
        let mut stream = self.connect();
        let headers = [&[("Content-Type", "application/json")], headers].concat();
        stream.write_all(&request("POST", path, &headers, json.as_bytes())).expect("the request is taken");
        stream
    }

    /// Waits until so many jobs run or wait.
    pub(crate) fn wait_for_all(&self, jobs: u64) {
        let started = Instant::now();
        loop {
            let ready = self.get("/readyz").json();
            if ready["running"].as_u64().zip(ready["waiting"].as_u64()).is_some_and(|(a, b)| a + b == jobs) {
                return;
            }
            assert!(started.elapsed() < PATIENCE, "{jobs} jobs never come: {ready}");
            thread::sleep(Duration::from_millis(2));
        }
    }

    /// Waits until so many jobs run and wait.
    pub(crate) fn wait_for(&self, running: u64, waiting: u64) {
        let started = Instant::now();
        loop {
            let ready = self.get("/readyz").json();
            if ready["running"] == running && ready["waiting"] == waiting {
                return;
            }
            assert!(started.elapsed() < PATIENCE, "{running}/{waiting} never comes: {ready}");
            thread::sleep(Duration::from_millis(2));
        }
    }
}

/// The address in a line about a listener, which may be JSON.
pub(crate) fn address_in(line: &str) -> Option<SocketAddr> {
    line.rsplit("http://").next()?.split('"').next()?.trim().parse().ok()
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub(crate) fn request(method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Vec<u8> {
    let mut text = format!("{method} {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n");
    for (name, value) in headers {
        text += &format!("{name}: {value}\r\n");
    }
    if method != "GET" {
        text += &format!("Content-Length: {}\r\n", body.len());
    }
    [text.as_bytes(), b"\r\n", body].concat()
}

/// An answer, taken apart.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) headers: Vec<(String, String)>,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    pub(crate) fn read(mut stream: TcpStream) -> Self {
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).expect("an answer comes");
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").expect("the headers end");
        let head = String::from_utf8(bytes[..end].to_vec()).expect("headers are text");
        let mut lines = head.split("\r\n");
        let status =
            lines.next().and_then(|line| line.split(' ').nth(1)).and_then(|s| s.parse().ok()).expect("a status");
        let headers =
            lines.filter_map(|line| line.split_once(": ")).map(|(k, v)| (k.to_lowercase(), v.into())).collect();
        Self { status, headers, body: bytes[end + 4..].to_vec() }
    }

    pub(crate) fn header(&self, name: &str) -> &str {
        self.headers.iter().find(|(known, _)| known == name).map_or("", |(_, value)| value)
    }

    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|_| panic!("not JSON: {}", self.text()))
    }

    pub(crate) fn picture(&self) -> image::DynamicImage {
        assert_eq!((self.status, self.header("content-type")), (200, "image/png"), "{}", self.text());
        image::load_from_memory(&self.body).expect("a PNG")
    }

    /// Checks that this is a problem as RFC 9457 wants it.
    pub(crate) fn problem(&self, status: u16, slug: &str) -> Value {
        assert_eq!(self.status, status, "{}", self.text());
        assert_eq!(self.header("content-type"), "application/problem+json");
        assert_eq!(self.header("cache-control"), "no-store");
        let problem = self.json();
        assert_eq!(problem["type"], format!("/problems/{slug}"), "{problem}");
        assert_eq!(problem["status"], status);
        assert_eq!(problem["instance"], self.header("x-request-id"));
        assert!(problem["detail"].as_str().is_some_and(|detail| !detail.is_empty()), "{problem}");
        problem
    }
}
