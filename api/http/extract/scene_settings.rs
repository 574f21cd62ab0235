//! Query parameters that replace settings of a scene, and those that say what is seen of a model.

use super::parameter::Values;
use super::query::Query;
use strahl::models::NameOrIndex;
use strahl::scene::description::{Fidelity, Precision};
use strahl::scene::limits;
use strahl::scene::model::ModelOptions;
use strahl::scene::nff::NffOptions;
use strahl::scene::{Format, Overrides};

/// Pixels across and down of the preview of a page, as the Open Graph protocol's users show it.
const PREVIEW: [u32; 2] = [1200, 630];

impl Query {
    /// Settings that replace the scene's.
    pub(crate) fn settings(&mut self, format: Format) -> Overrides {
        // Only for NFF, which cannot contain this setting.
        let two_sided = match self.described {
            Some(_) => None,
            None => self.flag("two_sided", "See opaque surfaces from behind, too (NFF only)."),
        };
        if two_sided.is_some() && format != Format::Nff {
            let detail = "it is for NFF; in JSON, materials have \"one_sided\"";
            self.wrong("two_sided", "unsupported", detail.into());
        }
        let ([width, height], dpr) = self.size();
        Overrides {
            width,
            height,
            dpr,
            max_depth: self.up_to("max_depth", "Longest chain of rays; the primary ray counts 1.", limits::MAX_DEPTH),
            min_weight: self.take(
                "min_weight",
                "Weight below which a ray is not followed.",
                Values::Number(0.0, Some(1.0), None),
                |text| text.parse().ok().filter(|weight| (0.0..=1.0).contains(weight)),
            ),
            accuracy: self.take(
                "accuracy",
                "What ends the recursion: `fixed`, `proved:CODES`, `time:MILLISECONDS`, `rays:COUNT`, or \
                 `statistical:CODES` with `,CONFIDENCE` after it or not.",
                Values::Accuracy,
                |text| text.parse().ok(),
            ),
            samples: self.up_to("samples", "Samples for each pixel.", limits::SAMPLES),
            antialias: self.flag("antialias", "Whether pixels that differ from a neighbor get more samples."),
            fidelity: self.word::<Fidelity>("fidelity", "How light gets from everywhere to surfaces."),
            precision: self.word::<Precision>("precision", "Floating-point format of the whole trace."),
            background: self.take(
                "background",
                "What the camera sees where nothing is: `scene`, `transparent`, or a color as rrggbb, which the picture shows as it is.",
                Values::Background,
                |text| text.parse().ok(),
            ),
            exposure: self.take(
                "exposure",
                "Exposure in stops, each of which doubles the light, in place of the scene's.",
                Values::Number(-32.0, Some(32.0), None),
                |text| text.parse().ok().filter(|stops: &f64| stops.abs() <= 32.0),
            ),
            tone: self.word("tone", "How light brighter than white is compressed, in place of what the scene says."),
            seen_from: None,
            nff: NffOptions { two_sided: two_sided.unwrap_or(false), ..NffOptions::default() },
            model: self.model(),
        }
    }

    /// `width`, `height`, `size` and `dpr`.
    fn size(&mut self) -> ([Option<u32>; 2], Option<f64>) {
        let width = self.up_to("width", "Pixels across, in place of the scene's.", limits::IMAGE_SIDE);
        let height = self.up_to("height", "Pixels down, in place of the scene's.", limits::IMAGE_SIDE);
        let about =
            "A size by its name, in place of width and height: `og` is that of a preview of a page, 1200 x 630.";
        let size = self.take("size", about, Values::Words(vec!["og".into()]), |name| (name == "og").then_some(PREVIEW));
        let about =
            "Pixels of the device for each of width and height, which are the scene's where they are not given.";
        let values = Values::Number(0.25, Some(8.0), None);
        let dpr = self
            .take("dpr", about, values, |text| text.parse().ok().filter(|ratio: &f64| (0.25..=8.0).contains(ratio)));
        if size.is_some() && (width.is_some() || height.is_some()) {
            self.wrong("size", "unsupported", "it takes the place of width and height: give either".into());
        }
        let [width, height] = size.map_or([width, height], |size| size.map(Some));
        let most = limits::IMAGE_SIDE.max as f64;
        for (side, pixels) in [("width", width), ("height", height)] {
            let scaled = f64::from(pixels.unwrap_or_default()) * dpr.unwrap_or(1.0);
            if scaled > most {
                self.wrong(
                    "dpr",
                    "out-of-range",
                    format!("a {side} of {scaled} pixels is more than {most} (image_side)"),
                );
            }
        }
        ([width, height], dpr)
    }

    /// What is asked of a model; scenes refuse it.
    fn model(&mut self) -> ModelOptions {
        const MOST: u32 = 1 << 20;
        let about = "From where a model is seen: three_quarter (default), front, back, left, right, top, bottom, iso, or two \
                     angles in degrees around it and from above, as 30,70.";
        ModelOptions {
            view: self.take("view", about, Values::View, |text| text.parse().ok()),
            up: self.word("up", "Which axis of a model is up."),
            camera: self.count_or_0("camera", "Which camera of a model's file sees it, from 0.", MOST),
            scene: self.count_or_0("scene", "Which scene of a model's file, from 0.", MOST),
            animation: self.which("animation", "Which animation of a model's file, by its place from 0 or its name."),
            t: self.take("t", "Seconds since the start of the animation.", Values::Number(0.0, None, None), |text| {
                text.parse().ok().filter(|t| ModelOptions::is_time(*t))
            }),
            variant: self.which("variant", "Which variant of a model's materials, by its place from 0 or its name."),
            light: self.word("light", "Which lights shine on a model."),
            strict: self.flag("strict", "Whether what a model requires and is not simulated is refused."),
            around: None,
        }
    }

    /// One of several things of a model's file.
    fn which(&mut self, name: &'static str, about: &'static str) -> Option<NameOrIndex> {
        self.take(name, about, Values::NameOrIndex, |text| text.parse().ok())
    }
}
