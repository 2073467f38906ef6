//! Walks through a bounding volume hierarchy (crate `obvhs`): along a ray, through a box, from a point outwards.
//!
//! Boxes are taken a little larger than they are, by what rounding may do to a coordinate, so that no walk passes by a box that the
//! exact test behind it would find touched.

use crate::math::Aabb;
use glam::{Vec3, Vec3A};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use smallvec::SmallVec;

/// Rounding of a coordinate and of a difference of two, as a share of the largest one.
pub(super) const ROUNDING: f32 = 5e-7;

/// A component of a direction that is smaller counts as this, so that its inverse stays finite.
const LEAST_COMPONENT: f32 = 1e-30;

/// Nodes that wait to be looked at, each with its distance. Deeper trees take memory.
type Stack = SmallVec<[(f32, u32); 96]>;

/// A box in the tree's own vector type, which may be of another version of `glam`.
pub(crate) fn tree_box(b: &Aabb) -> obvhs::aabb::Aabb {
    obvhs::aabb::Aabb::new(b.min.to_array().into(), b.max.to_array().into())
}

/// A tree of boxes, whose leaves are their numbers; the more so that walks are short, the longer it is searched for.
pub(crate) fn tree_of(boxes: &[obvhs::aabb::Aabb], search: PlocSearchDistance) -> Bvh2 {
    let indices = (0..boxes.len() as u32).collect();
    PlocBuilder::with_capacity(boxes.len()).build(search, boxes, indices, SortPrecision::U64, 0)
}

/// The same with `names` in place of the boxes' numbers, to which more can be added. A leaf holds one box.
pub(crate) fn tree_of_named(boxes: &[obvhs::aabb::Aabb], names: Vec<u32>) -> Bvh2 {
    let mut tree = tree_of(boxes, PlocSearchDistance::Low);
    // By itself it takes names to be numbers without gaps.
    let largest = names.iter().max().map_or(0, |&name| name as usize + 1);
    tree.primitives_to_nodes = vec![u32::MAX; largest];
    tree.primitive_indices = names;
    for (number, node) in (0..).zip(&tree.nodes) {
        if node.is_leaf() {
            let name = tree.primitive_indices[node.first_index as usize];
            tree.primitives_to_nodes[name as usize] = number;
        }
    }
    tree
}

/// The corners of a node's box in registers of four. The tree's vectors may be of another version of `glam`.
#[inline(always)]
fn corners(node: &Bvh2Node) -> [Vec3A; 2] {
    let b = node.aabb();
    [b.min, b.max].map(|corner| Vec3A::from_array(corner.to_array()))
}

/// Largest coordinate of points.
pub(super) fn largest<const N: usize>(points: [Vec3A; N]) -> f32 {
    let most = points.map(|point| point.abs().max_element());
    most.into_iter().fold(0.0, f32::max)
}

/// The root; none of a tree that has never had a leaf, or has lost all.
fn root(tree: &Bvh2) -> Option<&Bvh2Node> {
    let root = tree.nodes.first()?;
    (root.is_leaf() || tree.nodes.len() > 1).then_some(root)
}

fn primitives<'t>(tree: &'t Bvh2, leaf: &Bvh2Node) -> &'t [u32] {
    let first = leaf.first_index as usize;
    &tree.primitive_indices[first..first + leaf.prim_count as usize]
}

/// A box that is moved along a ray, or a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayWalk {
    origin: Vec3A,
    pub(super) inverse: Vec3A,
    /// The corners of the moved box when it begins.
    pub(super) moved: [Vec3A; 2],
}

impl RayWalk {
    /// Along the unit vector `direction` from `origin`; `moved` is the box about the origin that goes along, m.
    pub(crate) fn new(origin: Vec3, direction: Vec3, moved: Aabb) -> Self {
        let component = |c: f32| {
            if c.abs() < LEAST_COMPONENT {
                LEAST_COMPONENT.copysign(c)
            } else {
                c
            }
        };
        let direction = Vec3A::from_array(direction.to_array().map(component));
        let origin = Vec3A::from(origin);
        Self {
            origin,
            inverse: direction.recip(),
            moved: [moved.min, moved.max].map(|corner| origin + Vec3A::from(corner)),
        }
    }

    /// The same for boxes between these corners, with room for rounding.
    pub(super) fn among(self, [min, max]: [Vec3A; 2]) -> Self {
        let slack = Vec3A::splat(ROUNDING * largest([self.origin, min, max]));
        let [low, high] = self.moved;
        Self {
            moved: [low - slack, high + slack],
            ..self
        }
    }

    /// Where the moved box meets another one first, m; infinite if it does not before `end`.
    #[inline(always)]
    fn enters(&self, [min, max]: [Vec3A; 2], end: f32) -> f32 {
        let low = (min - self.moved[1]) * self.inverse;
        let high = (max - self.moved[0]) * self.inverse;
        let first = low.min(high).max_element().max(0.0);
        let last = low.max(high).min_element().min(end);
        if first <= last { first } else { f32::INFINITY }
    }
}

/// Visits the leaves that a ray meets before `end` (m), roughly from near to far. `visit` is given a primitive and the present
/// end, and returns the new one: what it found, or a negative number to stop.
pub(crate) fn along_ray(
    tree: &Bvh2,
    ray: RayWalk,
    mut end: f32,
    mut visit: impl FnMut(u32, f32) -> f32,
) {
    let Some(top) = root(tree).map(corners) else {
        return;
    };
    let ray = ray.among(top);
    let mut stack = Stack::new();
    stack.push((ray.enters(top, end), 0));
    while let Some((enters, index)) = stack.pop() {
        if enters > end || enters == f32::INFINITY {
            continue;
        }
        let node = &tree.nodes[index as usize];
        if node.is_leaf() {
            for &primitive in primitives(tree, node) {
                end = visit(primitive, end);
            }
            continue;
        }
        let children = [node.first_index, node.first_index + 1];
        let [near, far] = children.map(|child| {
            let b = corners(&tree.nodes[child as usize]);
            (ray.enters(b, end), child)
        });
        let (near, far) = if far.0 < near.0 {
            (far, near)
        } else {
            (near, far)
        };
        for child in [far, near] {
            if child.0 <= end && child.0 < f32::INFINITY {
                stack.push(child);
            }
        }
    }
}

/// Visits the leaves whose boxes meet a box.
pub(crate) fn within(tree: &Bvh2, b: &Aabb, mut visit: impl FnMut(u32)) {
    let Some(top) = root(tree).map(corners) else {
        return;
    };
    let [low, high] = [b.min, b.max].map(Vec3A::from);
    let slack = ROUNDING * largest([low, high, top[0], top[1]]).min(f32::MAX);
    let (low, high) = (low - Vec3A::splat(slack), high + Vec3A::splat(slack));
    let meets = |index: u32| {
        let [min, max] = corners(&tree.nodes[index as usize]);
        (min.cmple(high) & max.cmpge(low)).all()
    };
    let mut stack: SmallVec<[u32; 96]> = SmallVec::new();
    let mut next = meets(0).then_some(0);
    while let Some(index) = next {
        let node = &tree.nodes[index as usize];
        if node.is_leaf() {
            primitives(tree, node).iter().for_each(|&p| visit(p));
            next = stack.pop();
            continue;
        }
        let [first, second] = [node.first_index, node.first_index + 1];
        next = match [meets(first), meets(second)] {
            [true, true] => {
                stack.push(second);
                Some(first)
            }
            [true, false] => Some(first),
            [false, true] => Some(second),
            [false, false] => stack.pop(),
        };
    }
}

/// Visits the leaves whose boxes are not farther than `limit` (m) from a point, roughly from near to far. `visit` is given a
/// primitive and the present limit, and returns the new one.
pub(crate) fn around(
    tree: &Bvh2,
    point: Vec3,
    mut limit: f32,
    mut visit: impl FnMut(u32, f32) -> f32,
) {
    let Some(top) = root(tree).map(corners) else {
        return;
    };
    let point = Vec3A::from(point);
    let slack = Vec3A::splat(ROUNDING * largest([point, top[0], top[1]]));
    let (above, below) = (point + slack, point - slack);
    // Squares, whose roots nobody needs.
    let away = |[min, max]: [Vec3A; 2]| {
        let apart = (min - above).max(below - max).max(Vec3A::ZERO);
        apart.length_squared()
    };
    let mut stack = Stack::new();
    let mut next = Some((away(top), 0));
    while let Some((square, index)) = next {
        if square > limit * limit {
            next = stack.pop();
            continue;
        }
        let node = &tree.nodes[index as usize];
        if node.is_leaf() {
            for &primitive in primitives(tree, node) {
                limit = visit(primitive, limit);
            }
            next = stack.pop();
            continue;
        }
        let of_child = |child: u32| (away(corners(&tree.nodes[child as usize])), child);
        let [first, second] = [of_child(node.first_index), of_child(node.first_index + 1)];
        let (near, far) = if second.0 < first.0 {
            (second, first)
        } else {
            (first, second)
        };
        if far.0 <= limit * limit {
            stack.push(far);
        }
        next = Some(near);
    }
}
