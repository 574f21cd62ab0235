//! The interval in which a pixel lies when rays were omitted: from the sum of what was traced to that sum and the most that
//! the omitted rays could add.

use crate::film::srgb::Codes8;
use crate::lanes::Real;

/// Codes by which a channel may be shown above its lower end. An interval of twice `max_codes` shows its middle code, which
/// is at most `max_codes` from both ends. Black stays black.
pub(crate) fn allowed_raise(low: f32, max_codes: u8) -> u8 {
    if low > 0.0 { max_codes } else { 0 }
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

/// The lower and the upper end of each channel of a pixel, rounded outwards. `omitted` is the most that omitted rays could
/// add, and `roundings` the relative error of the sum.
#[inline(always)]
pub(crate) fn interval<R: Real>(sum: [R; 3], omitted: [R; 3], roundings: R) -> [[f32; 2]; 3] {
    let roundings = roundings.to_f64();
    let mut ends = [[0.0; 2]; 3];
    for c in 0..3 {
        let (sum, omitted) = (sum[c].to_f64(), omitted[c].to_f64());
        // Where nothing was omitted, both ends are the sum.
        ends[c] = [sum as f32; 2];
        if omitted != 0.0 {
            let high = ((sum + omitted) * (1.0 + roundings)) as f32;
            ends[c] = [(sum * (1.0 - roundings)) as f32, high.next_up()];
        }
    }
    ends
}
