//! The motion that connected bodies would have as one rigid body: what joints cannot change where nothing holds them.

use crate::solver::joint::system::{BatchJoint, JointSystem};
use crate::solver::joint::vector6::split;
use glam::{DMat3, DVec3};

/// A motion as one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidMotion {
    /// Center of mass, m.
    center: DVec3,
    /// m/s
    linear: DVec3,
    /// rad/s
    angular: DVec3,
    /// Twice its kinetic energy, J.
    pub(crate) twice_energy: f64,
}

impl RigidMotion {
    /// Velocities of a body with its center of mass there.
    pub(crate) fn at(&self, center: DVec3) -> [DVec3; 2] {
        let arm = center - self.center;
        [self.linear + self.angular.cross(arm), self.angular]
    }
}

impl BatchJoint {
    /// The component of connected bodies that it belongs to.
    pub(crate) fn component(&self) -> u32 {
        self.component
    }
}

impl JointSystem {
    /// Whether a body is of a component.
    pub(crate) fn is_of(&self, body: usize, component: u32) -> bool {
        self.sparsity.components[body] == component
    }

    /// The motion of a component as one, with its momentum and angular momentum; none if something holds it.
    pub(crate) fn free_motion(&self, component: u32) -> Option<RigidMotion> {
        if self.borne.is_held[component as usize] {
            return None;
        }
        let velocities = self.velocities.iter().map(split);
        let bodies = self.bodies.iter().zip(velocities).zip(0..);
        let bodies = bodies.filter(|&(_, at)| self.is_of(at, component));
        let bodies = bodies.map(|(body, _)| body);
        let (mut mass, mut center, mut momentum) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for (body, [linear, _]) in bodies.clone() {
            if body.locks != [DVec3::ZERO; 2] {
                return None;
            }
            mass += body.mass;
            center += body.mass * body.center;
            momentum += body.mass * linear;
        }
        let (center, linear) = (center / mass, momentum / mass);
        let (mut spin, mut inertia) = (DVec3::ZERO, DMat3::ZERO);
        for (body, [v, omega]) in bodies {
            let arm = body.center - center;
            spin += body.mass * arm.cross(v) + body.inertia * omega;
            let [x, y, z] = arm.to_array().map(|along| along * arm);
            let squares = DMat3::from_diagonal(DVec3::splat(arm.length_squared()));
            inertia += body.inertia + (squares - DMat3::from_cols(x, y, z)) * body.mass;
        }
        let angular = inertia.inverse() * spin;
        let motion = RigidMotion {
            center,
            linear,
            angular,
            twice_energy: momentum.dot(linear) + spin.dot(angular),
        };
        motion.twice_energy.is_finite().then_some(motion)
    }
}
