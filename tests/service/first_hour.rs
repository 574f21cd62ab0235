//! What somebody meets who starts with strahl: names that need not be given, hints where something fails, and where to begin.

use crate::common::BALL;
use crate::common::service::Service;
use std::path::Path;
use std::process::{Command, Output};

fn strahl_in(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_strahl")).args(args).current_dir(folder).output().expect("the binary starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn results_have_the_name_of_their_scene() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ball.json"), BALL).unwrap();
    for (args, name, begins) in [
        (&["render", "ball.json"][..], "ball.png", &b"\x89PNG"[..]),
        (&["render", "ball.json", "--format", "pfm"], "ball.pfm", b"PF"),
        (&["map", "ball.json", "--of", "rays"], "ball-map.png", b"\x89PNG"),
        (&["tradeoff", "ball.json", "--seconds", "2"], "ball-tradeoff.html", b"<!doctype"),
    ] {
        let output = strahl_in(folder.path(), args);
        assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
        assert_eq!(text(&output.stderr).trim(), format!("wrote {name}"), "{args:?}");
        assert!(std::fs::read(folder.path().join(name)).unwrap().starts_with(begins), "{name}");
    }
    let named = strahl_in(folder.path(), &["render", "ball.json", "-o", "other.png"]);
    assert_eq!(text(&named.stderr), "");
    let same = ["ball.png", "other.png"].map(|name| std::fs::read(folder.path().join(name)).unwrap());
    assert_eq!(same[0], same[1]);
}

#[test]
fn help_has_groups_and_examples() {
    let here = Path::new(".");
    let serve = text(&strahl_in(here, &["serve", "--help"]).stdout);
    let groups = ["Network and keys:", "Limits of one request:", "Caches:", "Folders:", "Jobs:"];
    let places: Vec<_> = groups.map(|group| serve.find(group).unwrap_or_else(|| panic!("{group} in {serve}"))).into();
    assert!(places.is_sorted(), "{places:?}");
    let render = text(&strahl_in(here, &["render", "--help"]).stdout);
    assert!(render.contains("Examples:\n  strahl render scenes/whitted/whitted.json"), "{render}");
    assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/whitted/whitted.json").is_file());
}

#[test]
fn a_taken_port_says_what_to_do() {
    let service = Service::start(&[]);
    let output = strahl_in(Path::new("."), &["serve", "--listen", &service.address.to_string()]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(error.contains("cannot listen on") && error.contains("--listen 127.0.0.1:0"), "{error}");
}

/// Nothing can be written into /proc, whoever tries.
#[test]
fn a_folder_that_is_read_only_is_not_another_processs() {
    let output = strahl_in(Path::new("."), &["serve", "--listen", "127.0.0.1:0", "--data", "/proc/strahl"]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(error.contains("has to write into this folder") && !error.contains("Another process"), "{error}");
}

#[test]
fn the_start_teaches_a_request_that_works() {
    let service = Service::start(&[]);
    service.wait_for_log("--data DIR keeps them");
    let log = service.log();
    assert!(log.contains(&format!("documentation: http://{}/docs", service.address)), "{log}");
    let curl = log.lines().find_map(|line| line.split_once("try: ")).expect("an example").1;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.json"), BALL).unwrap();
    let args = curl.strip_prefix("curl ").expect("curl");
    let sent = Command::new("curl").arg("-sS").args(args.split(' ')).current_dir(folder.path()).status();
    // Where there is no curl, the request is sent as curl would send it (`json_needs_no_content_type`).
    if sent.is_ok_and(|status| status.success()) {
        assert!(std::fs::read(folder.path().join("picture.png")).unwrap().starts_with(b"\x89PNG"));
    }
}

#[test]
fn the_root_says_where_to_begin() {
    let service = Service::start(&[]);
    let plain = service.get("/");
    assert_eq!((plain.status, plain.header("content-type")), (200, "text/plain; charset=utf-8"));
    let curl = "curl http://localhost/v1/render --data-binary @scene.json -o picture.png";
    assert!(plain.text().contains(curl), "{}", plain.text());
    let page = service.send("GET", "/", &[("Accept", "text/html,application/xhtml+xml,*/*;q=0.8")], b"");
    assert_eq!(page.header("content-type"), "text/html; charset=utf-8");
    let page = page.text();
    let links: Vec<_> = page.split("<a href=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert!(links.contains(&"/docs") && links.contains(&"/openapi.json"), "{links:?}");
    for link in links {
        assert_eq!(service.get(link).status, 200, "{link}");
    }
}
