//! What goes between fronts and nodes beside tiles: pieces of work, notes that one was begun, and why one was given up.
//! Each is JSON with its version; fields that are not known are skipped.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::ops::Not;
use strahl::camera::Window;
use strahl::film::Region;
use strahl::scene::{Format, Overrides};

/// The version of a piece of work. Raise it when a node of the version before would render another picture.
const VERSION: u32 = 1;
/// Bytes of a scene's text that a node takes.
pub(crate) const SCENE_BYTES: u64 = 1 << 32;

/// Tiles of a picture that one node renders one after the other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Piece {
    v: u32,
    /// The job, or another name for the render of a request.
    pub(crate) job: String,
    /// Its tenant.
    pub(crate) tenant: String,
    /// Which coordinator of the job has sent it: one that takes over is another.
    #[serde(rename = "life")]
    pub(crate) session: String,
    /// Number of the piece among those of that coordinator.
    pub(crate) piece: u64,
    /// What is rendered.
    pub(crate) scene: SceneSource,
    /// Which grid of pixels its picture has.
    pub(crate) view: View,
    /// The tiles.
    pub(crate) tiles: Vec<TilePlace>,
    /// Seconds that all of it may take.
    pub(crate) limit_s: f64,
}

/// A scene in the store, and the settings that replace its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SceneSource {
    /// Name of its text: the SHA-256.
    pub(crate) text: String,
    /// The format of the text.
    pub(crate) format: Format,
    /// The settings.
    pub(crate) settings: Overrides,
    /// The frame, if the text is that of a sequence and its scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) frame: Option<u32>,
}

impl SceneSource {
    /// The name of a scene's text.
    pub(crate) fn name_of(text: &[u8]) -> String {
        data_encoding::HEXLOWER.encode(&Sha256::digest(text))
    }

    /// Where the text is in the store.
    pub(crate) fn blob(&self) -> String {
        format!("scenes/{}", self.text)
    }
}

/// A window of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct View {
    origin: [f64; 2],
    step: [f64; 2],
    size: [u32; 2],
}

impl From<Window> for View {
    fn from(Window { origin, step, width, height }: Window) -> Self {
        Self { origin, step, size: [width, height] }
    }
}

impl From<View> for Window {
    fn from(View { origin, step, size: [width, height] }: View) -> Self {
        Self { origin, step, width, height }
    }
}

/// A tile: its number and its region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct TilePlace(pub(crate) u32, [u32; 4]);

impl TilePlace {
    /// The tile of a number.
    pub(crate) fn new(number: u32, Region { x, y, width, height }: Region) -> Self {
        Self(number, [x, y, width, height])
    }

    /// Its region.
    pub(crate) fn region(self) -> Region {
        let [x, y, width, height] = self.1;
        Region { x, y, width, height }
    }
}

/// Why a message is no piece of work for this node.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum NotWork {
    /// A front of another version has sent it: a node of that version will come.
    OtherVersion(u32),
    /// It is damaged.
    Broken(String),
}

impl Piece {
    /// A piece of this version.
    pub(crate) fn new(
        [job, tenant, session]: [&str; 3],
        piece: u64,
        scene: &SceneSource,
        view: View,
        tiles: Vec<TilePlace>,
        limit_s: f64,
    ) -> Self {
        let [job, tenant, session] = [job, tenant, session].map(str::to_owned);
        Self { v: VERSION, job, tenant, session, piece, scene: scene.clone(), view, tiles, limit_s }
    }

    /// As the payload of a message.
    pub(crate) fn write(&self) -> Vec<u8> {
        // Its keys are texts, so this cannot fail.
        serde_json::to_vec(self).unwrap_or_default()
    }

    /// From the payload of a message.
    pub(crate) fn read(payload: &[u8]) -> Result<Self, NotWork> {
        #[derive(Deserialize)]
        struct Version {
            v: u32,
        }
        let broken = |error: serde_json::Error| NotWork::Broken(error.to_string());
        let Version { v } = serde_json::from_slice(payload).map_err(broken)?;
        if v != VERSION {
            return Err(NotWork::OtherVersion(v));
        }
        let piece: Self = serde_json::from_slice(payload).map_err(broken)?;
        let [width, height] = piece.view.size;
        match piece.tiles.iter().all(|tile| tile.region().pixels() > 0 && tile.region().fits(width, height)) {
            true => Ok(piece),
            false => Err(NotWork::Broken("a tile lies outside of the picture".into())),
        }
    }
}

/// A node has begun with a piece.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Begun {
    /// The number of the piece.
    pub(crate) piece: u64,
    /// The node.
    pub(crate) node: String,
    /// It has too little memory for the scene, so it has not begun after all.
    #[serde(default, skip_serializing_if = "Not::not")]
    pub(crate) refused: bool,
}

/// Work was given up.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Dead {
    /// The job.
    pub(crate) job: String,
    /// Its tenant.
    pub(crate) tenant: String,
    /// How.
    pub(crate) kind: Death,
    /// In words.
    pub(crate) reason: String,
    /// Tiles that are missing, by number.
    pub(crate) tiles: Vec<u32>,
    /// The node that says so, if it is one.
    pub(crate) node: Option<String>,
}

/// How work was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Death {
    /// Rendering it has failed again and again.
    Failed,
    /// Nodes that rendered it have ended, or have stopped to get on, again and again.
    Killed,
    /// Two nodes have made different pixels of one tile.
    Differs,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece() -> Piece {
        let scene =
            SceneSource { text: "ab".into(), format: Format::Json, settings: Overrides::default(), frame: None };
        // A window whose numbers have no short decimal form.
        let window = Window::part([0.1, 1.0 / 3.0], [std::f64::consts::PI, 2.7], 64, 48);
        let tile = TilePlace::new(7, Region { x: 32, y: 0, width: 32, height: 48 });
        Piece::new(["job", "acme", "1"], 3, &scene, window.into(), vec![tile], 60.0)
    }

    #[test]
    fn work_arrives_to_the_last_bit() {
        let piece = piece();
        assert_eq!(Piece::read(&piece.write()), Ok(piece));
    }

    #[test]
    fn work_of_another_version_is_told_from_damaged_work() {
        let text = String::from_utf8(piece().write()).unwrap();
        let newer = text.replace("{\"v\":1", "{\"unheard\":[],\"v\":1");
        assert_eq!(Piece::read(newer.as_bytes()), Ok(piece()), "what is not known is skipped");
        assert_eq!(Piece::read(br#"{"v":2,"tiles":"other"}"#), Err(NotWork::OtherVersion(2)));
        for broken in [&text[..40], "{}", "[]", "", &text.replace("32,48]", "33,48]"), &text.replace("32,48]", "0,48]")]
        {
            assert!(matches!(Piece::read(broken.as_bytes()), Err(NotWork::Broken(_))), "{broken}");
        }
    }
}
