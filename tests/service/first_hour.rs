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
        let said = text(&output.stderr);
        assert!(said.lines().any(|line| line == format!("wrote {name}")), "{args:?}: {said}");
        assert!(std::fs::read(folder.path().join(name)).unwrap().starts_with(begins), "{name}");
    }
    let named = strahl_in(folder.path(), &["render", "ball.json", "-o", "other.png"]);
    assert!(!text(&named.stderr).contains("wrote"));
    let same = ["ball.png", "other.png"].map(|name| std::fs::read(folder.path().join(name)).unwrap());
    assert_eq!(same[0], same[1]);
}

/// One line, also where nobody watches and where the picture goes to standard output.
#[test]
fn a_picture_comes_with_its_price_and_its_bound() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ball.json"), BALL).unwrap();
    for output in [&["-o", "a.png"][..], &["-o", "-", "--format", "png"]] {
        let said = text(&strahl_in(folder.path(), &[&["render", "ball.json"], output].concat()).stderr);
        assert_eq!(said.lines().count(), 1, "{said}");
        for part in ["48 x 32 pixels, ", " rays, ", " tracing); proved: "] {
            assert!(said.contains(part), "{part} in {said}");
        }
    }
    // Mirrors that keep all light, and where only the time ends the recursion.
    let hopeless =
        BALL.replace("\"version\": 1", "\"version\": 1, \"render\": {\"accuracy\": {\"rays\": {\"count\": 1}}}");
    std::fs::write(folder.path().join("hopeless.json"), hopeless).unwrap();
    let said = text(&strahl_in(folder.path(), &["render", "hopeless.json", "-o", "a.png"]).stderr);
    assert!(said.contains("nothing is proved of its error: ") && !said.contains("?0"), "{said}");
}

/// A file of another program is not a scene with a hundred mistakes.
#[test]
fn files_of_other_formats_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (name, content, said) in [
        ("a.json", "Kaydara FBX Binary", "this is FBX, which strahl does not read: convert it to glTF (.glb)"),
        ("a.wrl", "#VRML V2.0 utf8", "this is VRML, which strahl does not read: convert it to glTF (.glb)"),
        ("b.nff", "v 0 0 1\nv 0 1 1\nf 1 2 1\n", "this is Wavefront OBJ, read it as obj (--input obj"),
        ("c.json", "glTF\u{2}\0\0\0", "this is binary glTF (.glb), read it as gltf (--input gltf"),
    ] {
        std::fs::write(folder.path().join(name), content).unwrap();
        for command in ["validate", "import", "render", "explain"] {
            let output = strahl_in(folder.path(), &[command, name]);
            let error = text(&output.stderr);
            assert_eq!(output.status.code(), Some(1), "{command} {name}: {error}");
            assert!(error.contains("has a problem") && error.contains(said), "{command} {name}: {error}");
        }
    }
    // Those that are read, under wrong names.
    std::fs::write(folder.path().join("ball.nff"), BALL).unwrap();
    std::fs::write(folder.path().join("balls.json"), "v\nfrom 0 0 1\n").unwrap();
    for (command, name, said) in [
        ("import", "ball.nff", "this is scene JSON already"),
        ("render", "ball.nff", "this is JSON, not NFF: read it as json (--input json"),
        ("validate", "balls.json", "this is Neutral File Format (NFF), not JSON: read it as nff (--input nff"),
    ] {
        let error = text(&strahl_in(folder.path(), &[command, name]).stderr);
        assert!(error.contains(said), "{command} {name}: {error}");
    }

    let service = Service::start(&[]);
    let gltf = r#"{"scenes": [{"nodes": [0]}], "asset": {"version": "2.0"}}"#;
    for (kind, body, said) in [
        ("application/json", "v 0 0 1\nv 0 1 1", "this is Wavefront OBJ"),
        ("application/x-www-form-urlencoded", "#VRML V2.0 utf8", "this is VRML"),
        ("application/x-www-form-urlencoded", "v\nfrom 0 0 1\n", "this looks like Neutral File Format"),
        ("model/gltf-binary", "v 0 0 1\nv 0 1 1", "this is Wavefront OBJ"),
        ("text/x-nff", gltf, "this is glTF,"),
        ("text/x-nff", BALL, "this is JSON, not NFF"),
    ] {
        for path in ["/v1/render", "/v1/scenes/validate", "/v1/explain"] {
            let answer = service.send("POST", path, &[("Content-Type", kind)], body.as_bytes());
            let problem = answer.problem(415, "unsupported-media-type");
            assert!(problem["detail"].as_str().is_some_and(|detail| detail.contains(said)), "{path} {kind}: {problem}");
        }
    }
}

#[test]
fn a_gallery_is_a_page_of_pictures_with_prices() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("scenes").join("inner");
    std::fs::create_dir_all(&inner).unwrap();
    std::fs::write(inner.join("ball.json"), BALL).unwrap();
    let named = BALL.replace("\"version\": 1", "\"version\": 1, \"name\": \"a <b> & c\"");
    std::fs::write(folder.path().join("scenes/named.json"), named).unwrap();
    std::fs::write(inner.join("notes.txt"), "no scene").unwrap();
    let output = strahl_in(folder.path(), &["gallery", "scenes", "-o", "g.html"]);
    let said = text(&output.stderr);
    assert!(output.status.success() && said.contains("2 of 2: scenes/named.json"), "{said}");
    let page = std::fs::read_to_string(folder.path().join("g.html")).unwrap();
    assert_eq!(page.matches("src=\"data:image/jpeg;base64,").count(), 2);
    for part in ["48 x 32", "million rays", "proved: ", "<b>a &lt;b> &amp; c</b>", "scenes/inner/ball.json"] {
        assert!(page.contains(part), "{part}");
    }
    std::fs::write(inner.join("bad.json"), "{").unwrap();
    let output = strahl_in(folder.path(), &["gallery", "scenes", "-o", "g.html"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("scenes/inner/bad.json has a problem"));
}

/// Nobody watches a pipe for a bar.
#[test]
fn a_tradeoff_tells_its_progress_into_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let hall = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/mirrors/hall.json");
    let args = ["tradeoff", hall.to_str().unwrap(), "--seconds", "3", "-o", "t.html"];
    let said = text(&strahl_in(folder.path(), &args).stderr);
    assert!(said.contains("measuring: ") && said.contains(" %\n"), "{said}");
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
    // With the studio browsers are led there.
    let service = Service::start(&["--no-studio"]);
    let page = service.send("GET", "/", &[("Accept", "text/html,application/xhtml+xml,*/*;q=0.8")], b"");
    assert_eq!(page.header("content-type"), "text/html; charset=utf-8");
    let page = page.text();
    let links: Vec<_> = page.split("<a href=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert!(links.contains(&"/docs") && links.contains(&"/openapi.json"), "{links:?}");
    for link in links {
        assert_eq!(service.get(link).status, 200, "{link}");
    }
}
