//! The surfaces that shadow rays cross, and what all of them let through.
//!
//! The order of factors decides the last bit of a product, and the order of traversal depends on the other rays and on the order of
//! the scene. So the factors are collected and multiplied in the order of their size.

use crate::control;
use crate::lanes::{Lanes, MAX_LANES, Real, V3, lanes_of};
use smallvec::SmallVec;
use std::cmp::Ordering;

/// Crossings that are kept one by one. Instances of instances may put millions of surfaces into one place.
const MOST: usize = 1 << 12;

/// What each channel keeps at a crossing.
type Factor<R> = [R; 3];

/// The crossings of a packet of shadow rays.
#[derive(Debug)]
pub(super) struct Crossings<R> {
    /// Lanes that have crossed a surface, and its factor.
    each: SmallVec<[(u32, Factor<R>); 8]>,
    /// Once there were many: factors in their order, and how often each lane has crossed surfaces of them.
    counted: Vec<(Factor<R>, [u32; MAX_LANES])>,
}

impl<R: Real> Crossings<R> {
    pub(super) fn new() -> Self {
        Self { each: SmallVec::new(), counted: Vec::new() }
    }

    /// Some lanes have crossed a surface.
    #[inline(always)]
    pub(super) fn push(&mut self, lanes: u32, factor: Factor<R>) {
        // Where all differ there are as many as are known already, so that each is moved only a few times.
        if self.each.len() >= MOST.max(self.counted.len()) {
            self.count();
        }
        self.each.push((lanes, factor));
    }

    /// Counts those that are kept one by one.
    #[cold]
    #[inline(never)]
    fn count(&mut self) {
        control::step((self.each.len() + self.counted.len()) as u32);
        self.each.sort_by(|(_, f), (_, g)| by_size(f, g));
        let mut known = std::mem::take(&mut self.counted).into_iter().peekable();
        for (lanes, factor) in self.each.drain(..) {
            while let Some(smaller) = known.next_if(|(other, _)| by_size(other, &factor).is_le()) {
                self.counted.push(smaller);
            }
            if self.counted.last().is_none_or(|(last, _)| by_size(last, &factor).is_ne()) {
                self.counted.push((factor, [0; MAX_LANES]));
            }
            if let Some((_, counts)) = self.counted.last_mut() {
                for lane in lanes_of(lanes) {
                    counts[lane] = counts[lane].saturating_add(1);
                }
            }
        }
        self.counted.extend(known);
    }

    /// The product of the factors of each lane.
    #[inline(always)]
    pub(super) fn product<L: Lanes<Real = R>>(&mut self, s: L::Simd) -> V3<L> {
        if !self.counted.is_empty() {
            return self.product_of_many(s);
        }
        // Equal factors need no sorting: most scenes have one kind of glass.
        if self.each.windows(2).any(|pair| pair[0].1 != pair[1].1) {
            self.each.sort_by(|(_, f), (_, g)| by_size(f, g));
        }
        let mut product = V3::splat(s, [R::from_f64(1.0); 3]);
        for &(lanes, factor) in &self.each {
            product = V3::select(L::mask(s, lanes), product.times(V3::splat(s, factor)), product);
        }
        product
    }

    /// The same, with the same rounding.
    #[cold]
    #[inline(never)]
    fn product_of_many<L: Lanes<Real = R>>(&mut self, s: L::Simd) -> V3<L> {
        self.count();
        let one = [R::from_f64(1.0); 3];
        let mut product = [one; MAX_LANES];
        for (factor, counts) in self.counted.iter().filter(|(factor, _)| *factor != one) {
            for (product, count) in product.iter_mut().zip(counts) {
                for _ in 0..*count {
                    *product = std::array::from_fn(|c| product[c] * factor[c]);
                }
            }
        }
        let channel = |c: usize| L::load(s, &product.map(|product| product[c]));
        V3 { x: channel(0), y: channel(1), z: channel(2) }
    }
}

/// An order of colors by nothing but their values.
fn by_size<R: Real>(a: &Factor<R>, b: &Factor<R>) -> Ordering {
    a.map(Real::to_f64).partial_cmp(&b.map(Real::to_f64)).unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn millions_of_crossings_are_a_few_numbers_and_the_same_product() {
        let factors = [[0.999, 0.5, 1.0], [1.0; 3], [0.9, 1.0, 0.999_99]];
        let mut crossings = Crossings::new();
        let mut expected = factors.map(|_| 0_u32);
        for i in 0..100_000_usize {
            let which = i * i % 7 % 3;
            crossings.push(1, factors[which]);
            expected[which] += 1;
        }
        assert!(crossings.each.len() <= MOST && crossings.counted.len() == 3);
        let mut product = [1.0_f64; 3];
        // In the order of their size.
        for which in [2, 0, 1] {
            for _ in 0..expected[which] {
                product = std::array::from_fn(|c| product[c] * factors[which][c]);
            }
        }
        assert_eq!(crossings.product::<f64>(()).lane(0), product);
    }

    #[test]
    fn as_many_factors_are_one_product() {
        let factor = |i: u32| [1.0 - f64::from(i * 7919 % 50_000) * 1e-9, 1.0, 0.5 + 0.5 * f64::from(i % 2)];
        let mut crossings = Crossings::new();
        (0..100_000).for_each(|i| crossings.push(1, factor(i)));
        let mut all: Vec<_> = (0..100_000).map(factor).collect();
        all.sort_by(by_size);
        let expected = all.iter().fold([1.0; 3], |product: [f64; 3], f| std::array::from_fn(|c| product[c] * f[c]));
        assert_eq!(crossings.product::<f64>(()).lane(0), expected);
        assert_eq!(crossings.counted.len(), 50_000);
    }

    #[test]
    fn no_order_changes_the_product() {
        let factors: Vec<[f32; 3]> = (0..6_000_u16).map(|i| [0.999 + f32::from(i % 11) * 9e-5, 1.0, 0.9999]).collect();
        let product = |factors: &mut dyn Iterator<Item = &[f32; 3]>| {
            let mut crossings = Crossings::new();
            factors.for_each(|factor| crossings.push(1, *factor));
            crossings.product::<f32>(()).lane(0)
        };
        for few in [100, 6_000] {
            let factors = &factors[..few];
            assert_eq!(product(&mut factors.iter()), product(&mut factors.iter().rev()));
        }
    }
}
