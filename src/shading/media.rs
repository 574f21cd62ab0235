//! Which media a ray is in: a list keyed by body, so that nested, touching and overlapping bodies may be left in any
//! order (after Schmidt and Budge, Simple Nested Dielectrics, 2002). There the author of the scene gives priorities; here
//! the volume does: where bodies overlap, the smaller one decides the index, and of equal ones the one written last. A body
//! inside another is always smaller, so nesting needs no priorities, and the media of a point do not depend on the path to
//! it.
//!
//! Lists share their tails in an arena, so a ray carries one number and a packet's tree of rays may be any size.

use crate::lanes::Real;

/// Bodies around one ray whose media are told apart. Further ones are passed as if they were not there.
const MAX_MEDIA: usize = 32;

/// A list of media: an index into [`Media`].
pub type MediumList = u32;

/// More lists than these are looked through for those that no ray needs any more.
const MANY: usize = 1 << 16;

/// The empty list: empty space, ior 1.
pub const OUTSIDE: MediumList = 0;

#[derive(Debug, Clone, Copy)]
struct Node<R> {
    medium: Medium<R>,
    below: MediumList,
}

/// The medium inside a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium<R> {
    /// Identity of the placed body.
    pub body: u64,
    /// Volume of the placed body.
    pub volume: f64,
    /// Index of refraction inside.
    pub ior: R,
    /// n_F - n_C inside.
    pub dispersion: R,
}

impl<R> Medium<R> {
    /// Whether this medium decides where both overlap.
    fn outranks(&self, other: &Self) -> bool {
        self.volume < other.volume || (self.volume == other.volume && self.body > other.body)
    }
}

/// The lists of one packet's rays.
#[derive(Debug, Clone)]
pub struct Media<R> {
    nodes: Vec<Node<R>>,
    /// How many lists there may be before those are looked for that nobody needs.
    limit: usize,
}

/// The lists that are kept while the others are forgotten.
#[derive(Debug)]
pub struct Compaction<'a, R> {
    media: &'a mut Media<R>,
    before: Vec<Node<R>>,
    /// Where each list is now, of those that are kept.
    now: Vec<MediumList>,
}

impl<R: Real> Default for Media<R> {
    fn default() -> Self {
        let outside =
            Medium { body: u64::MAX, volume: f64::INFINITY, ior: R::from_f64(1.0), dispersion: R::from_f64(0.0) };
        Self { nodes: vec![Node { medium: outside, below: OUTSIDE }], limit: MANY }
    }
}

impl<R: Real> Media<R> {
    /// Forgets all lists but the empty one.
    pub fn clear(&mut self) {
        self.nodes.truncate(1);
    }

    /// How many lists there are, for [`Self::forget`].
    pub fn mark(&self) -> usize {
        self.nodes.len()
    }

    /// Forgets the lists made since a mark.
    pub fn forget(&mut self, mark: usize) {
        self.nodes.truncate(mark);
    }

    /// Whether there are so many lists that those should go that nobody needs.
    #[inline(always)]
    pub fn is_crowded(&self) -> bool {
        self.nodes.len() > self.limit
    }

    /// Forgets all lists but those that [`Compaction::keep`] is called with.
    pub fn compact(&mut self) -> Compaction<'_, R> {
        let outside = self.nodes[OUTSIDE as usize];
        let before = std::mem::replace(&mut self.nodes, vec![outside]);
        Compaction { media: self, now: vec![OUTSIDE; before.len()], before }
    }

    /// The medium that decides where a ray with this list is; none in empty space.
    pub fn deciding(&self, list: MediumList) -> Option<Medium<R>> {
        self.entries(list).next()
    }

    /// Index of refraction where a ray with this list is.
    pub fn ior(&self, list: MediumList) -> R {
        self.nodes[list as usize].medium.ior
    }

    /// Mean dispersion where a ray with this list is.
    pub fn dispersion(&self, list: MediumList) -> R {
        self.nodes[list as usize].medium.dispersion
    }

    /// The list after a body has been entered; the same list if the ray was in it already, or if it holds `MAX_MEDIA`.
    pub fn enter(&mut self, list: MediumList, medium: Medium<R>) -> MediumList {
        if self.contains(list, medium.body) || self.entries(list).count() >= MAX_MEDIA {
            return list;
        }
        let above: Vec<Medium<R>> = self.entries(list).take_while(|other| other.outranks(&medium)).collect();
        let below = above.iter().fold(list, |list, _| self.nodes[list as usize].below);
        let entered = self.push(below, medium);
        above.into_iter().rev().fold(entered, |list, medium| self.push(list, medium))
    }

    /// The list after a body has been left; the same list if the ray was not in it.
    pub fn leave(&mut self, list: MediumList, body: u64) -> MediumList {
        if !self.contains(list, body) {
            return list;
        }
        let above: Vec<Medium<R>> = self.entries(list).take_while(|other| other.body != body).collect();
        let left = above.iter().fold(list, |list, _| self.nodes[list as usize].below);
        let below = self.nodes[left as usize].below;
        above.into_iter().rev().fold(below, |list, medium| self.push(list, medium))
    }

    /// Whether a ray with this list is inside a body.
    pub fn contains(&self, list: MediumList, body: u64) -> bool {
        self.entries(list).any(|medium| medium.body == body)
    }

    /// The media, the one that decides first.
    pub fn entries(&self, list: MediumList) -> impl Iterator<Item = Medium<R>> {
        let mut next = list;
        std::iter::from_fn(move || {
            (next != OUTSIDE).then(|| {
                let node = self.nodes[next as usize];
                next = node.below;
                node.medium
            })
        })
    }

    /// The list of a ray in several media.
    pub fn list(&mut self, media: &[Medium<R>]) -> MediumList {
        media.iter().fold(OUTSIDE, |list, medium| self.enter(list, *medium))
    }

    fn push(&mut self, below: MediumList, medium: Medium<R>) -> MediumList {
        self.nodes.push(Node { medium, below });
        (self.nodes.len() - 1) as MediumList
    }
}

impl<R: Real> Compaction<'_, R> {
    /// Keeps a list, and returns its new number.
    pub fn keep(&mut self, list: MediumList) -> MediumList {
        let mut moving = Vec::new();
        let mut next = list;
        while next != OUTSIDE && self.now[next as usize] == OUTSIDE {
            moving.push(next);
            next = self.before[next as usize].below;
        }
        let tail = self.now[next as usize];
        moving.into_iter().rev().fold(tail, |below, list| {
            let Node { medium, .. } = self.before[list as usize];
            self.now[list as usize] = self.media.push(below, medium);
            self.now[list as usize]
        })
    }
}

impl<R> Drop for Compaction<'_, R> {
    fn drop(&mut self) {
        // Twice as many, so that what is kept is not looked through again and again.
        self.media.limit = MANY.max(2 * self.media.nodes.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WATER: Medium<f64> = Medium { body: 1, volume: 8.0, ior: 1.33, dispersion: 0.0 };
    const GLASS: Medium<f64> = Medium { body: 2, volume: 3.0, ior: 1.5, dispersion: 0.0 };
    const BUBBLE: Medium<f64> = Medium { body: 0, volume: 0.1, ior: 1.0, dispersion: 0.0 };

    #[test]
    fn the_smaller_body_decides_whatever_was_entered_first() {
        let mut media = Media::default();
        for order in [[WATER, GLASS, BUBBLE], [BUBBLE, GLASS, WATER], [GLASS, BUBBLE, WATER]] {
            let list = media.list(&order);
            assert_eq!(media.entries(list).collect::<Vec<_>>(), [BUBBLE, GLASS, WATER]);
            assert_eq!(media.ior(list), 1.0);
        }
    }

    #[test]
    fn of_equal_bodies_the_later_one_decides() {
        let mut media = Media::default();
        let other = Medium { body: 7, ior: 2.4, ..GLASS };
        for order in [[GLASS, other], [other, GLASS]] {
            let list = media.list(&order);
            assert_eq!(media.ior(list), 2.4);
        }
    }

    #[test]
    fn bodies_may_be_left_in_any_order() {
        let mut media = Media::default();
        let both = media.list(&[WATER, GLASS]);
        let only_glass = media.leave(both, WATER.body);
        assert_eq!(media.entries(only_glass).collect::<Vec<_>>(), [GLASS]);
        let outside = media.leave(only_glass, GLASS.body);
        assert_eq!(media.ior(outside), 1.0);
        assert_eq!(media.leave(both, 7), both, "leaving what it is not in changes nothing");
        assert_eq!(media.leave(OUTSIDE, 7), OUTSIDE);
    }

    #[test]
    fn lists_that_are_kept_stay_what_they_were() {
        let mut media = Media::default();
        let gone = media.list(&[BUBBLE, WATER]);
        let lists = [media.list(&[WATER, GLASS]), media.list(&[GLASS]), OUTSIDE, media.list(&[WATER, GLASS, BUBBLE])];
        let entries = |media: &Media<f64>, list| media.entries(list).collect::<Vec<_>>();
        let before = lists.map(|list| entries(&media, list));
        let mut kept = media.compact();
        let after = lists.map(|list| kept.keep(list));
        assert_eq!(lists.map(|list| kept.keep(list)), after, "a list is kept once");
        drop(kept);
        assert_eq!(after.map(|list| entries(&media, list)), before);
        assert!(media.mark() <= 1 + 2 + 1 + 3 && after[3] < lists[3] && gone != OUTSIDE);
    }
}
