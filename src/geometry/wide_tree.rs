//! A bounding volume hierarchy of four boxes a node, for what does not change: half the depth of a tree of two, and less than half the
//! memory that a walk goes through, which is what walks through large trees wait for.
//!
//! Boxes and their order of tests are those of the tree of two that it is made from, so answers are the same.
//!
//! # References
//! H. Dammertz, J. Hanika, A. Keller, "Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays", Computer
//! Graphics Forum 27(4), 2008: nodes of four from nodes of two, the largest box first.

use crate::geometry::bvh::{ROUNDING, RayWalk, largest};
use crate::math::Aabb;
use glam::{Vec3, Vec3A, Vec4};
use obvhs::bvh2::Bvh2;
use smallvec::SmallVec;

/// Children of a node.
const WIDTH: usize = 4;

/// Says of a child that it is a leaf, and the rest its number.
const LEAF: u32 = 1 << 31;

/// Children that wait to be looked at, each with its distance or the square of it. Deeper trees take memory.
type Stack = SmallVec<[(f32, u32); 96]>;

/// Two lines of the cache.
#[derive(Clone, Copy, Default)]
#[repr(C, align(64))]
struct Node {
    /// Of the children's boxes, by axis and child, m.
    min: [Vec4; 3],
    max: [Vec4; 3],
    /// Numbers of nodes, or of leaves.
    children: [u32; WIDTH],
    /// How many there are.
    count: u32,
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
    nodes: Vec<Node>,
    /// Corners of the box around all.
    bounds: [Vec3A; 2],
}

impl Node {
    fn set(&mut self, child: usize, b: &obvhs::aabb::Aabb) {
        let (min, max) = (b.min.to_array(), b.max.to_array());
        for axis in 0..3 {
            self.min[axis][child] = min[axis];
            self.max[axis][child] = max[axis];
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

/// Up to four nodes of the tree of two below one of its nodes: the largest box is opened first.
fn opened(tree: &Bvh2, node: u32) -> SmallVec<[u32; WIDTH]> {
    let mut children = SmallVec::from_slice(&[node]);
    while children.len() < WIDTH {
        let area = |&at: &usize| tree.nodes[children[at] as usize].aabb().half_area();
        let inner = (0..children.len()).filter(|&at| !tree.nodes[children[at] as usize].is_leaf());
        let Some(at) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else {
            break;
        };
        let first = tree.nodes[children[at] as usize].first_index;
        children[at] = first;
        children.insert(at + 1, first + 1);
    }
    children
}

impl WideTree {
    /// From a tree of two with one box a leaf, whose number it keeps.
    pub(crate) fn of(tree: &Bvh2) -> Self {
        let Some(root) = tree.nodes.first() else {
            return Self::default();
        };
        let b = root.aabb();
        let bounds = [b.min, b.max].map(|corner| Vec3A::from_array(corner.to_array()));
        let mut nodes: Vec<Node> = Vec::with_capacity(tree.nodes.len() / 4 + 1);
        // Nodes that are to be made, and who wants to know their number: what lies together stands together.
        let mut wanted = vec![(0_u32, None::<(usize, usize)>)];
        while let Some((source, parent)) = wanted.pop() {
            let number = nodes.len();
            if let Some((node, child)) = parent {
                nodes[node].children[child] = number as u32;
            }
            let mut node = Node::default();
            let children = opened(tree, source);
            node.count = children.len() as u32;
            for (child, &from) in children.iter().enumerate() {
                let from_node = &tree.nodes[from as usize];
                node.set(child, from_node.aabb());
                if from_node.is_leaf() {
                    node.children[child] =
                        LEAF | tree.primitive_indices[from_node.first_index as usize];
                }
            }
            nodes.push(node);
            for (child, &from) in children.iter().enumerate().rev() {
                if !tree.nodes[from as usize].is_leaf() {
                    wanted.push((from, Some((number, child))));
                }
            }
        }
        Self { nodes, bounds }
    }

    /// As [`along_ray`](crate::geometry::bvh::along_ray).
    pub(crate) fn along_ray(
        &self,
        ray: RayWalk,
        mut end: f32,
        mut visit: impl FnMut(u32, f32) -> f32,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let ray = ray.among(self.bounds);
        let (low_corner, high_corner) = (ray.moved[1], ray.moved[0]);
        let mut stack = Stack::new();
        stack.push((0.0, 0));
        while let Some((enters, child)) = stack.pop() {
            if enters > end {
                continue;
            }
            if child & LEAF != 0 {
                end = visit(child & !LEAF, end);
                continue;
            }
            let node = &self.nodes[child as usize];
            let (mut first, mut last) = (Vec4::ZERO, Vec4::splat(end));
            for axis in 0..3 {
                let inverse = Vec4::splat(ray.inverse[axis]);
                let low = (node.min[axis] - Vec4::splat(low_corner[axis])) * inverse;
                let high = (node.max[axis] - Vec4::splat(high_corner[axis])) * inverse;
                first = first.max(low.min(high));
                last = last.min(low.max(high));
            }
            let met = first.cmple(last).bitmask() & node.used();
            push_far_first(&mut stack, node, met, first.to_array());
        }
    }

    /// As [`within`](crate::geometry::bvh::within).
    pub(crate) fn within(&self, b: &Aabb, mut visit: impl FnMut(u32)) {
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
            let met = (0..WIDTH).rev().filter(|child| met >> child & 1 != 0);
            stack.extend(met.map(|child| node.children[child]));
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

    /// As [`around`](crate::geometry::bvh::around), in search of what is nearest: where each side of a box is touched by what is in it, some of
    /// that is not farther than the farthest corner of the nearest side, and nothing beyond is visited.
    pub(crate) fn around(
        &self,
        point: Vec3,
        mut limit: f32,
        mut visit: impl FnMut(u32, f32) -> f32,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let point = Vec3A::from(point);
        let slack = ROUNDING * largest([point, self.bounds[0], self.bounds[1]]);
        let (above, below) = (point + Vec3A::splat(slack), point - Vec3A::splat(slack));
        let mut stack = Stack::new();
        stack.push((0.0, 0));
        while let Some((square, child)) = stack.pop() {
            if square > limit * limit {
                continue;
            }
            if child & LEAF != 0 {
                limit = visit(child & !LEAF, limit);
                continue;
            }
            let node = &self.nodes[child as usize];
            let mut squares = Vec4::ZERO;
            let (mut nearer, mut farther) = ([Vec4::ZERO; 3], [Vec4::ZERO; 3]);
            for axis in 0..3 {
                let before = node.min[axis] - Vec4::splat(above[axis]);
                let behind = Vec4::splat(below[axis]) - node.max[axis];
                let apart = before.max(behind).max(Vec4::ZERO);
                squares += apart * apart;
                let ends = [node.min[axis], node.max[axis]]
                    .map(|end| (end - Vec4::splat(point[axis])).abs() + Vec4::splat(slack));
                nearer[axis] = ends[0].min(ends[1]);
                farther[axis] = ends[0].max(ends[1]);
            }
            let [x, y, z] = nearer.map(|near| near * near);
            let [far_x, far_y, far_z] = farther.map(|far| far * far);
            let most = (x + far_y + far_z)
                .min(far_x + y + far_z)
                .min(far_x + far_y + z);
            let used = node.used();
            for (child, most) in most.to_array().into_iter().enumerate() {
                if used >> child & 1 != 0 && most < limit * limit {
                    limit = most.sqrt() * (1.0 + 4.0 * ROUNDING);
                }
            }
            let near = squares.cmple(Vec4::splat(limit * limit)).bitmask() & used;
            push_far_first(&mut stack, node, near, squares.to_array());
        }
    }
}

/// Lets the children whose bits are set wait, so that the nearest one comes first.
#[inline(always)]
fn push_far_first(stack: &mut Stack, node: &Node, met: u32, distances: [f32; WIDTH]) {
    let begin = stack.len();
    for child in (0..WIDTH).filter(|child| met >> child & 1 != 0) {
        let mut at = stack.len();
        stack.push((distances[child], node.children[child]));
        while at > begin && stack[at - 1].0 < stack[at].0 {
            stack.swap(at - 1, at);
            at -= 1;
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
                four.within(&region, |leaf| b.push(leaf));
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
                four.along_ray(walk, 9.0, |leaf, end| keep(&mut b, leaf, end));
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
                four.around(origin, 4.0, |leaf, end| nearest(&mut least[1], leaf, end));
                assert_eq!(least[0].0, least[1].0);
                a.sort_unstable();
                b.sort_unstable();
                assert_eq!(a, b);
            }
        }
        let none = WideTree::default();
        none.within(&Aabb::of_points([Vec3::ZERO]), |_| panic!("it has no leaf"));
    }
}
