//! The faces that meet in a vertex of a hull.

use crate::geometry::ConvexHull;
use crate::geometry::face::Face;
use glam::Vec3;

/// Corners whose places are found together.
const GROUP: usize = 8;

/// Groups that are passed over together where none has the vertex.
const GROUPS: usize = 4;

/// Sine of the angle between a plane and an edge below which a body that the end of the edge supports lies on all of it.
const LEVEL: f32 = 0.02;

impl ConvexHull {
    /// The face that looks against `direction` where a vertex supports the hull; none if no normal is a number.
    ///
    /// Of those that meet there it is the most opposed one. But where an edge all but lies across `direction`, it is one of the two
    /// beside the edge that does most: a body that lies on an edge is borne by both ends, whichever of them is lower by rounding, and the
    /// most opposed face at one end may end there.
    ///
    /// Nothing is kept for this: to look for a vertex in the loops of a hull is little beside the rest of a contact, and less
    /// than what every cut would have to do to keep lists of faces by vertex.
    pub(crate) fn incident_face(&self, vertex: usize, direction: Vec3) -> Option<&Face> {
        let mut best = (f32::INFINITY, f32::INFINITY, None);
        self.for_faces_around(vertex as u32, |face, place| {
            let height = direction.dot(face.plane.normal);
            let range = face.range();
            let before = if place == range.start {
                range.end
            } else {
                place
            } - 1;
            let after = if place + 1 == range.end {
                range.start
            } else {
                place + 1
            };
            for to in [before, after] {
                let slope = self.slope([place, to], direction);
                if slope < best.0 || slope == best.0 && height < best.1 {
                    best = (slope, height, Some(face));
                }
            }
        });
        best.2
    }

    /// Square of the sine, with its sign, of the angle between the plane across `direction` and the edge between two places of the loops;
    /// infinite from [`LEVEL`] on.
    #[inline]
    fn slope(&self, places: [usize; 2], direction: Vec3) -> f32 {
        let [from, to] = places.map(|place| self.vertices()[self.loops[place] as usize]);
        let edge = to - from;
        let (rise, length) = (direction.dot(edge), edge.length_squared());
        let square = rise * rise.abs();
        if square < LEVEL * LEVEL * length {
            square / length
        } else {
            f32::INFINITY
        }
    }

    /// Calls `found` for each face that has a vertex, in their order, with its place in the loops.
    fn for_faces_around<'h>(&'h self, vertex: u32, mut found: impl FnMut(&'h Face, usize)) {
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
                    let place = first + places.trailing_zeros() as usize;
                    found(face_at(place), place);
                    places &= places - 1;
                }
            }
        }
        let rest = (groups.len() * GROUP..).zip(rest);
        for (place, _) in rest.filter(|&(_, &corner)| corner == vertex) {
            found(face_at(place), place);
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
                hull.for_faces_around(vertex, |face, place| {
                    assert_eq!(hull.loops[place], vertex);
                    found.push(*face);
                });
                let faces = hull.faces().iter().copied();
                let expected: Vec<_> = faces
                    .filter(|face| hull.face_loop(face).contains(&vertex))
                    .collect();
                assert_eq!(found, expected);
            }
        }
    }
}
