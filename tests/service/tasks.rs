//! The commands that managers of other farms run many times: parts of pictures and frames, and their exit codes.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const BALL: &str = crate::common::BALL;

/// A folder of its own for each test, with a scene in it.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tasks").join(test);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("ball.json"), BALL).unwrap();
    folder
}

fn strahl(folder: &Path, line: &str, index: Option<u32>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_strahl"));
    command
        .args(line.split_whitespace())
        .current_dir(folder)
        .env_remove("STRAHL_STORE")
        .env_remove("JOB_COMPLETION_INDEX");
    index.map(|index| command.env("JOB_COMPLETION_INDEX", index.to_string()));
    command.output().unwrap()
}

fn done(folder: &Path, line: &str, index: Option<u32>) {
    let output = strahl(folder, line, index);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Runs a command that fails; its message.
fn fails(folder: &Path, line: &str, code: i32) -> String {
    let output = strahl(folder, line, None);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{line}: {said}");
    said
}

#[test]
fn parts_make_the_bytes_of_the_whole_picture() {
    let folder = folder("parts");
    for (settings, of, parts, ending) in [
        ("", "1", 1, "png"),
        ("--samples 4 --accuracy proved:0", "5", 5, "png"),
        ("--accuracy statistical:4", "3x2", 6, "png"),
        ("--accuracy fixed --precision double", "4x4", 16, "exr"),
        ("", "7", 7, "jpg"),
    ] {
        done(&folder, &format!("render ball.json -o whole.{ending} {settings}"), None);
        for index in (0..parts).rev() {
            let threads = 1 + index % 2;
            let line = format!("tile ball.json --of {of} -o tiles/{{index}}.tile --threads {threads} {settings}");
            done(&folder, &line, Some(index));
        }
        let line = format!(
            "assemble ball.json tiles/{{index}}.tile --of {of} -o made/ball.{ending} {settings} --stats made/cost.json"
        );
        done(&folder, &line, None);
        let read = |file: &str| std::fs::read(folder.join(format!("{file}.{ending}"))).unwrap();
        assert!(read("whole") == read("made/ball"), "{settings} {of}");
        let cost: Value = serde_json::from_slice(&std::fs::read(folder.join("made/cost.json")).unwrap()).unwrap();
        done(&folder, &format!("render ball.json -o whole.{ending} {settings} --stats whole.json"), None);
        let whole: Value = serde_json::from_slice(&std::fs::read(folder.join("whole.json")).unwrap()).unwrap();
        assert_eq!(cost["error"], whole["error"]);
        // Each part looks at the pixels around it, too, to know where contrast is.
        let camera = |report: &Value| report["cost"]["rays"]["camera"].as_u64().unwrap();
        assert!(camera(&cost) >= camera(&whole), "{settings} {of}");
    }
}

#[test]
fn parts_and_scenes_may_be_in_a_store() {
    let folder = folder("store");
    std::fs::create_dir_all(folder.join("store/scenes")).unwrap();
    std::fs::copy(folder.join("ball.json"), folder.join("store/scenes/ball.json")).unwrap();
    for index in 1..=3 {
        let line = "tile store:scenes/ball.json --of 3 --first 1 -o store:tiles/{index}.tile --store store";
        done(&folder, line, Some(index));
    }
    let line =
        "assemble store:scenes/ball.json store:tiles/{index}.tile --of 3 --first 1 -o store:ball.png --store store";
    done(&folder, line, None);
    done(&folder, "render ball.json -o whole.png", None);
    assert!(std::fs::read(folder.join("whole.png")).unwrap() == std::fs::read(folder.join("store/ball.png")).unwrap());
}

#[test]
fn frames_have_numbers_in_their_names() {
    let folder = folder("frames");
    std::fs::copy(folder.join("ball.json"), folder.join("ball.0012.json")).unwrap();
    done(&folder, "frame ball.{frame}.json -o out/{frame}.png --stats out/{frame}.json", Some(12));
    done(&folder, "render ball.json -o whole.png", None);
    assert!(std::fs::read(folder.join("whole.png")).unwrap() == std::fs::read(folder.join("out/0012.png")).unwrap());
    assert!(folder.join("out/0012.json").is_file());
    assert!(fails(&folder, "frame ball.{frame}.json --frame 13 -o out/{frame}.png", 66).contains("ball.0013.json"));
}

#[test]
fn a_frame_of_a_sequence_is_the_scene_seen_from_there() {
    let folder = folder("sequence");
    std::fs::write(folder.join("turn.json"), r#"{ "count": 4, "turntable": {} }"#).unwrap();
    for frame in [0, 2] {
        done(&folder, "frame ball.json --sequence turn.json -o out/{frame}.png", Some(frame));
    }
    done(&folder, "render ball.json -o whole.png", None);
    let read = |file: &str| std::fs::read(folder.join(file)).unwrap();
    assert!(read("whole.png") == read("out/0000.png"), "the first frame is where the camera is");
    assert!(read("whole.png") != read("out/0002.png"));
    assert!(fails(&folder, "frame ball.json --sequence turn.json --frame 4 -o a.png", 2).contains("0 to 3"));
    std::fs::write(folder.join("bad.json"), r#"{ "count": 0 }"#).unwrap();
    fails(&folder, "frame ball.json --sequence bad.json --frame 0 -o a.png", 65);
    std::fs::write(folder.join("none.json"), "[]").unwrap();
    fails(&folder, "frame ball.json --sequence none.json --frame 0 -o a.png", 65);
    fails(&folder, "frame ball.json --sequence gone.json --frame 0 -o a.png", 66);
}

#[test]
fn exit_codes_say_whether_another_try_makes_sense() {
    let folder = folder("codes");
    std::fs::write(folder.join("bad.json"), BALL.replace("\"red\" }", "\"blue\" }")).unwrap();
    std::fs::write(folder.join("file"), "").unwrap();
    assert!(fails(&folder, "tile bad.json --of 2 --index 0 -o a.tile", 65).contains("blue"));
    fails(&folder, "frame bad.json --frame 0 -o a.png", 65);
    assert!(fails(&folder, "tile gone.json --of 2 --index 0 -o a.tile", 66).contains("gone.json"));
    assert!(fails(&folder, "tile ball.json --of 2 --index 0 -o file/a.tile", 73).contains("file/a.tile"));
    assert!(fails(&folder, "tile ball.json --of 2 --index 2 -o a.tile", 2).contains("0 to 1"));
    assert!(fails(&folder, "tile ball.json --of 2 --index 0 --first 1 -o a.tile", 2).contains("1 to 2"));
    assert!(fails(&folder, "tile ball.json --of 33 --index 0 -o a.tile", 2).contains("48 x 32"));
    assert!(fails(&folder, "tile ball.json --of 2 --index 0 -o a.tile --accuracy time:50", 2).contains("--accuracy"));
    assert!(fails(&folder, "tile store:a.json --of 2 --index 0 -o a.tile", 2).contains("--store"));
    fails(&folder, "tile ball.json --of 2 --index 0 -o store:a.tile --store file", 75);
    fails(&folder, "tile ball.json --of 2 -o a.tile", 2);
    assert!(!folder.join("a.tile").exists());

    done(&folder, "tile ball.json --of 2 --index 0 -o 0.tile", None);
    assert!(fails(&folder, "assemble ball.json {index}.tile --of 2 -o a.png", 66).contains("1.tile"));
    done(&folder, "tile ball.json --of 2 --index 1 --samples 2 -o 1.tile", None);
    assert!(fails(&folder, "assemble ball.json {index}.tile --of 2 -o a.png", 65).contains("other settings"));
    done(&folder, "tile ball.json --of 3 --index 1 -o 1.tile", None);
    assert!(fails(&folder, "assemble ball.json {index}.tile --of 2 -o a.png", 65).contains("a part of 3, not of 2"));
    std::fs::copy(folder.join("0.tile"), folder.join("1.tile")).unwrap();
    assert!(fails(&folder, "assemble ball.json {index}.tile --of 2 -o a.png", 65).contains("not part 1"));
    done(&folder, "tile ball.json --of 2 --index 1 -o 1.tile", None);
    let whole = std::fs::read(folder.join("1.tile")).unwrap();
    for spoilt in [&whole[..whole.len() - 1], &[&whole[..], b"x"].concat(), &whole[..40], b"", b"{}\n"] {
        std::fs::write(folder.join("1.tile"), spoilt).unwrap();
        fails(&folder, "assemble ball.json {index}.tile --of 2 -o a.png", 65);
    }
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    std::fs::write(folder.join("1.tile"), flipped).unwrap();
    assert!(fails(&folder, "assemble ball.json {index}.tile --of 2 -o a.png", 65).contains("damaged"));
    fails(&folder, "assemble ball.json 0.tile --of 2 -o a.png", 2);
    assert!(!folder.join("a.png").exists());
}
