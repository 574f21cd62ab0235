//! One suite for both kinds of stores: a folder, and an S3 server that runs here (`moto_server` of the package `moto[server]`).

use super::*;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// What both stores do.
async fn keeps_its_promises(objects: &Objects) {
    let digest = data_encoding::HEXLOWER.encode(&Sha256::digest(b"scene"));
    let named = format!("scenes/{digest}.json");
    assert_eq!(objects.get(&named, 100).await, Ok(None));
    assert_eq!(objects.exists(&named).await, Ok(false));
    assert_eq!(objects.put_if_absent(&named, b"scene".to_vec()).await, Ok(true));
    assert_eq!(objects.put_if_absent(&named, b"other".to_vec()).await, Ok(false), "the first one stays");
    assert_eq!(objects.get(&named, 5).await, Ok(Some(b"scene".to_vec())));
    assert_eq!(objects.exists(&named).await, Ok(true));
    assert_eq!(objects.get(&named, 4).await, Err(ObjectError::TooLarge { bytes: 5, max: 4 }));

    objects.put(&named, b"spoilt".to_vec()).await.unwrap();
    assert_eq!(objects.get(&named, 100).await, Err(ObjectError::Damaged(named.clone())));
    objects.delete(&named).await.unwrap();
    objects.delete(&named).await.unwrap();
    assert_eq!(objects.exists(&named).await, Ok(false));

    objects.put("renders/other/00.png", vec![1; 3 << 20]).await.unwrap();
    assert_eq!(objects.get("renders/other/00.png", 3 << 20).await.unwrap().unwrap(), vec![1; 3 << 20]);

    for name in ["", "/a", "a/", "a//b", "../a", "a/../b", "a/./b", "a b", "a#1", "ü", "a\\b", "a%2e", &"a".repeat(513)]
    {
        assert!(matches!(objects.put(name, vec![]).await, Err(ObjectError::Name(_))), "{name}");
        assert!(matches!(objects.get(name, 1).await, Err(ObjectError::Name(_))), "{name}");
    }
}

#[tokio::test]
async fn a_folder_keeps_blobs() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("new/store");
    let objects = Objects::open(place.to_str().unwrap()).await.unwrap();
    keeps_its_promises(&objects).await;
    assert!(objects.url("a/b.png").starts_with("file:///") && objects.url("a/b.png").ends_with("/new/store/a/b.png"));

    objects.put("again", b"there".to_vec()).await.unwrap();
    let objects = Objects::open(place.to_str().unwrap()).await.unwrap();
    assert_eq!(objects.get("again", 10).await, Ok(Some(b"there".to_vec())));
}

#[tokio::test]
async fn of_two_who_write_at_once_one_is_first() {
    let folder = tempfile::tempdir().unwrap();
    let objects = Objects::open(folder.path().to_str().unwrap()).await.unwrap();
    for round in 0..50 {
        let name = format!("r/{round}");
        let (a, b) = tokio::join!(
            objects.put_if_absent(&name, vec![b'a'; 100_000]),
            objects.put_if_absent(&name, vec![b'b'; 100_000])
        );
        assert!(a.clone().unwrap() != b.unwrap());
        let winner = if a.unwrap() { b'a' } else { b'b' };
        assert_eq!(objects.get(&name, 100_000).await.unwrap().unwrap(), vec![winner; 100_000]);
    }
}

#[tokio::test]
async fn what_is_no_store_is_refused_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let error = refusal(Objects::open(file.to_str().unwrap()).await);
    assert!(error.contains("name another with --store DIR"), "{error}");

    std::fs::write(folder.path().join(MARKER), "{\"v\":2}").unwrap();
    let error = refusal(Objects::open(folder.path().to_str().unwrap()).await);
    assert!(error.contains("of another version"), "{error}");

    for (place, why) in [
        ("gs://bucket", "name a folder or s3://BUCKET/PREFIX"),
        ("s3://", "there is no bucket"),
        ("s3://bucket/../other", "is no name for a blob"),
    ] {
        let error = refusal(Objects::open(place).await);
        assert!(error.contains(why), "{error}");
    }
    let plain = [("AWS_ENDPOINT_URL".to_owned(), "http://127.0.0.1:1".to_owned())];
    let error = refusal(Objects::open_in("s3://bucket", plain.into_iter()).await);
    assert!(error.contains("AWS_ALLOW_HTTP=true"), "{error}");
}

fn refusal(opened: Result<Objects, StartError>) -> String {
    match opened {
        Ok(objects) => panic!("{objects:?} was opened"),
        Err(StartError::Settings(why) | StartError::Machine(why)) => why,
    }
}

#[tokio::test]
async fn a_bucket_keeps_blobs() {
    let Some(server) = Server::start(&[]) else { return };
    server.make_bucket("farm");
    let place = "s3://farm/strahl/store/";
    let objects = Objects::open_in(place, server.environment()).await.unwrap();
    keeps_its_promises(&objects).await;
    assert_eq!(objects.url("a/b.png"), "s3://farm/strahl/store/a/b.png");
    let whole = Objects::open_in("s3://farm", server.environment()).await.unwrap();
    assert_eq!(whole.exists("strahl/store/renders/other/00.png").await, Ok(true), "a prefix is part of names");

    let error = refusal(Objects::open_in("s3://other", server.environment()).await);
    assert!(error.contains("There is no such bucket"), "{error}");
}

#[tokio::test]
async fn keys_that_may_not_write_are_refused_at_the_start() {
    // All but the first request are checked.
    let Some(server) = Server::start(&[("INITIAL_NO_AUTH_ACTION_COUNT", "1")]) else { return };
    server.make_bucket("farm");
    let error = refusal(Objects::open_in("s3://farm", server.environment()).await);
    assert!(error.contains("must be allowed to get, put and delete"), "{error}");
}

/// A server of S3 in memory.
struct Server {
    process: Child,
    port: u16,
}

impl Server {
    /// Starts it, or says why that is not possible.
    fn start(settings: &[(&str, &str)]) -> Option<Self> {
        let installed = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/target/external/moto/bin/moto_server"));
        let program = std::env::var_os("STRAHL_MOTO_SERVER").map_or_else(installed, PathBuf::from);
        if !program.is_file() {
            println!("skipped: there is no S3 server: install moto[server] and name moto_server in STRAHL_MOTO_SERVER");
            return None;
        }
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let process = Command::new(program)
            .args(["-H", "127.0.0.1", "-p", &port.to_string()])
            .envs(settings.iter().copied())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let server = Self { process, port };
        let answers = (0..600).any(|_| {
            std::thread::sleep(Duration::from_millis(100));
            TcpStream::connect(("127.0.0.1", port)).is_ok()
        });
        assert!(answers, "moto_server does not listen");
        Some(server)
    }

    fn environment(&self) -> impl Iterator<Item = (String, String)> {
        let port = self.port;
        let endpoint = format!("http://127.0.0.1:{port}");
        [
            ("AWS_ENDPOINT_URL", endpoint.as_str()),
            ("AWS_ALLOW_HTTP", "true"),
            ("AWS_REGION", "us-east-1"),
            ("AWS_ACCESS_KEY_ID", "key"),
            ("AWS_SECRET_ACCESS_KEY", "secret"),
        ]
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .into_iter()
    }

    fn make_bucket(&self, name: &str) {
        let mut socket = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        write!(socket, "PUT /{name} HTTP/1.0\r\nHost: 127.0.0.1\r\nContent-Length: 0\r\n\r\n").unwrap();
        let mut answer = String::new();
        socket.read_to_string(&mut answer).unwrap();
        assert!(answer.contains(" 200 "), "{answer}");
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
