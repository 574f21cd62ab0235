//! Which media a ray is in: a list keyed by body, so that nested, touching and overlapping bodies may be left in any
//! order (after Schmidt and Budge, Simple Nested Dielectrics, 2002). The body entered last decides the index.
//!
//! Lists share their tails in an arena, so a ray carries one number and a packet's tree of rays may be any size.

use crate::lanes::Real;

/// A list of media: an index into [`Media`].
pub type MediumList = u32;

/// The empty list: empty space, ior 1.
pub const OUTSIDE: MediumList = 0;

#[derive(Debug, Clone, Copy)]
struct Node<R> {
    body: u64,
    ior: R,
    below: MediumList,
}

/// The lists of one packet's rays.
#[derive(Debug, Clone)]
pub struct Media<R> {
    nodes: Vec<Node<R>>,
}

impl<R: Real> Default for Media<R> {
    fn default() -> Self {
        Self { nodes: vec![Node { body: u64::MAX, ior: R::from_f64(1.0), below: OUTSIDE }] }
    }
}

impl<R: Real> Media<R> {
    /// Forgets all lists but the empty one.
    pub fn clear(&mut self) {
        self.nodes.truncate(1);
    }

    /// Index of refraction where a ray with this list is.
    pub fn ior(&self, list: MediumList) -> R {
        self.nodes[list as usize].ior
    }

    /// The list inside a body that has been entered.
    pub fn enter(&mut self, list: MediumList, body: u64, ior: R) -> MediumList {
        self.nodes.push(Node { body, ior, below: list });
        (self.nodes.len() - 1) as MediumList
    }

    /// The list after a body has been left; the same list if the ray was not in it.
    pub fn leave(&mut self, list: MediumList, body: u64) -> MediumList {
        if list == OUTSIDE {
            return OUTSIDE;
        }
        if self.nodes[list as usize].body == body {
            return self.nodes[list as usize].below;
        }
        if !self.contains(list, body) {
            return list;
        }
        // Media entered later stay on top.
        let kept: Vec<Node<R>> = self.iter(list).take_while(|node| node.body != body).collect();
        let mut result = self.iter(list).find(|node| node.body == body).map_or(OUTSIDE, |node| node.below);
        for node in kept.into_iter().rev() {
            result = self.enter(result, node.body, node.ior);
        }
        result
    }

    /// Whether a ray with this list is inside a body.
    pub fn contains(&self, list: MediumList, body: u64) -> bool {
        self.iter(list).any(|node| node.body == body)
    }

    /// Bodies and indices of refraction, innermost first.
    pub fn entries(&self, list: MediumList) -> impl Iterator<Item = (u64, R)> {
        self.iter(list).map(|node| (node.body, node.ior))
    }

    fn iter(&self, list: MediumList) -> impl Iterator<Item = Node<R>> {
        let mut next = list;
        std::iter::from_fn(move || {
            (next != OUTSIDE).then(|| {
                let node = self.nodes[next as usize];
                next = node.below;
                node
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_may_be_left_in_any_order() {
        let mut media = Media::<f64>::default();
        let water = media.enter(OUTSIDE, 1, 1.33);
        let glass = media.enter(water, 2, 1.5);
        assert_eq!(media.ior(glass), 1.5);
        let only_glass = media.leave(glass, 1);
        assert_eq!(media.entries(only_glass).collect::<Vec<_>>(), [(2, 1.5)]);
        assert_eq!(media.ior(media.clone().leave(only_glass, 2)), 1.0);
        assert_eq!(media.leave(glass, 7), glass, "leaving what it is not in changes nothing");
        assert_eq!(media.leave(OUTSIDE, 7), OUTSIDE);
    }
}
