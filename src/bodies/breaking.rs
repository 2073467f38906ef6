//! Bodies that break: whether what they were hit with so far in a step is more than they bear.
//!
//! Looked at while the step is being solved. As soon as one body of a batch is overloaded, the solve is given up: the body
//! breaks, and the step is solved anew with its pieces. If nothing may break any more in the step, it is only noted.

/// What one body of a batch bears in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BreakingLimit {
    /// Its number within the batch.
    pub body: u32,
    /// Impulse that it bears, N s.
    pub impulse: f32,
    /// Energy that a load must have to break it, J.
    pub energy: f32,
}

impl BreakingLimit {
    /// Whether a load is more than the body bears.
    pub fn is_exceeded_by(&self, load: &ImpactLoad) -> bool {
        load.impulse > self.impulse && load.energy >= self.energy
    }
}

/// What contacts did to a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpactLoad {
    /// Sum of the normal impulses, N s.
    pub impulse: f32,
    /// Kinetic energy that they took out of the approach, J.
    pub energy: f32,
}

impl ImpactLoad {
    /// Adds a contact point with the normal impulse `impulse` (N s) on two bodies that approached each other with `speed`
    /// (m/s) before the step.
    ///
    /// A plastic load changes the energy by `impulse (v + v') / 2` with the speeds before and after it, and leaves `v' = 0`.
    pub fn add(&mut self, impulse: f32, speed: f32) {
        self.impulse += impulse;
        self.energy += 0.5 * impulse * speed.max(0.0);
    }
}
