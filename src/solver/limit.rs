//! Bodies that break: whether what they were hit with so far in a step is more than they bear.
//!
//! Looked at while the step is being solved. As soon as one body of a batch is overloaded, the solve is given up: the body
//! breaks, and the step is solved anew with its pieces. If nothing may break any more in the step, it is only noted.

use super::batch::Batch;
use super::blocks::vector;
use super::bodies::Bodies;

/// What one body of a batch bears in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Its number within the batch.
    pub body: u32,
    /// Impulse that it bears, N s.
    pub impulse: f32,
    /// Energy that a blow must have to break it, J.
    pub energy: f32,
}

impl Limit {
    /// Whether a blow is more than the body bears.
    pub fn is_exceeded_by(&self, blow: &BodyBlow) -> bool {
        blow.impulse > self.impulse && blow.energy >= self.energy
    }
}

/// What contacts did to a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyBlow {
    /// Sum of the normal impulses, N s.
    pub impulse: f32,
    /// Kinetic energy that they took out of the approach, J.
    pub energy: f32,
}

impl BodyBlow {
    /// Adds a contact point with the normal impulse `impulse` (N s) on two bodies that approached each other with `speed`
    /// (m/s) before the step.
    ///
    /// A plastic blow changes the energy by `impulse (v + v') / 2` with the speeds before and after it, and leaves `v' = 0`.
    pub fn add(&mut self, impulse: f32, speed: f32) {
        self.impulse += impulse;
        self.energy += 0.5 * impulse * speed.max(0.0);
    }
}

impl Batch {
    /// Lists those of its bodies that may break.
    pub(super) fn load_limits(&mut self, bodies: &Bodies) {
        if !bodies.any_fracturable() {
            return;
        }
        for (body, &slot) in (0..).zip(&self.layout.slots) {
            if let Some(limit) = bodies.limit(slot) {
                self.limits.push(Limit { body, ..limit });
            }
        }
        if !self.limits.is_empty() {
            self.scratch.start.clear();
            self.scratch.start.extend_from_slice(&self.bodies);
        }
    }

    /// Notes the bodies that are overloaded by the impulses of the step until now; whether there are any.
    pub(super) fn find_overloaded(&mut self) -> bool {
        self.overloaded.clear();
        if self.limits.is_empty() {
            return false;
        }
        let mut blows = std::mem::take(&mut self.scratch.blows);
        blows.clear();
        blows.resize(self.bodies.len(), BodyBlow::default());
        for block in &self.blocks {
            for lane in 0..block.used {
                let (pair, normal) = (block.pair(lane), vector(&block.normal, lane));
                let start = pair.map(|body| &self.scratch.start[body as usize]);
                for point in &self.points[block.points.clone()] {
                    let impulse = point.total.0[lane] + point.impulse[0].0[lane];
                    if impulse > 0.0 {
                        let speed = -point.normal_velocity(lane, normal, start);
                        pair.iter()
                            .for_each(|&body| blows[body as usize].add(impulse, speed));
                    }
                }
            }
        }
        let overloaded = self.limits.iter().filter_map(|limit| {
            let blow = blows[limit.body as usize];
            let is_over = limit.is_exceeded_by(&blow);
            is_over.then_some((self.layout.slots[limit.body as usize], blow))
        });
        self.overloaded.extend(overloaded);
        self.scratch.blows = blows;
        !self.overloaded.is_empty()
    }
}
