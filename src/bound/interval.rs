//! The interval in which a pixel lies when rays were omitted: from the sum of what was traced to that sum and the most that
//! the omitted rays could add.

use crate::film::Display;
use crate::film::srgb::Codes8;
use crate::lanes::Real;

/// Codes by which a channel may be shown above its lower end. An interval of twice `max_codes` shows its middle code, which
/// is at most `max_codes` from both ends. Black stays black.
fn allowed_raise(low: f32, max_codes: u8) -> u8 {
    if low > 0.0 { max_codes } else { 0 }
}

/// How much of a transparent background a pixel may have missed that is to be at most `max_codes` off. A quarter of a code, since what
/// is shown is divided by alpha before a tone curve; half of that where alpha is to be exact, whose code decides.
pub(crate) fn alpha_allowed(max_codes: u8) -> f64 {
    0.25 * f64::from(max_codes).max(0.5) / 255.0
}

/// How much a pixel sees of a transparent background, or a part of it, and the most that it may have missed.
pub(crate) type Background = Option<[f64; 2]>;

/// The least and the most alpha there can be.
fn alpha_ends([clear, unseen]: [f64; 2]) -> [f32; 2] {
    [clear + unseen, clear].map(|clear| (1.0 - clear).clamp(0.0, 1.0) as f32)
}

/// Whether each channel of a whole pixel is proved to be at most `max_codes` off, and its alpha.
pub(crate) fn proved(display: &Display, ends: [[f32; 2]; 3], background: Background, max_codes: u8) -> [bool; 3] {
    let (low, high) = (ends.map(|[low, _]| low), ends.map(|[_, high]| high));
    let off = match background {
        Some(background) => display.codes_of_part_off(low, high, alpha_ends(background)),
        None if display.is_plain() => {
            let codes = Codes8::get();
            return ends
                .map(|[low, high]| codes.code(high) - codes.code(low) <= max_codes + allowed_raise(low, max_codes));
        }
        None => display.codes_off(low, high),
    };
    // Tone curves mix channels, and alpha is of all of them: each may be off because of another.
    [off.iter().all(|off| *off <= max_codes); 3]
}

/// The interval of each linear channel that is shown, and the codes by which it may be raised.
fn shown(display: &Display, ends: [[f32; 2]; 3], background: Background, max_codes: u8) -> ([[f32; 2]; 3], u8) {
    let (low, high) = (ends.map(|[low, _]| low), ends.map(|[_, high]| high));
    match background {
        Some(background) => {
            let [least, most] = alpha_ends(background);
            let behind = display.backdrop().unwrap_or_default();
            let mut shown = display.ends_of_part(low, high, least, most);
            for ([low, high], behind) in shown.iter_mut().zip(behind) {
                (*low, *high) = (*low + behind * (1.0 - most), *high + behind * (1.0 - least));
            }
            (shown, 0)
        }
        None if display.is_plain() => (ends, max_codes),
        None => (display.ends(low, high), 0),
    }
}

/// The light that a pixel misses at most, as a multiple of what it may miss; 1 or more.
pub(crate) fn excess(display: &Display, ends: [[f32; 2]; 3], background: Background, max_codes: u8) -> f64 {
    let codes = Codes8::get();
    let (shown, raise) = shown(display, ends, background, max_codes);
    let channel = |[low, high]: [f32; 2]| {
        let most = codes.code(low).saturating_add(max_codes + allowed_raise(low, raise));
        if most == u8::MAX {
            return 1.0;
        }
        f64::from(high - low) / f64::from((codes.least(most + 1) - low).max(f32::MIN_POSITIVE))
    };
    shown.into_iter().map(channel).fold(1.0, f64::max)
}

/// The width of each channel's interval as a share of the codes that it may be wide; with 0 codes, of one code.
pub(crate) fn share_of_code(display: &Display, ends: [[f32; 2]; 3], background: Background, max_codes: u8) -> [f64; 3] {
    let codes = Codes8::get();
    let (shown, raise) = shown(display, ends, background, max_codes);
    shown.map(|[low, high]| {
        let code = codes.code(low);
        if code == u8::MAX {
            return 0.0;
        }
        let width = codes.least(code + 1) - if code == 0 { 0.0 } else { codes.least(code) };
        f64::from(high - low) / f64::from(width) / f64::from((max_codes + allowed_raise(low, raise)).max(1))
    })
}

/// The light to add to the sum of a channel before it is shown, so that it is at most `max_codes` off; 0 if it is so without,
/// or cannot be.
#[inline(always)]
pub(crate) fn raise<R: Real>(sum: R, [low, high]: [f32; 2], max_codes: u8) -> R {
    let codes = Codes8::get();
    let (least, most) = (codes.code(low), codes.code(high));
    let apart = most - least;
    if apart <= max_codes || apart > max_codes + allowed_raise(low, max_codes) {
        return R::default();
    }
    let mut more = R::from_f64((f64::from(codes.least(most - max_codes)) - sum.to_f64()).max(0.0));
    // The addition rounds.
    while codes.code((sum + more).to_f64() as f32) < most - max_codes {
        more = more + more * R::from_f64(2.0 * R::ROUNDOFF) + R::from_f64(f64::from(f32::MIN_POSITIVE));
    }
    more
}

/// The lower and the upper end of each channel of a pixel. `omitted` is the most that omitted rays could add, and `rounding`
/// the relative error of the sum. Both ends are rounded as the pixel of recursion without end would be: rounding keeps order.
#[inline(always)]
pub(crate) fn interval<R: Real>(sum: [f64; 3], omitted: [R; 3], rounding: f64) -> [[f32; 2]; 3] {
    let mut ends = [[0.0; 2]; 3];
    for c in 0..3 {
        let (sum, omitted) = (sum[c], omitted[c].to_f64());
        // Where nothing was omitted, both ends are the sum.
        ends[c] = [sum as f32; 2];
        if omitted != 0.0 {
            let high = (sum + omitted) * (1.0 + rounding);
            ends[c] = [(sum * (1.0 - rounding)) as f32, high as f32];
        }
    }
    ends
}
