//! How trees of four boxes a node are made from trees of two, and follow what moves.
//!
//! # References
//! H. Dammertz, J. Hanika, A. Keller, 2008, as in `wide_tree.rs`: nodes of four from nodes of two, the largest box first.

use crate::geometry::wide_tree::{LEAF, Node, WIDTH, WideTree};
use crate::math::Aabb;
use glam::{Vec3, Vec3A};
use obvhs::bvh2::Bvh2;
use smallvec::SmallVec;

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
            let mut node = Node::EMPTY;
            let children = opened(tree, source);
            node.count = children.len() as u32;
            for (child, &from) in children.iter().enumerate() {
                let from_node = &tree.nodes[from as usize];
                let b = from_node.aabb();
                let [min, max] = [b.min, b.max].map(|corner| Vec3::from(corner.to_array()));
                node.set(child, &Aabb { min, max });
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

    /// Renumbers the leaves by where they stand: what lies together has numbers side by side. Their former numbers.
    pub(crate) fn renumber(&mut self) -> Vec<u32> {
        let mut former = Vec::new();
        for node in &mut self.nodes {
            for child in &mut node.children[..node.count as usize] {
                if *child & LEAF != 0 {
                    let number = former.len() as u32;
                    former.push(*child & !LEAF);
                    *child = LEAF | number;
                }
            }
        }
        former
    }

    /// Makes the boxes those around what leaves are now. The sum of the surfaces of all nodes, m2: what walks cost goes with it.
    pub(crate) fn refit(&mut self, leaf: impl Fn(u32) -> Aabb) -> f32 {
        let mut surface = 0.0;
        // Nodes stand before those below them.
        for number in (0..self.nodes.len()).rev() {
            let mut node = self.nodes[number];
            for child in 0..node.count as usize {
                let of = node.children[child];
                let b = if of & LEAF != 0 {
                    leaf(of & !LEAF)
                } else {
                    self.nodes[of as usize].around_all()
                };
                node.set(child, &b);
            }
            self.nodes[number] = node;
            let Vec3 { x, y, z } = node.around_all().extents();
            surface += 2.0 * (x * y + y * z + z * x);
        }
        if let Some(root) = self.nodes.first() {
            let b = root.around_all();
            self.bounds = [b.min, b.max].map(Vec3A::from);
        }
        surface
    }
}
