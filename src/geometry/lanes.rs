//! A hull as the narrow phase reads it: coordinates in lanes of four, and the faces around each vertex.
//!
//! Loops over the lanes have no branches and no order between lanes, so that the compiler makes vector instructions of
//! them; each lane computes what a scalar loop would, to the last bit.

use super::convex::Face;
use crate::math::{Aabb, Plane};
use glam::{Mat3, Vec3};

/// Lanes of a group.
pub(crate) const LANES: usize = 4;

/// Four points, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Points4 {
    pub(crate) x: [f32; LANES],
    pub(crate) y: [f32; LANES],
    pub(crate) z: [f32; LANES],
}

impl Points4 {
    #[inline]
    fn of([a, b, c, d]: [Vec3; LANES]) -> Self {
        Self {
            x: [a.x, b.x, c.x, d.x],
            y: [a.y, b.y, c.y, d.y],
            z: [a.z, b.z, c.z, d.z],
        }
    }

    /// One of the points.
    pub(crate) fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Writes one of the points.
    pub(crate) fn set(&mut self, lane: usize, point: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = point.into();
    }

    /// Coordinates along `axis`.
    pub(crate) fn along(&self, axis: Vec3) -> [f32; LANES] {
        let mut along = [0.0; LANES];
        #[allow(clippy::needless_range_loop, reason = "three arrays side by side")]
        for l in 0..LANES {
            along[l] = axis.x * self.x[l] + axis.y * self.y[l] + axis.z * self.z[l];
        }
        along
    }
}

/// Point number `index` of a list of groups.
pub(crate) fn point(groups: &[Points4], index: usize) -> Vec3 {
    groups[index / LANES].get(index % LANES)
}

/// Fills `groups` with `points`; the last group is filled up with the first point, which changes no extreme.
fn group_points(groups: &mut Vec<Points4>, points: &[Vec3]) {
    let (whole, rest) = points.as_chunks::<LANES>();
    groups.clear();
    groups.reserve_exact(points.len().div_ceil(LANES));
    groups.extend(whole.iter().map(|points| Points4::of(*points)));
    if !rest.is_empty() {
        let mut last = [points[0]; LANES];
        last[..rest.len()].copy_from_slice(rest);
        groups.push(Points4::of(last));
    }
}

/// Four planes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Planes4 {
    pub(crate) normals: Points4,
    pub(crate) offset: [f32; LANES],
}

impl Planes4 {
    #[inline]
    fn of([a, b, c, d]: [&Plane; LANES]) -> Self {
        Self {
            normals: Points4::of([a.normal, b.normal, c.normal, d.normal]),
            offset: [a.offset, b.offset, c.offset, d.offset],
        }
    }

    /// Heights of a point above the planes, m.
    pub(crate) fn heights(&self, point: Vec3) -> [f32; LANES] {
        let mut heights = self.normals.along(point);
        #[allow(clippy::needless_range_loop, reason = "three arrays side by side")]
        for l in 0..LANES {
            heights[l] -= self.offset[l];
        }
        heights
    }
}

/// Fills `groups` with the planes of `faces`; the last group is filled up with the first one.
fn group_planes(groups: &mut Vec<Planes4>, faces: &[Face]) {
    let (whole, rest) = faces.as_chunks::<LANES>();
    groups.clear();
    groups.reserve_exact(faces.len().div_ceil(LANES));
    groups.extend(
        (whole.iter()).map(|[a, b, c, d]| Planes4::of([&a.plane, &b.plane, &c.plane, &d.plane])),
    );
    if !rest.is_empty() {
        let mut last = [&faces[0].plane; LANES];
        last.iter_mut()
            .zip(rest)
            .for_each(|(lane, face)| *lane = &face.plane);
        groups.push(Planes4::of(last));
    }
}

/// Copies of a hull's numbers in the order in which loops want them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct HullLanes {
    /// Vertices, filled up with the first one.
    pub(crate) points: Vec<Points4>,
    /// Planes of the faces, filled up with the first one.
    pub(crate) planes: Vec<Planes4>,
    /// Faces around each vertex.
    pub(crate) around: FacesAround,
}

impl HullLanes {
    /// Copies of the numbers of a hull with at least one vertex and one face.
    pub(crate) fn of(vertices: &[Vec3], faces: &[Face], loops: &[u32]) -> Self {
        let mut lanes = Self::default();
        lanes.copy(vertices, faces);
        lanes.around.sort_corners(vertices.len(), faces, loops);
        lanes
    }

    /// Copies points and planes, and leaves the faces around each vertex as they are.
    pub(crate) fn copy(&mut self, vertices: &[Vec3], faces: &[Face]) {
        group_points(&mut self.points, vertices);
        group_planes(&mut self.planes, faces);
    }

    /// The faces that meet in a vertex, ascending.
    pub(crate) fn faces_around(&self, vertex: usize) -> &[u32] {
        self.around.of(vertex)
    }
}

/// Faces around each vertex, ascending, one vertex after the other.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FacesAround {
    faces: Vec<u32>,
    /// Where each vertex's run begins in `faces`, and where the last one ends.
    first: Vec<u32>,
}

impl Default for FacesAround {
    /// Of no vertex.
    fn default() -> Self {
        Self {
            faces: Vec::new(),
            first: vec![0],
        }
    }
}

impl FacesAround {
    /// Counting sort of all corners by vertex.
    fn sort_corners(&mut self, vertices: usize, faces: &[Face], loops: &[u32]) {
        self.first.resize(vertices + 1, 0);
        loops.iter().for_each(|&v| self.first[v as usize + 1] += 1);
        for v in 0..vertices {
            self.first[v + 1] += self.first[v];
        }
        let mut next = self.first.clone();
        self.faces.resize(loops.len(), 0);
        for (index, face) in (0..).zip(faces) {
            for &v in &loops[face.first as usize..][..face.count as usize] {
                self.faces[next[v as usize] as usize] = index;
                next[v as usize] += 1;
            }
        }
    }

    /// Makes room for so many vertices with so many corners, to be written in order.
    pub(crate) fn rewrite(&mut self, vertices: usize, corners: usize) -> AroundWriter<'_> {
        self.first.resize(vertices + 1, 0);
        self.faces.resize(corners, 0);
        AroundWriter {
            ends: &mut self.first[1..],
            faces: &mut self.faces,
            written: 0,
        }
    }

    /// The faces that meet in a vertex, ascending.
    pub(crate) fn of(&self, vertex: usize) -> &[u32] {
        &self.faces[self.first[vertex] as usize..self.first[vertex + 1] as usize]
    }
}

/// Most vertices of a hull have no more faces around them.
const USUALLY_AROUND: usize = 8;

/// Writes the faces around vertices, one vertex after the other.
#[derive(Debug)]
pub(crate) struct AroundWriter<'a> {
    /// Of the vertices that are still to come.
    ends: &'a mut [u32],
    faces: &'a mut [u32],
    written: usize,
}

impl AroundWriter<'_> {
    /// Writes the faces around `vertices` of `other`, which are called `numbers` here, in the same order. False if there is
    /// no room left.
    pub(crate) fn copy(&mut self, other: &FacesAround, vertices: &[u32], numbers: &[u32]) -> bool {
        let Some((ends, rest)) =
            std::mem::take(&mut self.ends).split_at_mut_checked(vertices.len())
        else {
            return false;
        };
        self.ends = rest;
        let (firsts, all) = (&other.first[..], &other.faces[..]);
        let (room, mut written) = (&mut *self.faces, self.written);
        let mut has_room = true;
        for (&vertex, end) in vertices.iter().zip(ends) {
            let first = firsts[vertex as usize] as usize;
            let count = firsts[vertex as usize + 1] as usize - first;
            let from = all.get(first..first + USUALLY_AROUND);
            let to = room.get_mut(written..written + USUALLY_AROUND);
            if let (Some(from), Some(to), true) = (from, to, count <= USUALLY_AROUND) {
                // More than are there, which the next vertex writes over: there is no guessing how many it will be.
                for (to, &from) in to.iter_mut().zip(from) {
                    *to = numbers[from as usize];
                }
            } else if let Some(to) = room.get_mut(written..written + count) {
                for (to, &from) in to.iter_mut().zip(&all[first..]) {
                    *to = numbers[from as usize];
                }
            } else {
                has_room = false;
            }
            written += count;
            *end = written as u32;
        }
        self.written = written;
        has_room
    }

    /// Writes the faces around the next vertex, ascending. False if there is no room left.
    #[inline]
    pub(crate) fn push(&mut self, faces: &[u32]) -> bool {
        let to = (self.faces).get_mut(self.written..self.written + faces.len());
        let ends = std::mem::take(&mut self.ends);
        let (Some(to), Some((end, rest))) = (to, ends.split_first_mut()) else {
            return false;
        };
        to.copy_from_slice(faces);
        self.written += faces.len();
        *end = self.written as u32;
        self.ends = rest;
        true
    }
}

/// The point with the smallest coordinate along `axis`, and that coordinate; the first one on a tie.
///
/// (0, infinity) if no coordinate is a number.
pub(crate) fn lowest<'p>(groups: impl Iterator<Item = &'p Points4>, axis: Vec3) -> (usize, f32) {
    let mut best = [f32::INFINITY; LANES];
    let mut group_of = [0_u32; LANES];
    for (number, group) in (0_u32..).zip(groups) {
        let height = group.along(axis);
        #[allow(clippy::needless_range_loop, reason = "three arrays side by side")]
        for l in 0..LANES {
            let is_lower = height[l] < best[l];
            best[l] = if is_lower { height[l] } else { best[l] };
            group_of[l] = if is_lower { number } else { group_of[l] };
        }
    }
    let mut found = (0, f32::INFINITY);
    for l in 0..LANES {
        let index = group_of[l] as usize * LANES + l;
        if best[l] < found.1 || (best[l] == found.1 && index < found.0) {
            found = (index, best[l]);
        }
    }
    found
}

/// The smallest coordinate along `axis`; infinity if none is a number.
pub(crate) fn lowest_height(groups: &[Points4], axis: Vec3) -> f32 {
    let mut best = [f32::INFINITY; LANES];
    for group in groups {
        let height = group.along(axis);
        #[allow(clippy::needless_range_loop, reason = "three arrays side by side")]
        for l in 0..LANES {
            best[l] = if height[l] < best[l] {
                height[l]
            } else {
                best[l]
            };
        }
    }
    best.into_iter().fold(f32::INFINITY, f32::min)
}

/// Fills `moved` with `points` in another frame.
pub(crate) fn move_points(moved: &mut Vec<Points4>, points: &[Points4], turn: &Mat3, shift: Vec3) {
    let rows = turn.transpose();
    moved.clear();
    moved.extend(points.iter().map(|group| {
        let mut group = Points4 {
            x: group.along(rows.x_axis),
            y: group.along(rows.y_axis),
            z: group.along(rows.z_axis),
        };
        #[allow(clippy::needless_range_loop, reason = "three arrays side by side")]
        for l in 0..LANES {
            group.x[l] += shift.x;
            group.y[l] += shift.y;
            group.z[l] += shift.z;
        }
        group
    }));
}

/// The box around points in another frame.
pub(crate) fn bounds(points: &[Points4], turn: &Mat3, shift: Vec3) -> Aabb {
    let rows = turn.transpose();
    let (x, y, z) = (
        range_along(points, rows.x_axis),
        range_along(points, rows.y_axis),
        range_along(points, rows.z_axis),
    );
    Aabb {
        min: Vec3::new(x[0], y[0], z[0]) + shift,
        max: Vec3::new(x[1], y[1], z[1]) + shift,
    }
}

/// The box around points in their own frame.
pub(crate) fn box_of(points: &[Points4]) -> Aabb {
    let (x, y, z) = (
        range_of(points, |group| group.x),
        range_of(points, |group| group.y),
        range_of(points, |group| group.z),
    );
    Aabb {
        min: Vec3::new(x[0], y[0], z[0]),
        max: Vec3::new(x[1], y[1], z[1]),
    }
}

/// The smallest and the largest of one coordinate.
fn range_of(points: &[Points4], coordinate: impl Fn(&Points4) -> [f32; LANES]) -> [f32; 2] {
    let lower = |[a, b]: [f32; 2]| if b < a { b } else { a };
    let higher = |[a, b]: [f32; 2]| if b > a { b } else { a };
    let (mut least, mut most) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    for group in points {
        let along = coordinate(group);
        least = std::array::from_fn(|l| lower([least[l], along[l]]));
        most = std::array::from_fn(|l| higher([most[l], along[l]]));
    }
    [
        least.into_iter().fold(f32::INFINITY, f32::min),
        most.into_iter().fold(f32::NEG_INFINITY, f32::max),
    ]
}

/// The smallest and the largest coordinate along `axis`.
fn range_along(points: &[Points4], axis: Vec3) -> [f32; 2] {
    let (mut least, mut most) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    for group in points {
        let height = group.along(axis);
        #[allow(clippy::needless_range_loop, reason = "three arrays side by side")]
        for l in 0..LANES {
            least[l] = if height[l] < least[l] {
                height[l]
            } else {
                least[l]
            };
            most[l] = if height[l] > most[l] {
                height[l]
            } else {
                most[l]
            };
        }
    }
    [
        least.into_iter().fold(f32::INFINITY, f32::min),
        most.into_iter().fold(f32::NEG_INFINITY, f32::max),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::primitives::icosphere;

    #[test]
    fn lowest_point_is_the_first_of_the_scalar_loop() {
        let hull = icosphere(1.0, 1).expect("a ball is valid");
        let lanes = &hull.lanes;
        for axis in [Vec3::X, Vec3::NEG_Y, Vec3::ONE, Vec3::new(0.3, -0.2, 0.7)] {
            let heights = hull.vertices().iter().map(|v| axis.dot(*v));
            let mut expected = (0, f32::INFINITY);
            for (index, height) in heights.enumerate() {
                if height < expected.1 {
                    expected = (index, height);
                }
            }
            assert_eq!(lowest(lanes.points.iter(), axis), expected);
            assert_eq!(lowest_height(&lanes.points, axis), expected.1);
        }
        assert_eq!(lowest(lanes.points.iter(), Vec3::NAN), (0, f32::INFINITY));
    }

    #[test]
    fn faces_around_a_vertex_are_those_whose_loops_name_it() {
        let hull = icosphere(1.0, 1).expect("a ball is valid");
        for vertex in 0..hull.vertices().len() {
            let expected: Vec<u32> = (0..)
                .zip(hull.faces())
                .filter(|(_, face)| hull.face_loop(face).contains(&(vertex as u32)))
                .map(|(index, _)| index)
                .collect();
            assert_eq!(hull.lanes.faces_around(vertex), expected);
        }
    }
}
