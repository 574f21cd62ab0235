//! A receiver of webhooks, and the secret that it shares with the service.

use data_encoding::BASE64;
use hmac::{Hmac, KeyInit, Mac};
use serde_json::Value;
use sha2::Sha256;
use std::collections::VecDeque;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// A message as it arrived.
#[derive(Debug, Clone)]
pub(crate) struct Message {
    pub(crate) head: String,
    pub(crate) body: String,
}

impl Message {
    pub(crate) fn header(&self, name: &str) -> &str {
        let line = self.head.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
        line.unwrap_or_else(|| panic!("{name} in {}", self.head))
    }

    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap()
    }

    /// Verifies the signature as Standard Webhooks says.
    pub(crate) fn is_signed_with(&self, secret: &str) -> bool {
        let (id, time) = (self.header("webhook-id"), self.header("webhook-timestamp"));
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs();
        let key = BASE64.decode(secret.strip_prefix("whsec_").unwrap().as_bytes()).unwrap();
        let mac = Hmac::<Sha256>::new_from_slice(&key).unwrap().chain_update(format!("{id}.{time}.{}", self.body));
        let tag = self.header("webhook-signature").strip_prefix("v1,").unwrap();
        now.abs_diff(time.parse().unwrap()) < 120 && mac.verify_slice(&BASE64.decode(tag.as_bytes()).unwrap()).is_ok()
    }
}

/// A receiver that gives these answers one after the other, and the last one from then on. It never answers an empty one.
pub(crate) struct Receiver {
    pub(crate) port: u16,
    seen: Arc<Mutex<Vec<Message>>>,
}

impl Receiver {
    pub(crate) fn start(answers: &[&str]) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let (port, seen) = (listener.local_addr().unwrap().port(), Arc::<Mutex<Vec<Message>>>::default());
        let answers = Arc::new(Mutex::new(answers.iter().map(|answer| (*answer).to_owned()).collect::<VecDeque<_>>()));
        let messages = Arc::clone(&seen);
        thread::spawn(move || {
            for socket in listener.incoming().map_while(Result::ok) {
                let (answers, messages) = (Arc::clone(&answers), Arc::clone(&messages));
                thread::spawn(move || receive(socket, &answers, &messages));
            }
        });
        Self { port, seen }
    }

    pub(crate) fn url(&self) -> String {
        format!("http://127.0.0.1:{}/hook", self.port)
    }

    pub(crate) fn seen(&self) -> Vec<Message> {
        self.seen.lock().unwrap().clone()
    }

    pub(crate) fn wait_for(&self, messages: usize) -> Vec<Message> {
        let started = Instant::now();
        while self.seen().len() < messages {
            assert!(started.elapsed() < Duration::from_secs(60), "{messages} messages do not come: {:?}", self.seen());
            thread::sleep(Duration::from_millis(5));
        }
        self.seen()
    }
}

fn receive(mut socket: TcpStream, answers: &Mutex<VecDeque<String>>, messages: &Mutex<Vec<Message>>) {
    let mut bytes = Vec::new();
    let (head, length) = loop {
        let mut some = [0; 4_096];
        match socket.read(&mut some) {
            Ok(0) | Err(_) => return,
            Ok(read) => bytes.extend(&some[..read]),
        }
        let Some(end) = bytes.windows(4).position(|four| four == b"\r\n\r\n") else { continue };
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        let length =
            head.lines().find_map(|line| line.strip_prefix("content-length: ")).unwrap().parse::<usize>().unwrap();
        if bytes.len() >= end + 4 + length {
            break (head, length);
        }
    };
    let body = String::from_utf8(bytes[bytes.len() - length..].to_vec()).unwrap();
    let answer = {
        let mut answers = answers.lock().unwrap();
        if answers.len() > 1 { answers.pop_front().unwrap() } else { answers[0].clone() }
    };
    messages.lock().unwrap().push(Message { head, body });
    if answer.is_empty() {
        thread::sleep(Duration::from_secs(300));
    }
    let _ = write!(socket, "HTTP/1.1 {answer}\r\nContent-Length: 0\r\n\r\n");
}

/// A file with a secret, and the secret.
pub(crate) fn secret(folder: &tempfile::TempDir) -> (PathBuf, String) {
    let made = Command::new(env!("CARGO_BIN_EXE_strahl")).args(["key", "webhook"]).output().unwrap();
    assert!(made.status.success(), "{made:?}");
    let secret = String::from_utf8(made.stdout).unwrap();
    let file = folder.path().join("webhook.secret");
    std::fs::write(&file, &secret).unwrap();
    (file, secret.trim().to_owned())
}
