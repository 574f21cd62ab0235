//! The file of one part of a picture: a line that says what it is, and the part as bytes, with a hash over both. It has linear
//! light and the bounds of pixels, so that the picture of all parts has the bytes that it has when it is rendered at once.

use super::failure::{BAD_DATA, Failure};
use super::scene_inputs::SceneInputs;
use crate::service::pictures::tile_bytes::{Owner, Tile};
use crate::service::scenes::ids::renderer;
use crate::service::scenes::prepared::PreparedScene;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;
use strahl::film::Region;
use strahl::render::Picture;

/// Parts of a picture.
const MOST: u32 = 1_000_000;
/// Bytes of the line.
const LINE: usize = 1_024;

/// How a picture is cut into parts: columns and rows, whose sizes differ by one pixel at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cut {
    columns: u32,
    rows: u32,
}

impl Cut {
    /// Number of parts.
    pub(super) fn parts(self) -> u32 {
        self.columns * self.rows
    }

    /// The part of a manager's number, from 0.
    pub(super) fn part(self, index: u32, first: u32) -> Result<u32, Failure> {
        index.checked_sub(first).filter(|part| *part < self.parts()).ok_or_else(|| {
            let last = first.saturating_add(self.parts() - 1);
            Failure::Usage(format!("--index {index} is none of the parts {first} to {last} of --of {self}"))
        })
    }

    /// The pixels of a part, row by row of parts.
    pub(super) fn region(self, part: u32, [width, height]: [u32; 2]) -> Result<Region, Failure> {
        if self.columns > width || self.rows > height {
            return Err(Failure::Usage(format!(
                "--of {self} are more parts than the picture of {width} x {height} has pixels"
            )));
        }
        let edge = |at: u32, parts: u32, length: u32| (u64::from(at) * u64::from(length) / u64::from(parts)) as u32;
        let span = |at: u32, parts: u32, length: u32| {
            let start = edge(at, parts, length);
            (start, edge(at + 1, parts, length) - start)
        };
        let (x, width) = span(part % self.columns, self.columns, width);
        let (y, height) = span(part / self.columns, self.rows, height);
        Ok(Region { x, y, width, height })
    }
}

impl FromStr for Cut {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (columns, rows) = text.split_once('x').unwrap_or(("1", text));
        let number = |text: &str| text.parse().ok().filter(|count| (1..=MOST).contains(count));
        let cut = number(columns).zip(number(rows)).map(|(columns, rows)| Self { columns, rows });
        let is_few = |cut: &Self| u64::from(cut.columns) * u64::from(cut.rows) <= u64::from(MOST);
        cut.filter(is_few).ok_or("expected a number of bands, or columns and rows as 4x4, a million parts at most")
    }
}

impl fmt::Display for Cut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.columns == 1 { write!(f, "{}", self.rows) } else { write!(f, "{}x{}", self.columns, self.rows) }
    }
}

/// What all parts of a picture have in common: the line at the start of their files.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct TileFile {
    /// Version of the file.
    strahl_tile: u32,
    /// Id of the scene with its settings.
    scene: String,
    /// A hash of the files beside it, whose content its id does not say.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    files: String,
    /// Version of the renderer.
    renderer: String,
    /// Pixels across and down the whole picture.
    image: [u32; 2],
    /// How it is cut.
    of: String,
    #[serde(skip)]
    cut: Option<Cut>,
}

impl TileFile {
    /// The files of a scene's parts.
    pub(super) fn of(ready: &PreparedScene, inputs: &SceneInputs, cut: Cut) -> Result<Self, Failure> {
        if ready.render.accuracy().is_budget() {
            let why = "a picture that a time or a number of rays ends has no parts: choose --accuracy proved, fixed or statistical";
            return Err(Failure::Usage(why.into()));
        }
        Ok(Self {
            strahl_tile: 1,
            scene: ready.scene_id.clone(),
            files: inputs.hash(),
            renderer: renderer().to_owned(),
            image: [ready.scene.width, ready.scene.height],
            of: cut.to_string(),
            cut: Some(cut),
        })
    }

    /// The hash of a part is over this, too.
    fn owner(&self) -> Owner {
        Owner::of(&format!("{} {:?} {}", self.scene, self.image, self.of))
    }

    /// The file of a part.
    pub(super) fn write(&self, part: u32, picture: Picture) -> Result<Vec<u8>, Failure> {
        let wrong = |error: &dyn fmt::Display| Failure::Input(format!("the part cannot be written: {error}"));
        let mut bytes = serde_json::to_vec(self).map_err(|error| wrong(&error))?;
        bytes.push(b'\n');
        let tile = self.owner().write(&Tile { number: part, picture }).map_err(|error| wrong(&error))?;
        bytes.extend(tile);
        Ok(bytes)
    }

    /// A part out of its file.
    pub(super) fn read(&self, name: &str, part: u32, bytes: &[u8]) -> Result<Picture, Failure> {
        let bad = |why: String| Failure::task(BAD_DATA, format!("{name} {why}"));
        let end = bytes.iter().take(LINE).position(|byte| *byte == b'\n');
        let (line, mut tile) = bytes.split_at(end.unwrap_or(0));
        let found: Self = serde_json::from_slice(line).map_err(|_| bad("is no file of `strahl tile`".into()))?;
        let same = Self { cut: self.cut, ..found.clone() };
        if same != *self {
            let what = if found.renderer != self.renderer {
                "was rendered by another version of strahl".into()
            } else if found.scene != self.scene || found.image != self.image {
                "is of another scene, or of other settings".into()
            } else if found.files != self.files {
                "was rendered when a model or a picture of the scene was another file".into()
            } else {
                format!("is a part of {}, not of {}", found.of, self.of)
            };
            return Err(bad(what));
        }
        tile = &tile[1..];
        let region = |number: u32| (number == part).then(|| self.cut?.region(part, self.image).ok()).flatten();
        let read = self.owner().read(&mut tile, self.image, region);
        match read {
            Ok(Some((found, _))) if tile.is_empty() => Ok(found.picture),
            _ => Err(bad(format!("is damaged, or not part {part}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_a_picture_without_a_gap() {
        for (text, size) in [("1", [5, 5]), ("7", [3, 100]), ("4x4", [10, 9]), ("3x2", [3, 2]), ("5x1", [641, 7])] {
            let cut: Cut = text.parse().unwrap();
            let mut seen = vec![0; (size[0] * size[1]) as usize];
            for part in 0..cut.parts() {
                let region = cut.region(part, size).unwrap();
                assert!(region.fits(size[0], size[1]), "{text} {part}");
                region.iter().for_each(|[x, y]| seen[(y * size[0] + x) as usize] += 1);
            }
            assert!(seen.iter().all(|count| *count == 1), "{text}");
            assert_eq!(cut.to_string().parse(), Ok(cut));
        }
        assert!("6".parse::<Cut>().unwrap().region(0, [9, 5]).is_err());
        for wrong in ["", "0", "x", "4x", "x4", "0x4", "4x0", "4x4x4", "-1", "1000001", "2000x2000", "99999999999"] {
            assert!(wrong.parse::<Cut>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn managers_count_from_where_they_like() {
        let cut: Cut = "4x4".parse().unwrap();
        assert_eq!([cut.part(0, 0).unwrap(), cut.part(15, 0).unwrap(), cut.part(1, 1).unwrap()], [0, 15, 0]);
        assert_eq!(cut.part(1_016, 1_001).unwrap(), 15);
        for (index, first) in [(16, 0), (0, 1), (17, 1), (u32::MAX, 0), (0, u32::MAX)] {
            assert!(cut.part(index, first).is_err(), "{index} from {first}");
        }
    }
}
