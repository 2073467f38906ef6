//! The kinematic bodies that move in a step, so that a character looks at those near it alone.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use glam::Vec3;
use smallvec::SmallVec;

/// So many are looked at one by one by everybody.
const FEW: usize = 64;

/// Of more, one of so many, which is fastest.
const SHARE: usize = 16;

/// Slots of those that are looked at: room for them on the stack but among thousands.
type Near = SmallVec<[u32; 2 * FEW]>;

/// Kinematic bodies that move.
#[derive(Clone, Debug, Default)]
pub(crate) struct KinematicMovers {
    /// Those that are faster than the limit.
    far: Vec<u32>,
    /// How fast those are that are looked for in the tree of the queries, m/s; 0 as long as nobody needs to.
    limit: f32,
    /// How many there are, and the sum of their speeds, m/s.
    count: usize,
    speeds: f32,
}

impl KinematicMovers {
    /// Those of a scene.
    pub(crate) fn of(bodies: &Bodies) -> Self {
        let mut all = Self::default();
        all.find(bodies);
        all
    }

    /// Those of a scene, in place of what was known.
    pub(crate) fn find(&mut self, bodies: &Bodies) {
        let mut far = std::mem::take(&mut self.far);
        far.clear();
        *self = Self {
            far,
            ..Self::default()
        };
        for slot in 0..bodies.slots() as u32 {
            self.add(bodies, slot);
        }
    }

    /// Takes a body in, if it is kinematic and moves.
    pub(crate) fn add(&mut self, bodies: &Bodies, slot: u32) {
        if !is_mover(bodies, slot) {
            return;
        }
        let own = speed(bodies, slot);
        if own.is_finite() {
            self.count += 1;
            self.speeds += own;
        }
        if own <= self.limit {
            return;
        }
        self.far.push(slot);
        if self.far.len() > FEW + self.count / SHARE {
            // No more than one of so many is faster than so many times the mean.
            self.limit = self.speeds * SHARE as f32 / self.count as f32;
            (self.far).retain(|&slot| speed(bodies, slot) > self.limit);
        }
    }

    /// Those that may come to a region in a step of so many seconds, and some others; ascending. `visit` visits what is in the region with so
    /// much room around it (m).
    pub(crate) fn near(
        &self,
        bodies: &Bodies,
        step_dt: f32,
        visit: impl FnOnce(f32, &mut dyn FnMut(u32)),
    ) -> Near {
        let mut found: Near = self.far.iter().copied().collect();
        if self.limit > 0.0 {
            visit(step_dt * self.limit, &mut |slot| {
                if is_mover(bodies, slot) {
                    found.push(slot);
                }
            });
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

fn is_mover(bodies: &Bodies, slot: u32) -> bool {
    // What contacts move is not kinematic; that spares most bodies a look at far memory.
    bodies.solver_bodies()[slot as usize].inverse_mass == 0.0
        && bodies.velocity(slot) != (Vec3::ZERO, Vec3::ZERO)
        && bodies.is_moving(slot)
        && bodies.kind(slot) == RigidBody::Kinematic
}

/// How fast the points of a body are at most, m/s.
fn speed(bodies: &Bodies, slot: u32) -> f32 {
    let ((linear, angular), radius) = (bodies.velocity(slot), bodies.radius(slot));
    if radius == 0.0 {
        // What has no end has no radius.
        return f32::INFINITY;
    }
    linear.length() + radius * angular.length()
}
