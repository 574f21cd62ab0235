//! The files of the studio: `web/` and some scenes, as parts of the program.

use flate2::Compression;
use flate2::write::GzEncoder;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Component, Path};
use std::sync::{LazyLock, OnceLock};

/// A path below `web/`, and the bytes.
type Part = (&'static str, &'static [u8]);

/// The page. The hash of all files and the list of modules are put into it.
const PAGE: &str = include_str!("../../../../web/index.html");

macro_rules! web {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_bytes!(concat!("../../../../web/", $path)))),*]
    };
}

/// Everything that the page loads. A test compares the list with the folder.
const FILES: &[Part] = web![
    "app/api.js",
    "app/assist.js",
    "app/bar.js",
    "app/base.js",
    "app/camera.js",
    "app/commands.js",
    "app/dialogs.js",
    "app/edit-pane.js",
    "app/editor-look.js",
    "app/editor.js",
    "app/framing.js",
    "app/gestures.js",
    "app/ladder.js",
    "app/link.js",
    "app/looking.js",
    "app/main.js",
    "app/panels/accuracy-dial.js",
    "app/panels/accuracy-plot.js",
    "app/panels/accuracy-stamp.js",
    "app/panels/accuracy-stops.js",
    "app/panels/accuracy.js",
    "app/panels/compare-flip.js",
    "app/panels/compare-layer.js",
    "app/panels/compare-metrics.js",
    "app/panels/compare-overlay.js",
    "app/panels/compare-pictures.js",
    "app/panels/compare.js",
    "app/panels/farm-model.js",
    "app/panels/farm.js",
    "app/panels/jobs-list.js",
    "app/panels/jobs-model.js",
    "app/panels/jobs-row.js",
    "app/panels/jobs-show.js",
    "app/panels/jobs-submit.js",
    "app/panels/jobs-thumbs.js",
    "app/panels/jobs.js",
    "app/panels/maps-load.js",
    "app/panels/maps-objects.js",
    "app/panels/maps.js",
    "app/panels/pfm.js",
    "app/panels/pixel-asked.js",
    "app/panels/pixel-glow.js",
    "app/panels/pixel-icicle.js",
    "app/panels/pixel-links.js",
    "app/panels/pixel-objects.js",
    "app/panels/pixel-outline.js",
    "app/panels/pixel-outside.js",
    "app/panels/pixel-overlay.js",
    "app/panels/pixel-projection.js",
    "app/panels/pixel-ray.js",
    "app/panels/pixel-rays.js",
    "app/panels/pixel-sum.js",
    "app/panels/pixel.js",
    "app/panels/plan-measured.js",
    "app/panels/plan-rows.js",
    "app/panels/plan-without.js",
    "app/panels/plan.js",
    "app/panels/registry.js",
    "app/panels/widgets.js",
    "app/pareto.js",
    "app/picking.js",
    "app/picture-pane.js",
    "app/picture.js",
    "app/pointers.js",
    "app/problems.js",
    "app/ramps.js",
    "app/report.js",
    "app/scenes.js",
    "app/schema.js",
    "app/scrub.js",
    "app/session.js",
    "app/share.js",
    "app/sse.js",
    "app/state.js",
    "app/strip.js",
    "app/theme.js",
    "app/tiles.js",
    "app/ui.js",
    "app/values.js",
    "app/viewport.js",
    "icon.svg",
    "studio.css",
    "vendor/LICENSES.txt",
    "vendor/editor.js",
    "vendor/preact.js",
];

/// A scene to begin with.
pub(super) struct Example {
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    pub(super) about: &'static str,
    pub(super) text: &'static str,
}

macro_rules! examples {
    ($($path:literal, $title:literal, $about:literal;)*) => {
        &[$(Example {
            id: $path,
            title: $title,
            about: $about,
            text: include_str!(concat!("../../../../scenes/", $path, ".json")),
        }),*]
    };
}

/// What the studio offers to begin with. Hard cases are among them.
pub(super) const EXAMPLES: &[Example] = examples![
    "whitted/whitted", "Whitted 1980", "A mirror ball, a glass ball and a floor: the picture that began recursion.";
    "refraction/glass_of_water", "Glass of water", "Three media, nested: glass, water and air.";
    "mirrors/hall", "Hall of mirrors", "Parallel mirrors: what depth 3, 5 and 100 change.";
    "effects/gloss", "Rough mirrors", "Reflections that blur with distance.";
    "lights/stage", "Stage", "Spotlights with colors.";
    "homage/lute", "Lute", "After the drawings of the first perspectives.";
    "effects/dispersion", "Dispersion", "Glass that bends blue more than red.";
    "spheres/flake_4", "Sphere flake", "7,381 mirror balls.";
    "effects/fog", "Fog", "Light that fades on its way.";
    "hard/inside_glass", "Hard case: inside glass", "The camera stands in the glass.";
    "hard/touching", "Hard case: touching", "Surfaces that touch without a gap.";
];

/// A file, and whether it is compressed with gzip.
pub(super) struct Served {
    pub(super) bytes: &'static [u8],
    pub(super) is_packed: bool,
}

/// The files as they are served.
pub(super) struct Site {
    /// It names the folder of the files, so that each of them may be kept for ever.
    pub(super) hash: String,
    page: String,
    packed_page: OnceLock<Vec<u8>>,
    packed: Vec<OnceLock<Vec<u8>>>,
}

/// Made at the first request, so that the service starts no later.
pub(super) static SITE: LazyLock<Site> = LazyLock::new(|| {
    let mut hash = Sha256::new_with_prefix(PAGE);
    for (path, bytes) in FILES {
        hash.update(path);
        hash.update(bytes);
    }
    let hash: String = hash.finalize().iter().take(8).fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    });
    let page = page(PAGE, &hash);
    Site { hash, page, packed_page: OnceLock::new(), packed: FILES.iter().map(|_| OnceLock::new()).collect() }
});

impl Site {
    /// The page.
    pub(super) fn page(&'static self, packed: bool) -> Served {
        served(self.page.as_bytes(), &self.packed_page, packed)
    }

    /// A file by its path.
    pub(super) fn file(&'static self, path: &str, packed: bool) -> Option<Served> {
        let index = FILES.iter().position(|(known, _)| *known == path)?;
        Some(served(FILES[index].1, &self.packed[index], packed))
    }
}

fn served(bytes: &'static [u8], kept: &'static OnceLock<Vec<u8>>, packed: bool) -> Served {
    if !packed {
        return Served { bytes, is_packed: false };
    }
    let pack = || {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        // Writing to memory cannot fail.
        let _ = encoder.write_all(bytes);
        encoder.finish().unwrap_or_default()
    };
    Served { bytes: kept.get_or_init(pack), is_packed: true }
}

/// A page with the hash of its files, and with all modules: else the browser would find them one after the other. Panels come
/// after the first picture.
pub(super) fn page(template: &str, hash: &str) -> String {
    let is_module = |path: &&str| path.starts_with("app/") && path.ends_with(".js");
    let modules: String =
        FILES.iter().map(|(path, _)| *path).filter(is_module).fold(String::new(), |mut text, path| {
            let later = if path.starts_with("app/panels/") { " fetchpriority=\"low\"" } else { "" };
            let _ = writeln!(text, "<link rel=\"modulepreload\" href=\"studio/{hash}/{path}\"{later}>");
            text
        });
    template.replace("<!-- modules -->\n", &modules).replace("{hash}", hash)
}

/// A file of a folder on disk, for people who change the studio.
pub(super) fn from_disk(folder: &Path, path: &str) -> Option<Vec<u8>> {
    let path = Path::new(path);
    let is_inside = path.components().all(|part| matches!(part, Component::Normal(_)));
    is_inside.then(|| std::fs::read(folder.join(path)).ok())?
}
