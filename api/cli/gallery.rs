//! `strahl gallery`: many scenes as one page, each picture with its price and its bound.

use super::failure::Failure;
use super::interrupt;
use super::scene_args::{SceneArgs, SettingsArgs};
use super::session::Session;
use super::{output, progress};
use crate::service::pictures::render::{self, RenderSpec, Rendered};
use crate::service::pictures::report::Report;
use crate::service::scenes::prepared::PreparedScene;
use clap::Args;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use strahl::film::{FileFormat, Region};
use strahl::render::Control;
use strahl::tradeoff::duration;

/// `strahl gallery`.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: strahl gallery scenes -o gallery.html")]
pub(super) struct GalleryArgs {
    /// Scene files, or folders with scenes, which are searched with all folders in them.
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Page with all pictures; - for standard output.
    #[arg(short, long, value_name = "FILE.html", default_value = "gallery.html")]
    output: PathBuf,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Ends of the names of scene files and models in folders.
const SCENES: [&str; 8] = [".json", ".nff", ".nff.gz", ".glb", ".gltf", ".obj", ".stl", ".ply"];
/// Quality of the JPEGs on the page.
const QUALITY: u8 = 90;

/// Renders all, one after the other.
pub(super) fn run(args: &GalleryArgs) -> Result<(), Failure> {
    output::check_folder(&args.output)?;
    let mut files = Vec::new();
    for path in &args.scenes {
        find(path, &mut files)?;
    }
    if files.is_empty() {
        return Err(Failure::Input("there is no scene in these folders".into()));
    }
    let control = Control::default();
    interrupt::cancel_on_ctrl_c(&control)?;
    let mut page = HEAD.to_owned();
    for (done, file) in files.iter().enumerate() {
        let name = file.display().to_string();
        let (picture, title, report) = picture(&name, args, &control)?;
        output::say(&format!("{} of {}: {name}", done + 1, files.len()));
        figure(&mut page, &picture, title.as_deref(), &name, &report);
    }
    page.push_str("</main>\n");
    output::write(&args.output, page.as_bytes())?;
    if !output::is_standard(&args.output) {
        output::say(&format!("wrote {}", args.output.display()));
    }
    Ok(())
}

/// A scene file, or all scene files of a folder in the order of their names.
fn find(path: &Path, files: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let cannot = |error: std::io::Error| Failure::Input(format!("{} cannot be read: {error}", path.display()));
    if !path.is_dir() {
        files.push(path.to_owned());
        return Ok(());
    }
    let entries: Result<Vec<_>, _> = std::fs::read_dir(path).map_err(cannot)?.map(|e| e.map(|e| e.path())).collect();
    let mut entries = entries.map_err(cannot)?;
    entries.sort();
    let is_scene = |path: &PathBuf| {
        let name = path.to_string_lossy().to_ascii_lowercase();
        path.is_dir() || SCENES.iter().any(|ending| name.ends_with(ending))
    };
    entries.iter().filter(|path| is_scene(path)).try_for_each(|path| find(path, files))
}

/// The JPEG of a scene, the scene's name, and what it cost.
fn picture(file: &str, args: &GalleryArgs, control: &Control) -> Result<(Vec<u8>, Option<String>, Report), Failure> {
    let scene = SceneArgs { scene: file.to_owned(), input: None };
    let session = Session::with(&scene, &args.settings, control.clone())?;
    let loaded = session.load()?;
    session.file.inputs.check_outputs([args.output.as_path()])?;
    output::warn(&session.file.name, &loaded.scene.warnings);
    let title = loaded.description.name.clone();
    let ready = session.workers.work(|| PreparedScene::without_id(loaded))?;
    let region = Region::whole(ready.scene.width, ready.scene.height);
    let shot = RenderSpec::of(&ready.scene, region, FileFormat::Jpeg(QUALITY));
    let make = || render::make(session.started, &ready, ready.loading, &shot, &session.workers, control, None, None);
    let Rendered { file, report, .. } = progress::while_showing(control, make)?;
    Ok((file, title, report))
}

fn figure(page: &mut String, picture: &[u8], title: Option<&str>, file: &str, report: &Report) {
    let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    let Region { width, height, .. } = report.replay.region;
    // Writing to a String cannot fail.
    let _ = write!(
        page,
        "<figure><img loading=\"lazy\" width=\"{width}\" height=\"{height}\" alt=\"{0}\" src=\"data:image/jpeg;base64,{1}\">\
         <figcaption><b>{2}</b><span>{3}, {4:.1} million rays, {width} x {height}</span><span>{5}</span>\
         <code>strahl render {0}</code></figcaption></figure>",
        escape(file),
        data_encoding::BASE64.encode(picture),
        escape(title.unwrap_or(file)),
        duration(report.cost.wall_ms),
        report.cost.rays.total() as f64 / 1e6,
        escape(&report.error.in_words())
    );
}

const HEAD: &str = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
    content=\"width=device-width\"><title>strahl: gallery</title><style>:root{color-scheme:light dark}\
    body{font:15px/1.45 system-ui,sans-serif;margin:0;color:#222;background:#fafafa}\
    main{max-width:1400px;margin:0 auto;padding:12px;display:grid;gap:24px 18px;\
    grid-template-columns:repeat(auto-fill,minmax(min(100%,420px),1fr))}figure{margin:0}\
    img{display:block;width:100%;height:auto;max-height:440px;object-fit:contain;background:#0002;border-radius:4px}\
    figcaption{display:grid;gap:2px;padding-top:6px}span,code{color:#666;font-size:.9em;overflow-wrap:anywhere}\
    @media(prefers-color-scheme:dark){body{color:#ddd;background:#15171a}span,code{color:#aaa}}</style><main>";
