//! Pairs of which one body has several parts: a contact for each pair of parts that touch, and one for those that lie in one plane.

use crate::bodies::body::Shape;
use crate::collide::narrow_phase::compound_near::{
    PartScratch, examine_on_plane, find_near, gap_of_boxes, part_pair,
};
use crate::collide::narrow_phase::level::examine_level;
use crate::collide::narrow_phase::part::{PairRun, touch_of};
use crate::collide::narrow_phase::relative_pose;
use crate::collide::narrow_phase::scene::{OVERLAP, Scene};
use crate::collide::proxies::CONTACT_MARGIN;
use crate::contact::local_manifold::LocalManifold;
use crate::contact::narrow::cast::{Cast, CastResult};
use crate::contact::narrow::compound::{Bearing, PartPair, Side, lifted, on_surface};
use crate::contact::narrow::course::Course;
use crate::contact::narrow::flush::{CompoundScratch, Found};
use crate::contact::narrow::level::LevelPair;
use crate::contact::narrow::round::cast::RoundCast;
use crate::contact::narrow::scratch::SatResult;
use crate::contact::pairs::broad_phase::Pair;
use crate::contact::pairs::recycle::{
    PairView, Recycle, haste, min_approach, reach_of_test, smaller_extent,
};
use crate::geometry::support::Core;
use crate::geometry::{HalfSpaceShape, StaticMesh};
use crate::math::{Pose, rotate};
use glam::Mat3;

/// How much farther than contacts reach parts are looked for, as a share of the smaller body's least extent: if there are none, there is
/// time until the next look.
const SPARE: f32 = 0.5;

/// How far the planes of contacts that make one may be apart, as a share of the smaller body's least extent.
const FLUSH: f32 = 5e-4;

/// Share of the depth of a contact that is on no surface which others must have to hold the bodies apart.
const HELD: f32 = 0.25;

/// A pair of bodies whose parts are tested.
struct BodyPair<'s> {
    scene: &'s Scene<'s>,
    pair: Pair,
    shapes: [&'s Shape; 2],
    b_in_a: Pose,
    reach: f32,
}

/// What is known of the distance of two bodies.
#[derive(Clone, Copy, Debug)]
struct Gap {
    /// No parts are nearer to each other, m.
    least: f32,
    /// Whether parts touch, perhaps without points.
    touches: bool,
}

impl PairRun {
    /// Looks closer at a pair, and tests it if that does not help; false if none of the two has several parts.
    pub(super) fn renew_compound(&mut self, scene: &Scene, pair: Pair, index: usize) -> bool {
        let bodies = scene.bodies;
        let shapes = [pair.a, pair.b].map(|slot| &bodies.info(slot).shape);
        if shapes.iter().all(|shape| shape.compound().is_none()) {
            return false;
        }
        let mut view = self.known.view(index, scene.pair(pair), scene.paces(pair));
        let margin = scene.margin_of(&view);
        let is_slow = view.paces[0].ahead + view.paces[1].ahead <= min_approach(view.paces);
        let may_hold = is_slow || view.term.points == 0;
        if may_hold && view.verdict(margin, scene.fall, scene.widest(margin)) == Recycle::Holds {
            return true;
        }
        let test = BodyPair {
            scene,
            pair,
            shapes,
            b_in_a: relative_pose(bodies, pair.a, pair.b),
            reach: reach_of_test(view.paces, margin),
        };
        let scratch = &mut self.compound_scratch;
        scratch.found.clear();
        let mut others = PartScratch {
            hulls: &mut self.scratch,
            round: &mut self.round_scratch,
            level: &mut self.level_scratch,
        };
        let gap = test.examine(&view, scratch, &mut others);
        let extent = smaller_extent(view.paces);
        if !gap.touches && gap.least > test.reach {
            view.set_apart(None, gap.least);
            return true;
        }
        scratch.merge_flush(&test.b_in_a, FLUSH * extent);
        let touches = scratch.found.iter();
        let touches = touches.map(|it| touch_of(bodies, pair, &it.patch, it.turn));
        view.set_near_all(touches, test.reach, is_slow);
        true
    }
}

/// Keeps the deeper of two contacts that are on no surface where they are deep, if they are.
fn note_deeper(hidden: &mut Option<Found>, other: Found) {
    let known = hidden.as_ref().map_or(0.0, |it| it.patch.depth());
    if other.patch.depth() > known {
        *hidden = Some(other);
    }
}

/// Takes the deepest contact that is on no surface there after all, if no other holds the bodies apart.
fn stand_in(hidden: Option<Found>, scratch: &mut CompoundScratch) {
    if let Some(hidden) = hidden {
        let held = HELD * hidden.patch.depth();
        if scratch.found.iter().all(|it| it.patch.depth() < held) {
            scratch.found.push(hidden);
        }
    }
}

impl<'s> BodyPair<'s> {
    /// Fills `scratch.found` with the contacts of all parts.
    fn examine(
        &self,
        view: &PairView,
        scratch: &mut CompoundScratch,
        others: &mut PartScratch,
    ) -> Gap {
        match self.shapes {
            [Shape::HalfSpace(below), _] => self.on_half_space(below, true, scratch, others),
            [_, Shape::HalfSpace(below)] => self.on_half_space(below, false, scratch, others),
            [Shape::Level(level), _] => self.on_level(level, true, scratch, others),
            [_, Shape::Level(level)] => self.on_level(level, false, scratch, others),
            _ => self.between_parts(view, scratch, others),
        }
    }

    /// Contacts of parts with each other, and of parts with a convex body.
    fn between_parts(
        &self,
        view: &PairView,
        scratch: &mut CompoundScratch,
        others: &mut PartScratch,
    ) -> Gap {
        let wide = self.reach + SPARE * smaller_extent(view.paces);
        find_near(self.shapes, &self.b_in_a, wide, &mut scratch.near);
        let mut gap = Gap {
            least: wide,
            touches: false,
        };
        let mut hidden: Option<Found> = None;
        for &near in &scratch.near {
            let Some(parts) = part_pair(self.shapes, near) else {
                continue;
            };
            let pose = parts.own_pose(self.b_in_a);
            let apart = gap_of_boxes(&parts, &pose);
            if apart > self.reach {
                gap.least = gap.least.min(apart);
                continue;
            }
            match parts.examine(pose, self.reach, (others.hulls, others.round)) {
                SatResult::Separated { distance, .. } => gap.least = gap.least.min(distance),
                SatResult::Touching(patch) => {
                    gap.touches = true;
                    let beside = others.beside(parts.is_round());
                    let followed = self.follow(view, &parts, patch, pose, others);
                    let Some((patch, there)) = followed else {
                        continue;
                    };
                    // What bears besides does so where they are, and not where they touch first.
                    let beside = beside.filter(|_| there == pose);
                    let bearing = Bearing { patch, beside };
                    let settled = parts.settle(bearing, &there, self.reach, others.hulls);
                    let found = |patch: &LocalManifold| Found {
                        patch: parts.lift(patch),
                        turn: parts.turn_of_bodies(&there),
                        is_ahead: there != pose,
                    };
                    scratch.found.extend(settled.patches().map(found));
                    // What is left of it may be where they hardly touch.
                    if settled.depth() < HELD * patch.depth() {
                        note_deeper(&mut hidden, found(&patch));
                    }
                }
            }
        }
        stand_in(hidden, scratch);
        gap
    }

    /// What two parts touch within the step, and with which pose, if a contact of theirs at the start is this one.
    fn follow(
        &self,
        view: &PairView,
        parts: &PartPair,
        patch: LocalManifold,
        pose: Pose,
        others: &mut PartScratch,
    ) -> Option<(LocalManifold, Pose)> {
        let bodies = self.scene.bodies;
        if bodies.are_bonded(self.pair.a, self.pair.b) {
            return Some((patch, pose));
        }
        let extent = smaller_extent(view.paces);
        let margin = CONTACT_MARGIN * extent + self.scene.fall;
        let (course, reach) = (self.course(parts, pose), self.reach);
        let result = if parts.is_round() {
            let is_quiet = view.paces[0].ahead + view.paces[1].ahead <= min_approach(view.paces);
            if is_quiet || patch.count == 0 {
                return Some((patch, pose));
            }
            let gaps = patch.points().iter().map(|point| point.separation);
            let cast = RoundCast {
                meshes: parts.sides.map(|side| side.shape),
                course,
                tolerance: OVERLAP * extent,
                reach,
                margin,
            };
            let gap = gaps.fold(f32::INFINITY, f32::min);
            cast.outcome(patch.normal, gap, others.round)
        } else {
            let turn = parts.turn_of_bodies(&pose);
            let touch = touch_of(bodies, self.pair, &parts.lift(&patch), turn);
            if !view.needs_cast(&touch.patch, self.scene.fall) {
                return Some((patch, pose));
            }
            let cast = Cast {
                hulls: parts.sides.map(|side| side.shape.hull()),
                course,
                tolerance: OVERLAP * extent,
                reach,
                margin,
            };
            cast.outcome(&patch, others.hulls)
        };
        match result {
            CastResult::AsFound => Some((patch, pose)),
            CastResult::Touches(patch, pose) => Some((patch, pose)),
            CastResult::Misses => None,
        }
    }

    /// How two parts move within the step.
    fn course(&self, parts: &PartPair, pose: Pose) -> Course {
        let of_bodies = self.scene.course(self.pair, self.b_in_a);
        let back = parts.sides[0].pose.rotation.inverse();
        let center = |side: usize| {
            let pose = &parts.sides[side].pose;
            pose.inverse_transform_point(of_bodies.centers[side])
        };
        let centers = [center(0), center(1)];
        let radius = |side: usize| parts.sides[side].shape.farthest_from(centers[side]);
        Course {
            b_in_a: pose,
            centers,
            travel: rotate(back, of_bodies.travel),
            spins: of_bodies.spins.map(|spin| rotate(back, spin)),
            radii: [radius(0), radius(1)],
            end: of_bodies.end,
        }
    }

    /// The compound, and its pose in the frame of the other body; `is_second`: whether it is B.
    fn seen_from_other(&self, is_second: bool) -> Pose {
        if is_second {
            self.b_in_a
        } else {
            relative_pose(self.scene.bodies, self.pair.b, self.pair.a)
        }
    }

    fn on_half_space(
        &self,
        below: &HalfSpaceShape,
        is_second: bool,
        scratch: &mut CompoundScratch,
        others: &mut PartScratch,
    ) -> Gap {
        let mut gap = Gap {
            least: f32::INFINITY,
            touches: false,
        };
        let Some(compound) = self.shapes[usize::from(is_second)].compound() else {
            return gap;
        };
        let seen = self.seen_from_other(is_second);
        let down = -rotate(seen.rotation.inverse(), below.normal);
        let height = below.normal.dot(seen.position);
        let mut hidden = None;
        for (index, part) in (0..).zip(compound.boxes()) {
            // The box's lowest corner.
            let lowest = height - down.dot(Core::Box(*part).support(down));
            if lowest > self.reach {
                gap.least = gap.least.min(lowest);
                continue;
            }
            let side = Side::part(compound, index);
            let below_in_part = (seen * side.pose).inverse();
            match examine_on_plane(&side, below.normal, below_in_part, self.reach, others) {
                SatResult::Separated { distance, .. } => gap.least = gap.least.min(distance),
                SatResult::Touching(patch) => {
                    gap.touches = true;
                    let beside = others.beside(side.shape.is_round());
                    for patch in std::iter::once(patch).chain(beside) {
                        self.take(&side, &patch, is_second, (scratch, &mut hidden));
                    }
                }
            }
        }
        stand_in(hidden, scratch);
        gap
    }

    /// Takes a contact of a part with the other body, the part first, as far as it is on the surface, and keeps it if it is the deepest of those
    /// that are not where they are deep.
    fn take(
        &self,
        side: &Side,
        patch: &LocalManifold,
        is_second: bool,
        (scratch, hidden): (&mut CompoundScratch, &mut Option<Found>),
    ) {
        let lift = |patch: &LocalManifold| {
            let patch = lifted(patch, &side.pose, &Pose::IDENTITY);
            Found {
                patch: if is_second {
                    patch.swapped(&self.b_in_a.inverse())
                } else {
                    patch
                },
                turn: self.b_in_a.rotation,
                is_ahead: false,
            }
        };
        let kept = on_surface(side, patch);
        if kept.count > 0 {
            scratch.found.push(lift(&kept));
        }
        if kept.depth() < HELD * patch.depth() {
            note_deeper(hidden, lift(patch));
        }
    }

    fn on_level(
        &self,
        level: &StaticMesh,
        is_second: bool,
        scratch: &mut CompoundScratch,
        others: &mut PartScratch,
    ) -> Gap {
        let [a, b] = self.scene.pair(self.pair);
        let paces = self.scene.paces(self.pair);
        let (on_parts, on_level) = if is_second { (b, a) } else { (a, b) };
        let is_slow = paces[0].ahead + paces[1].ahead <= min_approach(paces);
        let reach = if is_slow {
            self.reach
        } else {
            self.scene.margin(paces, a.turning + b.turning)
        };
        let travel = haste([a, b], self.scene.fall) * (on_parts.travel - on_level.travel);
        let travel = on_level.place.turn.transpose() * travel;
        // Levels tell no distance.
        let gap = Gap {
            least: 0.0,
            touches: true,
        };
        let Some(compound) = self.shapes[usize::from(is_second)].compound() else {
            return gap;
        };
        let seen = self.seen_from_other(is_second);
        let bounds = level.aabb().fattened(reach + travel.length());
        let of_level = [self.pair.b, self.pair.a][usize::from(is_second)];
        let is_by_slot = self.scene.bodies.info(of_level).surfaces.is_some();
        let mut hidden = None;
        for index in 0..compound.len() as u32 {
            let side = Side::part(compound, index);
            let pose = seen * side.pose;
            let turn = Mat3::from_quat(pose.rotation);
            if !side.shape.bounds(&turn, pose.position).overlaps(&bounds) {
                continue;
            }
            let pair = LevelPair {
                shape: side.shape,
                mesh: level,
                hull_in_mesh: pose,
                travel,
                reach,
                reach_over_plane: reach + travel.length(),
                slide: 0.0,
                is_by_slot,
            };
            examine_level(&pair, pair.ground_below().as_ref(), others);
            for patch in &others.level.patches {
                self.take(&side, patch, is_second, (scratch, &mut hidden));
            }
        }
        stand_in(hidden, scratch);
        gap
    }
}
