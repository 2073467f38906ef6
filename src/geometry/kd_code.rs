//! 32-bit implicit KD-tree code of a point in a body's box.

use crate::math::Aabb;
use glam::Vec3;

/// The path to a leaf of the implicit KD-tree over a box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KdCode(pub u32);

/// The box that codes refer to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdBox {
    /// Lower corner, m.
    pub min: Vec3,
    /// Edge lengths, m.
    pub extents: Vec3,
}

impl KdBox {
    /// The code box of a body whose hull has the given bounding box.
    pub fn around(_aabb: Aabb) -> Self {
        unreachable!("written by the contact work")
    }
}
