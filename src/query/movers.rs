//! The kinematic bodies that move in a step, so that a character looks at those near it alone.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::math::Aabb;
use crate::query::view::Queries;
use glam::Vec3;
use smallvec::SmallVec;

/// So many are looked at one by one by everybody.
const FEW: usize = 64;

/// Of more, one of so many, which goes farthest.
const SHARE: usize = 16;

/// Slots of those that are looked at: room for them on the stack but among thousands.
type Near = SmallVec<[u32; 2 * FEW]>;

/// Kinematic bodies that move.
#[derive(Debug, Default)]
pub(crate) struct KinematicMovers {
    /// Those that go farther than the limit in the step.
    far: Vec<u32>,
    /// How far those go that are looked for in the tree of the queries, m; 0 as long as nobody needs to.
    limit: f32,
    /// How many there are, and how far they go together, m.
    count: usize,
    way: f32,
    step_dt: f32,
}

impl KinematicMovers {
    /// Those of a scene in a step of so many seconds, in place of what was known.
    pub(crate) fn find(&mut self, bodies: &Bodies, step_dt: f32) {
        let mut far = std::mem::take(&mut self.far);
        far.clear();
        *self = Self {
            far,
            step_dt,
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
        let step_dt = self.step_dt;
        let own = way(bodies, slot, step_dt);
        if own.is_finite() {
            self.count += 1;
            self.way += own;
        }
        if own <= self.limit {
            return;
        }
        self.far.push(slot);
        if self.far.len() > FEW + self.count / SHARE {
            // No more than one of so many goes farther than so many times the mean.
            self.limit = self.way * SHARE as f32 / self.count as f32;
            (self.far).retain(|&slot| way(bodies, slot, step_dt) > self.limit);
        }
    }

    /// Those that may come to a region, and some others; ascending.
    pub(crate) fn near(&self, queries: &Queries, region: &Aabb) -> Near {
        let mut found: Near = self.far.iter().copied().collect();
        if self.limit > 0.0 {
            let bodies = queries.bodies();
            queries.inside(&region.fattened(self.limit), |slot| {
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

/// How far the points of a body go within a step at most, m.
fn way(bodies: &Bodies, slot: u32, step_dt: f32) -> f32 {
    let ((linear, angular), radius) = (bodies.velocity(slot), bodies.radius(slot));
    if radius == 0.0 {
        // What has no end has no radius.
        return f32::INFINITY;
    }
    // No point goes farther about the center than to the other side.
    step_dt * linear.length() + radius * (step_dt * angular.length()).min(2.0)
}
