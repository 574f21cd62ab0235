//! Several fronts of one farm: whatever is asked of one of them is true at all, and none of them is needed.

use crate::backends::MIRRORS;
use crate::common::BALL;
use crate::common::service::{Answer, Service, request};
use crate::harness::{Broker, LEASE, Node, new_key, wait_until};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::thread;

/// A broker, a store, and fronts.
pub(crate) struct Fronts {
    pub(crate) fronts: Vec<Service>,
    pub(crate) store: tempfile::TempDir,
    pub(crate) broker: Broker,
    flags: Vec<String>,
}

impl Fronts {
    /// Starts so many; none where there is no server.
    pub(crate) fn start(count: usize, flags: &[&str]) -> Option<Self> {
        let broker = Broker::start()?;
        let flags = flags.iter().map(|flag| (*flag).to_owned()).collect();
        let mut farm = Self { fronts: Vec::new(), store: tempfile::tempdir().unwrap(), broker, flags };
        for _ in 0..count {
            farm.add();
        }
        Some(farm)
    }

    fn add(&mut self) {
        let (url, folder) = (self.broker.url(), self.store.path().to_str().unwrap().to_owned());
        let farm = ["--farm", &url, "--store", &folder, "--farm-lease", LEASE, "--threads", "1"];
        let flags: Vec<&str> = farm.into_iter().chain(self.flags.iter().map(String::as_str)).collect();
        self.fronts.push(Service::start(&flags));
    }

    pub(crate) fn node(&self) -> Node {
        Node::start(&self.broker.url(), self.store.path().to_str().unwrap(), "node", &[])
    }

    /// Which front works on a job.
    fn owner(&self, id: &str) -> usize {
        let mut owner = None;
        wait_until("a front works on a job", || {
            owner =
                self.fronts.iter().position(|front| front.log().contains(&format!("this front begins job=\"{id}\"")));
            owner.is_some()
        });
        owner.unwrap()
    }
}

pub(crate) fn order(scene: &str, settings: &Value) -> String {
    json!({ "scene": serde_json::from_str::<Value>(scene).unwrap(), "settings": settings }).to_string()
}

pub(crate) fn submit(front: &Service, scene: &str, settings: &Value) -> String {
    let answer = front.post_json("/v1/jobs", &order(scene, settings));
    assert_eq!(answer.status, 202, "{}", answer.text());
    id_of(&answer)
}

pub(crate) fn id_of(answer: &Answer) -> String {
    answer.json()["id"].as_str().unwrap().to_owned()
}

fn job(front: &Service, id: &str) -> Value {
    front.get(&format!("/v1/jobs/{id}")).json()
}

pub(crate) fn state(front: &Service, id: &str) -> String {
    job(front, id)["state"].as_str().unwrap_or("gone").to_owned()
}

pub(crate) fn wait_for(front: &Service, id: &str, wanted: &str) {
    wait_until(&format!("{id} is {wanted}; it is {}", job(front, id)), || state(front, id) == wanted);
}

pub(crate) fn wait_for_tiles(front: &Service, id: &str, share: f64) {
    wait_until(&format!("{share} of {id} is done"), || {
        let progress = job(front, id)["progress"].clone();
        progress["fraction"].as_f64().is_some_and(|fraction| fraction >= share)
    });
}

pub(crate) fn image(front: &Service, id: &str) -> Vec<u8> {
    let answer = front.get(&format!("/v1/jobs/{id}/image"));
    assert_eq!(answer.status, 200, "{}", answer.text());
    answer.body
}

/// The picture of a job request as one machine renders it.
fn of_one_machine(scene: &str, settings: &Value) -> Vec<u8> {
    let service = Service::start(&["--threads", "2"]);
    let id = submit(&service, scene, settings);
    wait_for(&service, &id, "succeeded");
    image(&service, &id)
}

/// Events of a job, by name and number.
struct Events(BufReader<TcpStream>);

impl Events {
    fn of(front: &Service, id: &str, last: Option<u64>) -> Self {
        let last = last.map(|last| last.to_string());
        let headers: Vec<(&str, &str)> = last.iter().map(|last| ("Last-Event-ID", last.as_str())).collect();
        let mut stream = front.connect();
        stream.write_all(&request("GET", &format!("/v1/jobs/{id}/events"), &headers, b"")).unwrap();
        Self(BufReader::new(stream))
    }

    fn next(&mut self) -> Option<(String, u64)> {
        let (mut name, mut id) = (String::new(), 0);
        loop {
            let mut line = String::new();
            if self.0.read_line(&mut line).unwrap_or(0) == 0 {
                return None;
            }
            match line.trim().split_once(": ") {
                Some(("event", value)) => name = value.to_owned(),
                Some(("id", value)) => id = value.parse().unwrap(),
                _ if line.trim().is_empty() && !name.is_empty() => return Some((name, id)),
                _ => {}
            }
        }
    }

    fn all(mut self) -> Vec<(String, u64)> {
        std::iter::from_fn(|| self.next()).collect()
    }
}

#[test]
fn any_front_answers_for_any_job() {
    let Some(farm) = Fronts::start(2, &[]) else { return };
    let [here, there] = [&farm.fronts[0], &farm.fronts[1]];
    let id = submit(here, MIRRORS, &json!({}));
    // At once: the other front has not been told, and asks.
    assert_eq!(there.get(&format!("/v1/jobs/{id}")).status, 200);
    assert_eq!(there.get("/v1/jobs").json()["jobs"][0]["id"], id.as_str());
    let watched: Vec<_> = [here, there].map(|front| Events::of(front, &id, None)).into();
    let _node = farm.node();
    wait_for_tiles(there, &id, 0.3);
    for front in [here, there] {
        let preview = front.get(&format!("/v1/jobs/{id}/preview"));
        assert_eq!(preview.picture().width(), 400, "the front that does not render it asks the one that does");
        let tile = front.get(&format!("/v1/jobs/{id}/tile?x=190&y=140&w=20&h=20"));
        assert_eq!(tile.picture().width(), 20);
        assert_eq!(front.send("POST", &format!("/v1/jobs/{id}/look?x=0&y=0&w=9&h=9"), &[], b"").status, 204);
    }
    wait_for(there, &id, "succeeded");
    assert!(image(there, &id) == image(here, &id) && image(there, &id) == of_one_machine(MIRRORS, &json!({})));
    let preview = |front: &Service| front.get(&format!("/v1/jobs/{id}/preview")).body;
    assert!(preview(here) == preview(there));
    assert!(job(there, &id)["report"].is_object(), "{}", job(there, &id));
    // Both streams are the same, from the first event that both saw.
    let [mut one, mut other] = watched.into_iter().map(Events::all).collect::<Vec<_>>().try_into().unwrap();
    for events in [&mut one, &mut other] {
        assert_eq!(events.last().unwrap().0, "succeeded", "{events:?}");
        events.retain(|(name, _)| !["snapshot", "queued"].contains(&name.as_str()));
    }
    let first = one[0].1.max(other[0].1);
    for events in [&mut one, &mut other] {
        events.retain(|(_, seq)| *seq >= first);
    }
    assert_eq!(one, other);
    assert!(one.len() > 10, "{one:?}");
}

/// T4, a front that somebody watches through, and which does not work on the job.
#[test]
fn who_watched_through_a_front_that_is_killed_goes_on_at_another() {
    let Some(farm) = Fronts::start(2, &[]) else { return };
    let id = submit(&farm.fronts[0], MIRRORS, &json!({}));
    let owner = farm.owner(&id);
    let Fronts { mut fronts, store, broker, flags } = farm;
    let (mut victim, other) = (fronts.remove(1 - owner), fronts.remove(0));
    let mut events = Events::of(&victim, &id, None);
    let farm = Fronts { fronts: vec![other], store, broker, flags };
    let _node = farm.node();
    let last = loop {
        let (name, seq) = events.next().unwrap();
        if name == "tile" {
            break seq;
        }
    };
    victim.signal("-KILL");
    victim.ended();
    let rest = Events::of(&farm.fronts[0], &id, Some(last)).all();
    let numbers: Vec<u64> = rest.iter().map(|(_, seq)| *seq).collect();
    assert_eq!(numbers, (last + 1..=last + numbers.len() as u64).collect::<Vec<_>>(), "nothing is lost or told twice");
    assert_eq!(rest.last().unwrap().0, "succeeded");
    let last = Some(numbers[numbers.len() - 1]);
    assert_eq!(Events::of(&farm.fronts[0], &id, last).all(), [], "nothing more will come");
}

/// T4, the front that works on the job.
#[test]
fn a_front_that_is_killed_leaves_its_job_to_another() {
    let Some(mut farm) = Fronts::start(2, &[]) else { return };
    let id = submit(&farm.fronts[0], MIRRORS, &json!({}));
    let owner = farm.owner(&id);
    let mut events = Events::of(&farm.fronts[owner], &id, None);
    let node = farm.node();
    wait_for_tiles(&farm.fronts[1 - owner], &id, 0.2);
    // It is killed before the end.
    node.signal("-STOP");
    let mut victim = farm.fronts.remove(owner);
    let mut last = 0;
    while let Some((name, seq)) = events.next() {
        last = seq;
        if name == "tile" {
            break;
        }
    }
    victim.signal("-KILL");
    victim.ended();
    node.signal("-CONT");
    let rest = Events::of(&farm.fronts[0], &id, Some(last)).all();
    assert!(rest.iter().all(|(_, seq)| *seq > last), "{last}: {rest:?}");
    assert_eq!(rest.last().unwrap().0, "succeeded", "{}", farm.fronts[0].log());
    let ended = job(&farm.fronts[0], &id);
    assert!(ended["stats"]["tiles_recovered"].as_u64().unwrap() > 0, "{ended}");
    assert!(image(&farm.fronts[0], &id) == of_one_machine(MIRRORS, &json!({})));
}

#[test]
fn a_front_that_was_stopped_finds_its_job_taken_and_leaves_it() {
    let Some(farm) = Fronts::start(2, &[]) else { return };
    let id = submit(&farm.fronts[0], MIRRORS, &json!({ "width": 800, "height": 600 }));
    let owner = farm.owner(&id);
    let node = farm.node();
    wait_for_tiles(&farm.fronts[1 - owner], &id, 0.05);
    // Nothing ends while nobody works on it.
    node.signal("-STOP");
    farm.fronts[owner].signal("-STOP");
    let other = &farm.fronts[1 - owner];
    wait_until("the other front takes the job", || other.log().contains(&format!("this front begins job=\"{id}\"")));
    node.signal("-CONT");
    farm.fronts[owner].signal("-CONT");
    wait_for(other, &id, "succeeded");
    wait_for(&farm.fronts[owner], &id, "succeeded");
    assert!(image(&farm.fronts[owner], &id) == image(other, &id));
    other.wait_for_log("a job has ended");
    let ended = |front: &Service| front.log().matches("a job has ended").count();
    assert_eq!([ended(&farm.fronts[owner]), ended(other)], [0, 1], "{}", farm.fronts[owner].log());
    // The one that was stopped works as before.
    let next = submit(&farm.fronts[owner], BALL, &json!({}));
    wait_for(&farm.fronts[owner], &next, "succeeded");
}

#[test]
fn fronts_that_all_end_lose_no_job() {
    let Some(mut farm) = Fronts::start(2, &[]) else { return };
    let ids: Vec<String> =
        (0..4).map(|at| submit(&farm.fronts[at % 2], BALL, &json!({ "width": 64 + at, "height": 64 }))).collect();
    farm.owner(&ids[0]);
    for mut front in farm.fronts.drain(..) {
        front.terminate();
        front.ended();
    }
    farm.add();
    let _node = farm.node();
    for id in &ids {
        wait_for(&farm.fronts[0], id, "succeeded");
    }
    assert_eq!(farm.fronts[0].get("/v1/jobs").json()["jobs"].as_array().unwrap().len(), 4);
}

#[test]
fn one_key_is_one_job_at_whichever_front() {
    let Some(farm) = Fronts::start(2, &[]) else { return };
    let body = order(BALL, &json!({}));
    for round in 0..5 {
        let key = format!("key {round}");
        let headers = [("Content-Type", "application/json"), ("Idempotency-Key", key.as_str())];
        let send = |front: &Service| loop {
            let answer = front.send("POST", "/v1/jobs", &headers, body.as_bytes());
            match answer.status {
                202 => return id_of(&answer),
                // The other one is being accepted.
                409 => assert_eq!(answer.header("retry-after"), "1"),
                status => panic!("{status}: {}", answer.text()),
            }
        };
        let ids: BTreeSet<String> = thread::scope(|scope| {
            let (fronts, send) = (&farm.fronts, &send);
            let sent: Vec<_> = (0..6).map(|at| scope.spawn(move || send(&fronts[at % 2]))).collect();
            sent.into_iter().map(|sent| sent.join().unwrap()).collect()
        });
        assert_eq!(ids.len(), 1, "{ids:?}");
        let other = farm.fronts[1].send("POST", "/v1/jobs", &headers, order(MIRRORS, &json!({})).as_bytes());
        other.problem(422, "idempotency-key-reused");
    }
    assert_eq!(farm.fronts[1].get("/v1/jobs").json()["jobs"].as_array().unwrap().len(), 5);
}

/// T11.
#[test]
fn as_many_jobs_wait_as_may_however_many_fronts_are_asked() {
    let folder = tempfile::tempdir().unwrap();
    let keys = folder.path().join("keys.toml");
    let bearer = new_key(&keys, "acme");
    let text = fs::read_to_string(&keys).unwrap();
    fs::write(&keys, format!("[tenants.acme]\njobs = 7\n{text}")).unwrap();
    let Some(farm) = Fronts::start(2, &["--keys", keys.to_str().unwrap()]) else { return };
    let headers = [("Content-Type", "application/json"), ("Authorization", bearer.as_str())];
    let answers: Vec<Answer> = thread::scope(|scope| {
        let send = |at: usize| {
            let body = order(BALL, &json!({ "width": 40 + at }));
            farm.fronts[at % 2].send("POST", "/v1/jobs", &headers, body.as_bytes())
        };
        let sent: Vec<_> = (0..24).map(|at| scope.spawn(move || send(at))).collect();
        sent.into_iter().map(|sent| sent.join().unwrap()).collect()
    });
    let (accepted, refused): (Vec<_>, Vec<_>) = answers.into_iter().partition(|answer| answer.status == 202);
    assert_eq!(accepted.len(), 7, "{}\n{}", farm.fronts[0].log(), farm.fronts[1].log());
    assert!(refused.iter().all(|answer| answer.status == 429 && !answer.header("retry-after").is_empty()));
    let _node = farm.node();
    let get = |front: &Service, path: &str| front.send("GET", path, &headers, b"");
    for answer in &accepted {
        let path = format!("/v1/jobs/{}", id_of(answer));
        wait_until("an accepted job succeeds", || get(&farm.fronts[0], &path).json()["state"] == "succeeded");
    }
    // What one front signs opens a job at the other.
    let id = id_of(&accepted[0]);
    let capability =
        farm.fronts[0].send("POST", "/v1/capabilities", &headers, json!({ "job_id": id }).to_string().as_bytes());
    assert_eq!(capability.status, 201, "{}", capability.text());
    let prefix = capability.json()["prefix"].as_str().unwrap().to_owned();
    assert_eq!(farm.fronts[1].get(&format!("{prefix}/v1/jobs/{id}")).status, 200);
}

#[test]
fn a_job_is_changed_canceled_and_deleted_at_any_front() {
    let Some(farm) = Fronts::start(2, &[]) else { return };
    let id = submit(&farm.fronts[0], MIRRORS, &json!({}));
    let owner = farm.owner(&id);
    let (here, there) = (&farm.fronts[owner], &farm.fronts[1 - owner]);
    let path = format!("/v1/jobs/{id}");
    let change = |front: &Service, priority: u8, tag: &str| {
        let headers = [("Content-Type", "application/json"), ("If-Match", tag)];
        front.send("PATCH", &path, &headers, json!({ "priority": priority }).to_string().as_bytes())
    };
    let tag = there.get(&path).header("etag").to_owned();
    assert_eq!(change(there, 80, &tag).json()["priority"], 80);
    wait_until("the other front hears of it", || job(here, &id)["priority"] == 80);
    assert_eq!([change(here, 70, &tag).status, change(there, 70, &tag).status], [412, 412]);
    let tag = here.get(&path).header("etag").to_owned();
    let both = [here, there].map(|front| change(front, 60, &tag).status);
    assert_eq!(both.iter().filter(|status| **status == 200).count(), 1, "{both:?}");

    let events = Events::of(here, &id, None);
    let _node = farm.node();
    wait_for_tiles(there, &id, 0.05);
    assert_eq!(there.send("POST", &format!("{path}/cancel"), &[], b"").status, 202);
    wait_for(here, &id, "canceled");
    wait_until("its work is gone", || farm.broker.messages("FARM_T") == 0);
    assert_eq!(events.all().last().unwrap().0, "canceled");
    assert_eq!(here.send("POST", &format!("{path}/cancel"), &[], b"").status, 409);

    let second = submit(there, MIRRORS, &json!({}));
    wait_for_tiles(here, &second, 0.05);
    assert_eq!(there.send("DELETE", &format!("/v1/jobs/{second}"), &[], b"").status, 204);
    wait_until("it is gone", || here.get(&format!("/v1/jobs/{second}")).status == 404);
    assert_eq!(here.send("DELETE", &path, &[], b"").status, 204);
    wait_until("it is gone", || there.get(&path).status == 404);
    // What follows is rendered as ever.
    let third = submit(here, BALL, &json!({}));
    wait_for(there, &third, "succeeded");
}

/// A scene that was posted at one front is known at all, until it is deleted at any.
#[test]
fn a_posted_scene_is_known_at_every_front() {
    let Some(farm) = Fronts::start(2, &[]) else { return };
    let [here, there] = [&farm.fronts[0], &farm.fronts[1]];
    let known = here.post_json("/v1/scenes", BALL).json();
    let link = |name: &str| known["links"][name].as_str().unwrap().to_owned();
    for path in [link("iiif"), link("xyz"), link("dzi"), link("self")] {
        assert_eq!([here, there].map(|front| front.get(&path).status), [200; 2], "{path}");
    }
    let picture = format!("/v1/images/{}.png", known["image_id"].as_str().unwrap());
    let [first, second] = [here, there].map(|front| front.get(&picture));
    assert!(second.status == 200 && first.body == second.body, "{}", second.text());
    let variation = json!({ "base": known["scene_id"], "patch": { "ambient": 0.5 } }).to_string();
    let varied = [here, there].map(|front| front.post_json("/v1/render", &variation));
    assert!(varied[1].status == 200 && varied[0].body == varied[1].body, "{}", varied[1].text());
    let path = format!("/v1/scenes/{}", known["scene_id"].as_str().unwrap());
    assert_eq!(there.send("DELETE", &path, &[], b"").status, 204);
    assert_eq!([here, there].map(|front| front.get(&path).status), [404; 2]);
    assert_eq!(here.send("DELETE", &path, &[], b"").status, 404);
}
