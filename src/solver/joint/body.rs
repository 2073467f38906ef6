//! Bodies at the ends of joints: those that joints move, and those that they do not.

use crate::bodies::free_rotation::FreeRotation;
use crate::solver::joint::measure::Place;
use crate::solver::joint::vector6::{Block6, Vector6, join, split};
use glam::{DMat3, DQuat, DVec3};

/// How many times heavier a body is along and about axes on which it does not move.
const LOCKED: f64 = 1e9;

/// A body that joints move.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointedBody {
    /// Its rotation.
    pub(crate) spin: FreeRotation,
    /// The same in double precision, of length 1.
    pub(crate) rotation: DQuat,
    /// Where its center of mass is, m.
    pub(crate) center: DVec3,
    /// kg
    pub(crate) mass: f64,
    /// Principal moments, kg m2.
    pub(crate) principal: DVec3,
    /// `body_from_principal`.
    pub(crate) frame: DQuat,
    /// One for each axis of the world along and about which it does not move, else zero.
    pub(crate) locks: [DVec3; 2],
    /// Inertia tensor and its inverse, world axes.
    pub(crate) inertia: DMat3,
    pub(crate) inverse_inertia: DMat3,
    /// Inertia that it has besides where joints are solved, since what it bears resists its turn.
    pub(crate) implicit_inertia: DMat3,
    /// `h^2 k J M^-1 J^T` of its springs together.
    pub(crate) swing: f64,
}

/// A body that joints do not move, or the world.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FixedBody {
    pub(crate) place: Place,
    pub(crate) velocity: Vector6,
}

impl FixedBody {
    /// Where it is `h` seconds later.
    pub(crate) fn after(&self, h: f64) -> Place {
        let [linear, angular] = split(&self.velocity);
        let half = 0.5 * h * angular;
        let half = half * (1.0 + half.length_squared() / 3.0);
        let turn = DQuat::from_xyzw(half.x, half.y, half.z, 1.0);
        Place {
            center: self.place.center + h * linear,
            rotation: (turn * self.place.rotation).normalize(),
        }
    }
}

impl JointedBody {
    /// Mass and inertia where joints are solved, about its center of mass.
    #[inline(always)]
    pub(super) fn spatial_inertia(&self) -> Block6 {
        let mut block = self.own_inertia();
        for i in 0..3 {
            for j in 0..3 {
                block[3 + i][3 + j] += self.implicit_inertia.col(j)[i];
            }
        }
        block
    }

    /// Its own mass and inertia, about its center of mass.
    #[inline(always)]
    pub(super) fn own_inertia(&self) -> Block6 {
        let mut block = Block6::default();
        let shares = DVec3::ONE + LOCKED * self.locks[0];
        for i in 0..3 {
            block[i][i] = self.mass * shares[i];
            for j in 0..3 {
                block[3 + i][3 + j] = self.inertia.col(j)[i];
            }
        }
        block
    }

    /// Its momentum about its center of mass at a velocity, by its own mass and inertia.
    #[inline(always)]
    pub(super) fn momentum(&self, velocity: &Vector6) -> Vector6 {
        let [linear, angular] = split(velocity);
        let shares = DVec3::ONE + LOCKED * self.locks[0];
        join(self.mass * shares * linear, self.inertia * angular)
    }

    /// Whether it has inertia besides its own.
    #[inline(always)]
    pub(super) fn is_stiffened(&self) -> bool {
        self.implicit_inertia != DMat3::ZERO
    }

    /// How far from its center of mass its mass is, m.
    pub(super) fn gyration(&self) -> f64 {
        (self.principal.max_element() / self.mass).sqrt()
    }

    /// Has no end of inertia about axes that it does not turn about; what the others have is the inverse of that part of the inertia.
    pub(super) fn lock_turns(&mut self) {
        let locks = DMat3::from_diagonal(self.locks[1]);
        let keeps = DMat3::from_diagonal(DVec3::ONE - self.locks[1]);
        let most = self.principal.max_element();
        let free = keeps * self.inertia * keeps;
        self.inertia = free + LOCKED * most * locks;
        self.inverse_inertia = keeps * (free + most * locks).inverse() * keeps;
    }

    /// What of a direction it may move along.
    #[inline(always)]
    pub(super) fn free_part(&self, direction: DVec3) -> DVec3 {
        (DVec3::ONE - self.locks[0]) * direction
    }

    /// Whether it is, as it was loaded, what it was when a step ended.
    pub(super) fn is_as_loaded(&self, ended: &Self) -> bool {
        self.spin == ended.spin
            && self.center == ended.center
            && self.mass == ended.mass
            && self.principal == ended.principal
            && self.frame == ended.frame
            && self.locks == ended.locks
    }
}
