//! Vectors of a packet's lanes in double precision, to be taken in halves where lanes of f64 are half as many.

use super::{Double, Lanes, MAX_LANES, Real, V3};

/// The packet's lanes in parts that lanes of f64 hold: the first of each part, and its lanes among those asked for, if any.
#[inline(always)]
pub(crate) fn parts<L: Lanes>(lanes: u32) -> impl Iterator<Item = (usize, u32)> {
    let count = L::Double::COUNT;
    let part = move |first: usize| (first, lanes >> first & ((1 << count) - 1));
    (0..L::COUNT).step_by(count).map(part).filter(|(_, lanes)| *lanes != 0)
}

/// One number for each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column([f64; MAX_LANES]);

impl Column {
    /// Wider, without a rounding.
    #[inline(always)]
    pub(crate) fn of<L: Lanes>(numbers: L) -> Self {
        let mut own = [L::Real::default(); MAX_LANES];
        numbers.store(&mut own);
        let mut wide = [0.0; MAX_LANES];
        for lane in 0..L::COUNT {
            wide[lane] = own[lane].to_f64();
        }
        Self(wide)
    }

    /// The lanes from `first` on.
    #[inline(always)]
    pub(crate) fn part<W: Double>(&self, s: W::Simd, first: usize) -> W {
        W::load(s, &self.0[first..])
    }

    /// Replaces lanes from `first` on, where the mask is true.
    #[inline(always)]
    pub(crate) fn put<W: Double>(&mut self, s: W::Simd, first: usize, mask: W::Mask, numbers: W) {
        W::select(mask, numbers, self.part(s, first)).store(&mut self.0[first..]);
    }

    /// The nearest numbers of the packet's own format.
    #[inline(always)]
    pub(crate) fn lanes<L: Lanes>(&self, s: L::Simd) -> L {
        let mut own = [L::Real::default(); MAX_LANES];
        for lane in 0..L::COUNT {
            own[lane] = L::Real::from_f64(self.0[lane]);
        }
        L::load(s, &own)
    }
}

/// Three numbers for each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Columns([Column; 3]);

impl Columns {
    /// Wider, without a rounding.
    #[inline(always)]
    pub(crate) fn of<L: Lanes>(v: V3<L>) -> Self {
        Self([Column::of(v.x), Column::of(v.y), Column::of(v.z)])
    }

    /// The lanes from `first` on.
    #[inline(always)]
    pub(crate) fn part<W: Double>(&self, s: W::Simd, first: usize) -> V3<W> {
        let [x, y, z] = &self.0;
        V3 { x: x.part(s, first), y: y.part(s, first), z: z.part(s, first) }
    }

    /// Replaces lanes from `first` on, where the mask is true.
    #[inline(always)]
    pub(crate) fn put<W: Double>(&mut self, s: W::Simd, first: usize, mask: W::Mask, v: V3<W>) {
        let [x, y, z] = &mut self.0;
        x.put(s, first, mask, v.x);
        y.put(s, first, mask, v.y);
        z.put(s, first, mask, v.z);
    }

    /// The nearest numbers of the packet's own format.
    #[inline(always)]
    pub(crate) fn lanes<L: Lanes>(&self, s: L::Simd) -> V3<L> {
        let [x, y, z] = &self.0;
        V3 { x: x.lanes(s), y: y.lanes(s), z: z.lanes(s) }
    }
}
