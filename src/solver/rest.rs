//! Rest: for how long each body has been slow and in place.
//!
//! What is slow and drifts by less than a share of its size is still. What rocks on the spot gets farther, and is at rest after a longer time.
//! What creeps or slides on leaves either room before that.

use crate::bodies::sleep_state::{Rest, Status, Stay};
use crate::bodies::store::Bodies;
use crate::solver::config::SleepConfig;
use glam::Vec3;

/// How many times farther what is thin may drift at most, as the square root of its length over its thickness tells: what creeps by 2e-3 of
/// the thickness of a card or a needle creeps by 1e-4 of its length.
const MAX_LEEWAY: f32 = 4.0;

/// How many times farther what rocks on the spot may get, and how many times longer it must have done so. A last wobble on the corners of a
/// splinter is not seen, hardly dies down, and would keep all that lies about it awake.
const ROCKING_ROOM: f32 = 8.0;
const ROCKING_TIMES: f32 = 2.0;

impl Bodies {
    /// Counts for how long each body has been at rest, after a step of `step_dt` seconds.
    pub(super) fn count_rest(&mut self, config: &SleepConfig, step_dt: f32) {
        let slots = self.slots();
        let gravity = self.sleep.gravity.length();
        self.sleep.rest.resize(slots, Rest::default());
        for slot in 0..slots as u32 {
            let i = slot as usize;
            if self.status[i] != Status::Active || self.velocity[i].inverse_mass == 0.0 {
                continue;
            }
            // What a force of its own presses against a wall may tremble there as what gravity does.
            let pull = self.pull_on(slot).length().max(gravity);
            if self.is_slow(slot, config, pull) {
                let room = self.drift_room(slot, config, pull);
                self.count_stays(slot, room, config.time, step_dt);
            } else {
                self.sleep.rest[i] = self.rest_here(slot);
            }
        }
    }

    /// Counts a step of `step_dt` seconds for a slow body that may get `room` (m) away; of each stay, at most `most` seconds as rocking.
    fn count_stays(&mut self, slot: u32, room: f32, most: f32, step_dt: f32) {
        let Rest { still, rocking } = self.sleep.rest[slot as usize];
        if self.has_stayed(slot, &still, room) {
            self.sleep.rest[slot as usize].still.time += step_dt;
            return;
        }
        let mut rest = self.rest_here(slot);
        if self.has_stayed(slot, &rocking, ROCKING_ROOM * room) {
            rest.rocking = rocking;
            rest.rocking.time += still.time.min(most) + step_dt;
        }
        self.sleep.rest[slot as usize] = rest;
    }

    /// Whether a body has been at rest for long enough.
    pub(super) fn is_rested(&self, slot: u32, config: &SleepConfig) -> bool {
        let Rest { still, rocking } = &self.sleep.rest[slot as usize];
        still.time >= config.time || rocking.time + still.time >= ROCKING_TIMES * config.time
    }

    /// Mean velocity of a body while it has been still, or the one it has, m/s. What trembles in its place has none.
    pub(super) fn mean_velocity(&self, slot: u32, config: &SleepConfig) -> Vec3 {
        let i = slot as usize;
        let still = &self.sleep.rest[i].still;
        let is_known = still.time >= config.time && still.time.is_finite();
        if is_known && self.velocity[i].inverse_mass > 0.0 {
            (self.center[i] - still.center) / still.time
        } else {
            self.velocity[i].linear
        }
    }

    /// Whether a body is slower than the limit for its size.
    fn is_slow(&self, slot: u32, config: &SleepConfig, gravity: f32) -> bool {
        let body = &self.velocity[slot as usize];
        let turn = self.rotation[slot as usize].inverse() * body.angular;
        let speed_squared = body.linear.length_squared() + self.sway_squared(slot, turn);
        let natural = gravity * self.min_extent[slot as usize];
        speed_squared <= config.speed * config.speed * natural
    }

    /// Whether a body is within `room` (m) of the place where a stay began.
    fn has_stayed(&self, slot: u32, stay: &Stay, room: f32) -> bool {
        let i = slot as usize;
        let turn = stay.rotation.inverse() * self.rotation[i];
        // The vector part has half the angle's length, for small angles.
        let sway = self.sway_squared(slot, 2.0 * turn.xyz()).sqrt();
        self.center[i].distance(stay.center) + sway <= room
    }

    /// How far a body at rest may get, m.
    fn drift_room(&self, slot: u32, config: &SleepConfig, gravity: f32) -> f32 {
        let least = self.min_extent[slot as usize];
        let fall = 0.5 * gravity * config.time * config.time;
        // A cube's farthest corner is at half of the square root of 3.
        let slenderness = self.radius(slot) / (0.866 * least);
        let leeway = slenderness.sqrt().clamp(1.0, MAX_LEEWAY);
        leeway * config.drift * (least * least.max(fall)).sqrt()
    }

    /// Square of how far the point that goes farthest gets when a body turns by a small vector, given in its own axes; with an
    /// angular velocity (rad/s), of how fast it is.
    ///
    /// About the axis of the largest moment of inertia `I` it is the farthest point's distance `R`, about one of a smaller
    /// moment `I_k` it is `R sqrt(I_k / I)`: exact for ellipsoids, a little too much for boxes. A rod that rolls on the spot
    /// moves its surface and not its ends.
    fn sway_squared(&self, slot: u32, turn: Vec3) -> f32 {
        let (r, mass) = (self.radius(slot), &self.mass[slot as usize]);
        let turn = mass.principal_frame.inverse() * turn;
        let shares = mass.principal / mass.principal.max_element();
        r * r * (shares * turn * turn).element_sum()
    }

    /// What gravity and the body's own forces pull it with, m/s2.
    pub(super) fn pull_on(&self, slot: u32) -> Vec3 {
        let gravity = self.sleep.gravity;
        let drive = self.drive_of(slot, gravity);
        drive.map_or(gravity, |drive| gravity + drive.acceleration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::body::BodyDesc;
    use crate::geometry::ConvexMesh;
    use rand_core::{Rng, SeedableRng};
    use rand_pcg::Pcg32;

    const STEP_DT: f32 = 1.0 / 60.0;

    fn in_range(random: &mut Pcg32, from: f32, to: f32) -> f32 {
        from + (to - from) * (random.next_u32() >> 8) as f32 / (1 << 24) as f32
    }

    /// Whether a box is found at rest in one of the steps of four seconds, on a line on which it is `way(time)` of its rooms from where it began.
    fn comes_to_rest(random: &mut Pcg32, way: impl Fn(f32) -> f32) -> bool {
        let config = SleepConfig::default();
        let mut bodies = Bodies::default();
        let [least, b, c] = [0.01, 1.0, 1.0].map(|least| in_range(random, least, 3.0));
        let shape = ConvexMesh::cuboid(least, b * least, c * least).expect("a box");
        let body = BodyDesc::dynamic(shape, Vec3::ZERO);
        let slot = bodies.insert(body).expect("usable");
        bodies.refresh_mass(slot).expect("a solid box");
        bodies.sleep.gravity = -9.81 * Vec3::Y;
        let room = bodies.drift_room(slot, &config, 9.81);
        let along = Vec3::new(0.6, 0.0, 0.8);
        (1..240).any(|step| {
            bodies.center[slot as usize] = room * way(step as f32 * STEP_DT) * along;
            bodies.count_rest(&config, STEP_DT);
            bodies.is_rested(slot, &config)
        })
    }

    #[test]
    fn what_rocks_on_the_spot_comes_to_rest_and_what_goes_far_or_on_does_not() {
        let random = &mut Pcg32::seed_from_u64(30);
        for member in 0..200 {
            let period = in_range(random, 0.1, 0.5);
            // From nothing up to one and back.
            let swing = |time: f32| 1.0 - (2.0 * (time / period).fract() - 1.0).abs();
            let small = in_range(random, 1.2, 7.0);
            assert!(
                comes_to_rest(random, |time| small * swing(time)),
                "{member}"
            );
            let large = in_range(random, 25.0, 60.0);
            assert!(
                !comes_to_rest(random, |time| large * swing(time)),
                "{member}"
            );
            let slow = in_range(random, 0.0, 1.8);
            assert!(comes_to_rest(random, |time| slow * time), "{member}");
            let fast = in_range(random, 9.0, 90.0);
            assert!(!comes_to_rest(random, |time| fast * time), "{member}");
        }
    }
}
