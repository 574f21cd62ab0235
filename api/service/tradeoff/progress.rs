//! What a trade-off has found so far, for those who look on.

use schemars::JsonSchema;
use serde::Serialize;
use strahl::tradeoff::sweep::Settings;

/// Who is told.
pub(crate) type Watch<'a> = &'a (dyn Fn(Progress) + Sync);

/// What was found.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum Progress {
    /// The pictures of a size that others are compared with.
    Reference(Size),
    /// A picture of some settings, which a larger one may follow.
    Point(Box<Found>),
}

/// Which pictures are measured.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "TradeoffSize")]
pub(crate) struct Size {
    /// `choices`: about ten settings to choose from; then `points`: many more.
    pub(crate) part: &'static str,
    /// Pixels across.
    pub(crate) width: u32,
    /// Pixels down.
    pub(crate) height: u32,
}

/// A picture that was measured.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "TradeoffProgress")]
pub(crate) struct Found {
    /// Its size.
    #[serde(flatten)]
    pub(crate) size: Size,
    /// Its index in the part's list.
    pub(crate) index: usize,
    /// The settings.
    pub(crate) settings: Settings,
    /// Milliseconds of tracing.
    pub(crate) time_ms: f64,
    /// Rays of all kinds.
    pub(crate) rays: u64,
    /// Codes that it is proved to be off at most.
    pub(crate) proved_codes: Option<u8>,
    /// What it is off from the reference of the same samples, if there is one and the picture is not large.
    pub(crate) error: Option<Off>,
}

/// How far a picture is from its reference, in 8-bit codes.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "TradeoffProgressError")]
pub(crate) struct Off {
    /// The most.
    pub(crate) max_codes: f64,
    /// 99.9 % of the pixels are not off by more.
    pub(crate) p999_codes: f64,
    /// Share of the pixels that are the same.
    pub(crate) identical: f64,
}
