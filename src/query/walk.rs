//! `Queries::walk`: a character that walks over a scene, by casts of its shape.
//!
//! A step of a character, in order: it is carried by what it stands on to where that will be; it gets out of the way of what moves
//! against it; it goes where it wants to along the ground, along walls and up steps; it falls, or is set down on ground that is not
//! farther than a step down. What moves by its velocity is met where it will be after the step.

use crate::bodies::body::RigidBody;
use crate::math::{Aabb, Pose};
use crate::query::ahead::Ahead;
use crate::query::ball::Ball;
use crate::query::filter::QueryFilter;
use crate::query::hit::QueryHit;
use crate::query::movers::KinematicMovers;
use crate::query::slide::{Obstacles, Slider};
use crate::query::view::Queries;
use crate::query::walker::{Push, WalkInput, WalkSettings, WalkState};
use glam::Vec3;

/// How often a motion is deflected.
const MAX_SLIDES: usize = 6;

/// Share of a fall that is none.
const NOWHERE: f32 = 1e-4;

/// A character in one step.
pub(super) struct Walk<'w, 'q> {
    /// With what moves where it will be.
    pub(super) queries: Queries<'q>,
    /// With everything where it is.
    pub(super) present: Queries<'q>,
    pub(super) ahead: &'q Ahead,
    pub(super) slider: &'w Slider<'w>,
    pub(super) settings: &'w WalkSettings,
    pub(super) filter: &'w QueryFilter<'w>,
    pub(super) step_dt: f32,
    /// Cosine of the steepest slope.
    pub(super) min_rise: f32,
    /// Velocity of what carries it, m/s.
    ground_velocity: Vec3,
    pushes: &'w mut Vec<Push>,
}

impl Queries<'_> {
    /// Moves a character for a step. `pushes` gets what it pushes; it is cleared first. `slider` is its shape; its skin is that of
    /// the settings.
    ///
    /// Kinematic bodies are met where their velocities take them in the step. A state or an input that is not finite, settings that are
    /// not usable, or a step without length, moves nothing.
    pub fn walk(
        &self,
        how: (&Slider, &WalkSettings),
        state: &mut WalkState,
        input: &WalkInput,
        filter: &QueryFilter,
        pushes: &mut Vec<Push>,
    ) {
        let of_now;
        let moving = match self.kinematic_movers() {
            Some(known) => known,
            None => {
                of_now = KinematicMovers::of(self.bodies());
                &of_now
            }
        };
        self.walk_among(moving, how, state, (input, filter), pushes);
    }

    /// The same among kinematic bodies that are known to move.
    pub(crate) fn walk_among(
        &self,
        moving: &KinematicMovers,
        (slider, settings): (&Slider, &WalkSettings),
        state: &mut WalkState,
        (input, filter): (&WalkInput, &QueryFilter),
        pushes: &mut Vec<Push>,
    ) {
        pushes.clear();
        if !is_usable(settings, state, input) {
            return;
        }
        let slider = &Slider {
            skin: settings.skin,
            ..*slider
        };
        let ahead = &self.look_ahead(moving, (slider, settings), state, input);
        let mut walk = Walk {
            queries: self.with_ahead(ahead.places()),
            present: *self,
            ahead,
            slider,
            settings,
            filter,
            step_dt: input.step_dt,
            min_rise: 1.0 / (1.0 + settings.max_slope * settings.max_slope).sqrt(),
            ground_velocity: Vec3::ZERO,
            pushes,
        };
        let mut moved = *state;
        walk.step(&mut moved, input);
        // Numbers may be finite, and what is made of them not.
        let is_finite = moved.position.is_finite()
            && moved.velocity.is_finite()
            && moved.drift.is_finite()
            && moved.rotation.is_finite();
        if is_finite {
            *state = moved;
        } else {
            pushes.clear();
        }
    }

    /// What may meet a character in a step, where it will be.
    fn look_ahead(
        &self,
        moving: &KinematicMovers,
        (slider, settings): (&Slider, &WalkSettings),
        state: &WalkState,
        input: &WalkInput,
    ) -> Ahead {
        let (bodies, dt) = (self.bodies(), input.step_dt);
        let bounds = (slider.shape).bounds(&Pose::new(state.position, state.rotation));
        let speed = input.velocity.length() + state.velocity.length() + state.drift.length();
        let way = dt * (speed + input.jump.abs() + dt * input.gravity.length());
        let room = way + 2.0 * (settings.step_height + settings.skin);
        let region = bounds.fattened(room);
        let within = (Ball::around(&region), dt);
        let mut ahead = Ahead::default();
        let footing = (state.footing).filter(|it| bodies.is_current(it.body, it.id));
        if let Some(footing) = footing {
            ahead.look(bodies, footing.body, within);
        }
        if let Some(carrier) = ahead.movers().first() {
            // What goes with it on the same ground is ahead too.
            let way = carrier.way(state.position).abs();
            let region = Aabb {
                min: region.min - way,
                max: region.max + way,
            };
            self.inside(&region, |slot| {
                if bodies.is_carried(slot) {
                    ahead.look(bodies, slot, within);
                }
            });
        }
        let near = moving.near(bodies, dt, |room, visit| {
            self.inside(&region.fattened(room), visit);
        });
        for slot in near {
            ahead.look(bodies, slot, within);
        }
        ahead
    }
}

/// Whether a character can be moved at all.
fn is_usable(settings: &WalkSettings, state: &WalkState, input: &WalkInput) -> bool {
    let numbers = [
        state.position,
        state.velocity,
        state.drift,
        input.velocity,
        input.gravity,
    ];
    numbers.iter().all(|v| v.is_finite())
        && state.rotation.is_normalized()
        && settings.is_usable()
        && input.step_dt > 0.0
        && input.step_dt.is_finite()
}

/// What of a vector is across a unit vector.
pub(super) fn across(v: Vec3, up: Vec3) -> Vec3 {
    v - v.dot(up) * up
}

impl Walk<'_, '_> {
    fn step(&mut self, state: &mut WalkState, input: &WalkInput) {
        let (up, dt) = (self.settings.up, self.step_dt);
        let from = Pose::new(state.position, state.rotation);
        let mut pose = from;
        let carrier = state.footing.map(|footing| footing.body);
        if let Some(footing) = &mut state.footing {
            self.ground_velocity = self.ride(&mut pose, footing) / dt;
        }
        let is_lifted = self.give_way(&from, &mut pose, carrier);
        self.come_out(&mut pose);
        let (wish, mut rise) = (across(input.velocity, up), state.velocity.dot(up));
        let wish = wish + state.drift;
        let lift = self.ground_velocity.dot(up);
        let jumps = state.footing.is_some() && input.jump > 0.0;
        if jumps {
            state.footing = None;
            rise = input.jump;
        }
        // Where up is another direction now, or the ground has turned, it may be too steep.
        let ground = state.footing.map(|footing| footing.normal);
        let ground = ground.filter(|normal| normal.dot(up) >= self.min_rise);
        let begin = pose;
        self.go(&mut pose, dt * wish, ground);
        let made = across(pose.position - begin.position, up) / dt;
        // What it ran into takes its speed, what it climbs does not.
        let kept = made.length().min(wish.length());
        let mut level = made.normalize_or_zero() * kept;
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
        state.drift = hindered(state.drift, wish - level);
        state.footing = if jumps || (rise > 0.0 && !is_lifted) {
            None
        } else {
            let stood_on = ground.and(carrier);
            self.set_down(&mut pose, (&begin, stood_on))
        };
        if state.footing.is_some() {
            rise = 0.0;
            state.drift = Vec3::ZERO;
        } else if carrier.is_some() {
            // It keeps what it had of the ground.
            state.drift = across(self.ground_velocity, up);
            level += state.drift;
            rise += lift;
        }
        state.velocity = level + rise * up;
        (state.position, state.rotation) = (pose.position, pose.rotation);
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
            let (moved, hit) = self.advance(pose, rest);
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

    /// Pushes what it runs into, if that can be moved, once a step.
    fn push(&mut self, hit: &QueryHit, wish: Vec3) {
        let bodies = self.queries.bodies();
        let (slot, most) = (hit.body, self.settings.push_force * self.step_dt);
        let is_pushed = self.pushes.iter().any(|push| push.body == slot);
        let is_movable = bodies.kind(slot) == RigidBody::Dynamic && most > 0.0 && !is_pushed;
        let Some(into) = across(-hit.normal, self.settings.up).try_normalize() else {
            return;
        };
        if !is_movable || hit.normal.dot(self.settings.up) >= self.min_rise {
            return;
        }
        let (linear, angular) = bodies.velocity(slot);
        let arm = hit.point - bodies.center_of_mass(slot);
        let own = wish / self.step_dt + self.ground_velocity;
        let speed = into.dot(own - linear - angular.cross(arm));
        // Pushed beside its center it turns, and is as fast there by less.
        let turns = bodies.inverse_inertia[slot as usize] * arm.cross(into);
        let yields = 1.0 / bodies.mass(slot).mass + turns.cross(arm).dot(into);
        let impulse = (speed / yields).min(most);
        if impulse > 0.0 {
            self.pushes.push(Push {
                body: slot,
                point: hit.point,
                impulse: impulse * into,
            });
        }
    }

    /// Moves up or down, and along slopes that are too steep to stand on; whether something stops it.
    fn fall(&mut self, pose: &mut Pose, way: f32) -> bool {
        let motion = way * self.settings.up;
        let (mut rest, mut obstacles) = (motion, Obstacles::default());
        for _ in 0..MAX_SLIDES {
            let (moved, hit) = self.advance(pose, rest);
            pose.position += moved;
            rest -= moved;
            let Some(hit) = hit else {
                return false;
            };
            if way > 0.0 || self.is_ground(&hit).is_some() {
                return true;
            }
            rest = obstacles.deflect(rest, hit.normal);
            // Between slopes it may lead nowhere.
            if rest.dot(motion) <= NOWHERE * motion.length_squared() {
                return true;
            }
        }
        true
    }
}

/// What is left of a drift where something takes so much of a velocity.
fn hindered(drift: Vec3, lost: Vec3) -> Vec3 {
    let Some(against) = lost.try_normalize() else {
        return drift;
    };
    let taken = drift.dot(against).clamp(0.0, lost.length());
    drift - taken * against
}
