//! The studio as it is served and as it is written: without Node and without a browser, which `tests/external/studio.py` has.

use crate::common::service::{Answer, Service};
use flate2::read::GzDecoder;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Beside the files that are served: the page itself, what developers need, and types.
const FOR_DEVELOPERS: [&str; 6] =
    ["index.html", "README.md", "package.json", "package-lock.json", "jsconfig.json", "vendor.mjs"];

fn web() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("web")
}

/// The files that the page may load, by their paths below `web/`.
fn files() -> Vec<String> {
    fn walk(folder: &Path, into: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let is_for_developers = ["node_modules", "tests", "embed"].iter().any(|name| path.ends_with(name));
            match path.is_dir() {
                true if is_for_developers => {}
                true => walk(&path, into),
                false => into.push(path),
            }
        }
    }
    let mut paths = Vec::new();
    walk(&web(), &mut paths);
    let names = paths.iter().map(|path| path.strip_prefix(web()).unwrap().to_str().unwrap().replace('\\', "/"));
    let is_served = |name: &String| {
        !FOR_DEVELOPERS.contains(&name.as_str()) && !name.ends_with(".d.ts") && name != "vendor/vendor.json"
    };
    let mut names: Vec<_> = names.filter(is_served).collect();
    names.sort();
    names
}

fn source(path: &str) -> String {
    std::fs::read_to_string(web().join(path)).unwrap()
}

fn unpacked(answer: &Answer) -> Vec<u8> {
    assert_eq!(answer.header("content-encoding"), "gzip");
    let mut plain = Vec::new();
    GzDecoder::new(answer.body.as_slice()).read_to_end(&mut plain).unwrap();
    plain
}

fn get_packed(service: &Service, path: &str) -> Answer {
    service.send("GET", path, &[("Accept-Encoding", "gzip, br")], b"")
}

/// The hash that the page names.
fn hash(page: &str) -> &str {
    page.split("href=\"studio/").nth(1).unwrap().split('/').next().unwrap()
}

#[test]
fn browsers_are_led_to_the_studio_and_others_are_not() {
    let service = Service::start(&[]);
    let browser = [("Accept", "text/html,application/xhtml+xml,*/*;q=0.8")];
    let led = service.send("GET", "/", &browser, b"");
    assert_eq!((led.status, led.header("location")), (303, "/studio"));
    assert!(service.get("/").text().contains("/studio"), "others read of it");
    let without = Service::start(&["--no-studio"]);
    assert_eq!(without.send("GET", "/", &browser, b"").status, 200);
    assert!(!without.get("/").text().contains("/studio"));
    assert_eq!(without.get("/studio").status, 404);
    assert_eq!(without.get("/v1/examples").status, 200, "examples are for all");
}

#[test]
fn the_program_contains_the_files_of_the_folder_and_each_lasts_for_ever() {
    let service = Service::start(&[]);
    let page = service.get("/studio");
    let hash = hash(&page.text()).to_owned();
    for name in files() {
        let path = format!("/studio/{hash}/{name}");
        let plain = service.get(&path);
        assert_eq!(plain.status, 200, "{name} has no line in api/http/routes/studio/files.rs");
        assert!(plain.body == std::fs::read(web().join(&name)).unwrap(), "{name} is not the file of the folder");
        assert_eq!(plain.header("cache-control"), "public, max-age=31536000, immutable");
        let packed = get_packed(&service, &path);
        assert!(unpacked(&packed) == plain.body, "{name}");
        assert_eq!(packed.header("vary"), "Accept-Encoding");
        let kind = match name.rsplit('.').next().unwrap() {
            "js" => "text/javascript; charset=utf-8",
            "css" => "text/css; charset=utf-8",
            "svg" => "image/svg+xml",
            _ => "text/plain; charset=utf-8",
        };
        assert_eq!(plain.header("content-type"), kind, "{name}");
    }
}

#[test]
fn a_file_of_another_version_is_never_answered_with_something_else() {
    let service = Service::start(&[]);
    let page = service.get("/studio").text();
    let hash = hash(&page);
    for path in [
        format!("/studio/{hash}/app/nothing.js"),
        format!("/studio/{hash}/index.html"),
        format!("/studio/{hash}/../Cargo.toml"),
        format!("/studio/{hash}/%2e%2e/Cargo.toml"),
        "/studio/0000000000000000/app/main.js".to_owned(),
        "/studio/files/app/main.js".to_owned(),
    ] {
        let answer = service.get(&path);
        assert_eq!((answer.status, answer.header("cache-control")), (404, "no-store"), "{path}");
        assert!(answer.json()["detail"].is_string(), "{path}");
    }
}

#[test]
fn the_page_is_asked_for_again_and_has_the_policy_to_the_letter() {
    let service = Service::start(&[]);
    let page = service.get("/studio");
    assert_eq!((page.status, page.header("content-type")), (200, "text/html; charset=utf-8"));
    assert_eq!(page.header("cache-control"), "no-cache");
    assert_eq!(
        page.header("content-security-policy"),
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'; \
         trusted-types 'none'"
    );
    assert_eq!((page.header("referrer-policy"), page.header("x-content-type-options")), ("no-referrer", "nosniff"));
    let again = service.send("GET", "/studio", &[("If-None-Match", page.header("etag"))], b"");
    assert_eq!((again.status, again.body.len()), (304, 0));
    // Browsers keep the page, but take the policy of this answer.
    assert_eq!(again.header("content-security-policy"), page.header("content-security-policy"));
    assert_eq!(again.header("etag"), page.header("etag"));
    assert!(unpacked(&get_packed(&service, "/studio")) == page.body);
}

#[test]
fn the_studio_needs_no_key_and_its_requests_do() {
    let keys = tempfile::NamedTempFile::new().unwrap();
    let service = Service::start(&["--keys", keys.path().to_str().unwrap()]);
    for path in ["/studio", "/v1/examples", "/v1/examples/whitted/whitted"] {
        assert_eq!(service.get(path).status, 200, "{path}");
    }
    assert_eq!(service.post_json("/v1/render", "{}").status, 401);
}

#[test]
fn all_modules_are_preloaded_and_all_imports_lead_somewhere() {
    let service = Service::start(&[]);
    let page = service.get("/studio").text();
    let names: BTreeSet<_> = files().into_iter().collect();
    for module in names.iter().filter(|name| name.starts_with("app/")) {
        assert!(
            page.contains(&format!("<link rel=\"modulepreload\" href=\"studio/{}/{module}\"", hash(&page))),
            "{module}"
        );
        let text = source(module);
        let folder = Path::new(module).parent().unwrap();
        for part in text.split(" from \"").skip(1).chain(text.split("import(\"").skip(1)) {
            let target = part.split('"').next().unwrap();
            if !target.starts_with('.') {
                // Types of packages, in comments.
                continue;
            }
            let mut path = folder.to_owned();
            for step in Path::new(target).components() {
                match step.as_os_str().to_str().unwrap() {
                    "." => {}
                    ".." => assert!(path.pop(), "{module} leaves the folder by {target}"),
                    name => path.push(name),
                }
            }
            assert!(names.contains(path.to_str().unwrap()), "{module} imports {target}");
        }
    }
}

#[test]
fn nothing_in_the_sources_needs_an_exception_from_the_policy() {
    let forbidden = [
        "innerHTML",
        "outerHTML",
        "insertAdjacentHTML",
        "document.write",
        "DOMParser",
        "createContextualFragment",
        "eval(",
        "new Function",
        "style=\"",
        "onclick=\"",
        "onload=\"",
        "javascript:",
        "http:",
        "https:",
        "localStorage.setItem(\"strahl-key",
        "EventSource",
        "srcdoc",
    ];
    for name in files().iter().filter(|name| !name.starts_with("vendor/")).map(String::as_str).chain(["index.html"]) {
        // The namespace of an icon is a name, not an address.
        let text = source(name).replace("http://www.w3.org/2000/svg", "");
        for word in forbidden {
            assert!(!text.contains(word), "{name} has {word}");
        }
        let lines = text.lines().count();
        assert!(!name.starts_with("app/") || lines <= 300, "{name} has {lines} lines");
        assert!(!name.starts_with("app/") || text.starts_with("// "), "{name} has no first line that says what it is");
    }
    let page = source("index.html");
    assert_eq!(page.matches("<script").count(), page.matches("<script type=\"module\" src=").count(), "inline script");
    assert!(!page.contains("<style"));
}

#[test]
fn all_rules_of_the_style_sheet_end() {
    // A brace that a merge loses takes all rules after it into the one before.
    let mut depth = 0;
    for (line, text) in source("studio.css").lines().enumerate() {
        let text = text.split("/*").next().unwrap();
        if !text.is_empty() && !text.starts_with([' ', '}']) {
            assert_eq!(depth, 0, "studio.css:{}: a rule before this line has not ended", line + 1);
        }
        depth += text.matches('{').count();
        depth -= text.matches('}').count();
    }
    assert_eq!(depth, 0);
}

#[test]
fn what_is_loaded_stays_small() {
    let service = Service::start(&[]);
    let page = service.get("/studio").text();
    let hash = hash(&page);
    let size = |name: &str| get_packed(&service, &format!("/studio/{hash}/{name}")).body.len();
    let names = files();
    let sum =
        |of: &dyn Fn(&str) -> bool| -> usize { names.iter().filter(|name| of(name)).map(|name| size(name)).sum() };
    // Panels come after the first picture.
    let panels = sum(&|name| name.starts_with("app/panels/"));
    let modules = sum(&|name| name.starts_with("app/")) - panels;
    let shell = modules + size("vendor/preact.js") + size("studio.css") + get_packed(&service, "/studio").body.len();
    let editor = size("vendor/editor.js");
    let all: usize = names.iter().map(|name| size(name)).sum();
    println!("gzip: modules {modules}, panels {panels}, shell {shell}, editor {editor}, all {all}");
    assert!(modules <= 80_000, "modules have {modules} bytes");
    assert!(panels <= 105_000, "panels have {panels} bytes");
    assert!(shell <= 105_000, "the page without the editor has {shell} bytes");
    assert!(editor <= 150_000, "the editor has {editor} bytes");
    // 345,000 before the page took cut answers, refusals and smaller tiles.
    assert!(all <= 347_500, "all files have {all} bytes");
}

#[test]
fn other_peoples_code_is_what_its_list_says_and_has_its_licences() {
    let list: Value = serde_json::from_str(&source("vendor/vendor.json")).unwrap();
    let lock: Value = serde_json::from_str(&source("package-lock.json")).unwrap();
    let licences = source("vendor/LICENSES.txt");
    let files = list["files"].as_array().unwrap();
    assert_eq!(files.len(), 2);
    for file in files {
        let name = file["file"].as_str().unwrap();
        let hash: String =
            Sha256::digest(source(&format!("vendor/{name}"))).iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(file["sha256"], hash, "{name} is not what web/vendor.mjs made");
        for package in file["packages"].as_array().unwrap() {
            let of = package["name"].as_str().unwrap();
            let (version, licence) = (package["version"].as_str().unwrap(), package["license"].as_str().unwrap());
            assert!(["MIT", "Apache-2.0"].contains(&licence), "{of}: {licence}");
            assert!(licences.contains(&format!("{of} {version} ({licence})\n")), "{of} has no licence text");
            let locked = &lock["packages"][format!("node_modules/{of}")];
            assert_eq!(
                (&locked["version"], &locked["integrity"]),
                (&package["version"], &package["integrity"]),
                "{of}"
            );
        }
    }
}

#[test]
fn every_example_is_a_scene_that_renders() {
    let service = Service::start(&[]);
    let list = service.get("/v1/examples").json();
    let examples = list["examples"].as_array().unwrap();
    assert!(examples.len() >= 6);
    for example in examples {
        let text = service.get(example["href"].as_str().unwrap());
        let picture = service.post_json("/v1/render?width=16&height=9&antialias=false&samples=1", &text.text());
        assert_eq!(picture.status, 200, "{}: {}", example["id"], String::from_utf8_lossy(&picture.body));
    }
    let missing = service.get("/v1/examples/no/such");
    assert_eq!(missing.status, 404);
    assert!(missing.json()["detail"].as_str().unwrap().contains("/v1/examples"));
}

#[test]
fn files_on_disk_are_read_at_each_request_and_only_from_their_folder() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("index.html"), "<link href=\"studio/{hash}/a.js\">").unwrap();
    std::fs::create_dir(folder.path().join("app")).unwrap();
    let service = Service::start(&["--studio-files", folder.path().join("app/..").to_str().unwrap()]);
    assert!(service.get("/studio").text().contains("studio/files/a.js"));
    let file = folder.path().join("app/a.js");
    for text in ["one", "two"] {
        std::fs::write(&file, text).unwrap();
        let answer = service.get("/studio/files/app/a.js");
        assert_eq!((answer.text().as_str(), answer.header("cache-control")), (text, "no-store"));
    }
    std::fs::write(folder.path().parent().unwrap().join("strahl-secret"), "secret").unwrap();
    for path in ["../strahl-secret", "app/../../strahl-secret", "%2e%2e/strahl-secret", "//etc/passwd", "app"] {
        assert_eq!(service.get(&format!("/studio/files/{path}")).status, 404, "{path}");
    }
    std::fs::remove_file(folder.path().parent().unwrap().join("strahl-secret")).unwrap();
}
