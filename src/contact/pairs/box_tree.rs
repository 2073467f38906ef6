//! The tree of kept boxes: boxes come, move and go one by one, and where many came the tree is made anew.

use crate::geometry::bvh::tree_of_named;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;

/// A tree is made anew when at least so many boxes came since it was last made, and at least this share of all: with one that grew
/// box by box, a ray among 10 000 bodies takes a quarter longer.
const MANY_NEW: usize = 64;
const NEW_SHARE: f32 = 0.5;

/// A tree whose leaves are slots, one each.
#[derive(Clone, Default)]
pub(super) struct BoxTree {
    tree: Bvh2,
    /// Boxes that came since the tree was made.
    inserted: usize,
}

impl BoxTree {
    pub(super) fn tree(&self) -> &Bvh2 {
        &self.tree
    }

    pub(super) fn insert(&mut self, b: Aabb, slot: u32) {
        self.tree.insert_primitive(b, slot);
        self.inserted += 1;
    }

    pub(super) fn set(&mut self, b: Aabb, slot: u32) {
        self.tree.move_primitive(b, slot);
    }

    pub(super) fn remove(&mut self, slot: u32) {
        self.tree.remove_primitive(slot);
    }

    /// Makes the tree anew of `boxes`, which are by slot, if much of it is new. What it holds stays the same.
    pub(super) fn tidy(&mut self, boxes: impl Iterator<Item = Option<Aabb>>) {
        if self.inserted < MANY_NEW {
            return;
        }
        let named = (0..).zip(boxes);
        let (names, boxes): (Vec<u32>, Vec<Aabb>) =
            named.filter_map(|(slot, b)| Some((slot, b?))).unzip();
        if !names.is_empty() && self.inserted as f32 >= NEW_SHARE * names.len() as f32 {
            self.tree = tree_of_named(&boxes, names);
            self.inserted = 0;
        }
    }
}
