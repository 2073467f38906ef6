//! What is known of a body whose parts are held by bonds, besides its shape.

use crate::cluster::bearing::Bearing;
use crate::cluster::elastic::{Elastic, Wrench};
use crate::cluster::network::Network;
use crate::contact::body_id::BodyId;
use glam::DVec3;
use std::sync::Arc;

/// What is known of a cluster.
#[derive(Clone, Debug)]
pub(crate) struct ClusterState {
    /// Its parts and bonds.
    pub(crate) network: Arc<Network>,
    /// By part, whether it holds on to the world; none while that is to be found out. Nothing of a dynamic body does.
    pub(crate) held: Option<Vec<bool>>,
    /// If nothing of it does: the newest body when that was found out.
    pub(crate) looked_at: Option<u32>,
    /// Where it lies on others, by these.
    pub(crate) bearings: Vec<(LoadSource, Bearing)>,
    /// What it bears, low-passed, by source and part.
    pub(crate) loads: Vec<PartLoad>,
    /// The same when it was last found out what that does to the bonds.
    pub(crate) judged: Option<JudgedLoad>,
    /// For how long it has been more than they bear, s.
    pub(crate) overloaded: f32,
    /// What tells how loads move its parts, as far as it is worked out.
    pub(crate) elastic: Option<Box<Elastic>>,
}

/// What another body, or a joint, does to a part; frame of the compound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PartLoad {
    /// Who does it, and which part.
    pub(crate) from: (LoadSource, u32),
    pub(crate) wrench: Wrench,
}

/// Who loads a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum LoadSource {
    /// A body by id, and its slot.
    Contact(BodyId, u32),
    Joint(u32),
    /// Forces that somebody lets act at points of it.
    Push,
}

/// A load whose bonds bear it.
#[derive(Clone, Debug)]
pub(crate) struct JudgedLoad {
    pub(crate) loads: Vec<PartLoad>,
    /// Gravity and spin in the frame of the compound, m/s2 and rad/s.
    pub(crate) motion: [DVec3; 2],
    /// The most that a bond bears, as a share of its strength.
    pub(crate) utilization: f64,
}

impl PartLoad {
    /// N.
    pub(crate) fn size(&self) -> f64 {
        self.wrench.force.length()
    }
}

impl ClusterState {
    /// Takes note that the bonds bear what the loads do, with gravity and spin in the frame of the compound.
    pub(crate) fn note_judged(&mut self, motion: [DVec3; 2], utilization: f64) {
        self.judged = Some(JudgedLoad {
            loads: self.loads.clone(),
            motion,
            utilization,
        });
    }

    /// Whether a part holds on to the world.
    pub(crate) fn holds(&self, part: u32) -> bool {
        let held = self.held.as_ref();
        held.is_some_and(|held| held[part as usize])
    }
}
