//! Reads a scene from a file or standard input, and finds its format.

use super::failure::Failure;
use super::scene_args::SceneArgs;
use super::scene_inputs::SceneInputs;
use std::io::{self, Read};
use std::path::Path;
use strahl::models::ModelFormat;
use strahl::scene::limits::SCENE_BYTES;
use strahl::scene::nff::NffOptions;
use strahl::scene::recognise::{Recognised, recognise, recognise_start};
use strahl::scene::{Format, Loaded, Overrides, load_with};

/// The bytes of a scene.
#[derive(Debug)]
pub(super) struct SceneFile {
    /// File name, or `standard input`: for error messages.
    pub(super) name: String,
    /// Everything in it.
    pub(super) bytes: Vec<u8>,
    /// Which format it is in.
    pub(super) format: Format,
    /// What is read for it.
    pub(super) inputs: SceneInputs,
}

impl SceneFile {
    /// Reads the scene that the arguments name.
    pub(super) fn read(scene: &SceneArgs) -> Result<Self, Failure> {
        let (name, bytes) = read(&scene.scene)?;
        Ok(Self::given(scene, name, bytes))
    }

    /// The scene that the arguments name, whose bytes are known.
    pub(super) fn given(scene: &SceneArgs, name: String, bytes: Vec<u8>) -> Self {
        let format = scene.input.or_else(|| by_name(&scene.scene)).unwrap_or_else(|| by_content(&bytes));
        Self { name, bytes, format, inputs: SceneInputs::of(Path::new(&scene.scene)) }
    }

    /// The format of a model that is JSON, which its keys tell.
    pub(super) fn hidden_model(&self) -> Option<ModelFormat> {
        (recognise(&self.bytes) == Recognised::Gltf).then_some(ModelFormat::Gltf)
    }

    /// Reads, checks and compiles the scene.
    pub(super) fn load(&self, overrides: &Overrides) -> Result<Loaded, Failure> {
        self.load_text(&self.bytes, overrides)
    }

    /// The same for the last time: the text is given away, so that the hierarchy can be built where it was.
    pub(super) fn load_last(&mut self, overrides: &Overrides) -> Result<Loaded, Failure> {
        let text = std::mem::take(&mut self.bytes);
        self.load_text(text, overrides)
    }

    fn load_text(&self, text: impl AsRef<[u8]>, overrides: &Overrides) -> Result<Loaded, Failure> {
        if self.format != Format::Nff && overrides.nff != NffOptions::default() {
            let what = "--two-sided and --spd-counts are for NFF files; in JSON, materials have \"one_sided\"";
            return Err(Failure::Usage(what.into()));
        }
        load_with(text, self.format, overrides, &self.inputs)
            .map_err(|problems| Failure::Scene { name: self.name.clone(), problems })
    }
}

/// The whole of a file, or of standard input for `-`; its name and its bytes.
pub(super) fn read(path: &str) -> Result<(String, Vec<u8>), Failure> {
    let name = if path == "-" { "standard input" } else { path };
    let cannot = |error: io::Error| Failure::Input(format!("{name} cannot be read: {error}"));
    let file: Box<dyn Read> =
        if path == "-" { Box::new(io::stdin().lock()) } else { Box::new(std::fs::File::open(path).map_err(cannot)?) };
    let mut bytes = Vec::new();
    // The loader refuses anything longer than the limit, so one byte more is enough, also of an endless input.
    file.take(SCENE_BYTES.max + 1).read_to_end(&mut bytes).map_err(cannot)?;
    Ok((name.to_owned(), bytes))
}

fn by_name(path: &str) -> Option<Format> {
    let path = path.to_ascii_lowercase();
    if path.ends_with(".json") {
        Some(Format::Json)
    } else if path.ends_with(".nff") || path.ends_with(".nff.gz") {
        Some(Format::Nff)
    } else if path.ends_with(".glb") || path.ends_with(".gltf") {
        Some(Format::Gltf)
    } else if path.ends_with(".obj") {
        Some(Format::Obj)
    } else if path.ends_with(".stl") {
        Some(Format::Stl)
    } else if path.ends_with(".ply") {
        Some(Format::Ply)
    } else {
        None
    }
}

/// The format by content. What is no scene is refused when it is read, by its name if it is known.
fn by_content(bytes: &[u8]) -> Format {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let recognised = recognise_start(bytes);
    if let Some(model) = recognised.model() {
        return model;
    }
    match recognised {
        Recognised::Nff => Format::Nff,
        // Text of a Sense8 file is refused by the reader of NFF.
        Recognised::Unknown if text.first().is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'#') => {
            Format::Nff
        }
        _ => Format::Json,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_known_by_name_or_by_content() {
        assert_eq!(by_name("a/B.JSON"), Some(Format::Json));
        assert_eq!(by_name("balls.nff.gz"), Some(Format::Nff));
        assert_eq!(by_name("Fox.GLB"), Some(Format::Gltf));
        assert_eq!(by_name("-"), None);
        assert_eq!(by_content(b"\xef\xbb\xbf\n {}"), Format::Json);
        assert_eq!(by_content(b"v\nfrom 0 0 1"), Format::Nff);
        assert_eq!(by_content(b"\x1f\x8b\x08"), Format::Nff);
        assert_eq!(by_content(b"glTF\x02\0\0\0"), Format::Gltf);
        assert_eq!(by_content(b""), Format::Json);
    }
}
