//! The faces that meet in a vertex of a hull.

use super::ConvexHull;
use super::convex::Face;
use glam::Vec3;

/// Corners that are looked at together.
const GROUP: usize = 8;

impl ConvexHull {
    /// Of the faces that meet in a vertex the one whose normal is most opposed to `direction`, the first on a tie; none if no
    /// normal is a number.
    ///
    /// Nothing is kept for this: to look for a vertex in the loops of a hull is little beside the rest of a contact, and less
    /// than what every cut would have to do to keep lists of faces by vertex.
    pub(crate) fn most_opposed_face(&self, vertex: usize, direction: Vec3) -> Option<&Face> {
        let mut best = (f32::INFINITY, None);
        self.for_faces_around(vertex as u32, |face| {
            let height = direction.dot(face.plane.normal);
            if height < best.0 {
                best = (height, Some(face));
            }
        });
        best.1
    }

    /// Calls `found` for each face that has a vertex, in their order.
    fn for_faces_around<'h>(&'h self, vertex: u32, mut found: impl FnMut(&'h Face)) {
        let mut look_at = |first: usize, corners: &[u32]| {
            for (place, _) in (first..).zip(corners).filter(|&(_, &v)| v == vertex) {
                // Faces stand in the order of their loops.
                let after = (self.faces).partition_point(|face| face.first as usize <= place);
                found(&self.faces[after - 1]);
            }
        };
        let (groups, rest) = self.loops.as_chunks::<GROUP>();
        for (number, group) in groups.iter().enumerate() {
            if has(group, vertex) {
                look_at(number * GROUP, group);
            }
        }
        look_at(groups.len() * GROUP, rest);
    }
}

/// Whether a vertex is among eight, without a branch for each.
#[inline(always)]
fn has(group: &[u32; GROUP], vertex: u32) -> bool {
    (group.iter()).fold(false, |has, &corner| has | (corner == vertex))
}

#[cfg(test)]
mod tests {
    use crate::geometry::primitives::{icosphere, regular_prism};

    #[test]
    fn faces_around_a_vertex_are_those_whose_loops_name_it() {
        for hull in [icosphere(1.0, 1), regular_prism(7, 1.0, 0.3)] {
            let hull = hull.expect("valid sizes");
            for vertex in 0..hull.vertices().len() as u32 {
                let mut found = Vec::new();
                hull.for_faces_around(vertex, |face| found.push(*face));
                let faces = hull.faces().iter().copied();
                let expected: Vec<_> = faces
                    .filter(|face| hull.face_loop(face).contains(&vertex))
                    .collect();
                assert_eq!(found, expected);
            }
        }
    }
}
