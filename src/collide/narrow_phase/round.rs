//! Pairs of which one body is round.

use crate::bodies::body::Shape;
use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::part::{PairRun, touch_of};
use crate::collide::narrow_phase::relative_pose;
use crate::collide::narrow_phase::scene::{OVERLAP, Scene};
use crate::collide::proxies::CONTACT_MARGIN;
use crate::contact::local_manifold::LocalManifold;
use crate::contact::narrow::cast::CastResult;
use crate::contact::narrow::round::cast::RoundCast;
use crate::contact::narrow::round::pair::{
    examine_round, examine_round_half_space, round_distance_along,
};
use crate::contact::narrow::round::patch::RoundScratch;
use crate::contact::narrow::scratch::SatResult;
use crate::contact::pairs::broad_phase::Pair;
use crate::contact::pairs::recycle::{Recycle, min_approach, reach_of_test, smaller_extent};
use crate::geometry::{ConvexMesh, HalfSpaceShape};
use crate::math::{Plane, Pose, rotate};

impl PairRun {
    /// Looks closer at a pair, and tests it if that does not help; false if none of the two is round.
    pub(super) fn renew_round(&mut self, scene: &Scene, pair: Pair, index: usize) -> bool {
        let bodies = scene.bodies;
        let meshes = [pair.a, pair.b].map(|slot| bodies.convex(slot));
        if !meshes.iter().flatten().any(|mesh| mesh.is_round()) {
            return false;
        }
        let mut view = self.known.view(index, scene.pair(pair), scene.paces(pair));
        let margin = scene.margin_of(&view);
        let Recycle::Unknown(axis) = view.verdict(margin, scene.fall, scene.widest(margin)) else {
            return true;
        };
        let reach = reach_of_test(view.paces, margin);
        let b_in_a = relative_pose(bodies, pair.a, pair.b);
        let both = match meshes {
            [Some(a), Some(b)] => Some([a, b]),
            _ => None,
        };
        if let (Some(axis), Some(meshes)) = (axis, both) {
            let distance = round_distance_along(meshes, b_in_a, axis);
            if distance > reach {
                view.set_apart(axis, distance);
                return true;
            }
        }
        let scratch = &mut self.round_scratch;
        let patch = match examine_round_pair(bodies, pair, b_in_a, reach, scratch) {
            Some(SatResult::Touching(patch)) => patch,
            Some(SatResult::Separated { axis, distance }) => {
                view.set_apart(axis, distance);
                return true;
            }
            None => return false,
        };
        let bind = |patch: &LocalManifold, turn| touch_of(bodies, pair, patch, turn);
        let near = |patch: &LocalManifold| bind(patch, b_in_a.rotation);
        let is_quiet = view.paces[0].ahead + view.paces[1].ahead <= min_approach(view.paces);
        let is_still = is_quiet || bodies.are_bonded(pair.a, pair.b) || patch.count == 0;
        let Some(meshes) = both.filter(|_| !is_still) else {
            view.set_near(near(&patch), reach);
            return true;
        };
        let gaps = patch.points().iter().map(|point| point.separation);
        let gap = gaps.fold(f32::INFINITY, f32::min);
        let extent = smaller_extent(view.paces);
        let cast = RoundCast {
            meshes,
            course: scene.course(pair, b_in_a),
            tolerance: OVERLAP * extent,
            reach,
            margin: CONTACT_MARGIN * extent + scene.fall,
        };
        match cast.outcome(patch.normal, gap, scratch) {
            CastResult::AsFound => view.set_near(near(&patch), reach),
            CastResult::Touches(patch, pose) => {
                view.set_passing(Some(bind(&patch, pose.rotation)));
            }
            CastResult::Misses => view.set_passing(None),
        }
        true
    }
}

/// Contact of one pair in A's frame, normal from A to B; none if none of the two is round.
pub(in crate::collide) fn examine_round_pair(
    bodies: &Bodies,
    pair: Pair,
    b_in_a: Pose,
    reach: f32,
    scratch: &mut RoundScratch,
) -> Option<SatResult> {
    let [a, b] = [pair.a, pair.b].map(|slot| &bodies.info(slot).shape);
    match (a, b) {
        (Shape::Convex(a), Shape::Convex(b)) if a.is_round() || b.is_round() => {
            Some(examine_round([a, b], b_in_a, reach, scratch))
        }
        (Shape::Convex(a), Shape::HalfSpace(b)) if a.is_round() => {
            Some(on_half_space(a, b, b_in_a, reach, scratch))
        }
        (Shape::HalfSpace(a), Shape::Convex(b)) if b.is_round() => {
            let a_in_b = relative_pose(bodies, pair.b, pair.a);
            Some(match on_half_space(b, a, a_in_b, reach, scratch) {
                SatResult::Touching(patch) => SatResult::Touching(patch.swapped(&a_in_b)),
                SatResult::Separated { distance, .. } => SatResult::Separated {
                    axis: a.normal,
                    distance,
                },
            })
        }
        _ => None,
    }
}

fn on_half_space(
    mesh: &ConvexMesh,
    below: &HalfSpaceShape,
    pose: Pose,
    reach: f32,
    scratch: &mut RoundScratch,
) -> SatResult {
    let plane = Plane::through(pose.position, rotate(pose.rotation, below.normal));
    examine_round_half_space(mesh, plane, pose, reach, scratch)
}
