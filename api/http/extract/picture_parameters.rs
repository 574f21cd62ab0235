//! The parameters of pictures: their format, and which part of them is meant.

use super::accept::by_accept;
use super::parameter::{MAX_PIXELS, SHEET_SIDE, Values};
use super::query::Query;
use crate::http::problem::Problem;
use crate::service::scenes::ids::MAX_ZOOM;
use crate::service::values::point;
use axum::http::HeaderMap;
use strahl::enum_names::words;
use strahl::film::animation::AnimationFormat;
use strahl::film::{FileFormat, PictureFormat, Region};
use strahl::render::Layers;

/// The format of a picture in a query.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Output {
    /// The format, if it is named.
    pub(crate) format: Option<PictureFormat>,
    bits: Option<u8>,
    quality: Option<u8>,
}

impl Query {
    /// The format of an animation.
    pub(crate) fn animation_format(&mut self) -> Option<AnimationFormat> {
        let names = AnimationFormat::ALL.map(|format| format.names().0.to_owned()).to_vec();
        let about = "Format of the animation, whatever `Accept` says.";
        self.take("format", about, Values::Words(names), AnimationFormat::by_name)
    }

    /// How many are side by side and below each other, as COLUMNSxROWS.
    pub(crate) fn sheet(&mut self, name: &'static str, about: &'static str) -> Option<[u32; 2]> {
        self.take(name, about, Values::Sheet, |text| {
            let (columns, rows) = text.split_once('x')?;
            let side = |text: &str| text.parse().ok().filter(|side: &u32| (1..=SHEET_SIDE).contains(side));
            Some([side(columns)?, side(rows)?])
        })
    }

    /// `format`, `bits` and `quality`.
    pub(crate) fn output(&mut self) -> Output {
        let names = words::<PictureFormat>().into_iter().map(|word| word.name).collect();
        let about = "Format of the picture, whatever `Accept` says.";
        let format = self.take("format", about, Values::Words(names), PictureFormat::by_name);
        Output { format, ..self.details() }
    }

    /// `bits` and `quality`.
    pub(crate) fn details(&mut self) -> Output {
        let bits = self.take(
            "bits",
            "Bits for each channel of a PNG; other formats refuse it.",
            Values::Words(vec!["8".into(), "16".into()]),
            |text| text.parse().ok().filter(|bits| matches!(bits, 8 | 16)),
        );
        let about = "Quality of a JPEG, 90 if it is not given; other formats refuse it.";
        let quality = self.count("quality", about, 100).map(|quality| quality as u8);
        Output { format: None, bits, quality }
    }

    /// The picture's format: that of the query, else the one that the client accepts.
    pub(crate) fn picture_format(&mut self, output: Output, headers: &HeaderMap) -> Result<FileFormat, Problem> {
        let format = output.format.map_or_else(|| by_accept(headers), Ok)?;
        Ok(self.with_details(format, output))
    }

    /// A format with `bits` or `quality`, if it takes them.
    pub(crate) fn with_details(&mut self, format: PictureFormat, output: Output) -> FileFormat {
        format.with(output.bits, output.quality).unwrap_or_else(|wrong| {
            wrong.iter().for_each(|wrong| self.wrong(wrong.parameter, "unsupported", format!("it {}", wrong.why)));
            // With an error noted, `finish` fails, and this is not used.
            FileFormat::Png8
        })
    }

    /// `layers`, which EXR has room for.
    pub(crate) fn layers(&mut self) -> Layers {
        let about = "Layers beside the colors of an EXR, with commas between: `distance`, `position`, `normal`, `albedo`, \
                     `object`, `material`, and `share:/objects/3` of one object.";
        let Some(text) = self.text("layers", about) else { return Layers::default() };
        text.parse().unwrap_or_else(|wrong| {
            self.wrong("layers", "out-of-range", wrong);
            // With an error noted, `finish` fails, and this is not used.
            Layers::default()
        })
    }

    /// Refuses layers where the answer has no room for them.
    pub(crate) fn refuse_layers(&mut self, layers: Layers, why: &str) {
        if !layers.is_empty() {
            self.wrong("layers", "unsupported", why.to_owned());
        }
    }

    /// `zoom`: a scene may be opened as 2^zoom times its size.
    pub(crate) fn zoom(&mut self) -> u32 {
        self.within("zoom", "The scene is opened as 2^zoom times its size.", 0, u64::from(MAX_ZOOM), None).unwrap_or(0)
    }

    /// `x`, `y`, `w` and `h`: a region of the picture, which has to lie inside it.
    pub(crate) fn region(&mut self) -> Region {
        Region {
            x: self.pixels("x", "Left edge, from 0.", 0),
            y: self.pixels("y", "Upper edge, from 0.", 0),
            width: self.pixels("w", "Width in pixels.", 1),
            height: self.pixels("h", "Height in pixels.", 1),
        }
    }

    /// The same, if it is given; without it all of the picture is meant.
    pub(crate) fn part(&mut self) -> Option<Region> {
        let mut number = |name, about, least| {
            let values = Values::Whole(least, MAX_PIXELS, None);
            self.take(name, about, values, |text| text.parse::<u32>().ok().filter(|n| u64::from(*n) >= least))
        };
        let given = [
            number("x", "Left edge of a part, from 0.", 0),
            number("y", "Its upper edge, from 0.", 0),
            number("w", "Its width in pixels.", 1),
            number("h", "Its height in pixels.", 1),
        ];
        match given {
            [Some(x), Some(y), Some(width), Some(height)] => Some(Region { x, y, width, height }),
            [None, None, None, None] => None,
            _ => {
                self.wrong("x", "missing-key", "\"x\", \"y\", \"w\" and \"h\" go together".into());
                None
            }
        }
    }

    /// `x` and `y`: a pixel of the picture.
    pub(crate) fn pixel(&mut self) -> [u32; 2] {
        [self.pixels("x", "Column, from 0 at the left.", 0), self.pixels("y", "Row, from 0 at the top.", 0)]
    }

    /// `from` and `to`: where another camera stands and what it looks at.
    pub(crate) fn viewpoint(&mut self) -> Option<[[f64; 3]; 2]> {
        let read = |text: &str| point(text).ok();
        let from = self.take("from", "Eye of another camera, as `x,y,z`.", Values::Point, read);
        let to = self.take("to", "What it looks at, as `x,y,z`.", Values::Point, read);
        if from.is_some() != to.is_some() {
            self.wrong("from", "missing-key", "\"from\" and \"to\" go together".into());
        }
        Some([from?, to?])
    }

    /// `seconds`: a number from 0.1 to a limit.
    pub(crate) fn seconds(&mut self, most: Option<f64>) -> Option<f64> {
        let about = "Seconds that loading and measuring may take, at most `max_tradeoff_seconds` of `/v1/limits`.";
        let values = Values::Number(0.1, most, Some("max_tradeoff_seconds"));
        let fits = |seconds: &f64| *seconds >= 0.1 && most.is_none_or(|most| *seconds <= most);
        self.take("seconds", about, values, |text| text.parse().ok().filter(fits))
    }
}
