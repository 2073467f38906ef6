//! Pairs of a hull and a level of triangles: several manifolds, one for each direction.

use crate::collide::narrow_phase::compound_near::PartScratch;
use crate::collide::narrow_phase::part::{PairRun, touch_of};
use crate::collide::narrow_phase::relative_pose;
use crate::collide::narrow_phase::scene::Scene;
use crate::contact::local_manifold::LocalManifold;
use crate::contact::narrow::level::LevelPair;
use crate::contact::pairs::broad_phase::Pair;
use crate::contact::pairs::recycle::{
    PairView, Recycle, SLIDE, haste, min_approach, reach_of_test, smaller_extent,
};
use crate::contact::pairs::touches::NO_TOUCH;
use crate::geometry::flat_ground::FlatGround;
use crate::geometry::{ConvexMesh, StaticMesh};

impl PairRun {
    /// Looks closer at a pair, and tests it if that does not help; false if it is none of a hull and a level.
    pub(super) fn renew_on_level(&mut self, scene: &Scene, pair: Pair, index: usize) -> bool {
        let bodies = scene.bodies;
        let shapes = [pair.a, pair.b].map(|slot| &bodies.info(slot).shape);
        let (hull, mesh, is_hull_first) = match shapes.map(|s| (s.convex(), s.level())) {
            [(Some(hull), _), (_, Some(mesh))] => (hull, mesh, true),
            [(_, Some(mesh)), (Some(hull), _)] => (hull, mesh, false),
            [(_, Some(_)), _] | [_, (_, Some(_))] => return true,
            _ => return false,
        };
        let mut view = self.known.view(index, scene.pair(pair), scene.paces(pair));
        let margin = scene.margin_of(&view);
        let is_slow = is_slow(&view);
        let widest = scene.widest(margin);
        if is_slow && view.verdict(margin, scene.fall, widest) == Recycle::Holds {
            return true;
        }
        let slots = if is_hull_first {
            [pair.a, pair.b]
        } else {
            [pair.b, pair.a]
        };
        let level = level_pair(scene, slots, (hull, mesh), &view, margin);
        let ground = level.ground_below();
        if ground.is_some()
            && !is_slow
            && view.verdict(margin, scene.fall, widest) == Recycle::Holds
        {
            return true;
        }
        let b_in_a = relative_pose(bodies, pair.a, pair.b);
        let touch = |patch: &LocalManifold| {
            let patch = if is_hull_first {
                *patch
            } else {
                patch.swapped(&level.hull_in_mesh.inverse())
            };
            touch_of(bodies, pair, &patch, b_in_a.rotation)
        };
        let mut others = PartScratch {
            hulls: &mut self.scratch,
            round: &mut self.round_scratch,
            level: &mut self.level_scratch,
        };
        examine_level(&level, ground.as_ref(), &mut others);
        let (patches, reach) = (&self.level_scratch.patches, level.reach_over_plane);
        match patches.as_slice() {
            [patch] if ground.is_some() => view.set_near(touch(patch), reach),
            [_, _] if ground.is_some() => {
                view.set_near_all(patches.iter().map(touch), reach, true);
            }
            patches => view.set_near_all(patches.iter().map(touch), level.reach, is_slow),
        }
        true
    }

    /// Lists the touches of a pair besides the first one, from `count` on; their number.
    pub(super) fn list_rest(&mut self, index: usize, count: usize) -> usize {
        let mut at = self.known.touches.after(self.known.terms[index].touch);
        let mut listed = 0;
        while at != NO_TOUCH {
            self.touching.push([0; 2]);
            self.touching[count + listed] = [index as u32, at];
            listed += 1;
            at = self.known.touches.after(at);
        }
        listed
    }
}

/// Whether a pair moves so little that what a test finds holds for a while.
fn is_slow(view: &PairView) -> bool {
    view.paces[0].ahead + view.paces[1].ahead <= min_approach(view.paces)
}

/// A shape over a level, whose bodies are in these slots, as a pair where gaps up to `margin` (m) matter.
fn level_pair<'s>(
    scene: &Scene,
    [on_top, below]: [u32; 2],
    (shape, mesh): (&'s ConvexMesh, &'s StaticMesh),
    view: &PairView,
    margin: f32,
) -> LevelPair<'s> {
    let [a, b] = view.bodies;
    let [top, ground] = [on_top, below].map(|slot| &scene.seen[slot as usize]);
    let travel = haste([a, b], scene.fall) * (top.travel - ground.travel);
    let reach_over_plane = reach_of_test(view.paces, margin);
    LevelPair {
        shape,
        mesh,
        hull_in_mesh: relative_pose(scene.bodies, below, on_top),
        travel: ground.place.turn.transpose() * travel,
        reach: if is_slow(view) {
            reach_over_plane
        } else {
            scene.margin(view.paces, a.turning + b.turning)
        },
        reach_over_plane,
        slide: SLIDE * smaller_extent(view.paces),
        is_by_slot: scene.bodies.info(below).surfaces.is_some(),
    }
}

/// Fills the level's buffer with the contacts of a shape with it, where it may be a plane.
pub(super) fn examine_level(
    pair: &LevelPair,
    ground: Option<&FlatGround>,
    others: &mut PartScratch,
) {
    let PartScratch {
        hulls,
        round,
        level,
    } = others;
    if let Some(ground) = ground {
        level.patches.clear();
        let found = pair.examine_ground(ground, hulls, round);
        level.patches.extend(found.into_iter().flatten());
    } else if pair.shape.is_round() {
        pair.examine_round(level, round);
    } else {
        pair.examine(level);
    }
}
