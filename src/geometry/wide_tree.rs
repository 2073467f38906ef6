//! A bounding volume hierarchy of four boxes a node, for what does not change, or is refitted: half the depth of a tree of two, and less
//! than half the memory that a walk goes through, which is what walks through large trees wait for.
//!
//! Boxes are those of the tree of two that it is made from, so answers are the same.
//!
//! # References
//! H. Dammertz, J. Hanika, A. Keller, "Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays", Computer
//! Graphics Forum 27(4), 2008: nodes of four from nodes of two, the largest box first.

use crate::geometry::bvh::{ROUNDING, RayWalk, largest};
use crate::geometry::tree_queue::{Stack, Waiting, pop_nearest, push_heap};
use crate::math::Aabb;
use crate::simd::prefetch::prefetch;
use glam::{Vec3, Vec3A, Vec4};
use smallvec::SmallVec;

/// Children of a node.
pub(super) const WIDTH: usize = 4;

/// Says of a child that it is a leaf, and the rest its number.
pub(super) const LEAF: u32 = 1 << 31;

/// Two lines of the cache.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Of the children's boxes, by axis and child, m.
    pub(super) min: [Vec4; 3],
    pub(super) max: [Vec4; 3],
    /// Numbers of nodes, or of leaves.
    pub(super) children: [u32; WIDTH],
    /// How many there are.
    pub(super) count: u32,
}

/// What a walk that looks at nodes too does after one child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Visit {
    /// It goes on with what is below the child; for a leaf as [`Next`](Self::Next).
    Below,
    /// It leaves out what is below the child.
    Next,
    /// It ends.
    End,
}

/// The tree.
#[derive(Clone, Default)]
pub(crate) struct WideTree {
    pub(super) nodes: Vec<Node>,
    /// Corners of the box around all.
    pub(super) bounds: [Vec3A; 2],
}

impl Node {
    /// Without children.
    pub(super) const EMPTY: Self = Self {
        min: [Vec4::INFINITY; 3],
        max: [Vec4::NEG_INFINITY; 3],
        children: [0; WIDTH],
        count: 0,
    };

    pub(super) fn set(&mut self, child: usize, b: &Aabb) {
        for axis in 0..3 {
            self.min[axis][child] = b.min[axis];
            self.max[axis][child] = b.max[axis];
        }
    }

    /// The box around all children, m.
    pub(super) fn around_all(&self) -> Aabb {
        Aabb {
            min: self.min.map(Vec4::min_element).into(),
            max: self.max.map(Vec4::max_element).into(),
        }
    }

    /// The box around a child, m.
    fn bounds(&self, child: usize) -> Aabb {
        let [min, max] = [self.min, self.max].map(|corner| corner.map(|axis| axis[child]));
        Aabb {
            min: min.into(),
            max: max.into(),
        }
    }

    /// Bits of the children that are there.
    fn used(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// Bits of the children whose boxes overlap one with these corners.
    #[inline(always)]
    fn met(&self, low: Vec3A, high: Vec3A) -> u32 {
        let mut met = self.used();
        for axis in 0..3 {
            let begins = self.min[axis].cmple(Vec4::splat(high[axis]));
            let ends = self.max[axis].cmpge(Vec4::splat(low[axis]));
            met &= (begins & ends).bitmask();
        }
        met
    }
}

impl WideTree {
    /// As [`along_ray`](crate::geometry::bvh::along_ray). `leaves` are what leaves are of: it is brought near before it is visited.
    pub(crate) fn along_ray<T>(
        &self,
        leaves: &[T],
        ray: RayWalk,
        mut end: f32,
        mut visit: impl FnMut(u32, f32) -> f32,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let ray = ray.among(self.bounds);
        let splat = |v: Vec3A| v.to_array().map(Vec4::splat);
        let [low_corner, high_corner, inverse] =
            [ray.moved[1], ray.moved[0], ray.inverse].map(splat);
        let mut stack = Stack::new();
        let mut next = Some(Waiting::ROOT);
        while let Some(waiting) = next {
            let child = waiting.child();
            if waiting.distance() > end {
                next = stack.pop();
                continue;
            }
            if child & LEAF != 0 {
                end = visit(child & !LEAF, end);
                next = stack.pop();
                continue;
            }
            let node = &self.nodes[child as usize];
            let (mut first, mut last) = (Vec4::ZERO, Vec4::splat(end));
            for axis in 0..3 {
                let low = (node.min[axis] - low_corner[axis]) * inverse[axis];
                let high = (node.max[axis] - high_corner[axis]) * inverse[axis];
                first = first.max(low.min(high));
                last = last.min(low.max(high));
            }
            let met = first.cmple(last).bitmask() & node.used();
            let children = self.waiting(leaves, node, met, first.to_array());
            let count = met.count_ones() as usize;
            stack.extend(children[..count].iter().skip(1).rev().copied());
            next = match count {
                0 => stack.pop(),
                _ => Some(children[0]),
            };
        }
    }

    /// As [`within`](crate::geometry::bvh::within). `leaves` as [along a ray](Self::along_ray).
    pub(crate) fn within<T>(&self, leaves: &[T], b: &Aabb, mut visit: impl FnMut(u32)) {
        let [low, high] = self.with_slack(b);
        let mut stack: SmallVec<[u32; 96]> = SmallVec::new();
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(child) = stack.pop() {
            if child & LEAF != 0 {
                visit(child & !LEAF);
                continue;
            }
            let node = &self.nodes[child as usize];
            let met = node.met(low, high);
            for child in (0..WIDTH).rev().filter(|child| met >> child & 1 != 0) {
                self.bring(leaves, node.children[child]);
                stack.push(node.children[child]);
            }
        }
    }

    /// As [`within`](Self::within), but it asks at each child on its way: with the number of the node, of the child in it, and of the leaf
    /// if the child is one.
    pub(crate) fn visit_within(
        &self,
        b: &Aabb,
        mut visit: impl FnMut(usize, usize, Option<u32>) -> Visit,
    ) {
        let [low, high] = self.with_slack(b);
        let mut stack: SmallVec<[u32; 96]> = SmallVec::new();
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(number) = stack.pop() {
            let node = &self.nodes[number as usize];
            let met = node.met(low, high);
            for child in (0..WIDTH).filter(|child| met >> child & 1 != 0) {
                let below = node.children[child];
                let leaf = (below & LEAF != 0).then_some(below & !LEAF);
                match visit(number as usize, child, leaf) {
                    Visit::Below if leaf.is_none() => stack.push(below),
                    Visit::Below | Visit::Next => {}
                    Visit::End => return,
                }
            }
        }
    }

    /// What is below each child of each node, from what leaves are, and the parts of a node, with their boxes, as one.
    pub(crate) fn fold_up<T: Copy + Default>(
        &self,
        leaf: impl Fn(u32) -> T,
        join: impl Fn(&[(Aabb, T)]) -> T,
    ) -> Vec<[T; WIDTH]> {
        let mut below = vec![[T::default(); WIDTH]; self.nodes.len()];
        let mut parts: SmallVec<[(Aabb, T); WIDTH]> = SmallVec::new();
        // Nodes stand before those below them.
        for number in (0..self.nodes.len()).rev() {
            let node = &self.nodes[number];
            for child in 0..node.count as usize {
                let of = node.children[child];
                below[number][child] = if of & LEAF != 0 {
                    leaf(of & !LEAF)
                } else {
                    let inner = &self.nodes[of as usize];
                    let children = 0..inner.count as usize;
                    parts.clear();
                    parts.extend(children.map(|k| (inner.bounds(k), below[of as usize][k])));
                    join(&parts)
                };
            }
        }
        below
    }

    /// The corners of a box, so far out that rounding hides nothing.
    fn with_slack(&self, b: &Aabb) -> [Vec3A; 2] {
        let [low, high] = [b.min, b.max].map(Vec3A::from);
        let slack = ROUNDING * largest([low, high, self.bounds[0], self.bounds[1]]);
        let slack = Vec3A::splat(slack.min(f32::MAX));
        [low - slack, high + slack]
    }

    /// As [`around`](crate::geometry::bvh::around), but strictly from the nearest box outwards: nothing is looked at that is farther than
    /// what is found at last. `leaves` as [along a ray](Self::along_ray).
    pub(crate) fn around<T>(
        &self,
        leaves: &[T],
        point: Vec3,
        mut limit: f32,
        mut visit: impl FnMut(u32, f32) -> f32,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let point = Vec3A::from(point);
        let slack = ROUNDING * largest([point, self.bounds[0], self.bounds[1]]);
        let splat = |v: Vec3A| v.to_array().map(Vec4::splat);
        let (above, below) = (point + Vec3A::splat(slack), point - Vec3A::splat(slack));
        let (above, below) = (splat(above), splat(below));
        let mut queue = Stack::new();
        let mut next = Some(Waiting::ROOT);
        while let Some(waiting) = next {
            let child = waiting.child();
            if waiting.distance() > limit * limit {
                return;
            }
            if child & LEAF != 0 {
                limit = visit(child & !LEAF, limit);
                next = pop_nearest(&mut queue);
                continue;
            }
            let node = &self.nodes[child as usize];
            let mut squares = Vec4::ZERO;
            for axis in 0..3 {
                let before = node.min[axis] - above[axis];
                let behind = below[axis] - node.max[axis];
                let apart = before.max(behind).max(Vec4::ZERO);
                squares += apart * apart;
            }
            let met = squares.cmple(Vec4::splat(limit * limit)).bitmask() & node.used();
            let children = self.waiting(leaves, node, met, squares.to_array());
            for &child in children[..met.count_ones() as usize].iter().skip(1) {
                push_heap(&mut queue, child);
            }
            next = match queue.first() {
                Some(&known) if known < children[0] => {
                    let nearest = pop_nearest(&mut queue);
                    if children[0] != Waiting::LAST {
                        push_heap(&mut queue, children[0]);
                    }
                    nearest
                }
                _ => (children[0] != Waiting::LAST).then_some(children[0]),
            };
        }
    }

    /// The children whose bits are set, the nearest one first.
    #[inline(always)]
    fn waiting<T>(
        &self,
        leaves: &[T],
        node: &Node,
        met: u32,
        distances: [f32; WIDTH],
    ) -> [Waiting; WIDTH] {
        let mut children = [Waiting::LAST; WIDTH];
        for child in 0..WIDTH {
            if met >> child & 1 != 0 {
                self.bring(leaves, node.children[child]);
                children[child] = Waiting::new(distances[child], node.children[child]);
            }
        }
        for [a, b] in [[0, 1], [2, 3], [0, 2], [1, 3], [1, 2]] {
            let pair = [children[a], children[b]];
            (children[a], children[b]) = (pair[0].min(pair[1]), pair[0].max(pair[1]));
        }
        children
    }

    /// Asks for a child that waits: walks through large trees wait for memory, and so do so for several children at once.
    #[inline(always)]
    fn bring<T>(&self, leaves: &[T], child: u32) {
        if child & LEAF == 0 {
            prefetch(&self.nodes[child as usize]);
        } else if let Some(leaf) = leaves.get((child & !LEAF) as usize) {
            prefetch(leaf);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::WideTree;
    use crate::geometry::bvh::{RayWalk, along_ray, around, tree_box, tree_of, within};
    use crate::math::Aabb;
    use glam::Vec3;
    use obvhs::ploc::PlocSearchDistance;

    /// Numbers from -1 to 1.
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 7_u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            2.0 * (state >> 8) as f32 / (1 << 24) as f32 - 1.0
        }
    }

    #[test]
    fn walks_meet_what_those_of_a_tree_of_two_meet() {
        let mut next = numbers();
        let mut point = |size: f32| size * Vec3::new(next(), next(), next());
        for count in [1, 2, 3, 4, 5, 17, 400] {
            let boxes: Vec<_> = (0..count)
                .map(|_| {
                    let (center, half) = (point(10.0), point(1.0).abs());
                    tree_box(&Aabb {
                        min: center - half,
                        max: center + half,
                    })
                })
                .collect();
            let two = tree_of(&boxes, PlocSearchDistance::VeryLow);
            let four = WideTree::of(&two);
            for _ in 0..50 {
                let (origin, half) = (point(12.0), point(3.0).abs());
                let region = Aabb {
                    min: origin - half,
                    max: origin + half,
                };
                let (mut a, mut b) = (Vec::new(), Vec::new());
                within(&two, &region, |leaf| a.push(leaf));
                four.within(&boxes, &region, |leaf| b.push(leaf));
                let small = Aabb {
                    min: -0.1 * half,
                    max: 0.1 * half,
                };
                let walk = RayWalk::new(origin, point(1.0).normalize(), small);
                let keep = |found: &mut Vec<u32>, leaf: u32, end: f32| {
                    found.push(leaf);
                    end
                };
                along_ray(&two, walk, 9.0, |leaf, end| keep(&mut a, leaf, end));
                four.along_ray(&boxes, walk, 9.0, |leaf, end| keep(&mut b, leaf, end));
                let nearest = |found: &mut (f32, u32), leaf: u32, end: f32| {
                    let b = boxes[leaf as usize];
                    let [min, max] = [b.min, b.max].map(|corner| Vec3::from(corner.to_array()));
                    let away = origin.clamp(min, max).distance(origin);
                    if (away, leaf) < *found {
                        *found = (away, leaf);
                    }
                    end.min(away)
                };
                let mut least = [(f32::INFINITY, 0); 2];
                around(&two, origin, 4.0, |leaf, end| {
                    nearest(&mut least[0], leaf, end)
                });
                four.around(&boxes, origin, 4.0, |leaf, end| {
                    nearest(&mut least[1], leaf, end)
                });
                assert_eq!(least[0].0, least[1].0);
                a.sort_unstable();
                b.sort_unstable();
                assert_eq!(a, b);
            }
        }
        let none = WideTree::default();
        let boxes_of_none: [u8; 0] = [];
        none.within(&boxes_of_none, &Aabb::of_points([Vec3::ZERO]), |_| {
            panic!("it has no leaf")
        });
    }
}
