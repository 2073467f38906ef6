//! Solids of revolution about y with a straight side: cylinders and cones.

use crate::geometry::primitives::unit_circle;
use glam::{DVec2, DVec3, Vec3};
use std::sync::LazyLock;

/// Corners of the polygon that stands for a disc where contacts are chosen from it: its radius is 0.5 % too small at most.
pub(crate) const DISC_CORNERS: usize = 32;

static CIRCLE: LazyLock<[DVec2; DISC_CORNERS]> =
    LazyLock::new(|| std::array::from_fn(|k| unit_circle(k as u32, DISC_CORNERS as u32)));

/// A conical frustum about the y axis: all between two discs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frustum {
    /// Where the two discs are along y, the lower one first, m.
    pub(crate) levels: [f32; 2],
    /// Their radii, m; 0 for the tip of a cone.
    pub(crate) radii: [f32; 2],
}

impl Frustum {
    pub(crate) fn new(bottom: f32, top: f32, height: f32) -> Self {
        Self {
            levels: [-0.5 * height, 0.5 * height],
            radii: [bottom, top],
        }
    }

    /// Distance from the axis and height of the unit normal of the side.
    pub(crate) fn side_normal(&self) -> DVec2 {
        let [bottom, top] = self.radii.map(f64::from);
        DVec2::new(self.height(), bottom - top).normalize()
    }

    pub(crate) fn height(&self) -> f64 {
        f64::from(self.levels[1]) - f64::from(self.levels[0])
    }

    /// The point farthest along `axis`.
    pub(crate) fn support(&self, axis: DVec3) -> DVec3 {
        let across = DVec2::new(axis.x, axis.z);
        let length = across.length();
        let out = if length > 0.0 {
            across / length
        } else {
            DVec2::ZERO
        };
        let [bottom, top] = [0, 1].map(|k| {
            let (level, radius) = (f64::from(self.levels[k]), f64::from(self.radii[k]));
            (axis.y * level + length * radius, level, radius)
        });
        let (_, level, radius) = if top.0 > bottom.0 { top } else { bottom };
        DVec3::new(radius * out.x, level, radius * out.y)
    }

    /// What is deeper inside than `depth` (m), which must leave something.
    pub(crate) fn shrunk(&self, depth: f32) -> Self {
        let (n, depth) = (self.side_normal(), f64::from(depth));
        let [bottom, top] = self.levels.map(f64::from);
        let side = n.x * f64::from(self.radii[0]) + n.y * bottom - depth;
        let radius_at = |level: f64| (side - n.y * level) / n.x;
        let (low, mut high) = (bottom + depth, top - depth);
        if radius_at(high) < 0.0 {
            high = side / n.y;
        }
        Self {
            levels: [low as f32, high as f32],
            radii: [radius_at(low) as f32, radius_at(high).max(0.0) as f32],
        }
    }

    /// Radius of the largest sphere inside, m.
    pub(crate) fn inradius(&self) -> f32 {
        let n = self.side_normal();
        let [bottom, top] = self.levels.map(f64::from);
        // On the axis, as far from the side as from the lower disc.
        let at_side = n.x * f64::from(self.radii[0]) + n.y * bottom;
        let level = (at_side + bottom) / (1.0 + n.y);
        let half = 0.5 * (top - bottom);
        (level - bottom).min(half).min(f64::from(self.radii[0])) as f32
    }

    /// Height of a point above the surface, m, which is negative inside; the outward normal and the point of the surface there.
    pub(crate) fn nearest(&self, point: DVec3) -> (f64, DVec3, DVec3) {
        let across = DVec2::new(point.x, point.z);
        let from_axis = across.length();
        let out = across.try_normalize().unwrap_or(DVec2::X);
        let at = DVec2::new(from_axis, point.y);
        let [low, high] =
            [0, 1].map(|k| DVec2::new(f64::from(self.radii[k]), f64::from(self.levels[k])));
        let in_space = |v: DVec2| DVec3::new(v.x * out.x, v.y, v.x * out.y);
        let n = self.side_normal();
        // The three outlines of the half-plane through the point: lower disc, side, upper disc.
        let outlines = [
            (DVec2::new(0.0, low.y), low, DVec2::NEG_Y),
            (low, high, n),
            (high, DVec2::new(0.0, high.y), DVec2::Y),
        ];
        let heights = outlines.map(|(from, _, normal)| normal.dot(at - from));
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if highest <= 0.0 {
            let k = heights.iter().position(|&h| h == highest).unwrap_or(0);
            let normal = outlines[k].2;
            let surface = in_space(at - highest * normal);
            return (highest, in_space(normal), surface);
        }
        let nearest_of = |(from, to, _): (DVec2, DVec2, DVec2)| {
            let along = to - from;
            let share = (at - from).dot(along) / along.length_squared();
            // Not a number where the disc is a point.
            let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
            from + share * along
        };
        let mut best = (f64::INFINITY, DVec2::ZERO);
        for outline in outlines {
            let near = nearest_of(outline);
            let away = near.distance_squared(at);
            if away < best.0 {
                best = (away, near);
            }
        }
        let distance = best.0.sqrt();
        let normal = (at - best.1).try_normalize().unwrap_or(n);
        (distance, in_space(normal), in_space(best.1))
    }

    /// A point of the rim of a disc: `out` is a unit vector across the axis.
    pub(crate) fn rim(&self, disc: usize, out: Vec3) -> Vec3 {
        self.radii[disc] * out + self.levels[disc] * Vec3::Y
    }

    /// The corners of the polygon that stands for a disc, counter-clockwise seen from outside, the first one along `out`, a unit
    /// vector across the axis.
    pub(crate) fn disc(&self, disc: usize, out: Vec3) -> impl Iterator<Item = Vec3> {
        let (this, side) = (*self, out.cross(Vec3::Y));
        let sign = if disc == 0 { 1.0 } else { -1.0 };
        CIRCLE.iter().map(move |at| {
            let (along, across) = (at.x as f32, sign * at.y as f32);
            this.rim(disc, along * out + across * side)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Frustum;
    use glam::DVec3;

    const SHAPES: [Frustum; 3] = [
        Frustum {
            levels: [-0.5, 0.5],
            radii: [0.3, 0.3],
        },
        Frustum {
            levels: [-0.5, 0.5],
            radii: [0.3, 0.0],
        },
        Frustum {
            levels: [-0.1, 0.2],
            radii: [1.0, 0.5],
        },
    ];

    #[test]
    fn what_is_shrunk_is_as_deep_inside_as_was_asked() {
        for shape in SHAPES {
            let depth = 0.2 * shape.inradius();
            let inner = shape.shrunk(depth);
            for k in 0..200 {
                let t = f64::from(k);
                #[expect(clippy::disallowed_methods, reason = "directions of a test")]
                let axis = DVec3::new((t * 1.3).sin(), (t * 0.7).cos(), (t * 2.1).sin());
                let (height, ..) = shape.nearest(inner.support(axis.normalize()));
                assert!(
                    (height + f64::from(depth)).abs() < 1e-6,
                    "{shape:?} {height} {depth}"
                );
            }
        }
    }

    #[test]
    fn the_nearest_point_is_farthest_along_its_normal() {
        for shape in SHAPES {
            for k in 0..300 {
                let t = f64::from(k);
                #[expect(clippy::disallowed_methods, reason = "places of a test")]
                let at = 1.5 * DVec3::new((t * 1.3).sin(), (t * 0.7).cos(), (t * 2.1).sin());
                let (height, normal, surface) = shape.nearest(at);
                let reach = normal.dot(shape.support(normal));
                assert!((normal.dot(surface) - reach).abs() < 1e-6);
                assert!((normal.dot(at) - reach - height).abs() < 1e-6);
            }
        }
    }
}
