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
use glam::{Quat, Vec3};

/// How often it is looked for what shoves, after the last shove may have led against the next.
const MAX_SHOVES: usize = 6;

/// A shove that is not worth it, as a share of the skin.
const NO_SHOVE: f32 = 1e-3;

impl Walk<'_, '_> {
    /// Goes with what it stands on: to where that has gone against what was expected, and to where it will be. How far its footing goes, m.
    pub(super) fn ride(&mut self, pose: &mut Pose, footing: &mut Footing) -> Vec3 {
        let (up, bodies) = (self.settings.up, self.queries.bodies());
        if !(bodies.is_current(footing.body, footing.id) && bodies.is_active(footing.body)) {
            return Vec3::ZERO;
        }
        if self.is_in(pose, footing.body) {
            return Vec3::ZERO;
        }
        let (slip, slip_turn) = self.slip(footing);
        let mover = self.ahead.mover(footing.body);
        // Straight below the frame, about which it turns.
        let below = pose.position + (footing.point - pose.position).dot(up) * up;
        let mut way = slip + rotate(slip_turn, below - footing.point) - (below - footing.point);
        let mut angle = 2.0 * slip_turn.xyz() * slip_turn.w.signum();
        footing.normal = rotate(slip_turn, footing.normal);
        if let Some(mover) = mover {
            way += mover.way(below + way);
            angle += mover.angle;
            footing.normal = rotate(mover.turn, footing.normal);
        }
        let belt = self.surface_velocity(footing);
        if way == Vec3::ZERO && angle == Vec3::ZERO && belt == Vec3::ZERO {
            return Vec3::ZERO;
        }
        footing.point += way;
        way += self.step_dt * belt;
        self.take_along(pose, way, footing.body);
        pose.rotation = rotate_by(pose.rotation, angle.dot(up) * up, 1.0);
        way
    }

    /// How fast what it stands on runs along its surface, m/s.
    fn surface_velocity(&self, footing: &Footing) -> Vec3 {
        let velocity = self.queries.bodies().surface_velocity(footing.body);
        velocity - velocity.dot(footing.normal) * footing.normal
    }

    /// Whether it is in a body that contacts move: each would push the other along for ever if that carried it.
    fn is_in(&self, pose: &Pose, slot: u32) -> bool {
        if self.is_firm(slot) {
            return false;
        }
        let counts =
            |other| other == slot && self.filter.predicate.is_none_or(|counts| counts(slot));
        let filter = self.filter.with_predicate(&counts);
        let down = -self.slider.skin * self.settings.up;
        let cast = ShapeCast::new(self.slider.shape, *pose, down, self.slider.skin).ok();
        let hit = cast.and_then(|cast| self.present.cast_shape(&cast, &filter));
        hit.is_some_and(|hit| hit.distance <= 0.0)
    }

    /// How far its footing is from where it was expected to be by now, m, and how the body has turned against that. One that is far from
    /// there was put elsewhere, and takes nobody along.
    fn slip(&self, footing: &Footing) -> (Vec3, Quat) {
        let bodies = self.queries.bodies();
        let now = bodies.pose(footing.body);
        let slip = now.transform_point(footing.place) - footing.point;
        let is_elsewhere = slip.length() > 2.0 * bodies.radius(footing.body);
        if now.rotation == footing.rotation || is_elsewhere {
            let slip = if is_elsewhere { Vec3::ZERO } else { slip };
            return (slip, Quat::IDENTITY);
        }
        (slip, now.rotation * footing.rotation.inverse())
    }

    /// What it stands on, at a place with a normal.
    pub(super) fn footing_on(&self, hit: &QueryHit, normal: Vec3) -> Footing {
        let pose = self.ahead.pose(self.queries.bodies(), hit.body);
        let place = pose.inverse_transform_point(hit.point);
        Footing {
            body: hit.body,
            id: hit.id,
            normal,
            // So that it is the same to the bit as long as the body stays.
            point: pose.transform_point(place),
            place,
            rotation: pose.rotation,
        }
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
