//! Faces and edges of a hull.

use crate::math::Plane;
use std::ops::Range;
/// A face of a convex hull: a planar convex polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Plane of the face, its normal pointing outwards.
    pub plane: Plane,
    /// First entry of the face's loop in [`ConvexHull::loops`](crate::geometry::ConvexHull::loops).
    pub first: u32,
    /// Number of vertices of the loop.
    pub count: u32,
}

impl Face {
    /// Where the face's loop stands in the loops of its hull.
    #[inline]
    pub(crate) fn range(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// The loops of a hull from this face's on, and how many corners it has.
    #[inline(always)]
    pub(crate) fn polygon<'l>(&self, loops: &'l [u32]) -> (&'l [u32], usize) {
        (&loops[self.first as usize..], self.count as usize)
    }
}

/// An undirected edge of a convex hull.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Edge {
    /// End points, in the order in which `faces[0]` runs through them.
    pub vertices: [u32; 2],
    /// The two faces that share the edge.
    pub faces: [u32; 2],
}
