//! What moves under a character and against it: the one carries it, the other shoves it.
//!
//! Both take it along whatever it wants, and no body that contacts move holds it back from that.

use crate::bodies::body::RigidBody;
use crate::math::{Pose, rotate, rotate_by};
use crate::query::ahead::Mover;
use crate::query::hit::QueryHit;
use crate::query::request::ShapeCast;
use crate::query::walk::Walk;
use crate::query::walker::Footing;
use glam::Vec3;

/// How often it is looked for what shoves, after the last shove may have led against the next.
const MAX_SHOVES: usize = 6;

/// A shove that is not worth it, as a share of the skin.
const NO_SHOVE: f32 = 1e-3;

impl Walk<'_, '_> {
    /// Goes with what it stands on to where that will be; how far its footing goes, m.
    pub(super) fn ride(&mut self, pose: &mut Pose, footing: &mut Footing) -> Vec3 {
        let up = self.settings.up;
        let is_current = self.queries.bodies().is_current(footing.body, footing.id);
        let mover = self.ahead.mover(footing.body).filter(|_| is_current);
        let Some(mover) = mover else {
            return Vec3::ZERO;
        };
        // Straight below the frame, about which it turns.
        let below = pose.position + (footing.point - pose.position).dot(up) * up;
        let way = mover.way(below);
        footing.point += way;
        footing.normal = rotate(mover.turn, footing.normal);
        self.take_along(pose, way, mover.slot);
        pose.rotation = rotate_by(pose.rotation, mover.angle.dot(up) * up, 1.0);
        way
    }

    /// Goes out of the way of all that moves against it, on its way from a pose; whether anything lifts it.
    pub(super) fn give_way(&self, from: &Pose, pose: &mut Pose, footing: Option<u32>) -> bool {
        let mut is_lifted = false;
        for _ in 0..MAX_SHOVES {
            let mut is_shoved = false;
            for mover in self.ahead.movers() {
                let shoves = mover.kind != RigidBody::Dynamic && Some(mover.slot) != footing;
                let shove = shoves.then(|| self.shove(mover, from, pose)).flatten();
                let Some(shove) = shove else {
                    continue;
                };
                self.take_along(pose, shove, mover.slot);
                is_shoved = true;
                is_lifted |= shove.dot(self.settings.up) > 0.5 * shove.length();
            }
            if !is_shoved {
                break;
            }
        }
        is_lifted
    }

    /// By how much what moves would get into the shape if this went straight from one pose to the other, and which way that leads out.
    fn shove(&self, mover: &Mover, from: &Pose, pose: &Pose) -> Option<Vec3> {
        let way = pose.position - from.position - mover.way(from.position);
        let cast = ShapeCast::new(self.slider.shape, *from, way, way.length()).ok()?;
        let counts =
            |slot| slot == mover.slot && self.filter.predicate.is_none_or(|counts| counts(slot));
        let filter = self.filter.with_predicate(&counts);
        let hit: QueryHit = self.present.cast_shape(&cast, &filter)?;
        let rest = way - hit.distance * cast.direction;
        let depth = -rest.dot(hit.normal);
        (depth > NO_SHOVE * self.slider.skin).then(|| depth * rotate(mover.turn, hit.normal))
    }

    /// Moves as it is moved, along what neither moves it nor is moved by contacts.
    fn take_along(&self, pose: &mut Pose, way: Vec3, by: u32) {
        if way == Vec3::ZERO {
            return;
        }
        let counts = |slot| slot != by && self.is_firm(slot);
        let filter = self.filter.with_predicate(&counts);
        let (start, mut met) = (*pose, Vec::new());
        let slid = (self.queries).move_and_slide(self.slider, start, way, &filter, &mut met);
        pose.position = slid.position;
    }

    /// Comes out of what has moved into it.
    pub(super) fn come_out(&self, pose: &mut Pose) {
        let counts = |slot| self.is_firm(slot);
        let filter = self.filter.with_predicate(&counts);
        pose.position = self.queries.push_out(self.slider, *pose, &filter);
    }

    /// Whether a body counts, and no contact moves it.
    pub(super) fn is_firm(&self, slot: u32) -> bool {
        let is_moved = self.queries.bodies().kind(slot) == RigidBody::Dynamic;
        !is_moved && self.filter.predicate.is_none_or(|counts| counts(slot))
    }
}
