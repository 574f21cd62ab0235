//! The command as its users see it: the real binary, its files, its streams, its exit codes.

mod inspection;
mod pictures;
mod scenes;
mod tradeoffs;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

const BALL: &str = r#"{
  "version": 1,
  "image": { "width": 40, "height": 30 },
  "camera": { "pinhole": { "eye": [0, 1, 5], "look_at": [0, 0.5, 0] } },
  "materials": { "red": { "diffuse": [0.8, 0.2, 0.1], "reflection": 0.2 } },
  "objects": [
    { "sphere": { "center": [0, 1, 0], "radius": 1, "material": "red" } },
    { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0] } }
  ]
}"#;

const NFF: &str = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 16 16\nb 0.1 0.2 0.3\n\
                   l 3 3 3\nf 1 0.5 0.2 0.8 0.2 10 0 1\ns 0 0 0 1\n";

/// A folder of its own for each test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli").join(test);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("ball.json"), BALL).unwrap();
    std::fs::write(folder.join("ball.nff"), NFF).unwrap();
    folder
}

fn strahl(folder: &Path, args: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_strahl"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A command that does not read its input may be gone already.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    child.wait_with_output().unwrap()
}

/// Most resident bytes of a command that succeeds, as far as one sees from outside until it ends.
#[cfg(target_os = "linux")]
fn most_resident(folder: &Path, args: &[&str]) -> u64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_strahl"));
    let mut child = command.args(args).current_dir(folder).stderr(Stdio::null()).spawn().unwrap();
    let mut most = 0;
    loop {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
        most = most.max(kilobytes.unwrap_or(0) * 1_024);
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{status}");
            return most;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[track_caller]
fn done(folder: &Path, args: &[&str], input: &str) -> Vec<u8> {
    let output = strahl(folder, args, input);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

#[track_caller]
fn fails(folder: &Path, args: &[&str], input: &str, code: i32, part: &str) {
    let output = strahl(folder, args, input);
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
    let error = text.lines().find(|line| !line.starts_with("warning: ")).unwrap_or_default();
    assert!(error.starts_with("error: ") && text.contains(part), "{args:?}: {part} in {text}");
}

fn size(png: &[u8]) -> (u32, u32) {
    let picture = image::load_from_memory(png).unwrap();
    (picture.width(), picture.height())
}
