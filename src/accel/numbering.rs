//! Numbers of primitives while a hierarchy is built: item after item, and the faces of a mesh in their order.

use super::item::Primitive;

/// So many items are found one by one, more in a list of all primitives.
const FEW: usize = 8;

/// What has which number.
#[derive(Debug)]
pub(super) struct Numbering {
    /// The first number of each item, and its index.
    firsts: Vec<(u32, u32)>,
    /// All primitives, if there are more than a few items.
    all: Vec<Primitive>,
    count: u32,
    /// How many there will be.
    room: usize,
}

impl Numbering {
    /// Without items yet, for at most so many primitives.
    pub(super) fn with_room(room: usize) -> Self {
        Self { firsts: Vec::new(), all: Vec::new(), count: 0, room }
    }

    /// Gives numbers to the primitives of an item. Returns the first.
    pub(super) fn add(&mut self, item: u32, primitives: u32) -> u32 {
        let first = self.count;
        self.count += primitives;
        if self.firsts.len() == FEW && self.all.is_empty() {
            let mut all = Vec::with_capacity(self.room);
            all.extend((0..first).map(|number| self.find(number as usize)));
            self.all = all;
        }
        if self.firsts.len() < FEW {
            self.firsts.push((first, item));
        } else {
            self.all.extend((0..primitives).map(|face| Primitive { item, face }));
        }
        first
    }

    /// The primitive of a number. Those after it in the same item have the next ones.
    #[inline(always)]
    pub(super) fn find(&self, number: usize) -> Primitive {
        if let Some(primitive) = self.all.get(number) {
            return *primitive;
        }
        let number = number as u32;
        let (first, item) = self.firsts.iter().rev().find(|(first, _)| *first <= number).copied().unwrap_or_default();
        Primitive { item, face: number - first }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_few_and_of_many_items_find_their_primitives() {
        for items in [1, 3, FEW, FEW + 1, 50] {
            let (mut numbering, mut all) = (Numbering::with_room(0), Vec::new());
            for item in 0..items as u32 {
                // Some meshes have no face.
                let faces = item * 7 % 5;
                assert_eq!(numbering.add(item, faces) as usize, all.len());
                all.extend((0..faces).map(|face| (item, face)));
            }
            for (number, (item, face)) in all.into_iter().enumerate() {
                let found = numbering.find(number);
                assert_eq!((found.item, found.face), (item, face), "{number} of {items} items");
            }
        }
    }
}
