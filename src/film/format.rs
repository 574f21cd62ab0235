//! Formats of picture files: their names, media types and what each of them takes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Quality of a JPEG for which no other is asked.
pub const DEFAULT_QUALITY: u8 = 90;

/// A picture format by name, which is also the ending of its files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PictureFormat {
    /// sRGB.
    Png,
    /// sRGB, lossy.
    Jpg,
    /// sRGB, lossless.
    Webp,
    /// OpenEXR, linear 32-bit floats.
    Exr,
    /// Portable float map, linear 32-bit floats.
    Pfm,
}

/// A picture format with its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FileFormat {
    /// PNG, sRGB, 8 bits per channel.
    Png8,
    /// PNG, sRGB, 16 bits per channel.
    Png16,
    /// JPEG, sRGB, of a quality from 1 to 100.
    Jpeg(u8),
    /// Lossless WebP, sRGB, 8 bits per channel.
    WebP,
    /// OpenEXR, linear 32-bit floats; the data window is the region, the display window the whole picture.
    Exr,
    /// Portable float map, linear, little-endian.
    Pfm,
}

/// A parameter that another format takes, not this one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Misplaced {
    /// Its name.
    pub parameter: &'static str,
    /// Which format it is for, as a sentence about it.
    pub why: &'static str,
}

impl PictureFormat {
    /// All of them, the usual one first.
    pub const ALL: [Self; 5] = [Self::Png, Self::Jpg, Self::Webp, Self::Exr, Self::Pfm];

    /// Its name and its media type.
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Png => ("png", "image/png"),
            Self::Jpg => ("jpg", "image/jpeg"),
            Self::Webp => ("webp", "image/webp"),
            Self::Exr => ("exr", "image/x-exr"),
            Self::Pfm => ("pfm", "image/x-portable-floatmap"),
        }
    }

    /// The format that a file's ending or a query names.
    pub fn by_name(name: &str) -> Option<Self> {
        let name = if name == "jpeg" { "jpg" } else { name };
        Self::ALL.into_iter().find(|format| format.names().0 == name)
    }

    /// The format that a file's name asks for.
    pub fn by_file(name: &std::path::Path) -> Option<Self> {
        Self::by_name(&name.extension()?.to_str()?.to_ascii_lowercase())
    }

    /// Whether it holds linear floats, not 8-bit codes.
    pub fn is_linear(self) -> bool {
        matches!(self, Self::Exr | Self::Pfm)
    }

    /// The format with its parameters: bits of a channel for PNG, 8 or 16, and quality for JPEG, 1 to 100.
    pub fn with(self, bits: Option<u8>, quality: Option<u8>) -> Result<FileFormat, Vec<Misplaced>> {
        let why = "is for PNG; EXR and PFM hold 32-bit floats, JPEG and WebP 8 bits";
        let bits_misplaced = (self != Self::Png && bits.is_some()).then_some(Misplaced { parameter: "bits", why });
        let why = "is for JPEG; the other formats lose nothing";
        let quality_misplaced =
            (self != Self::Jpg && quality.is_some()).then_some(Misplaced { parameter: "quality", why });
        let misplaced: Vec<_> = bits_misplaced.into_iter().chain(quality_misplaced).collect();
        if !misplaced.is_empty() {
            return Err(misplaced);
        }
        Ok(match self {
            Self::Png if bits == Some(16) => FileFormat::Png16,
            Self::Png => FileFormat::Png8,
            Self::Jpg => FileFormat::Jpeg(quality.unwrap_or(DEFAULT_QUALITY)),
            Self::Webp => FileFormat::WebP,
            Self::Exr => FileFormat::Exr,
            Self::Pfm => FileFormat::Pfm,
        })
    }
}

impl FileFormat {
    /// Its name, which is the ending of its files, and its media type.
    pub fn names(self) -> (&'static str, &'static str) {
        PictureFormat::from(self).names()
    }
}

impl From<FileFormat> for PictureFormat {
    fn from(format: FileFormat) -> Self {
        match format {
            FileFormat::Png8 | FileFormat::Png16 => Self::Png,
            FileFormat::Jpeg(_) => Self::Jpg,
            FileFormat::WebP => Self::Webp,
            FileFormat::Exr => Self::Exr,
            FileFormat::Pfm => Self::Pfm,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::enum_names::words;

    #[test]
    fn names_are_the_words() {
        let names: Vec<_> = words::<PictureFormat>().into_iter().map(|word| word.name).collect();
        assert_eq!(names, PictureFormat::ALL.map(|format| format.names().0));
    }

    #[test]
    fn parameters_belong_to_their_format() {
        assert_eq!(PictureFormat::Png.with(Some(16), None), Ok(FileFormat::Png16));
        assert_eq!(PictureFormat::Jpg.with(None, Some(7)), Ok(FileFormat::Jpeg(7)));
        let wrong = PictureFormat::Exr.with(Some(8), Some(50)).unwrap_err();
        assert_eq!(wrong.iter().map(|wrong| wrong.parameter).collect::<Vec<_>>(), ["bits", "quality"]);
    }
}
