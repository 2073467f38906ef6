//! Where a round shape touches a level of triangles, without seams.
//!
//! A triangle is touched from above by what of the shape lies over it, as by a hull. What is nearest to its border touches it there,
//! but only in directions that no other triangle at the same place looks along: over an edge that is flat or hollow there are none.
//! That is asked of the triangles themselves, so that it does not matter how they are joined.
//!
//! What has got through a ridge touches neither side of it so: its lowest points are beyond it on both. If it touches nothing else, it comes
//! back along the triangle that it is least below.

use crate::contact::narrow::level::{Ground, LevelPair, PIERCED, SHALLOW};
use crate::contact::narrow::level_scratch::{Found, LevelScratch};
use crate::contact::narrow::round::axis::{PairAxis, SolidPair};
use crate::contact::narrow::round::patch::{PatchRule, RoundScratch, clip_places, patch_along};
use crate::contact::narrow::round::solid::Solid;
use crate::contact::narrow::scratch::MERGE;
use crate::contact::reduce::{Candidate, CornerKind};
use crate::geometry::EdgeKind;
use crate::geometry::distance::{Nearest, Separation, distance};
use crate::geometry::support::{Core, PlacedCore};
use crate::math::Pose;
use glam::{DVec3, Mat3, Quat, Vec3};

/// Sine of the angle up to which a direction counts as that of a face, or as across one.
const SLOPE: f64 = 1e-3;

/// Share of the shape's diagonal up to which a triangle has a point.
const AT: f64 = 1e-5;

/// A round shape where it is at a moment, axes of the level.
struct Placed<'s> {
    solid: Solid<'s>,
    turn: Mat3,
    rotation: Quat,
    size: f32,
}

impl Placed<'_> {
    /// The point that is lowest over a triangle, own axes, m.
    fn lowest(&self, ground: &Ground) -> Vec3 {
        let down = self.turn.transpose() * -ground.normal;
        self.solid.support(down.as_dvec3()).as_vec3()
    }

    /// How far the surface is from the core at most, m: of one that is shrunk for distances corners stand out.
    fn around(&self) -> f32 {
        let Solid { depth, radius, .. } = self.solid;
        if depth == radius {
            radius + AT as f32 * self.size
        } else {
            self.size
        }
    }
}

impl LevelPair<'_> {
    /// Fills `scratch.patches` with the contacts of a round shape, one manifold for each direction.
    pub(crate) fn examine_round(&self, scratch: &mut LevelScratch, round: &mut RoundScratch) {
        scratch.clear();
        if !self.is_usable() {
            return;
        }
        let placed = Placed {
            solid: Solid::of(self.shape),
            turn: Mat3::from_quat(self.hull_in_mesh.rotation),
            rotation: self.hull_in_mesh.rotation,
            size: self.shape.aabb().diagonal(),
        };
        self.follow(self.shape.bounds(&placed.turn, Vec3::ZERO), scratch);
        let grounds = |at: usize, scratch: &LevelScratch| {
            self.ground(&self.mesh.triangles()[scratch.near[at] as usize])
        };
        for at in 0..scratch.near.len() {
            if let Some(ground) = grounds(at, scratch) {
                self.add_face(&ground, &placed, scratch, round);
            }
        }
        let mut least = PIERCED * placed.size;
        let mut pierced = None;
        for at in 0..scratch.near.len() {
            if let Some(ground) = grounds(at, scratch).filter(|ground| !ground.has_no_rim()) {
                let depth = self.add_border(&ground, &placed, scratch, round);
                if let Some(depth) = depth.filter(|depth| *depth < least) {
                    (least, pierced) = (depth, Some(ground));
                }
            }
        }
        if let Some(ground) = pierced
            && scratch.found.iter().all(|found| found.separation > 0.0)
        {
            self.add_lowest(&ground, &placed, scratch);
        }
        for group in 0..scratch.groups.len() as u32 {
            self.add_round_patch(group, &placed, scratch);
        }
    }

    /// Adds what of the shape lies over a triangle.
    fn add_face(
        &self,
        ground: &Ground,
        placed: &Placed,
        scratch: &mut LevelScratch,
        round: &mut RoundScratch,
    ) {
        let down = -ground.normal;
        let own = placed.turn.transpose() * down;
        let radius = placed.solid.radius;
        let lowest = ground.height(placed.turn * placed.solid.support(own.as_dvec3()).as_vec3());
        let Some(first_shift) = self.shift_down(ground, lowest) else {
            return;
        };
        for stop in 0..=scratch.stops.len() {
            let shift = match stop {
                0 => first_shift,
                _ => scratch.stops[stop - 1],
            };
            placed.solid.feature(own, &mut round.places);
            for place in &mut round.places {
                place.at = placed.turn * place.at + shift;
            }
            // What comes down to it in the rest of the step counts too.
            let rest = down.dot(self.travel - shift).max(0.0);
            keep_over(ground, round);
            round
                .places
                .retain(|place| ground.height(place.at) - radius <= self.reach + rest);
            if round.places.is_empty() {
                continue;
            }
            if !came_from_side(ground, placed, round) {
                let group = scratch.group_of(ground.normal, ground.slot);
                let is_one = round.places.len() == 1;
                for place in &round.places {
                    let at = place.at - shift;
                    let own_place = placed.turn.transpose() * at;
                    scratch.found.push(Found {
                        group,
                        face: 0,
                        at: at + radius * down,
                        separation: ground.height(at) - radius,
                        curvature: if is_one {
                            placed.solid.curvature(own, own_place)
                        } else {
                            place.curvature
                        },
                    });
                }
            }
            return;
        }
    }

    /// Adds the lowest point below a triangle, wherever it is.
    fn add_lowest(&self, ground: &Ground, placed: &Placed, scratch: &mut LevelScratch) {
        let own = placed.turn.transpose() * -ground.normal;
        let own_place = placed.lowest(ground);
        let at = placed.turn * own_place;
        let group = scratch.group_of(ground.normal, ground.slot);
        scratch.found.push(Found {
            group,
            face: 0,
            at,
            separation: ground.height(at),
            curvature: placed.solid.curvature(own, own_place),
        });
    }

    /// Adds what touches the border of a triangle; how far the shape is below one that it has pierced, m.
    fn add_border(
        &self,
        ground: &Ground,
        placed: &Placed,
        scratch: &mut LevelScratch,
        round: &mut RoundScratch,
    ) -> Option<f32> {
        let core = Core::of_triangle(ground.corners);
        let limit = f64::from(self.reach + placed.around());
        let mut pierced = None;
        for stop in 0..=scratch.stops.len() {
            let shift = match stop {
                0 => Vec3::ZERO,
                _ => scratch.stops[stop - 1],
            };
            let pose = Pose::new(shift, placed.rotation);
            let inner = PlacedCore::new(placed.solid.inner, &pose);
            let (normal, on_a) = match distance(&core, &inner, limit) {
                Separation::Near(Nearest { normal, on_a, .. }) => (normal, on_a),
                Separation::Overlap if stop == 0 && !self.mesh.is_two_sided() => {
                    pierced = Some(-ground.height(placed.turn * placed.lowest(ground)));
                    continue;
                }
                _ => continue,
            };
            let along = normal.dot(ground.normal.as_dvec3());
            let is_face = along > 1.0 - 0.5 * SLOPE * SLOPE;
            let is_back = along <= 0.0 && !self.mesh.is_two_sided() && self.is_closed(ground);
            if is_face || is_back || !self.is_outermost(normal, on_a, placed, scratch) {
                continue;
            }
            let pair = SolidPair {
                a: Solid::of_triangle(ground.corners),
                b: placed.solid,
                b_in_a: pose,
            };
            let axis = PairAxis {
                normal: normal.as_vec3(),
                separation: pair.separation(normal.as_vec3()),
                inner: Some(on_a),
            };
            if axis.separation > f64::from(self.reach) {
                continue;
            }
            let rule = PatchRule::new(self.reach, placed.size);
            let patch = patch_along(&pair, &axis, rule, round);
            let group = scratch.group_of(axis.normal, ground.slot);
            scratch
                .found
                .extend(patch.points().iter().map(|point| Found {
                    group,
                    face: 0,
                    at: placed.turn * point.on_b,
                    separation: point.separation - axis.normal.dot(shift),
                    curvature: point.radii[1],
                }));
            break;
        }
        pierced
    }

    /// Whether something lies beyond all edges of a triangle.
    fn is_closed(&self, ground: &Ground) -> bool {
        !ground.edges.contains(&EdgeKind::Open)
    }

    /// Whether no triangle that has a point rises above the plane through it, across a direction.
    fn is_outermost(
        &self,
        direction: DVec3,
        point: DVec3,
        placed: &Placed,
        scratch: &LevelScratch,
    ) -> bool {
        let place = self.hull_in_mesh.position;
        let there = PlacedCore::new(
            Core::of_point(Vec3::ZERO),
            &Pose::new(point.as_vec3(), Quat::IDENTITY),
        );
        let near = AT * f64::from(placed.size);
        scratch.near.iter().all(|&other| {
            let triangle = &self.mesh.triangles()[other as usize];
            let corners = triangle.corners.map(|corner| corner - place);
            let rises = corners.iter().any(|&corner| {
                let arm = corner.as_dvec3() - point;
                direction.dot(arm) > SLOPE * arm.length()
            });
            let has_point = || match distance(&Core::of_triangle(corners), &there, near) {
                Separation::Overlap => true,
                Separation::Near(nearest) => nearest.distance <= near,
                Separation::Far => false,
            };
            !(rises && has_point())
        })
    }

    /// Makes the manifolds of one direction.
    fn add_round_patch(&self, group: u32, placed: &Placed, scratch: &mut LevelScratch) {
        let candidates = &mut scratch.candidates;
        candidates.clear();
        let of_group = scratch.found.iter().filter(|found| found.group == group);
        candidates.extend(of_group.map(|found| Candidate {
            at: found.at,
            separation: found.separation,
            kind: CornerKind::Incident,
            leaves_on_cut: false,
        }));
        self.add_candidates(group, MERGE * placed.size, &placed.turn, scratch);
    }
}

/// Keeps of the places what lies over a triangle.
fn keep_over(ground: &Ground, round: &mut RoundScratch) {
    round.outline.clear();
    round.outline.extend(ground.corners);
    if let [place] = round.places.as_slice() {
        if !ground.is_over(place.at) {
            round.places.clear();
        }
    } else {
        clip_places(ground.normal, round);
    }
}

/// Whether the core is below a triangle and farther so than it is inside of its border: then it came from there.
fn came_from_side(ground: &Ground, placed: &Placed, round: &RoundScratch) -> bool {
    let heights = round.places.iter().map(|place| ground.height(place.at));
    let depth = -heights.fold(f32::INFINITY, f32::min);
    let places = round.places.iter().map(|place| place.at);
    depth > SHALLOW * placed.size && ground.came_over(depth, places) != [false; 2]
}
