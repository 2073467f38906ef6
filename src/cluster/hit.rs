//! What a cluster is hit with.

use glam::Vec3;

/// One point where something hits the cluster, or stands against it; frame of the compound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Striker {
    /// The part that it is at.
    pub(crate) part: u32,
    /// m.
    pub(crate) point: Vec3,
    /// Unit vector along which it pushes the cluster.
    pub(crate) direction: Vec3,
    /// How fast it comes, relative to the cluster as a rigid body, m/s; negative if it goes.
    pub(crate) speed: f32,
    /// As seen along the direction, 1/kg; 0 for what stands.
    pub(crate) inverse_mass: f32,
}

/// An impulse on one part at the start of the instant; frame of the compound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Push {
    pub(crate) part: u32,
    /// N s.
    pub(crate) impulse: Vec3,
    /// About the center of the part, N m s.
    pub(crate) angular_impulse: Vec3,
}

/// What a cluster is hit with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit<'h> {
    pub(crate) strikers: &'h [Striker],
    pub(crate) pushes: &'h [Push],
}

impl<'h> Hit<'h> {
    /// By other bodies.
    pub(crate) fn of(strikers: &'h [Striker]) -> Self {
        Self {
            strikers,
            pushes: &[],
        }
    }

    /// By what pushes single parts.
    pub(crate) fn of_pushes(pushes: &'h [Push]) -> Self {
        Self {
            strikers: &[],
            pushes,
        }
    }
}
