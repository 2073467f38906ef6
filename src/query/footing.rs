//! What a character stands on, and steps up to.

use crate::bodies::body::RigidBody;
use crate::math::Pose;
use crate::query::filter::QueryFilter;
use crate::query::hit::QueryHit;
use crate::query::request::Ray;
use crate::query::walk::{Walk, across};
use crate::query::walker::Footing;
use glam::Vec3;

/// Share of the step height that the ray is long which looks what the top of an edge is like.
const PROBE: f32 = 0.1;

/// Least way forward, as a share of the step height, that is asked for on top of a step.
const FOOTHOLD: f32 = 0.1;

/// Least height that is a step, as a share of the skin and of the way.
const GAIN: f32 = 0.1;

/// How many bodies that contacts move are passed at most.
const MAX_PASSED: usize = 8;

/// Sine of the angle between a motion and what it overlaps below which it gets no deeper.
const LEAVING: f32 = 1e-4;

impl Walk<'_, '_> {
    /// How far it gets along a motion, and what it meets then. What contacts move and it gets away from does not hold it back.
    pub(super) fn advance(&self, pose: &Pose, motion: Vec3) -> (Vec3, Option<QueryHit>) {
        self.advance_past(pose, motion, |_| false)
    }

    /// The same, nor do those of them that `passes` says.
    fn advance_past(
        &self,
        pose: &Pose,
        motion: Vec3,
        passes: impl Fn(&QueryHit) -> bool,
    ) -> (Vec3, Option<QueryHit>) {
        let (mut passed, mut count) = ([u32::MAX; MAX_PASSED], 0);
        loop {
            let known = passed;
            let counts = |slot: u32| {
                !known.contains(&slot) && self.filter.predicate.is_none_or(|counts| counts(slot))
            };
            let filter = self.filter.with_predicate(&counts);
            let filter = if count == 0 { *self.filter } else { filter };
            let (moved, hit) = self.queries.advance(self.slider, pose, motion, &filter);
            let is_left = |hit: &QueryHit| {
                hit.distance <= 0.0 && hit.normal.dot(motion) >= -LEAVING * motion.length()
            };
            let yields = |hit: &QueryHit| {
                let kind = self.queries.bodies().kind(hit.body);
                kind == RigidBody::Dynamic && (is_left(hit) || passes(hit))
            };
            let Some(yields) = hit.filter(yields).filter(|_| count < MAX_PASSED) else {
                return (moved, hit);
            };
            passed[count] = yields.body;
            count += 1;
        }
    }

    /// Whether a place is ground to stand on.
    pub(super) fn is_ground(&self, hit: &QueryHit) -> Option<Vec3> {
        let up = self.settings.up;
        if hit.normal.dot(up) >= self.min_rise {
            return Some(hit.normal);
        }
        if hit.normal.dot(up) <= 0.0 {
            return None;
        }
        // On an edge: what is on top of it, a little towards the body that it belongs to?
        let inward = -across(hit.normal, up).try_normalize()?;
        let length = PROBE * self.settings.step_height;
        let origin = hit.point + length * (up + 0.5 * inward);
        let ray = Ray::new(origin, -up, 2.0 * length).ok()?;
        let top = self.queries.cast_ray(&ray, self.filter)?;
        (top.distance > 0.0 && top.normal.dot(up) >= self.min_rise).then_some(top.normal)
    }

    /// Up, forward and down again, where it ran into something with this normal; whether it is on a step then.
    pub(super) fn step_up(&self, pose: &mut Pose, rest: &mut Vec3, normal: Vec3) -> bool {
        let (up, height) = (self.settings.up, self.settings.step_height);
        let flat = across(*rest, up);
        let Some(direction) = flat.try_normalize() else {
            return false;
        };
        let (risen, _) = self.advance(pose, height * up);
        let raised = Pose {
            position: pose.position + risen,
            ..*pose
        };
        let (wanted, foothold) = (flat.length(), FOOTHOLD * height);
        // No farther than it wants to, if that leads over the edge already.
        let [near, far] = [wanted.min(foothold), wanted.max(foothold)].map(|way| way * direction);
        // Over the skin that it keeps from what it runs into, straight if it runs slantwise.
        let inward = -across(normal, up).try_normalize().unwrap_or(-direction);
        let short = (2.0 * self.settings.skin - far.dot(inward)).max(0.0);
        let mut ways = [near, far + short * inward].into_iter();
        let Some((position, moved)) = ways.find_map(|way| self.step_onto(pose, &raised, way))
        else {
            return false;
        };
        pose.position = position;
        *rest = flat - moved.dot(direction).clamp(0.0, wanted) * direction;
        true
    }

    /// Forward and down again from above `pose`: where it stands then, and how far forward that is, if it is on a step.
    fn step_onto(&self, pose: &Pose, raised: &Pose, forward: Vec3) -> Option<(Vec3, Vec3)> {
        let (up, skin) = (self.settings.up, self.settings.skin);
        let mut there = *raised;
        let (moved, _) = self.advance(&there, forward);
        there.position += moved;
        if moved.length() <= 0.5 * skin.min(forward.length()) {
            return None;
        }
        let (sunk, hit) = self.advance(&there, pose.position - raised.position);
        let hit = hit.filter(|hit| self.is_ground(hit).is_some())?;
        let is_movable = self.queries.bodies().kind(hit.body) == RigidBody::Dynamic;
        there.position += sunk;
        let gain = (there.position - pose.position).dot(up);
        // What it would stand on there may be higher than its feet are yet.
        let feet = -self.slider.shape.reach(pose, -up) - skin;
        let is_too_high = hit.point.dot(up) - feet > self.settings.step_height + skin;
        let is_higher = gain > GAIN * skin.min(forward.length());
        (is_higher && !is_movable && !is_too_high).then_some((there.position, moved))
    }

    /// Finds what it stands on, and goes down to it: by a step, if it was on the ground. `before`: where it was before it went, and the body
    /// that it stood on then.
    pub(super) fn set_down(
        &self,
        pose: &mut Pose,
        before: (&Pose, Option<u32>),
    ) -> Option<Footing> {
        let (up, skin) = (self.settings.up, self.settings.skin);
        let reach = if before.1.is_some() {
            self.settings.step_height
        } else {
            skin
        };
        let (moved, hit) = self.ground_below(pose, -(reach + skin) * up, before)?;
        let normal = self.is_ground(&hit)?;
        pose.position += moved;
        // What was pushed out of the ground keeps half of its skin.
        let short = skin / hit.normal.dot(up).max(self.min_rise) - hit.distance;
        if short > 1e-3 * skin {
            let (risen, _) = self.advance(pose, short * up);
            pose.position += risen;
        }
        Some(self.footing_on(&hit, normal))
    }

    /// How far it gets down, and what is below then. Of what contacts move, what has come to its side is not below, nor what has got under
    /// its feet while it stands on something firm; what it has walked onto is.
    fn ground_below(
        &self,
        pose: &Pose,
        down: Vec3,
        (begin, stood_on): (&Pose, Option<u32>),
    ) -> Option<(Vec3, QueryHit)> {
        let is_beside = |pose: &Pose, hit: &QueryHit| {
            self.is_ground(hit).is_none() || hit.distance <= 0.0 && !self.is_under(pose, hit.body)
        };
        let below = |pose| self.advance_past(pose, down, |hit| is_beside(pose, hit));
        let (moved, hit) = below(pose);
        let hit = hit?;
        if self.is_firm(hit.body) {
            let beside = self.ground_beside(pose, down, &hit);
            return Some((moved, beside.unwrap_or(hit)));
        }
        let counts = |slot| self.is_firm(slot);
        let filter = self.filter.with_predicate(&counts);
        let (fallen, firm) = self.queries.advance(self.slider, pose, down, &filter);
        let is_as_near = |firm: &QueryHit| {
            let apart = firm.distance - hit.distance;
            apart <= 2.0 * self.settings.skin && self.is_ground(firm).is_some()
        };
        let firm = firm.filter(is_as_near).map(|firm| (fallen, firm));
        let was_below = || below(begin).1.is_some_and(|before| before.body == hit.body);
        let has_come = |_: &_| stood_on != Some(hit.body) && was_below();
        firm.filter(has_come).or(Some((moved, hit)))
    }

    /// Whether it would come out of a body that is in it by going up.
    fn is_under(&self, pose: &Pose, slot: u32) -> bool {
        let counts = |other| other == slot;
        let filter = QueryFilter::all().with_predicate(&counts);
        let (shape, mut near) = (&self.slider.shape, Vec::new());
        let asked = (self.queries).near_shape(shape, pose, 0.0, &filter, &mut near);
        let out = near.first().filter(|_| asked.is_ok());
        out.is_some_and(|hit| hit.normal.dot(self.settings.up) >= self.min_rise)
    }

    /// The ground beside what is too steep to stand on, where it leans against that and stands on both.
    fn ground_beside(&self, pose: &Pose, down: Vec3, steep: &QueryHit) -> Option<QueryHit> {
        if self.is_ground(steep).is_some() {
            return None;
        }
        let room = 2.0 * self.settings.skin;
        let away = room * across(steep.normal, self.settings.up).try_normalize()?;
        let beside = Pose {
            position: pose.position + away,
            ..*pose
        };
        let (_, hit) = self.advance(&beside, down);
        hit.filter(|hit| hit.distance - steep.distance <= room && self.is_ground(hit).is_some())
    }
}
