//! T12: users of the broker with few rights, and encrypted connections. The users are those of `strahl farm accounts`.

use crate::backends::alone;
use crate::common::BALL;
use crate::common::service::Service;
use crate::harness::{Broker, Node, job, wait_until};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::thread;

/// A broker that only knows the users of a farm, and its certificates and their secrets.
struct Guarded {
    broker: Broker,
    folder: tempfile::TempDir,
}

fn run(folder: &Path, program: &str, words: &str) -> String {
    let output = Command::new(program).args(words.split_whitespace()).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{program} {words}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A certificate for 127.0.0.1 in `NAME.crt`, signed by `NAME-ca.crt`.
fn certify(folder: &Path, name: &str) {
    let key = "-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes";
    run(
        folder,
        "openssl",
        &format!("req -x509 {key} -days 2 -subj /CN={name}-ca -keyout {name}-ca.key -out {name}-ca.crt"),
    );
    run(folder, "openssl", &format!("req {key} -subj /CN={name} -keyout {name}.key -out {name}.csr"));
    fs::write(folder.join("names"), "subjectAltName=IP:127.0.0.1\n").unwrap();
    let signed = format!("-CA {name}-ca.crt -CAkey {name}-ca.key -CAcreateserial -days 2 -extfile names");
    run(folder, "openssl", &format!("x509 -req -in {name}.csr {signed} -out {name}.crt"));
}

impl Guarded {
    fn start() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let told = run(folder.path(), env!("CARGO_BIN_EXE_strahl"), "farm accounts --node node.nk --node other.nk");
        assert_eq!(told.lines().count(), 3, "{told}");
        assert_eq!(told.lines().nth(1), Some("--farm-credentials node.nk --farm-inbox _INBOX.node"));
        certify(folder.path(), "broker");
        let path = |name: &str| folder.path().join(name).display().to_string();
        let tls = format!("tls {{ cert_file: {:?}, key_file: {:?} }}", path("broker.crt"), path("broker.key"));
        fs::write(path("broker.conf"), format!("{tls}\ninclude ./accounts.conf\n")).unwrap();
        let broker = Broker::start_with(&["-c", &path("broker.conf")])?;
        Some(Self { broker, folder })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn url(&self) -> String {
        format!("tls://127.0.0.1:{}", self.broker.port)
    }

    /// Flags of a front or a node, whose file of certificates is `ca`.
    fn flags(&self, user: &str, ca: &str) -> Vec<String> {
        let file = |name: &str| self.path(name).display().to_string();
        let (credentials, certificates, inbox) = (file(&format!("{user}.nk")), file(ca), format!("_INBOX.{user}"));
        ["--farm-credentials", &credentials, "--farm-ca", &certificates, "--farm-inbox", &inbox]
            .map(str::to_owned)
            .into()
    }

    fn store(&self) -> String {
        self.path("store").display().to_string()
    }

    fn front(&self, flags: &[String]) -> Result<Service, (Option<i32>, String)> {
        let (url, store) = (self.url(), self.store());
        let mut all = vec!["--farm", &url, "--store", &store, "--threads", "1"];
        all.extend(flags.iter().map(String::as_str));
        Service::try_start(&all)
    }

    fn node(&self) -> Node {
        let flags = self.flags("node", "broker-ca.crt");
        Node::start(&self.url(), &self.store(), "guarded", &flags.iter().map(String::as_str).collect::<Vec<_>>())
    }
}

#[test]
fn a_farm_of_users_with_few_rights_renders_over_encrypted_connections() {
    let Some(farm) = Guarded::start() else { return };
    let front = farm.front(&farm.flags("front", "broker-ca.crt")).expect("it starts");
    let node = farm.node();
    let size = r#""settings": { "width": 300, "height": 200 }"#;
    let job = front.post_json("/v1/jobs", &job(size, BALL)).header("location").to_owned();
    wait_until("the job ends", || !["queued", "running"].contains(&front.get(&job).json()["state"].as_str().unwrap()));
    assert_eq!(front.get(&job).json()["state"], "succeeded", "{}\n{}", front.log(), node.log());
    assert!(front.get(&format!("{job}/image")).body == alone(size, BALL));
    let figures = || front.get("/v1/farm").json()["farm"].clone();
    // A node says every few seconds what it has done.
    wait_until("a node says that it has rendered", || {
        let figures = figures();
        figures["done"]["tiles"].as_u64() > Some(0) && figures["busy"] == 0
    });
    assert_eq!(figures()["nodes"]["ready"], 1);
    assert_eq!(figures()["trouble"]["broker_errors"], 0, "{}", front.log());
    assert_eq!(figures()["backlog_seconds"]["norm"].to_string(), "0.0");
    for log in [front.log(), node.log()] {
        assert!(!log.contains("refused"), "a right is missing:\n{log}");
    }
}

#[test]
fn nodes_cannot_hand_out_work_or_hear_what_is_not_theirs() {
    let Some(farm) = Guarded::start() else { return };
    let front = farm.front(&farm.flags("front", "broker-ca.crt")).expect("it starts");
    let published = [
        "farm.t.norm.x.y.z",
        "farm.ev.x",
        "farm.ctl.cancel.x",
        "farm.front.x",
        "$JS.API.STREAM.PURGE.FARM_T",
        "$JS.API.STREAM.PURGE.FARM_R",
        "$JS.API.STREAM.DELETE.FARM_T",
        "$JS.API.STREAM.CREATE.MINE",
        "$JS.API.CONSUMER.CREATE.FARM_R",
        "$JS.API.STREAM.MSG.GET.FARM_T",
        "$JS.API.STREAM.MSG.GET.KV_farm_jobs",
        "$JS.API.DIRECT.GET.KV_farm_jobs.a.b",
        "$JS.API.DIRECT.GET.KV_farm_secrets.capabilities",
        "$KV.farm_jobs.a.b",
        "_INBOX.front.x",
    ];
    let heard = ["_INBOX.>", "_INBOX.front.>", "_INBOX.other.>", "farm.t.>", "farm.r.>", ">"];
    let refusals = Arc::<Mutex<Vec<String>>>::default();
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
    let seed = fs::read_to_string(farm.path("node.nk")).unwrap().trim().to_owned();
    let sink = Arc::clone(&refusals);
    let (_subscriptions, _client) = runtime.block_on(async {
        let client = async_nats::ConnectOptions::with_nkey(seed)
            .add_root_certificates(farm.path("broker-ca.crt"))
            .event_callback(move |event| {
                sink.lock().unwrap().push(event.to_string());
                std::future::ready(())
            })
            .connect(farm.url())
            .await
            .unwrap();
        let mut subscriptions = Vec::new();
        for subject in published {
            client.publish(subject, "{}".into()).await.unwrap();
        }
        for subject in heard {
            subscriptions.push(client.subscribe(subject).await.unwrap());
        }
        client.flush().await.unwrap();
        (subscriptions, client)
    });
    for (kind, subject) in published.map(|s| ("publish", s)).into_iter().chain(heard.map(|s| ("subscription", s))) {
        let wanted = format!("permissions violation for {kind} to \"{subject}\"");
        wait_until(&wanted, || {
            refusals.lock().unwrap().iter().any(|said| said.to_lowercase().contains(&wanted.to_lowercase()))
        });
    }
    // The streams are still there, with nothing in them.
    let job = front.post_json("/v1/jobs", &job("", BALL)).header("location").to_owned();
    let node = farm.node();
    wait_until("the job ends", || front.get(&job).json()["state"] == "succeeded");
    drop(node);
}

#[test]
fn strangers_and_brokers_with_other_certificates_are_refused() {
    let Some(farm) = Guarded::start() else { return };
    certify(farm.folder.path(), "stranger");
    let ca = farm.path("broker-ca.crt").display().to_string();
    let attempts = [
        ("another certificate", farm.flags("front", "stranger-ca.crt"), "--farm-ca"),
        ("nobody", vec!["--farm-ca".into(), ca], "--farm-credentials"),
        // A node cannot be a front: it may not make streams.
        ("a node", farm.flags("node", "broker-ca.crt"), "farm accounts"),
    ];
    // All at one time, since each tries for some seconds.
    let farm = &farm;
    thread::scope(|scope| {
        for (who, flags, advice) in &attempts {
            scope.spawn(move || {
                let (code, said) = farm.front(flags).map(|_| ()).expect_err(who);
                assert!(code == Some(1) && said.contains(advice), "{who}: {code:?} {said}");
            });
        }
    });
}

#[test]
fn secrets_stay_when_the_command_is_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let strahl = |words: &str| run(folder.path(), env!("CARGO_BIN_EXE_strahl"), words);
    strahl("farm accounts");
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let (front, node, users) = (read("front.nk"), read("node.nk"), read("accounts.conf"));
    assert!(front.starts_with("SU") && node.starts_with("SU") && front != node);
    assert!(!users.contains(front.trim()) && !users.contains(node.trim()), "no secret is in the broker's file");
    #[cfg(unix)]
    for secret in ["front.nk", "node.nk"] {
        let mode =
            std::os::unix::fs::PermissionsExt::mode(&fs::metadata(folder.path().join(secret)).unwrap().permissions());
        assert_eq!(mode & 0o777, 0o600, "{secret}");
    }
    strahl("farm accounts --node node.nk --node more.nk");
    assert_eq!((read("front.nk"), read("node.nk")), (front, node));
    assert!(read("accounts.conf").len() > users.len() && read("more.nk").starts_with("SU"));
    let twice = Command::new(env!("CARGO_BIN_EXE_strahl"))
        .args("farm accounts --front a/x.nk --node b/x.nk".split(' '))
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(twice.status.code(), Some(1), "there is no folder a");
    fs::create_dir_all(folder.path().join("a")).unwrap();
    fs::create_dir_all(folder.path().join("b")).unwrap();
    let twice = Command::new(env!("CARGO_BIN_EXE_strahl"))
        .args("farm accounts --front a/x.nk --node b/x.nk".split(' '))
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(twice.status.code() == Some(2) && String::from_utf8_lossy(&twice.stderr).contains("names of their own"));
}
