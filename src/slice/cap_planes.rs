//! Which faces of pieces are caps, and on which planes: numbers are given out in the order of the cuts and never twice.

use crate::math::Plane;

/// The caps of the cuts since [`begin`](Self::begin), by the numbers of their faces.
#[derive(Clone, Debug, Default)]
pub(super) struct CapPlanes {
    /// The first number that is free.
    next: u32,
    /// In the order of their numbers.
    caps: Vec<CapFaces>,
}

/// The numbers of the faces of a cap, and its plane.
#[derive(Clone, Copy, Debug)]
struct CapFaces {
    first: u32,
    end: u32,
    plane: Plane,
}

impl CapPlanes {
    /// Forgets all caps; the next ones get numbers from `first` on.
    pub(super) fn begin(&mut self, first: u32) {
        self.caps.clear();
        self.next = first;
    }

    /// Leaves out numbers below `first`, which meshes have that are to be cut as well.
    pub(super) fn skip_to(&mut self, first: u32) {
        self.next = self.next.max(first);
    }

    /// The number of the next cap; each of its triangles may be a face by itself.
    pub(super) fn add(&mut self, plane: &Plane, triangles: usize) -> u32 {
        let first = self.next;
        self.next += triangles.max(1) as u32;
        self.caps.push(CapFaces {
            first,
            end: self.next,
            plane: *plane,
        });
        first
    }

    /// A number that no face has.
    pub(super) fn first_free(&self) -> u32 {
        self.next
    }

    /// The planes of the caps, in the order of the cuts.
    pub(super) fn planes(&self) -> impl ExactSizeIterator<Item = Plane> + '_ {
        self.caps.iter().map(|cap| cap.plane)
    }

    /// Which cap a face is; none if it is of another cut.
    pub(super) fn cap_of(&self, face: u32) -> Option<usize> {
        let after = self.caps.partition_point(|cap| cap.first <= face);
        let cap = after.checked_sub(1)?;
        (face < self.caps[cap].end).then_some(cap)
    }
}
