//! What bodies get by joints, until it is known which joint bears how much of it.

use crate::solver::joint::vector6::Vector6;

/// What is noted in a step.
#[derive(Debug, Default)]
pub(super) struct Borne {
    /// By component: whether its joints are no tree.
    pub(super) is_loop: Vec<bool>,
    pub(super) any: bool,
    /// By component: bodies that there are more than joints; whether joints hold some to what they do not move.
    pub(super) spare: Vec<i64>,
    pub(super) is_held: Vec<bool>,
    /// By body: velocities before the half of a sub-step.
    pub(super) before: Vec<Vector6>,
    /// By body: impulses of joints in the step that are to be spread.
    pub(super) impulses: Vec<Vector6>,
    /// By component: whether what its joints bear in a half of a sub-step is told by bodies.
    pub(super) is_passed: Vec<bool>,
    /// By body: impulse of the joint by which it hangs on another one, in a half of a sub-step.
    pub(super) passed: Vec<Vector6>,
}
