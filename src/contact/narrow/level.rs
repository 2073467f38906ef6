//! Where a hull touches a level of triangles, without seams.
//!
//! A triangle is touched by what of the hull's underside lies over it: all faces that look at it are cut by the planes through its
//! edges, so that no triangle acts beyond its border. Triangles in one plane make one manifold, so that a floor of many is as one.
//!
//! Where the hull moves far within the step, it is looked at when it reaches the plane of the triangle, and when it touches the level
//! first: contacts are along what is reached, and only there.
//!
//! A hull that has got in beside a convex edge, or at an open border, by less than it is below the triangle, came from the side:
//! what it touches is the triangle across that edge. Where all triangles say so of each other, as on rough ground that a thin rod has pierced,
//! the one that it is least below is touched.

use crate::contact::local_manifold::{LocalManifold, LocalPoint};
use crate::contact::narrow::level_scratch::{Found, Group, LevelScratch};
use crate::contact::narrow::scratch::MERGE;
use crate::contact::reduce::{Candidate, CornerKind, reduce_uneven};
use crate::geometry::ConvexMesh;
use crate::geometry::hull_lanes::{box_of, lowest_height, move_points};
use crate::geometry::level_triangle::LevelTriangle;
use crate::geometry::{EdgeKind, StaticMesh};
use crate::math::Pose;
use glam::{Mat3, Vec3};

/// Share of the hull's diagonal by which it may be below a triangle without it being asked from where it came.
pub(in crate::contact::narrow) const SHALLOW: f32 = 1e-3;

/// How deep a hull may be below a triangle that it is beside, and touch it if it touches nothing else, as a share of its diagonal.
pub(in crate::contact::narrow) const PIERCED: f32 = 0.25;

/// How far a hull may go in the step and is on one face, as a share of its diagonal: one that is faster turns over to others when it hits
/// something.
const STEADY: f32 = 0.02;

/// Gap that counts as none for a hull that moves, as a share of its diagonal.
pub(super) const TOUCH: f32 = 3e-6;

/// A hull or a round shape (A) over a level (B).
#[derive(Clone, Copy, Debug)]
pub(crate) struct LevelPair<'h> {
    pub(crate) shape: &'h ConvexMesh,
    pub(crate) mesh: &'h StaticMesh,
    /// The hull's pose in the frame of the level.
    pub(crate) hull_in_mesh: Pose,
    /// How far the hull goes within the step as seen from the level, its axes, m.
    pub(crate) travel: Vec3,
    /// How far they may be apart and touch, m.
    pub(crate) reach: f32,
    /// The same over a plane, where how fast the hull is does not tell where it gets to, m.
    pub(crate) reach_over_plane: f32,
    /// How far it may slide along a plane until it is looked at anew, m.
    pub(crate) slide: f32,
    /// Whether triangles of different material slots make contacts of their own.
    pub(crate) is_by_slot: bool,
}

/// A triangle that a hull has got below from the side, as it seems.
#[derive(Clone, Copy, Debug)]
struct Beside {
    /// Where the hull is when it is looked at.
    shift: Vec3,
    /// How far it is below, m.
    depth: f32,
}

/// A triangle with the origin of the hull's frame as its own, turned so that the hull is above it.
#[derive(Clone, Copy, Debug)]
pub(in crate::contact::narrow) struct Ground {
    pub(in crate::contact::narrow) corners: [Vec3; 3],
    pub(in crate::contact::narrow) normal: Vec3,
    pub(in crate::contact::narrow) edges: [EdgeKind; 3],
    /// Material slot, if contacts differ by it.
    pub(in crate::contact::narrow) slot: Option<u16>,
}

impl Ground {
    pub(in crate::contact::narrow) fn height(&self, at: Vec3) -> f32 {
        self.normal.dot(at - self.corners[0])
    }

    /// Whether a place is over the triangle.
    pub(in crate::contact::narrow) fn is_over(&self, at: Vec3) -> bool {
        (0..3).all(|edge| {
            let (from, outward) = self.border(edge);
            outward.dot(at - from) <= 0.0
        })
    }

    /// Whether no shape touches the border in a direction of its own: what lies beyond each edge goes on or rises, so that where
    /// something touches an edge or a corner from outside, another triangle there has an edge that falls away.
    pub(in crate::contact::narrow) fn has_no_rim(&self) -> bool {
        let goes_on = |kind: &EdgeKind| matches!(kind, EdgeKind::Flat | EdgeKind::Concave);
        self.edges.iter().all(goes_on)
    }

    /// Whether what is so far below the triangle (m), with these points over it, came over a convex edge of it, and over an open one: it is
    /// farther below than inside of that.
    pub(in crate::contact::narrow) fn came_over(
        &self,
        depth: f32,
        points: impl Iterator<Item = Vec3> + Clone,
    ) -> [bool; 2] {
        let mut sides = [false; 2];
        for edge in 0..3 {
            let side = match self.edges[edge] {
                EdgeKind::Flat | EdgeKind::Concave => continue,
                EdgeKind::Open => 1,
                EdgeKind::Convex => 0,
            };
            let (from, outward) = self.border(edge);
            let inward = points.clone().map(|at| -outward.dot(at - from));
            sides[side] |= inward.fold(0.0, f32::max) < depth;
        }
        sides
    }

    /// A corner on an edge, and the unit vector out of the triangle there.
    pub(in crate::contact::narrow) fn border(&self, edge: usize) -> (Vec3, Vec3) {
        let from = self.corners[edge];
        let along = self.corners[(edge + 1) % 3] - from;
        (from, along.cross(self.normal).normalize_or_zero())
    }
}

impl LevelPair<'_> {
    /// Whether all numbers are finite.
    pub(in crate::contact::narrow) fn is_usable(&self) -> bool {
        self.hull_in_mesh.is_finite() && self.travel.is_finite() && self.reach.is_finite()
    }

    /// Fills `scratch.patches` with the contacts, one manifold for each direction.
    pub(crate) fn examine(&self, scratch: &mut LevelScratch) {
        scratch.clear();
        if !self.is_usable() {
            return;
        }
        let turn = Mat3::from_quat(self.hull_in_mesh.rotation);
        let points = &self.shape.hull().lanes.points;
        move_points(&mut scratch.points, points, &turn, Vec3::ZERO);
        self.follow(box_of(&scratch.points), scratch);
        let mut beside: Option<(Ground, Beside)> = None;
        for at in 0..scratch.near.len() {
            let triangle = &self.mesh.triangles()[scratch.near[at] as usize];
            if let Some(ground) = self.ground(triangle)
                && let Some(it) = self.add_triangle(&ground, &turn, scratch)
                && beside.is_none_or(|(_, least)| it.depth < least.depth)
            {
                beside = Some((ground, it));
            }
        }
        if let Some((ground, it)) = beside
            && scratch.found.iter().all(|found| found.separation > 0.0)
        {
            self.find_over(&ground, it.shift, &turn, scratch);
            self.add_over(&ground, it.shift, scratch);
        }
        for group in 0..scratch.groups.len() as u32 {
            self.add_patch(group, &turn, scratch);
        }
    }

    /// A triangle that the hull may be on; none if it is behind.
    pub(in crate::contact::narrow) fn ground(&self, triangle: &LevelTriangle) -> Option<Ground> {
        let place = self.hull_in_mesh.position;
        let mut ground = Ground {
            corners: triangle.corners.map(|corner| corner - place),
            normal: triangle.plane.normal,
            edges: triangle.edges,
            slot: if self.is_by_slot {
                self.mesh.material_of(triangle.index)
            } else {
                None
            },
        };
        let is_above = self.is_in_front(triangle.corners[0], triangle.plane.normal);
        if !is_above && !self.mesh.is_two_sided() {
            return None;
        }
        if !is_above {
            ground.normal = -ground.normal;
            ground.corners.swap(1, 2);
            let [first, second, third] = ground.edges.map(EdgeKind::mirrored);
            ground.edges = [third, second, first];
        }
        Some(ground)
    }

    /// How far the shape goes in the step until it is down at a triangle that it is `lowest` (m) above, m: all the way if it gets no
    /// farther, nowhere if it does not come nearer; none if the triangle is out of reach.
    pub(in crate::contact::narrow) fn shift_down(
        &self,
        ground: &Ground,
        lowest: f32,
    ) -> Option<Vec3> {
        let rate = -ground.normal.dot(self.travel);
        if lowest > self.reach + rate.max(0.0) {
            return None;
        }
        let reached = if lowest > 0.0 && rate > 0.0 {
            (lowest / rate).min(1.0)
        } else {
            0.0
        };
        Some(reached * self.travel)
    }

    /// Adds the points over a triangle, if there are any, unless the hull came from the side.
    fn add_triangle(
        &self,
        ground: &Ground,
        turn: &Mat3,
        scratch: &mut LevelScratch,
    ) -> Option<Beside> {
        let normal = ground.normal;
        let lowest = lowest_height(&scratch.points, normal) - normal.dot(ground.corners[0]);
        let first_shift = self.shift_down(ground, lowest)?;
        for stop in 0..=scratch.stops.len() {
            let shift = match stop {
                0 => first_shift,
                _ => scratch.stops[stop - 1],
            };
            self.find_over(ground, shift, turn, scratch);
            if !scratch.over.is_empty() {
                let lowest = scratch.over.iter().map(|over| over.height);
                let depth = -lowest.fold(f32::INFINITY, f32::min);
                let size = self.shape.aabb().diagonal();
                let sides = if depth > SHALLOW * size {
                    ground.came_over(depth, scratch.over.iter().map(|over| over.at))
                } else {
                    [false; 2]
                };
                if sides == [false; 2] {
                    self.add_over(ground, shift, scratch);
                }
                let is_beside = sides == [true, false] && depth < PIERCED * size;
                return is_beside.then_some(Beside { shift, depth });
            }
        }
        None
    }

    /// Takes what lies over a triangle into the manifold of its direction.
    fn add_over(&self, ground: &Ground, shift: Vec3, scratch: &mut LevelScratch) {
        let group = scratch.group_of(ground.normal, ground.slot);
        let found = scratch.over.iter().map(|over| Found {
            group,
            face: over.face,
            at: over.at - shift,
            separation: ground.height(over.at - shift),
            curvature: 0.0,
        });
        scratch.found.extend(found);
    }

    /// The face that the hull stands on or lands on in one direction, seen in its own frame: of those at the deepest point the most
    /// opposed one. Points off it do not count, however near, or they would stand in for those that bear the hull.
    fn face_down(&self, group: u32, normal: Vec3, scratch: &LevelScratch) -> u32 {
        let found = || scratch.found.iter().filter(|found| found.group == group);
        let deepest = found().fold(f32::INFINITY, |d, found| d.min(found.separation));
        let merge = MERGE * self.shape.aabb().diagonal();
        let slope = |face: u32| {
            let face = &self.shape.hull().faces()[face as usize];
            face.plane.normal.dot(normal)
        };
        let lowest = found().filter(|found| found.separation <= deepest + merge);
        let faces = lowest.map(|found| (slope(found.face), found.face));
        let face = faces.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        face.map_or(0, |(_, face)| face)
    }

    /// Makes the manifolds of one direction.
    fn add_patch(&self, group: u32, turn: &Mat3, scratch: &mut LevelScratch) {
        let normal = scratch.groups[group as usize].normal;
        let is_steady = self.travel.length() <= STEADY * self.shape.aabb().diagonal();
        let face = is_steady.then(|| self.face_down(group, turn.transpose() * normal, scratch));
        let candidates = &mut scratch.candidates;
        candidates.clear();
        let found = scratch.found.iter();
        let found = found
            .filter(|found| found.group == group && face.is_none_or(|face| found.face == face));
        candidates.extend(found.map(|found| Candidate {
            at: found.at,
            separation: found.separation,
            kind: CornerKind::Incident,
            leaves_on_cut: false,
        }));
        self.add_candidates(group, MERGE * self.shape.aabb().diagonal(), turn, scratch);
    }

    /// Makes the manifolds of the candidates of one direction. `merge`: how near to each other points are one, m.
    pub(in crate::contact::narrow) fn add_candidates(
        &self,
        group: u32,
        merge: f32,
        turn: &Mat3,
        scratch: &mut LevelScratch,
    ) {
        let Group { normal, slot } = scratch.groups[group as usize];
        reduce_uneven(
            &mut scratch.candidates,
            &mut scratch.lower,
            normal,
            merge,
            0.0,
        );
        let (back, is_round) = (turn.transpose(), self.shape.is_round());
        for points in [&scratch.candidates, &scratch.lower] {
            let mut patch = LocalManifold {
                normal: -(back * normal),
                normal_in_b: Some(-normal),
                slot,
                ..LocalManifold::default()
            };
            for &Candidate { at, separation, .. } in points {
                let curvature = is_round.then(|| scratch.curvature_at(group, at));
                patch.push(LocalPoint {
                    on_a: back * at,
                    on_b: self.hull_in_mesh.position + (at - separation * normal),
                    separation,
                    radii: [curvature.unwrap_or(0.0), 0.0],
                    ..LocalPoint::default()
                });
            }
            if !points.is_empty() {
                scratch.patches.push(patch);
            }
        }
    }
}
