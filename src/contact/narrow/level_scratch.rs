//! What is found over a level of triangles, and the buffers for it.

use crate::contact::local_manifold::LocalManifold;
use crate::contact::reduce::Candidate;
use crate::geometry::hull_lanes::{LANES, Points4};
use glam::Vec3;

/// Cosine of the angle between normals that make one manifold.
const SAME: f32 = 0.9999;

/// A point that was found.
#[derive(Clone, Copy, Debug)]
pub(in crate::contact::narrow) struct Found {
    pub(in crate::contact::narrow) group: u32,
    /// Of a hull: which face it is on.
    pub(in crate::contact::narrow) face: u32,
    /// On the surface at the start of the step, axes of the level, from the origin of the shape's frame, m.
    pub(in crate::contact::narrow) at: Vec3,
    pub(in crate::contact::narrow) separation: f32,
    /// Radius of curvature of the surface, m.
    pub(in crate::contact::narrow) curvature: f32,
}

/// A triangle that a shape comes down to.
#[derive(Clone, Copy, Debug)]
pub(in crate::contact::narrow) struct Approach {
    pub(in crate::contact::narrow) leaf: u32,
    /// Share of the way before which it does not get there.
    pub(in crate::contact::narrow) share: f32,
}

/// A point of a hull over a triangle.
#[derive(Clone, Copy, Debug)]
pub(in crate::contact::narrow) struct Over {
    pub(in crate::contact::narrow) at: Vec3,
    /// Above the triangle, m.
    pub(in crate::contact::narrow) height: f32,
    /// Which face it is on.
    pub(in crate::contact::narrow) face: u32,
}

/// What makes one manifold: a direction, and of a level of several materials one of these.
#[derive(Clone, Copy, Debug)]
pub(in crate::contact::narrow) struct Group {
    pub(in crate::contact::narrow) normal: Vec3,
    pub(in crate::contact::narrow) slot: Option<u16>,
}

/// Buffers, and what was found.
#[derive(Clone, Debug, Default)]
pub(crate) struct LevelScratch {
    pub(in crate::contact::narrow) points: Vec<Points4>,
    pub(in crate::contact::narrow) near: Vec<u32>,
    pub(in crate::contact::narrow) ahead: Vec<u32>,
    pub(in crate::contact::narrow) approaches: Vec<Approach>,
    /// Shifts after which the hull touches the level, m.
    pub(in crate::contact::narrow) stops: Vec<Vec3>,
    pub(in crate::contact::narrow) polygon: Vec<Vec3>,
    pub(in crate::contact::narrow) clipped: Vec<Vec3>,
    /// By vertex of the hull: on which sides of a triangle it is out.
    pub(in crate::contact::narrow) sides: Vec<[u32; LANES]>,
    /// Points over one triangle.
    pub(in crate::contact::narrow) over: Vec<Over>,
    /// Of the manifolds.
    pub(in crate::contact::narrow) groups: Vec<Group>,
    pub(in crate::contact::narrow) found: Vec<Found>,
    pub(in crate::contact::narrow) candidates: Vec<Candidate>,
    /// What is as low as these and is not among them.
    pub(in crate::contact::narrow) lower: Vec<Candidate>,
    /// The manifolds, hull first.
    pub(crate) patches: Vec<LocalManifold>,
}

impl LevelScratch {
    /// The number of the manifold with a normal, on triangles of a material.
    pub(in crate::contact::narrow) fn group_of(&mut self, normal: Vec3, slot: Option<u16>) -> u32 {
        let is_same = |group: &Group| group.normal.dot(normal) > SAME && group.slot == slot;
        let known = self.groups.iter().position(is_same);
        known.unwrap_or_else(|| {
            self.groups.push(Group { normal, slot });
            self.groups.len() - 1
        }) as u32
    }

    /// Radius of curvature of what was found of a manifold of a round shape at a place, m.
    pub(in crate::contact::narrow) fn curvature_at(&self, group: u32, at: Vec3) -> f32 {
        let mut of_group = self.found.iter().filter(|found| found.group == group);
        let found = of_group.find(|found| found.at == at);
        found.map_or(0.0, |found| found.curvature)
    }

    /// Forgets what was found.
    pub(in crate::contact::narrow) fn clear(&mut self) {
        self.patches.clear();
        self.groups.clear();
        self.found.clear();
    }
}
