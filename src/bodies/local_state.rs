//! Who takes local steps: the state that `Bodies` keeps.

use crate::bodies::solver_body::{Motion, SolverBody};
use crate::contact::body_id::BodyId;
use glam::{Quat, Vec3};

/// Who takes local steps; buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct LocalBodies {
    /// Whether local steps are being taken.
    pub(crate) is_on: bool,
    /// Slots of the bodies that move in them: those that take them, and what moves by itself.
    pub(crate) slots: Vec<u32>,
    /// How the latter were before.
    pub(super) carriers: Vec<Carrier>,
    /// Grows when others take local steps than before.
    pub(crate) revision: u64,
}

/// A body that moves by itself and is moved by no contact, as it was before local steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carrier {
    pub(super) slot: u32,
    pub(super) id: BodyId,
    pub(super) center: Vec3,
    pub(super) rotation: Quat,
    pub(super) velocity: SolverBody,
    pub(super) motion: Motion,
}
