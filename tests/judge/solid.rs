//! How deep two bodies of convex parts overlap, by trying every axis there is, in `f64`: too simple to be wrong.
//!
//! Two convex polyhedra are as far apart, or as deep in each other, as the best of these axes says: the normals of the
//! faces of both, and the cross products of those of their edges that make a face of the Minkowski difference (S. Gottschalk,
//! M. C. Lin, D. Manocha, "OBBTree", 1996; D. Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013).
//! Apart, the best axis gives at most their distance; overlapping, exactly the depth. For what is round its polyhedron stands, which
//! has its corners on the surface.

use bevy_cleave::geometry::ConvexHull;
use bevy_cleave::prelude::{CompoundPart, Pose, Shape};
use bevy_cleave::testing::math::rotate;
use glam::{DQuat, DVec3};

/// An edge between two faces.
struct Ridge {
    /// A point on it, m.
    at: DVec3,
    along: DVec3,
    /// Outward normals of its two faces.
    normals: [DVec3; 2],
}

/// A body where it is, in world axes.
pub(crate) struct Solid(Vec<Part>);

/// A convex part of it.
struct Part {
    corners: Vec<DVec3>,
    /// Outward normals of the faces, and how far along them the faces are, m.
    faces: Vec<(DVec3, f64)>,
    ridges: Vec<Ridge>,
    middle: DVec3,
    /// Radius about the middle, m.
    radius: f64,
}

impl Solid {
    pub(crate) fn new(hull: &ConvexHull, pose: &Pose) -> Self {
        Self(vec![Part::new(hull, pose)])
    }

    /// A body of a shape; nothing of what has no inside.
    pub(crate) fn of(shape: &Shape, pose: &Pose) -> Option<Self> {
        match shape {
            Shape::Convex(mesh) => Some(Self::new(mesh.hull(), pose)),
            Shape::Compound(compound) => {
                let place = |part: &CompoundPart| {
                    let at = pose.transform_point(part.pose.position);
                    let turn = (pose.rotation * part.pose.rotation).normalize();
                    Part::new(part.shape.hull(), &Pose::new(at, turn))
                };
                Some(Self(compound.parts().iter().map(place).collect()))
            }
            Shape::HalfSpace(_) | Shape::Level(_) => None,
        }
    }

    /// Lowest corner along `normal`, m.
    pub(crate) fn lowest(&self, normal: DVec3) -> f64 {
        let parts = self.0.iter();
        parts.fold(f64::MAX, |low, part| low.min(part.lowest(normal)))
    }

    /// All corners of all parts, m.
    pub(crate) fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.0.iter().flat_map(|part| part.corners.iter().copied())
    }

    /// How far a point is outside, along the faces of the part that it is nearest to, m; below zero, how deep it is inside.
    pub(crate) fn outside(&self, point: DVec3) -> f64 {
        let of_part = |part: &Part| {
            let heights = part.faces.iter().map(|(n, reach)| n.dot(point) - reach);
            heights.fold(f64::MIN, f64::max)
        };
        self.0.iter().map(of_part).fold(f64::MAX, f64::min)
    }

    /// Signed distance of two bodies along the best axis, m: below zero, how deep their deepest parts overlap. Where it is certain that it
    /// is at least `enough`, that may be all it says.
    pub(crate) fn separation(&self, other: &Self, enough: f64) -> f64 {
        let pairs = self
            .0
            .iter()
            .flat_map(|a| other.0.iter().map(move |b| (a, b)));
        pairs.fold(f64::MAX, |least, (a, b)| least.min(a.separation(b, enough)))
    }
}

impl Part {
    fn new(hull: &ConvexHull, pose: &Pose) -> Self {
        let turn = pose.rotation.as_dquat().normalize();
        let place = |p: DVec3| turn * p + pose.position.as_dvec3();
        let corners: Vec<DVec3> = hull
            .vertices()
            .iter()
            .map(|v| place(v.as_dvec3()))
            .collect();
        let normals: Vec<DVec3> = hull
            .faces()
            .iter()
            .map(|face| outward(turn, face.plane.normal.as_dvec3()))
            .collect();
        let reach = |n: DVec3| corners.iter().fold(f64::MIN, |far, c| far.max(n.dot(*c)));
        let faces = normals.iter().map(|&n| (n, reach(n))).collect();
        let ridges = hull.edges().iter().map(|edge| {
            let [from, to] = edge.vertices.map(|v| corners[v as usize]);
            Ridge {
                at: from,
                along: to - from,
                normals: edge.faces.map(|face| normals[face as usize]),
            }
        });
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let radius = corners
            .iter()
            .fold(0.0_f64, |r, c| r.max(c.distance(middle)));
        Self {
            ridges: ridges.collect(),
            faces,
            middle,
            radius,
            corners,
        }
    }

    fn lowest(&self, normal: DVec3) -> f64 {
        self.corners
            .iter()
            .fold(f64::MAX, |low, c| low.min(normal.dot(*c)))
    }

    /// See [`Solid::separation`].
    fn separation(&self, other: &Self, enough: f64) -> f64 {
        let apart = self.middle.distance(other.middle) - self.radius - other.radius;
        if apart >= enough {
            return apart;
        }
        let mut best = apart;
        for (one, two) in [(self, other), (other, self)] {
            for &(normal, reach) in &one.faces {
                best = best.max(two.lowest(normal) - reach);
            }
            if best >= enough {
                return best;
            }
        }
        self.ridges
            .iter()
            .flat_map(|a| other.ridges.iter().map(move |b| (a, b)))
            .filter_map(|(a, b)| edge_gap(a, b))
            .fold(best, f64::max)
    }
}

/// The gap from one body to the other along the axis across an edge of each, if the two edges support each other, m.
fn edge_gap(a: &Ridge, b: &Ridge) -> Option<f64> {
    if !meets(a, b) {
        return None;
    }
    let axis = a.along.cross(b.along);
    let length = axis.length();
    if length <= 1e-9 * a.along.length() * b.along.length() {
        return None;
    }
    // Away from the first body is where the normals beside its edge point.
    let outward = axis.dot(a.normals[0] + a.normals[1]);
    Some(axis.dot(b.at - a.at) / length.copysign(outward))
}

fn outward(turn: DQuat, normal: DVec3) -> DVec3 {
    (turn * normal).normalize()
}

/// Whether the arcs of the two edges' normals cross on the sphere, that of B turned over: then they make a face of the
/// Minkowski difference.
fn meets(a: &Ridge, b: &Ridge) -> bool {
    let ([a1, a2], [b1, b2]) = (a.normals, b.normals.map(|n| -n));
    // Along the edges rather than across the normals, which may be nearly parallel.
    let (c1, c2) = (b1.dot(a.along), b2.dot(a.along));
    let (d1, d2) = (a1.dot(b.along), a2.dot(b.along));
    let same_side = a1.cross(a2).dot(b2) * b1.cross(b2).dot(a1) > 0.0;
    c1 * c2 < 0.0 && d1 * d2 < 0.0 && same_side
}

/// How far a body is above a plane through `point`, m.
pub(crate) fn above(solid: &Solid, point: DVec3, normal: DVec3) -> f64 {
    solid.lowest(normal) - normal.dot(point)
}

/// World normal and point of a half-space with a normal in the frame of `pose`.
pub(crate) fn plane_of(pose: &Pose, normal: glam::Vec3) -> (DVec3, DVec3) {
    let normal = rotate(pose.rotation, normal).as_dvec3().normalize();
    (pose.position.as_dvec3(), normal)
}
