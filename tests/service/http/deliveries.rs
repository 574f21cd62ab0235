//! What a job leaves behind after its end: a signed message to a webhook, and its picture in the store.

use super::access::{KeyFile, keyed};
use super::jobs::{ENDLESS, LONG, body, mirrors, submit, succeeded, text, until};
use super::operations::{metrics_with, with_admin};
use crate::common::receiver::{Receiver, secret};
use crate::common::service::Service;
use crate::common::{BALL, SLOW};
use serde_json::Value;
use std::collections::BTreeSet;
use std::thread;
use std::time::Duration;

/// Flags of a service that sends messages to this machine and does not wait long.
const LOCAL: [&str; 5] = ["--webhook-http", "--webhook-allow", "127.0.0.1", "--webhook-retry", "0.05"];

fn hook(url: &str) -> String {
    format!(r#""webhook": {{ "url": "{url}" }}"#)
}

/// Waits until a job's message is delivered or given up.
fn message_ended(service: &Service, id: &str) -> Value {
    until(service, id, |job| job["webhook"]["state"] != "pending")["webhook"].clone()
}

#[test]
fn a_job_says_how_it_ended_whatever_that_is() {
    let folder = tempfile::tempdir().unwrap();
    let (file, secret) = secret(&folder);
    let service = Service::start(&[&LOCAL[..], &["--webhook-secret-file", file.to_str().unwrap()]].concat());
    let receiver = Receiver::start(&["204 No Content"]);
    let rest = format!(r#""labels": ["shot 7"], {}"#, hook(&receiver.url()));
    let done = submit(&service, BALL, &rest);
    let message = receiver.wait_for(1)[0].clone();
    assert!(message.is_signed_with(&secret) && !message.is_signed_with("whsec_AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"));
    assert!(message.head.starts_with("POST /hook HTTP/1.1"), "{}", message.head);
    assert_eq!(message.header("webhook-id"), format!("msg_{done}"));
    let json = message.json();
    let data = &json["data"];
    assert_eq!(
        (&json["type"], &data["id"], &data["state"]),
        (&"job.succeeded".into(), &done.as_str().into(), &"succeeded".into())
    );
    assert_eq!((&data["labels"][0], &json["timestamp"]), (&"shot 7".into(), &data["finished_at"]));
    assert!(data["stats"]["rays"].as_u64() > Some(0), "{data}");
    let webhook = message_ended(&service, &done);
    assert_eq!((&webhook["state"], &webhook["attempts"]), (&"delivered".into(), &1.into()));
    assert_eq!(webhook["url"], receiver.url());

    let canceled = submit(&service, SLOW, &format!("{ENDLESS}, {}", hook(&receiver.url())));
    assert!(service.get(&format!("/v1/jobs/{canceled}")).json()["webhook"]["attempts"] == 0);
    service.post_json(&format!("/v1/jobs/{canceled}/cancel"), "");
    assert_eq!(receiver.wait_for(2)[1].json()["type"], "job.canceled");
    // The picture is there already: the job ends when it is accepted.
    let again = submit(&service, BALL, &hook(&receiver.url()));
    let json = receiver.wait_for(3)[2].json();
    assert_eq!((&json["data"]["id"], &json["data"]["stats"]["reused"]), (&again.as_str().into(), &true.into()));
    let silent = submit(&service, BALL, "");
    assert!(succeeded(&service, &silent)["webhook"].is_null());
    assert_eq!(receiver.seen().len(), 3);
}

#[test]
fn a_message_is_tried_again_under_one_id_with_one_text_until_it_arrives() {
    let folder = tempfile::tempdir().unwrap();
    let (file, secret) = secret(&folder);
    let (service, admin) = with_admin(&[&LOCAL[..], &["--webhook-secret-file", file.to_str().unwrap()]].concat());
    let receiver = Receiver::start(&["500 Oops", "302 Found", "503 Busy", "200 OK"]);
    let id = submit(&service, BALL, &hook(&receiver.url()));
    let webhook = message_ended(&service, &id);
    assert_eq!((&webhook["state"], &webhook["attempts"]), (&"delivered".into(), &4.into()), "{webhook}");
    let seen = receiver.seen();
    assert_eq!(seen.len(), 4);
    assert!(seen.iter().all(|message| message.is_signed_with(&secret)));
    let what: BTreeSet<_> =
        seen.iter().map(|message| (message.header("webhook-id").to_owned(), message.body.clone())).collect();
    assert_eq!(what.len(), 1, "{what:?}");
    let counted = |outcome, count| format!("strahl_deliveries_total{{what=\"message\",outcome=\"{outcome}\"}} {count}");
    metrics_with(admin, &[&counted("retried", 3), &counted("delivered", 1)]);
}

#[test]
fn a_message_that_does_not_arrive_is_given_up_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let (file, _) = secret(&folder);
    let flags = ["--webhook-secret-file", file.to_str().unwrap(), "--webhook-attempts", "3", "--webhook-timeout", "2"];
    let service = Service::start(&[&LOCAL[..], &flags].concat());
    let receiver = Receiver::start(&["500 Oops"]);
    let refused = submit(&service, BALL, &hook(&receiver.url()));
    let gone = Receiver::start(&["410 Gone"]);
    let ended = submit(&service, BALL, &hook(&gone.url()));
    let slow = Receiver::start(&[""]);
    let unanswered = submit(&service, BALL, &hook(&slow.url()));
    // A name is looked up when the message is sent. This one never has an address.
    let nowhere = submit(&service, BALL, &hook("http://nowhere.invalid/"));
    for (id, attempts, why) in
        [(refused, 3, "500"), (ended, 1, "410 Gone"), (unanswered, 3, "in time"), (nowhere, 3, "no address")]
    {
        let webhook = message_ended(&service, &id);
        assert_eq!((&webhook["state"], &webhook["attempts"]), (&"dead".into(), &attempts.into()), "{webhook}");
        assert!(text(&webhook["error"]).contains(why) && webhook["ended_at"].is_string(), "{webhook}");
        assert_eq!(succeeded(&service, &id)["state"], "succeeded", "the job itself did not fail");
    }
}

#[test]
fn receivers_inside_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (file, _) = secret(&folder);
    let service =
        Service::start(&["--webhook-http", "--webhook-attempts", "1", "--webhook-secret-file", file.to_str().unwrap()]);
    let receiver = Receiver::start(&["204 No Content"]);
    let port = receiver.port;
    for host in ["127.0.0.1", "[::1]", "[::ffff:127.0.0.1]", "2130706433", "0x7f.1", "169.254.169.254", "10.0.0.1"] {
        let refused = service.post_json("/v1/jobs", &body(BALL, &hook(&format!("http://{host}:{port}/"))));
        let problem = refused.problem(422, "invalid-request");
        assert!(text(&problem["detail"]).contains("not public"), "{host}: {problem}");
    }
    for url in ["ftp://example.org/", "https://a:b@example.org/", "nonsense"] {
        service.post_json("/v1/jobs", &body(BALL, &hook(url))).problem(422, "invalid-request");
    }
    let by_name = submit(&service, BALL, &hook(&format!("http://localhost:{port}/")));
    let webhook = message_ended(&service, &by_name);
    assert!(text(&webhook["error"]).contains("not public"), "{webhook}");
    assert_eq!(receiver.seen().len(), 0);

    let unsigned = Service::start(&LOCAL);
    let refused = unsigned.post_json("/v1/jobs", &body(BALL, &hook(&receiver.url())));
    assert!(text(&refused.problem(422, "invalid-request")["detail"]).contains("strahl key webhook"));
    let encrypted = Service::start(&["--webhook-allow", "127.0.0.1"]);
    let refused = encrypted.post_json("/v1/jobs", &body(BALL, &hook(&receiver.url())));
    assert!(text(&refused.problem(422, "invalid-request")["detail"]).contains("--webhook-http"));
}

#[test]
fn killed_before_and_in_mid_delivery_no_message_is_lost_or_changed() {
    let folder = tempfile::tempdir().unwrap();
    let (file, secret) = secret(&folder);
    let data = folder.path().join("data");
    let flags =
        [&LOCAL[..], &["--webhook-secret-file", file.to_str().unwrap(), "--data", data.to_str().unwrap()]].concat();
    // Never answered while the first processes live.
    let receiver = Receiver::start(&["", "", "", "", "500 Oops", "204 No Content"]);
    let service = Service::start(&flags);
    let rendered = submit(&service, &mirrors(), &format!("{LONG}, {}", hook(&receiver.url())));
    let at_once: Vec<_> = (0..3).map(|_| submit(&service, BALL, &hook(&receiver.url()))).collect();
    receiver.wait_for(1);
    service.signal("-KILL");
    drop(service);
    let service = Service::start(&flags);
    receiver.wait_for(3);
    service.signal("-KILL");
    drop(service);
    let service = Service::start(&flags);
    for id in at_once.iter().chain([&rendered]) {
        assert_eq!(message_ended(&service, id)["state"], "delivered", "{id}\n{}", service.log());
    }
    let seen = receiver.seen();
    assert!(seen.iter().all(|message| message.is_signed_with(&secret)));
    let mut texts = std::collections::BTreeMap::<String, BTreeSet<String>>::new();
    for message in &seen {
        texts.entry(message.header("webhook-id").to_owned()).or_default().insert(message.body.clone());
    }
    let ids: BTreeSet<_> = at_once.iter().chain([&rendered]).map(|id| format!("msg_{id}")).collect();
    assert_eq!(texts.keys().cloned().collect::<BTreeSet<_>>(), ids, "each job has one message");
    assert!(texts.values().all(|texts| texts.len() == 1), "an id has one text: {texts:?}");
    drop(service);
    let service = Service::start(&flags);
    thread::sleep(Duration::from_millis(500));
    assert_eq!(message_ended(&service, &rendered)["state"], "delivered");
    assert_eq!(receiver.seen().len(), seen.len(), "what has arrived is not sent again");
}

#[test]
fn a_tenant_has_its_own_secret_and_receiver_and_one_slow_receiver_holds_nobody_else_up() {
    let folder = tempfile::tempdir().unwrap();
    let (_, secret) = secret(&folder);
    let (slow, quick) = (Receiver::start(&[""]), Receiver::start(&["204 No Content"]));
    let entry =
        |name: &str, url: &str| format!("[tenants.{name}]\nwebhook = \"{url}\"\nwebhook_secret = \"{secret}\"\n");
    let file = KeyFile::new("webhooks", &(entry("slow", &slow.url()) + &entry("quick", &quick.url())));
    let (of_slow, of_quick) = (file.key("slow", "jobs,read,render"), file.key("quick", "jobs,read,render"));
    let service = file.serve(&[&LOCAL[..], &["--webhook-timeout", "60", "--webhook-parallel", "2"]].concat());
    for _ in 0..20 {
        assert_eq!(keyed(&service, &of_slow, "POST", "/v1/jobs", &body(BALL, "")).status, 202);
    }
    slow.wait_for(2);
    let job = keyed(&service, &of_quick, "POST", "/v1/jobs", &body(BALL, "")).json();
    let message = quick.wait_for(1)[0].clone();
    assert!(message.is_signed_with(&secret));
    assert_eq!(message.json()["data"]["id"], job["id"]);
    assert_eq!(slow.seen().len(), 2, "no more than its share at one time");
}

#[test]
fn pictures_go_to_the_store_under_names_of_their_tenant() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store");
    let (file, _) = secret(&folder);
    let flags = ["--store", store.to_str().unwrap(), "--webhook-secret-file", file.to_str().unwrap()];
    let service = Service::start(&[&LOCAL[..], &flags].concat());
    assert_eq!(service.get("/v1/limits").json()["deliveries"]["store"], true);
    let receiver = Receiver::start(&["204 No Content"]);
    let rest = format!(
        r#""store": {{ "key": "shots/{{date}}/ball_{{width}}x{{height}}.{{ext}}" }}, {}"#,
        hook(&receiver.url())
    );
    let id = submit(&service, BALL, &rest);
    let message = receiver.wait_for(1)[0].json();
    let stored = &message["data"]["store"];
    assert_eq!(stored["state"], "delivered", "the message comes after the picture: {message}");
    let key = text(&stored["key"]);
    assert!(key.starts_with("results/anonymous/shots/20") && key.ends_with("/ball_48x32.png"), "{key}");
    assert_eq!(stored["report_key"], format!("{key}.json"));
    assert!(text(&stored["url"]).starts_with("file:///") && text(&stored["url"]).ends_with(key), "{stored}");
    let picture = service.get(&format!("/v1/jobs/{id}/image")).body;
    assert_eq!(std::fs::read(store.join(key)).unwrap(), picture);
    let report: Value = serde_json::from_slice(&std::fs::read(store.join(format!("{key}.json"))).unwrap()).unwrap();
    assert_eq!(report, succeeded(&service, &id)["report"]);

    let plain = submit(&service, BALL, r#""store": {}"#);
    let job = until(&service, &plain, |job| job["store"]["state"] != "pending");
    assert_eq!(job["store"]["key"], format!("results/anonymous/{plain}.png"));
    for key in ["../other/a.png", "/a.png", "a/../../b.png", "{nobody}.png", "a b.png", ""] {
        let refused = service.post_json("/v1/jobs", &body(BALL, &format!(r#""store": {{ "key": "{key}" }}"#)));
        assert_eq!(refused.status, 422, "{key}: {}", refused.text());
    }
    let refused = service.post_json("/v1/jobs", &body(BALL, r#""store": { "key": "{frame}.png" }"#));
    assert_eq!(refused.status, 400, "a job without frames: {}", refused.text());
    let without = Service::start(&[]).post_json("/v1/jobs", &body(BALL, r#""store": {}"#));
    assert!(text(&without.problem(422, "invalid-request")["detail"]).contains("--store"));
}

#[test]
fn each_frame_of_a_sequence_goes_to_the_store_under_its_number() {
    let folder = tempfile::tempdir().unwrap();
    let service = Service::start(&["--store", folder.path().to_str().unwrap()]);
    let frames = r#""frames": { "count": 3, "turntable": {} }"#;
    let names = [("{}", "{job}/{frame}.png"), (r#"{ "key": "turn/{frame}.{ext}" }"#, "turn/{frame}.png")];
    for (store, name) in names {
        let id = submit(&service, BALL, &format!(r#"{frames}, "store": {store}"#));
        let job = until(&service, &id, |job| job["store"]["state"] != "pending");
        assert_eq!(job["store"]["state"], "delivered", "{job}");
        let key = format!("results/anonymous/{}", name.replace("{job}", &id));
        assert_eq!(text(&job["store"]["key"]), key);
        for number in 0..3 {
            let frame = service.get(&format!("/v1/jobs/{id}/frames/{number}")).body;
            let stored = folder.path().join(key.replace("{frame}", &format!("{number:04}")));
            assert!(std::fs::read(&stored).unwrap() == frame, "{}", stored.display());
        }
    }
    let one_name = format!(r#"{frames}, "store": {{ "key": "turn.png" }}"#);
    let refused = service.post_json("/v1/jobs", &body(BALL, &one_name));
    assert!(refused.status == 400 && refused.text().contains("{frame}"), "{}", refused.text());
}

#[test]
fn a_store_that_is_away_for_a_while_gets_the_picture_later() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store");
    let service = Service::start(&["--store", store.to_str().unwrap(), "--webhook-retry", "0.05"]);
    // A file where the folder of results is to be.
    std::fs::write(store.join("results"), "").unwrap();
    let id = submit(&service, BALL, r#""store": {}"#);
    let waiting = until(&service, &id, |job| job["store"]["attempts"].as_u64() >= Some(2));
    assert_eq!((&waiting["state"], &waiting["store"]["state"]), (&"succeeded".into(), &"pending".into()), "{waiting}");
    assert!(waiting["store"]["error"].is_string() && waiting["store"]["next_attempt_at"].is_string(), "{waiting}");
    std::fs::remove_file(store.join("results")).unwrap();
    let job = until(&service, &id, |job| job["store"]["state"] != "pending");
    assert_eq!(job["store"]["state"], "delivered", "{job}");
    assert!(store.join(text(&job["store"]["key"])).is_file());
}
