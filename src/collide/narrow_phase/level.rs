//! Pairs of a hull and a level of triangles: several manifolds, one for each direction.

use crate::collide::narrow_phase::part::{PairRun, Scene, touch_of};
use crate::collide::narrow_phase::relative_pose;
use crate::contact::local_manifold::LocalManifold;
use crate::contact::narrow::level::LevelPair;
use crate::contact::pairs::broad_phase::Pair;
use crate::contact::pairs::recycle::{Recycle, haste, min_approach, reach_of_test};
use crate::contact::pairs::touches::NO_TOUCH;

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
        let [a, b] = view.bodies;
        let margin = scene.margin_of(&view);
        let ahead = view.paces[0].ahead + view.paces[1].ahead;
        let (is_slow, fall) = (ahead <= min_approach(view.paces), scene.fall);
        if is_slow && view.verdict(margin, fall, scene.widest(margin)) == Recycle::Holds {
            return true;
        }
        let [first, second] = if is_hull_first {
            [pair.a, pair.b]
        } else {
            [pair.b, pair.a]
        };
        let (on_hull, on_mesh) = if is_hull_first { (a, b) } else { (b, a) };
        let hull_in_mesh = relative_pose(bodies, second, first);
        let travel = haste([a, b], fall) * (on_hull.travel - on_mesh.travel);
        let reach = if is_slow {
            reach_of_test(view.paces, margin)
        } else {
            scene.margin(view.paces, a.turning + b.turning)
        };
        let level = LevelPair {
            shape: hull,
            mesh,
            hull_in_mesh,
            travel: on_mesh.place.turn.transpose() * travel,
            reach,
            is_by_slot: bodies.info(second).surfaces.is_some(),
        };
        if hull.is_round() {
            level.examine_round(&mut self.level_scratch, &mut self.round_scratch);
        } else {
            level.examine(&mut self.level_scratch);
        }
        let b_in_a = relative_pose(bodies, pair.a, pair.b);
        let touch = |patch: &LocalManifold| {
            let patch = if is_hull_first {
                *patch
            } else {
                patch.swapped(&hull_in_mesh.inverse())
            };
            touch_of(bodies, pair, &patch, b_in_a.rotation)
        };
        let patches = self.level_scratch.patches.iter();
        view.set_near_all(patches.map(touch), reach, is_slow);
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
