//! What can be asked and told of the contacts of a body.

use crate::contact::body_id::BodyId;
use glam::Vec3;

/// What is to be told of the contacts of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactWatch {
    /// Whether it begins to touch or comes apart.
    pub touches: bool,
    /// Contacts that bear more than this, N; infinite if none is to be told.
    pub force: f32,
}

impl Default for ContactWatch {
    /// Nothing.
    fn default() -> Self {
        Self {
            touches: false,
            force: f32::INFINITY,
        }
    }
}

impl ContactWatch {
    pub(crate) fn is_any(&self) -> bool {
        self.touches || self.force < f32::INFINITY
    }
}

/// What happened to a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactChange {
    /// It touches now.
    Start,
    /// It touches no more, or one of the bodies is gone.
    End,
    /// It bears more than was asked for.
    Force {
        /// Whether it bore less in the step before, for each of the two bodies' limits.
        is_crossing: [bool; 2],
    },
}

/// News of a pair of bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactEvent {
    /// What happened.
    pub change: ContactChange,
    /// Slots and ids, the smaller id first.
    pub bodies: [(u32, BodyId); 2],
    /// Of which of the two this was to be told.
    pub of: [bool; 2],
    /// Where they touch, world, m; the mean of the points, weighted by what they bear. Zero at an end.
    pub point: Vec3,
    /// Unit normal from the first to the second body; zero at an end.
    pub normal: Vec3,
    /// Normal impulse of the whole step, N s; zero for sensors.
    pub impulse: f32,
    /// Speed of approach along the normal before the step, m/s; not negative.
    pub approach_speed: f32,
}
