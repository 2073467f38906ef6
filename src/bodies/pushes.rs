//! What pushes bodies at points: explosions, and what acts on parts of clusters.

use crate::bodies::explosion::Explosion;
use crate::contact::body_id::BodyId;
use glam::Vec3;

/// A force or an impulse on a part of a cluster; frame of the compound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PointPush {
    pub(crate) slot: u32,
    pub(crate) id: BodyId,
    /// m.
    pub(crate) place: Vec3,
    /// N or N s.
    pub(crate) amount: Vec3,
}

/// What pushes bodies at points in the next step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pushes {
    pub(crate) explosions: Vec<Explosion>,
    /// On parts of clusters, N s.
    pub(crate) impulses: Vec<PointPush>,
    /// The same, N.
    pub(crate) forces: Vec<PointPush>,
}
