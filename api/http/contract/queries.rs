//! Query parameters, for the contract. [`Parameters`](crate::http::extract::query) reads them; the limits here are those of
//! `strahl::scene::limits`, which a test compares.
#![allow(dead_code, reason = "only their descriptions are used")]

use utoipa::IntoParams;

/// Settings put over the scene's.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Settings {
    /// Pixels across, in place of the scene's.
    #[param(minimum = 1, maximum = 16_384)]
    width: Option<u32>,
    /// Pixels down, in place of the scene's.
    #[param(minimum = 1, maximum = 16_384)]
    height: Option<u32>,
    /// Longest chain of rays; the primary ray counts 1.
    #[param(minimum = 1, maximum = 100_000)]
    max_depth: Option<u32>,
    /// Weight below which a ray is not followed.
    #[param(minimum = 0.0, maximum = 1.0)]
    min_weight: Option<f64>,
    /// What ends the recursion: `fixed`, `proved:CODES`, `time:MILLISECONDS`, `rays:COUNT`, or
    /// `statistical:CODES` with `,CONFIDENCE` after it or not.
    #[param(
        pattern = "^(fixed|proved(:[0-2])?|time:[1-9][0-9]{0,5}|rays:[1-9][0-9]{0,14}|statistical:(0[.](25|5|75)|[1-9]([.][0-9])?|[1-5][0-9])(,0[.][5-9][0-9]?)?)$"
    )]
    accuracy: Option<String>,
    /// Samples for each pixel.
    #[param(minimum = 1, maximum = 1_024)]
    samples: Option<u32>,
    /// Whether pixels that differ from a neighbor get more samples.
    antialias: Option<bool>,
    /// Floating-point format of the whole trace.
    #[param(inline)]
    precision: Option<Precision>,
}

/// How a picture is written.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Output {
    /// Format of the picture, whatever `Accept` says.
    #[param(inline)]
    format: Option<PictureFormat>,
    /// Bits for each channel of a PNG; other formats refuse it.
    #[param(inline)]
    bits: Option<Bits>,
    /// Quality of a JPEG, 90 if it is not given; other formats refuse it.
    #[param(minimum = 1, maximum = 100)]
    quality: Option<u8>,
}

/// How a picture of a known format is written.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Details {
    /// Bits for each channel of a PNG; other formats refuse it.
    #[param(inline)]
    bits: Option<Bits>,
    /// Quality of a JPEG, 90 if it is not given; other formats refuse it.
    #[param(minimum = 1, maximum = 100)]
    quality: Option<u8>,
}

/// How large a scene is opened.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Zoom {
    /// As 2^zoom times its size.
    #[param(minimum = 0, maximum = 16)]
    zoom: Option<u32>,
}

/// How tiles are written.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Tiles {
    /// Format of the tiles that the description names.
    #[param(inline)]
    format: Option<TileFormat>,
}

/// A region of the picture, which has to lie inside it.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Region {
    /// Left edge, from 0.
    x: u32,
    /// Upper edge, from 0.
    y: u32,
    /// Width in pixels.
    #[param(minimum = 1)]
    w: u32,
    /// Height in pixels.
    #[param(minimum = 1)]
    h: u32,
}

/// A pixel of the picture.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Pixel {
    /// Column, from 0 at the left.
    x: u32,
    /// Row, from 0 at the top.
    y: u32,
    /// How the tree is written.
    #[param(inline)]
    format: Option<TreeFormat>,
}

/// What a map shows, and how it is written.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct MapOf {
    /// What is proved of each pixel, in 8-bit codes; the rays of each; nanoseconds of each, traced alone; rays in the longest
    /// chain of each. Default `proved`.
    #[param(inline)]
    of: Option<MapKind>,
    /// PNG with a scale, or the numbers. Default `png`.
    #[param(inline)]
    format: Option<MapFormat>,
}

/// What a map shows.
#[derive(Debug, utoipa::ToSchema)]
#[schema(rename_all = "lowercase")]
enum MapKind {
    Proved,
    Rays,
    Time,
    Depth,
}

/// How a map is written.
#[derive(Debug, utoipa::ToSchema)]
#[schema(rename_all = "lowercase")]
enum MapFormat {
    Png,
    Pfm,
    Exr,
}

/// How far an explanation goes.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Analyze {
    /// Whether the picture is rendered, too, and what it took is put beside the estimates.
    analyze: Option<bool>,
}

/// How long a trade-off is measured, and how it is written.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Measure {
    /// Seconds that loading and measuring may take, at most `max_tradeoff_seconds` of `/v1/limits`.
    #[param(minimum = 0.1)]
    seconds: Option<f64>,
    /// Format of the report, whatever `Accept` says.
    #[param(inline)]
    format: Option<ReportFormat>,
}

#[derive(Debug, utoipa::ToSchema)]
#[schema(rename_all = "lowercase")]
enum Precision {
    Single,
    Double,
}

#[derive(Debug, utoipa::ToSchema)]
#[schema(rename_all = "lowercase")]
enum PictureFormat {
    Png,
    Jpg,
    Webp,
    Exr,
    Pfm,
}

#[derive(Debug, utoipa::ToSchema)]
#[schema(rename_all = "lowercase")]
enum TileFormat {
    Png,
    Jpg,
    Webp,
}

#[derive(Debug, utoipa::ToSchema)]
enum Bits {
    #[schema(rename = "8")]
    Eight,
    #[schema(rename = "16")]
    Sixteen,
}

#[derive(Debug, utoipa::ToSchema)]
#[schema(rename_all = "lowercase")]
enum TreeFormat {
    Json,
    Dot,
    Svg,
}

#[derive(Debug, utoipa::ToSchema)]
#[schema(rename_all = "lowercase")]
enum ReportFormat {
    Json,
    Html,
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl::scene::limits;
    use utoipa::openapi::path::ParameterIn;

    #[test]
    fn limits_are_those_of_scenes() {
        let parameters = serde_json::to_value(Settings::into_params(|| Some(ParameterIn::Query))).unwrap();
        let maximum = |name: &str| {
            let of_that_name = parameters.as_array().unwrap().iter().find(|parameter| parameter["name"] == name);
            of_that_name.unwrap()["schema"]["maximum"].as_u64()
        };
        for (name, limit) in [
            ("width", limits::IMAGE_SIDE),
            ("height", limits::IMAGE_SIDE),
            ("max_depth", limits::MAX_DEPTH),
            ("samples", limits::SAMPLES),
        ] {
            assert_eq!(maximum(name), Some(limit.max), "{name}");
        }
    }
}
