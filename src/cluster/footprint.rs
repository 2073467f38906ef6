//! What of the face of a part lies on the face of a contact: where two convex outlines in one plane overlap.

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

/// Corners of a convex outline, one after the other around it. Two are a line, and one is a point.
pub(super) type Outline = SmallVec<[DVec2; 8]>;

/// A plane with two axes.
pub(super) struct Plane {
    axes: [DVec3; 2],
    normal: DVec3,
    height: f64,
}

impl Plane {
    /// Through a point.
    pub(super) fn through(point: DVec3, normal: DVec3) -> Self {
        let first = normal.any_orthonormal_vector();
        Self {
            axes: [first, normal.cross(first)],
            normal,
            height: normal.dot(point),
        }
    }

    /// How far above it a point is, m.
    pub(super) fn height_of(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.height
    }

    /// The outline of points in it.
    pub(super) fn outline(&self, points: impl Iterator<Item = DVec3>) -> Outline {
        let flat = points.map(|point| DVec2::from_array(self.axes.map(|axis| axis.dot(point))));
        outline_of(flat.collect())
    }

    /// The point of the plane at these coordinates.
    pub(super) fn point(&self, at: DVec2) -> DVec3 {
        at.x * self.axes[0] + at.y * self.axes[1] + self.height * self.normal
    }
}

/// The convex hull of points, counterclockwise (A. Andrew, 1979).
fn outline_of(mut points: Outline) -> Outline {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let mut outline = Outline::new();
    for turn in 0..2 {
        let start = outline.len();
        for &point in &points {
            while let [.., a, b] = outline[start..] {
                if (b - a).perp_dot(point - b) > 0.0 {
                    break;
                }
                outline.pop();
            }
            outline.push(point);
        }
        // The first one of the other half.
        outline.pop();
        if turn == 0 {
            points.reverse();
        }
    }
    outline
}

/// What of an outline is within a counterclockwise one, or beyond it by at most `near`.
pub(super) fn overlap(mut outline: Outline, rim: &Outline, near: f64) -> Outline {
    for (i, &from) in rim.iter().enumerate() {
        let edge = rim[(i + 1) % rim.len()] - from;
        let inward = edge.perp().normalize_or_zero();
        let depth = |point: DVec2| inward.dot(point - from) + near;
        let whole = std::mem::take(&mut outline);
        for (i, &point) in whole.iter().enumerate() {
            let next = whole[(i + 1) % whole.len()];
            let depths = [point, next].map(depth);
            if depths[0] >= 0.0 {
                outline.push(point);
            }
            if depths[0] * depths[1] < 0.0 {
                outline.push(point.lerp(next, depths[0] / (depths[0] - depths[1])));
            }
        }
    }
    outline
}
