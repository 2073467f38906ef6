//! A hull as the narrow phase reads it: coordinates in lanes of four.
//!
//! Loops over the lanes have no branches and no order between lanes, so that the compiler makes vector instructions of
//! them; each lane computes what a scalar loop would, to the last bit.

use crate::geometry::face::Face;
use crate::math::{Aabb, Plane};
use crate::simd::float4::{higher, lower};
use glam::{Mat3, Mat4, Vec3, Vec4};

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
    fn of(points: [Vec3; LANES]) -> Self {
        let [x, y, z, _] = columns(points.map(|point| point.extend(0.0)));
        Self { x, y, z }
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
    #[inline(always)]
    pub(crate) fn along(&self, axis: Vec3) -> [f32; LANES] {
        let mut along = [0.0; LANES];
        #[allow(clippy::needless_range_loop, reason = "three arrays side by side")]
        for l in 0..LANES {
            along[l] = axis.x * self.x[l] + axis.y * self.y[l] + axis.z * self.z[l];
        }
        along
    }
}

/// Rows as columns.
#[inline]
fn columns([a, b, c, d]: [Vec4; LANES]) -> [[f32; LANES]; 4] {
    Mat4::from_cols(a, b, c, d).transpose().to_cols_array_2d()
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
    fn of(planes: [&Plane; LANES]) -> Self {
        let [x, y, z, offset] = columns(planes.map(|plane| plane.normal.extend(plane.offset)));
        Self {
            normals: Points4 { x, y, z },
            offset,
        }
    }

    /// Heights of a point above the planes, m.
    #[inline(always)]
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
}

impl HullLanes {
    /// Copies of the numbers of a hull with at least one vertex and one face.
    pub(crate) fn of(vertices: &[Vec3], faces: &[Face]) -> Self {
        let mut lanes = Self::default();
        lanes.copy(vertices, faces);
        lanes
    }

    /// The same in the memory that is there.
    pub(crate) fn copy(&mut self, vertices: &[Vec3], faces: &[Face]) {
        group_points(&mut self.points, vertices);
        group_planes(&mut self.planes, faces);
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
    let turned = |group: &Points4, row| Vec4::from_array(group.along(row));
    let tight = box_around(points.iter().map(|group| {
        [
            turned(group, rows.x_axis),
            turned(group, rows.y_axis),
            turned(group, rows.z_axis),
        ]
    }));
    Aabb {
        min: tight.min + shift,
        max: tight.max + shift,
    }
}

/// The box around points in their own frame.
pub(crate) fn box_of(points: &[Points4]) -> Aabb {
    box_around(points.iter().map(|group| {
        [
            Vec4::from_array(group.x),
            Vec4::from_array(group.y),
            Vec4::from_array(group.z),
        ]
    }))
}

/// The box around points whose coordinates come by axis, four at a time.
#[inline(always)]
fn box_around(groups: impl Iterator<Item = [Vec4; 3]>) -> Aabb {
    let (mut least, mut most) = ([Vec4::INFINITY; 3], [Vec4::NEG_INFINITY; 3]);
    for group in groups {
        for axis in 0..3 {
            least[axis] = lower(least[axis], group[axis]);
            most[axis] = higher(most[axis], group[axis]);
        }
    }
    let across = |[x, y, z]: [Vec4; 3], pick: fn(Vec4, Vec4) -> Vec4| {
        let [a, b, c, d] = columns([x, y, z, Vec4::ZERO]).map(Vec4::from_array);
        pick(pick(a, b), pick(c, d)).truncate()
    };
    Aabb {
        min: across(least, lower),
        max: across(most, higher),
    }
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
}
