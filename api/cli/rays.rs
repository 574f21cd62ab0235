//! `strahl rays`: one JSON ray per line in, one JSON answer per line out, in the same order.

use super::failure::Failure;
use super::output;
use super::scene_args::{SceneArgs, SettingsArgs};
use super::session::Session;
use crate::service::scheduler::pool::Workers;
use clap::Args;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use strahl::inspect::query::{RayQuery, answer};
use strahl::render::Cancelled;
use strahl::scene::{Problem, Problems, Scene};

/// Most bytes of a line.
const LINE: u64 = 1 << 20;

/// `strahl rays`.
#[derive(Debug, Args)]
#[command(after_help = "\
A ray:  {\"origin\":[0,0,5],\"direction\":[0,0,-1],\"t_min\":0,\"t_max\":null}
The direction is taken as given: t counts in its units. If SCENE is -, the rays cannot come from standard input as well: \
use --rays FILE.")]
pub(super) struct RaysArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// File with the rays.
    #[arg(long, value_name = "FILE", default_value = "-")]
    rays: String,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Bytes that are read ahead, and about as many that are answered at a time.
const BATCH: usize = 1 << 20;

/// Answers rays until they end.
pub(super) fn run(args: &RaysArgs) -> Result<(), Failure> {
    if args.scene.scene == "-" && args.rays == "-" {
        return Err(Failure::Usage(
            "the scene and the rays cannot both come from standard input: use --rays FILE".into(),
        ));
    }
    let session = Session::start(&args.scene, &args.settings)?;
    let scene = session.load()?.scene;
    output::warn(&session.file.name, &scene.warnings);
    let name = if args.rays == "-" { "standard input" } else { args.rays.as_str() };
    let cannot = |error: io::Error| Failure::Input(format!("{name} cannot be read: {error}"));
    let rays: Box<dyn Read> =
        if args.rays == "-" { Box::new(io::stdin().lock()) } else { Box::new(File::open(&args.rays).map_err(cannot)?) };

    let mut rays = BufReader::with_capacity(BATCH, rays);
    let mut next_line = 1;
    let mut wrong = 0_usize;
    loop {
        let lines = read_batch(&mut rays).map_err(cannot)?;
        if lines.is_empty() {
            break;
        }
        let (text, wrong_here) = answer_lines(&scene, &lines, next_line, &session.workers)?;
        output::print(&text)?;
        next_line += lines.len();
        wrong += wrong_here;
    }
    match wrong {
        0 => Ok(()),
        1 => Err(Failure::Incomplete(format!("one line of {name} is not a ray; its answer says why"))),
        n => Err(Failure::Incomplete(format!("{n} lines of {name} are not rays; their answers say why"))),
    }
}

/// All lines that have arrived, at least one, so that a program that sends a ray and waits gets its answer.
fn read_batch<R: Read>(rays: &mut BufReader<R>) -> io::Result<Vec<Vec<u8>>> {
    let mut lines = Vec::new();
    loop {
        let mut line = Vec::new();
        if rays.by_ref().take(LINE).read_until(b'\n', &mut line)? == 0 {
            return Ok(lines);
        }
        if line.len() as u64 == LINE && line.last() != Some(&b'\n') {
            let detail = format!("a line has more than {LINE} bytes, and a ray needs a few hundred");
            return Err(io::Error::new(io::ErrorKind::InvalidData, detail));
        }
        lines.push(line);
        if !rays.buffer().contains(&b'\n') {
            return Ok(lines);
        }
    }
}

/// The answers, and how many of the lines are not rays.
fn answer_lines(
    scene: &Scene,
    lines: &[Vec<u8>],
    first: usize,
    workers: &Workers,
) -> Result<(Vec<u8>, usize), Cancelled> {
    let answers: Vec<_> = workers.work(|| lines.par_iter().map(|line| answer_line(scene, line)).collect())?;
    let mut text = Vec::new();
    let mut wrong = 0;
    for (i, answer) in answers.into_iter().enumerate() {
        match answer {
            Ok(json) => text.extend(json.into_bytes()),
            Err(error) => {
                wrong += 1;
                text.extend(serde_json::json!({ "error": error, "line": first + i }).to_string().into_bytes());
            }
        }
        text.push(b'\n');
    }
    Ok((text, wrong))
}

fn answer_line(scene: &Scene, line: &[u8]) -> Result<String, String> {
    let line = std::str::from_utf8(line).map_err(|_| "this is not UTF-8 text")?;
    let ray: RayQuery = line.parse().map_err(|Problems(found)| {
        // Its line is that of the input, which stands beside the error.
        let sentences = found.into_iter().map(|problem| Problem { line: None, column: None, ..problem }.to_string());
        format!("this is not a ray: {}", sentences.collect::<Vec<_>>().join("; "))
    })?;
    serde_json::to_string(&answer(scene, &ray)).map_err(|error| error.to_string())
}
