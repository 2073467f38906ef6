//! Boxes against hulls and balls: told apart, or together, by a few axes, without a search for where they are nearest.
//!
//! # References
//! S. Gottschalk, M. Lin, D. Manocha, "OBBTree: A Hierarchical Structure for Rapid Interference Detection", SIGGRAPH 1996: boxes that are
//! apart are so along an axis of one of them or across an edge of each.

use crate::geometry::ConvexHull;
use crate::geometry::hull_lanes::LANES;
use crate::geometry::support::PlacedCore;
use crate::math::{Aabb, Pose};
use glam::{DVec3, Mat3, Vec3};

/// Rounding of a gap along an axis, as a share of coordinates.
const ROUNDING: f32 = 1e-6;

/// Sine of an angle below which edges count as parallel.
pub(crate) const PARALLEL: f32 = 1e-6;

/// A box that lies anyhow, in the frame of a hull, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cuboid {
    pub(crate) center: Vec3,
    /// Unit vectors.
    pub(crate) axes: Mat3,
    pub(crate) half: Vec3,
}

/// What a few axes tell.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Told {
    Apart,
    Overlap,
    /// Nothing; this way they are farthest apart of those that were looked at.
    Nothing(Vec3),
}

/// The box that a hull is, if it is one along the axes of its frame.
pub(crate) fn box_of(hull: &ConvexHull) -> Option<Aabb> {
    let is_along = |n: Vec3| n.abs().max_element() == 1.0;
    let is_box = hull.faces().len() == 6 && hull.faces().iter().all(|f| is_along(f.plane.normal));
    is_box.then(|| hull.aabb())
}

impl Cuboid {
    /// The core of a question that is one.
    pub(crate) fn of(core: &PlacedCore) -> Option<Self> {
        let (center, axes, half) = core.as_box()?;
        Some(Self { center, axes, half })
    }

    /// A box at a pose.
    pub(crate) fn at(b: &Aabb, pose: &Pose) -> Self {
        Self {
            center: pose.transform_point(b.center()),
            axes: Mat3::from_quat(pose.rotation),
            half: 0.5 * b.extents(),
        }
    }

    /// Whether it comes within a radius (m) of a point.
    pub(crate) fn reaches(&self, point: Vec3, radius: f64) -> bool {
        let local = self.axes.transpose() * (point - self.center);
        let rest = (local.abs() - self.half).max(Vec3::ZERO);
        rest.as_dvec3().length_squared() <= radius * radius
    }

    /// Whether a hull overlaps or touches it.
    pub(crate) fn against(&self, hull: &ConvexHull) -> Told {
        if let Some(b) = box_of(hull) {
            return self.against_box(&b);
        }
        let size = hull.aabb().diagonal() + self.half.length() + self.center.abs().max_element();
        let slack = ROUNDING * size;
        let edges = Mat3::from_cols(
            self.axes.x_axis * self.half.x,
            self.axes.y_axis * self.half.y,
            self.axes.z_axis * self.half.z,
        );
        let (mut widest, mut face, mut highest) = (f32::NEG_INFINITY, 0, f32::NEG_INFINITY);
        for (group, planes) in hull.lanes.planes.iter().enumerate() {
            let heights = planes.heights(self.center);
            let [x, y, z] =
                [edges.x_axis, edges.y_axis, edges.z_axis].map(|e| planes.normals.along(e));
            for l in 0..LANES {
                let gap = heights[l] - (x[l].abs() + y[l].abs() + z[l].abs());
                highest = highest.max(heights[l]);
                if gap > widest {
                    (widest, face) = (gap, group * LANES + l);
                }
            }
            if widest > slack {
                return Told::Apart;
            }
        }
        if highest <= 0.0 {
            return Told::Overlap;
        }
        for (axis, half) in [self.axes.x_axis, self.axes.y_axis, self.axes.z_axis]
            .into_iter()
            .zip(self.half.to_array())
        {
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for points in &hull.lanes.points {
                for along in points.along(axis) {
                    (low, high) = (low.min(along), high.max(along));
                }
            }
            let middle = axis.dot(self.center);
            if low - middle > half + slack || middle - high > half + slack {
                return Told::Apart;
            }
        }
        let face = hull.faces().get(face);
        Told::Nothing(face.map_or(Vec3::X, |face| face.plane.normal))
    }

    /// Whether a box along the axes of the frame overlaps or touches it.
    pub(crate) fn against_box(&self, b: &Aabb) -> Told {
        let (apart, own) = (self.center - b.center(), 0.5 * b.extents());
        let size = 2.0 * own.length() + self.half.length() + self.center.abs().max_element();
        let slack = ROUNDING * size;
        if (apart.abs() - own).max_element() <= 0.0 {
            return Told::Overlap;
        }
        let turn = self.axes;
        let reaches = Mat3::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs());
        let along_faces = apart.abs() - own - reaches * self.half;
        let along_own = (turn.transpose() * apart).abs() - self.half - reaches.transpose() * own;
        if along_faces.max(along_own).max_element() > slack {
            return Told::Apart;
        }
        self.across_edges(b, slack)
    }

    /// What the axes across an edge of each tell of a box along the axes of the frame.
    fn across_edges(&self, b: &Aabb, slack: f32) -> Told {
        let apart = (self.center - b.center()).to_array();
        let own = (0.5 * b.extents()).to_array();
        let half = self.half.to_array();
        let turn = self.axes.to_cols_array_2d();
        let next = |i: usize| [(i + 1) % 3, (i + 2) % 3];
        let mut is_sure = true;
        for i in 0..3 {
            let [i1, i2] = next(i);
            for j in 0..3 {
                let [j1, j2] = next(j);
                let reach = own[i1] * turn[j][i2].abs()
                    + own[i2] * turn[j][i1].abs()
                    + half[j1] * turn[j2][i].abs()
                    + half[j2] * turn[j1][i].abs();
                let gap = (apart[i2] * turn[j][i1] - apart[i1] * turn[j][i2]).abs() - reach;
                if gap > slack {
                    return Told::Apart;
                }
                // Edges that are parallel tell nothing that the other axes do not.
                let sine = turn[j][i1].abs() + turn[j][i2].abs();
                is_sure &= gap < -slack || sine < PARALLEL;
            }
        }
        if is_sure {
            Told::Overlap
        } else {
            Told::Nothing(self.center - b.center())
        }
    }
}

/// The nearest point of a box from outside it: where, and how far that is.
pub(crate) fn nearest_of_box(b: &Aabb, point: Vec3) -> (Vec3, Vec3, f32) {
    let at = point.clamp(b.min, b.max);
    let apart = (point - at).as_dvec3();
    let away = apart.length();
    let normal = apart.try_normalize().unwrap_or(DVec3::X);
    (at, normal.as_vec3(), away as f32)
}
