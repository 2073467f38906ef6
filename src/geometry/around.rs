//! The faces that meet in a vertex of a hull.

use crate::geometry::ConvexHull;
use crate::geometry::face::Face;
use glam::Vec3;

/// Corners whose places are found together.
const GROUP: usize = 8;

/// Groups that are passed over together where none has the vertex.
const GROUPS: usize = 4;

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
        let has_triangles_only = self.only_triangles().is_some();
        let face_at = |place: usize| match has_triangles_only {
            true => &self.faces[place / 3],
            // Faces stand in the order of their loops.
            false => {
                let after = (self.faces).partition_point(|face| face.first as usize <= place);
                &self.faces[after - 1]
            }
        };
        let (groups, rest) = self.loops.as_chunks::<GROUP>();
        for (number, groups) in groups.chunks(GROUPS).enumerate() {
            if !has(vertex, groups.as_flattened()) {
                continue;
            }
            for (group, first) in groups
                .iter()
                .zip((number * GROUPS * GROUP..).step_by(GROUP))
            {
                let mut places = places_of(vertex, group);
                while places != 0 {
                    found(face_at(first + places.trailing_zeros() as usize));
                    places &= places - 1;
                }
            }
        }
        let rest = (groups.len() * GROUP..).zip(rest);
        for (place, _) in rest.filter(|&(_, &corner)| corner == vertex) {
            found(face_at(place));
        }
    }
}

/// Whether a vertex is among some corners, without a branch for each.
#[inline(always)]
fn has(vertex: u32, corners: &[u32]) -> bool {
    (corners.iter()).fold(false, |has, &corner| has | (corner == vertex))
}

/// The places of a vertex among eight, as bits, without a branch for each.
#[inline(always)]
fn places_of(vertex: u32, corners: &[u32; GROUP]) -> u32 {
    let mut places = 0;
    for (place, &corner) in corners.iter().enumerate() {
        places |= u32::from(corner == vertex) << place;
    }
    places
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
