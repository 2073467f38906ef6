//! Who rests and who sleeps: the state that [`Bodies`] keeps, and what wakes a body at once.
//!
//! When islands fall asleep, and what wakes them in a step, is decided in [`sleep`](crate::solver::sleep).

use crate::contact::body_id::BodyId;
use glam::{Quat, Vec3};

/// Whether a slot takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Status {
    /// No body here.
    Free,
    /// A body that moves and touches.
    Active,
    /// A body that rests until something wakes it.
    Asleep,
    /// As active, and takes part in the local steps that are being taken.
    Local,
    /// A body with a state that is not finite: kept, but nothing else sees it.
    Frozen,
}

/// How long a body has been near a place, and which.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stay {
    /// s.
    pub(crate) time: f32,
    /// Center of mass when the time began to count, m.
    pub(crate) center: Vec3,
    pub(crate) rotation: Quat,
}

/// How long a body has been at rest.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rest {
    /// In one place, but for its drift.
    pub(crate) still: Stay,
    /// About one place, by some times as much: what rocks on the spot. Its time is that of the stays before `still`.
    pub(crate) rocking: Stay,
}

/// An island all of whose bodies rest.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SleepCandidate {
    /// Its number among the islands of the step.
    pub(crate) island: usize,
    /// Impulse of gravity and of its bodies' own forces in the step, N s.
    pub(crate) weight: Vec3,
    /// Impulse that it got from fixed bodies, N s.
    pub(crate) support: Vec3,
    /// Whether a fixed body touches it.
    pub(crate) has_support: bool,
    /// Whether a fixed body that moves touches it, or a motor or a running surface moves it.
    pub(crate) is_carried: bool,
}

impl SleepCandidate {
    /// Whether fixed bodies bear at least this share of what pulls it.
    pub(crate) fn is_borne(&self, least: f32) -> bool {
        -self.support.dot(self.weight) >= least * self.weight.length_squared()
    }
}

/// What [`Bodies`] knows of sleep; empty until the first step with sleeping on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sleep {
    /// Whether changes of bodies are noted.
    pub(crate) is_on: bool,
    /// Number of bodies asleep.
    pub(crate) asleep: usize,
    /// Gravity under which the bodies fell asleep, m/s2.
    pub(crate) gravity: Vec3,
    /// By slot.
    pub(crate) rest: Vec<Rest>,
    /// By slot of a sleeping body: the next one of its island, in a ring.
    pub(crate) next: Vec<u32>,
    /// Slots of a fixed body and of a sleeping one that touches it.
    pub(crate) supports: Vec<[u32; 2]>,
    /// Slots of bodies that were added, removed or changed since the last step, as a list and as flags.
    pub(crate) changed: Vec<u32>,
    pub(crate) is_changed: Vec<bool>,
    /// Bodies that fell asleep or woke, or were expected to, for those who mark entities.
    pub(crate) sleep_changes: Vec<(u32, BodyId)>,
    /// Ids of bodies that woke since their multipliers were last fetched.
    pub(crate) woken: Vec<BodyId>,
    /// Ids of bodies that fell asleep in this step, ascending.
    pub(crate) slept: Vec<BodyId>,
    pub(crate) candidates: Vec<SleepCandidate>,
    /// By slot: index of the candidate it belongs to.
    pub(crate) candidate_of: Vec<u32>,
}

impl Sleep {
    pub(crate) fn is_changed(&self, slot: u32) -> bool {
        self.is_changed.get(slot as usize) == Some(&true)
    }

    /// Forgets how long the body in `slot` has been at rest.
    pub(crate) fn reset(&mut self, slot: u32) {
        if let Some(rest) = self.rest.get_mut(slot as usize) {
            *rest = Rest::default();
        }
    }
}
