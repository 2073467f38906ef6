//! `Queries::walk`: a character that walks over a scene, by casts of its shape.
//!
//! A step of a character, in order: it is pushed out of what has moved into it; it goes where it wants to along the ground, along walls
//! and up steps; it falls, or is set down on ground that is not farther than a step down; it is carried by that to where it will be.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::math::{Pose, rotate, rotate_by};
use crate::query::filter::QueryFilter;
use crate::query::hit::QueryHit;
use crate::query::request::Ray;
use crate::query::slide::{Obstacles, Slider};
use crate::query::view::Queries;
use crate::query::walker::{Footing, Push, WalkInput, WalkSettings, WalkState};
use glam::{Quat, Vec3};

/// How often a motion is deflected.
const MAX_SLIDES: usize = 6;

/// Share of the step height that the ray is long which looks what the top of an edge is like.
const PROBE: f32 = 0.1;

/// Least way forward, as a share of the step height, that is asked for on top of a step.
const FOOTHOLD: f32 = 0.1;

/// A character in one step.
struct Walk<'w, 'q> {
    queries: Queries<'q>,
    slider: &'w Slider<'w>,
    settings: &'w WalkSettings,
    filter: &'w QueryFilter<'w>,
    step_dt: f32,
    /// Cosine of the steepest slope.
    min_rise: f32,
    pushes: &'w mut Vec<Push>,
}

impl Queries<'_> {
    /// Moves a character for a step. `pushes` gets what it pushes; it is cleared first. `slider` is its shape; its skin is that of
    /// the settings.
    ///
    /// A state or an input that is not finite, settings that are not usable, or a step without length, moves nothing.
    pub fn walk(
        &self,
        (slider, settings): (&Slider, &WalkSettings),
        state: &mut WalkState,
        input: &WalkInput,
        filter: &QueryFilter,
        pushes: &mut Vec<Push>,
    ) {
        pushes.clear();
        let numbers = [
            state.position,
            state.velocity,
            input.velocity,
            input.gravity,
        ];
        let is_usable = numbers.iter().all(|v| v.is_finite())
            && state.rotation.is_normalized()
            && settings.is_usable()
            && input.step_dt > 0.0
            && input.step_dt.is_finite();
        if !is_usable {
            return;
        }
        let slider = &Slider {
            skin: settings.skin,
            ..*slider
        };
        let mut walk = Walk {
            queries: *self,
            slider,
            settings,
            filter,
            step_dt: input.step_dt,
            min_rise: 1.0 / (1.0 + settings.max_slope * settings.max_slope).sqrt(),
            pushes,
        };
        let mut moved = *state;
        walk.step(&mut moved, input);
        // Numbers may be finite, and what is made of them not.
        let is_finite = moved.position.is_finite() && moved.velocity.is_finite();
        if is_finite && moved.rotation.is_finite() {
            *state = moved;
        } else {
            pushes.clear();
        }
    }
}

/// What of a vector is across a unit vector.
fn across(v: Vec3, up: Vec3) -> Vec3 {
    v - v.dot(up) * up
}

/// How far the body in a slot takes a point of it within a step, m, and how it turns, rad; nothing if it is not moved by its velocity.
fn carried(bodies: &Bodies, slot: u32, point: Vec3, step_dt: f32) -> Option<(Vec3, Vec3)> {
    let moves = bodies.is_active(slot) && bodies.kind(slot) != RigidBody::Static;
    let (linear, angular) = moves.then(|| bodies.velocity(slot))?;
    let arm = point - bodies.center_of_mass(slot);
    let turn = rotate_by(Quat::IDENTITY, angular, step_dt);
    Some((
        step_dt * linear + rotate(turn, arm) - arm,
        step_dt * angular,
    ))
}

impl Walk<'_, '_> {
    fn step(&mut self, state: &mut WalkState, input: &WalkInput) {
        let (up, dt) = (self.settings.up, self.step_dt);
        let mut pose = Pose::new(state.position, state.rotation);
        pose.position = self.queries.push_out(self.slider, pose, self.filter);
        let wish = across(input.velocity, up);
        let jumps = state.footing.is_some() && input.jump > 0.0;
        let mut rise = state.velocity.dot(up);
        if jumps {
            rise = input.jump;
            state.footing = None;
        }
        let begin = pose.position;
        let ground = state.footing.map(|footing| footing.normal);
        self.go(&mut pose, dt * wish, ground);
        let made = across(pose.position - begin, up) / dt;
        // What it ran into takes its speed, what it climbs does not.
        let kept = made.length().min(wish.length());
        let level = made.normalize_or_zero() * kept;
        if ground.is_none() {
            let fall = dt * input.gravity.dot(up);
            let way = dt * (rise + 0.5 * fall);
            rise += fall;
            if self.fall(&mut pose, way) {
                rise = 0.0;
            }
        } else {
            rise = 0.0;
        }
        state.footing = if rise > 0.0 {
            None
        } else {
            self.set_down(&mut pose, ground.is_some())
        };
        if let Some(footing) = &mut state.footing {
            rise = 0.0;
            footing.point += self.ride(&mut pose, footing);
        }
        state.velocity = level + rise * up;
        (state.position, state.rotation) = (pose.position, pose.rotation);
    }

    /// Goes with what it stands on, to where that is after the step; how far its footing goes, m.
    fn ride(&mut self, pose: &mut Pose, footing: &Footing) -> Vec3 {
        let up = self.settings.up;
        let bodies = self.queries.bodies();
        // Straight below the frame, about which it turns.
        let below = pose.position + (footing.point - pose.position).dot(up) * up;
        let found = carried(bodies, footing.body, below, self.step_dt);
        let Some((way, turn)) = found else {
            return Vec3::ZERO;
        };
        if way != Vec3::ZERO {
            let predicate = self.filter.predicate;
            let counts = |slot| slot != footing.body && predicate.is_none_or(|it| it(slot));
            let others = self.filter.with_predicate(&counts);
            let mut met = Vec::new();
            let start = *pose;
            let slid = self
                .queries
                .move_and_slide(self.slider, start, way, &others, &mut met);
            pose.position = slid.position;
        }
        pose.rotation = rotate_by(pose.rotation, turn.dot(up) * up, 1.0);
        way
    }

    /// Whether a place is ground to stand on.
    fn is_ground(&self, hit: &QueryHit) -> Option<Vec3> {
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

    /// Goes along the ground, along walls and up steps.
    fn go(&mut self, pose: &mut Pose, wish: Vec3, ground: Option<Vec3>) {
        let up = self.settings.up;
        let along_ground = |motion: Vec3, normal: Vec3| {
            // As fast over the ground as seen from above.
            let rise = -motion.dot(normal) / normal.dot(up);
            motion + rise * up
        };
        let mut rest = ground.map_or(wish, |normal| along_ground(wish, normal));
        let mut obstacles = Obstacles::default();
        for _ in 0..MAX_SLIDES {
            let (moved, hit) = self.queries.advance(self.slider, pose, rest, self.filter);
            pose.position += moved;
            rest -= moved;
            let Some(hit) = hit else {
                return;
            };
            self.push(&hit, wish);
            if hit.normal.dot(up) >= self.min_rise {
                let flat = across(rest, up);
                rest = along_ground(flat, hit.normal);
                obstacles = Obstacles::default();
                continue;
            }
            if ground.is_some() && self.step_up(pose, &mut rest, hit.normal) {
                continue;
            }
            // Down along the ground it may run into an edge that is clear of the way ahead: it goes on level, and is set down after.
            rest -= rest.dot(up).min(0.0) * up;
            // What is too steep is a wall, however it leans.
            let wall = across(hit.normal, up).try_normalize().unwrap_or(hit.normal);
            rest = obstacles.deflect(rest, wall);
            if across(rest, up).dot(wish) <= 0.0 {
                return;
            }
        }
    }

    /// Pushes what it runs into, if that can be moved.
    fn push(&mut self, hit: &QueryHit, wish: Vec3) {
        let bodies = self.queries.bodies();
        let (slot, most) = (hit.body, self.settings.push_force * self.step_dt);
        let is_movable = bodies.kind(slot) == RigidBody::Dynamic && most > 0.0;
        let Some(into) = across(-hit.normal, self.settings.up).try_normalize() else {
            return;
        };
        if !is_movable || hit.normal.dot(self.settings.up) >= self.min_rise {
            return;
        }
        let (linear, angular) = bodies.velocity(slot);
        let arm = hit.point - bodies.center_of_mass(slot);
        let speed = into.dot(wish / self.step_dt - linear - angular.cross(arm));
        let impulse = (speed * bodies.mass(slot).mass).min(most);
        if impulse > 0.0 {
            self.pushes.push(Push {
                body: slot,
                point: hit.point,
                impulse: impulse * into,
            });
        }
    }

    /// Up, forward and down again, where it ran into something with this normal; whether it is on a step then.
    fn step_up(&mut self, pose: &mut Pose, rest: &mut Vec3, normal: Vec3) -> bool {
        let (up, height) = (self.settings.up, self.settings.step_height);
        let flat = across(*rest, up);
        let Some(direction) = flat.try_normalize() else {
            return false;
        };
        let mut there = *pose;
        let climb = height * up;
        let (risen, _) = self
            .queries
            .advance(self.slider, &there, climb, self.filter);
        there.position += risen;
        // Over the skin that it keeps from what it runs into, however slantwise.
        let over_skin = (2.0 * self.settings.skin / -direction.dot(normal)).abs();
        let foothold = over_skin.min(height).max(FOOTHOLD * height);
        let forward = direction * flat.length().max(foothold);
        let (moved, _) = self
            .queries
            .advance(self.slider, &there, forward, self.filter);
        there.position += moved;
        if moved.length() <= 0.5 * self.settings.skin {
            return false;
        }
        let (sunk, hit) = self
            .queries
            .advance(self.slider, &there, -risen, self.filter);
        let Some(hit) = hit.filter(|hit| self.is_ground(hit).is_some()) else {
            return false;
        };
        let is_movable = self.queries.bodies().kind(hit.body) == RigidBody::Dynamic;
        there.position += sunk;
        let gain = (there.position - pose.position).dot(up);
        // What it would stand on there may be higher than its feet are yet.
        let feet = -self.slider.shape.reach(pose, -up) - self.settings.skin;
        let is_too_high = hit.point.dot(up) - feet > height + self.settings.skin;
        if gain <= 0.0 || is_movable || is_too_high {
            return false;
        }
        *pose = there;
        *rest = flat - moved.clamp_length_max(flat.length());
        true
    }

    /// Moves up or down; whether something stops it.
    fn fall(&mut self, pose: &mut Pose, way: f32) -> bool {
        let motion = way * self.settings.up;
        let (moved, hit) = self.queries.advance(self.slider, pose, motion, self.filter);
        pose.position += moved;
        let Some(hit) = hit else {
            return false;
        };
        if way > 0.0 || self.is_ground(&hit).is_some() {
            return true;
        }
        // Down a slope that is too steep to stand on.
        let rest = motion - moved;
        let along = rest - rest.dot(hit.normal).min(0.0) * hit.normal;
        let (moved, _) = self.queries.advance(self.slider, pose, along, self.filter);
        pose.position += moved;
        false
    }

    /// Finds what it stands on, and goes down to it: by a step, if it was on the ground.
    fn set_down(&mut self, pose: &mut Pose, was_on_ground: bool) -> Option<Footing> {
        let (up, skin) = (self.settings.up, self.settings.skin);
        let reach = if was_on_ground {
            self.settings.step_height
        } else {
            skin
        };
        let (moved, hit) =
            self.queries
                .advance(self.slider, pose, -(reach + skin) * up, self.filter);
        let hit = hit?;
        let normal = self.is_ground(&hit)?;
        pose.position += moved;
        // What was pushed out of the ground keeps half of its skin.
        let short = skin / hit.normal.dot(up).max(self.min_rise) - hit.distance;
        if short > 1e-3 * skin {
            let (risen, _) = (self.queries).advance(self.slider, pose, short * up, self.filter);
            pose.position += risen;
        }
        Some(Footing {
            body: hit.body,
            normal,
            point: hit.point,
        })
    }
}
