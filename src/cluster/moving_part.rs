//! A part in the instant of a blow.

use crate::cluster::hit::Push;
use crate::cluster::network::Network;
use glam::{Mat3, Vec3};

/// A part in the instant of the blow, relative to the motion of the cluster.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub(super) inverse_mass: f32,
    pub(super) inverse_inertia: Mat3,
    pub(super) mass: f32,
    pub(super) inertia: Mat3,
    pub(super) velocity: Vec3,
    pub(super) angular: Vec3,
    pub(super) displacement: Vec3,
    pub(super) turn: Vec3,
    pub(super) force: Vec3,
    pub(super) torque: Vec3,
}

impl Body {
    /// One that nothing moves.
    pub(super) const FIXED: Self = Self {
        inverse_mass: 0.0,
        inverse_inertia: Mat3::ZERO,
        mass: 0.0,
        inertia: Mat3::ZERO,
        velocity: Vec3::ZERO,
        angular: Vec3::ZERO,
        displacement: Vec3::ZERO,
        turn: Vec3::ZERO,
        force: Vec3::ZERO,
        torque: Vec3::ZERO,
    };

    pub(super) fn of(network: &Network, part: u32, is_held: bool) -> Self {
        if is_held {
            return Self::FIXED;
        }
        let node = &network.nodes[part as usize];
        Self {
            mass: node.mass as f32,
            inertia: node.inertia.as_mat3(),
            inverse_mass: node.mass.recip() as f32,
            inverse_inertia: node.inverse_inertia,
            ..Self::FIXED
        }
    }

    /// Makes it heavier; it keeps its momentum.
    pub(super) fn enlarge(&mut self, factor: f32) {
        self.mass *= factor;
        self.inertia *= factor;
        self.inverse_mass /= factor;
        self.inverse_inertia *= factor.recip();
        self.velocity /= factor;
        self.angular /= factor;
    }

    /// Is pushed.
    pub(super) fn take(&mut self, push: &Push) {
        self.velocity += self.inverse_mass * push.impulse;
        self.angular += self.inverse_inertia * push.angular_impulse;
    }

    /// Symplectic Euler.
    pub(super) fn advance(&mut self, h: f32) {
        self.velocity += h * self.inverse_mass * self.force;
        self.angular += self.inverse_inertia * (h * self.torque);
        self.displacement += h * self.velocity;
        self.turn += h * self.angular;
        (self.force, self.torque) = (Vec3::ZERO, Vec3::ZERO);
    }
}
