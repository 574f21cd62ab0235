//! Sign changes of functions on intervals between their turns, and the turns of quartics. What a lane does not have is NaN.

use crate::lanes::{Lanes, Mask};

/// Upper bound on steps of one root's refinement; bisection alone needs 60.
const MAX_STEPS: usize = 80;

/// A function and its slope.
pub(super) trait Curve<W> {
    fn at(&self, x: W) -> W;
    fn slope(&self, x: W) -> W;
}

/// Where a function changes its sign on an interval, section by section: it is monotone between its turns. Touching zero without
/// crossing it is not a root, and a zero at the lower end is not one either: values of at most `noise` there count as zero, and
/// the slope decides the sign.
pub(super) struct SignChanges<W> {
    low: W,
    high: W,
    /// Where the next section begins, and the function there.
    start: W,
    value: W,
}

impl<W: Lanes> SignChanges<W> {
    #[inline(always)]
    pub(super) fn new(curve: &impl Curve<W>, low: W, high: W, noise: W) -> Self {
        let value = curve.at(low);
        let value = W::select(value.abs().le(noise), curve.slope(low), value);
        Self { low, high, start: low, value }
    }

    /// The root in the section that ends at a turn, or at the upper end; none where the turn is not in the interval. Other lanes
    /// than those asked for only go on.
    #[inline(always)]
    pub(super) fn next(&mut self, s: W::Simd, curve: &impl Curve<W>, end: W, lanes: W::Mask) -> W {
        let zero = W::lit(s, 0.0);
        let inside = end.gt(self.low) & end.le(self.high);
        let value = curve.at(end);
        let (falling, rising) = (value.lt(zero), self.value.lt(zero));
        let crosses = inside & lanes & ((rising & !falling) | (falling & !rising));
        let mut root = W::lit(s, f64::NAN);
        if crosses.any() {
            root = W::select(crosses, refine(s, curve, [self.start, end], rising, crosses), root);
        }
        (self.start, self.value) = (W::select(inside, end, self.start), W::select(inside, value, self.value));
        root
    }
}

/// Newton's method, held inside the shrinking bracket by bisection. Lanes that have arrived stay where they are.
#[inline(always)]
fn refine<W: Lanes>(
    s: W::Simd,
    curve: &impl Curve<W>,
    [mut a, mut b]: [W; 2],
    rising: W::Mask,
    mut active: W::Mask,
) -> W {
    let (zero, half, epsilon) = (W::lit(s, 0.0), W::lit(s, 0.5), W::lit(s, f64::EPSILON));
    let mut x = half * (a + b);
    for _ in 0..MAX_STEPS {
        let y = curve.at(x);
        active = active & !y.eq(zero);
        let below = y.lt(zero);
        let before = (below & rising) | (!below & !rising);
        (a, b) = (W::select(before, x, a), W::select(before, b, x));
        let newton = x - y / curve.slope(x);
        let next = W::select(newton.gt(a) & newton.lt(b), newton, half * (a + b));
        let arrived = next.eq(x) | next.le(a) | next.ge(b) | (next - x).abs().le(epsilon * next.abs());
        x = W::select(active, next, x);
        active = active & !arrived;
        if !active.any() {
            break;
        }
    }
    x
}

/// The slope of x^4 + a x^2 + b x + c: 4 x^3 + 2 a x + b.
struct Slope<W> {
    twice_a: W,
    b: W,
    four: W,
    twelve: W,
}

impl<W: Lanes> Curve<W> for Slope<W> {
    #[inline(always)]
    fn at(&self, x: W) -> W {
        self.b + x * (self.twice_a + x * (x * self.four))
    }

    #[inline(always)]
    fn slope(&self, x: W) -> W {
        self.twice_a + x * (x * self.twelve)
    }
}

/// Places where x^4 + a x^2 + b x + c has slope 0 on \[low, high\], in increasing order.
#[inline(always)]
pub(super) fn turns<W: Lanes>(s: W::Simd, a: W, b: W, low: W, high: W, lanes: W::Mask) -> [W; 3] {
    let (zero, twelve) = (W::lit(s, 0.0), W::lit(s, 12.0));
    let slope = Slope { twice_a: a + a, b, four: W::lit(s, 4.0), twelve };
    // Where the slope turns itself, if it does: 12 x^2 + 2 a = 0.
    let root = (zero - twelve * slope.twice_a).sqrt();
    let (first, second) = (-root / twelve, slope.twice_a / -root);
    let mut changes = SignChanges::new(&slope, low, high, zero);
    let first = changes.next(s, &slope, first, lanes);
    let second = changes.next(s, &slope, second, lanes);
    [first, second, changes.next(s, &slope, high, lanes)]
}
