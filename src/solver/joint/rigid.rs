//! The motion that connected bodies would have as one rigid body: what joints cannot change where nothing holds them.

use crate::solver::joint::body::JointedBody;
use crate::solver::joint::system::{BatchJoint, JointSystem};
use crate::solver::joint::vector6::{Vector6, split};
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
        let frozen = self.freeze(component)?;
        let (mut momentum, mut spin) = (DVec3::ZERO, DVec3::ZERO);
        for (body, velocity) in self.bodies_of(component) {
            let [v, omega] = split(velocity);
            momentum += body.mass * v;
            spin += body.mass * (body.center - frozen.center).cross(v) + body.inertia * omega;
        }
        frozen.moving(momentum, spin)
    }

    /// The turn of a component as one with an angular momentum, N m s; none if something holds it.
    pub(crate) fn free_turn(&self, component: u32, spin: DVec3) -> Option<RigidMotion> {
        self.freeze(component)?.moving(DVec3::ZERO, spin)
    }

    fn bodies_of(&self, component: u32) -> impl Iterator<Item = (&JointedBody, &Vector6)> {
        let bodies = self.bodies.iter().zip(&self.velocities).zip(0..);
        let own = bodies.filter(move |&(_, at)| self.is_of(at, component));
        own.map(|(body, _)| body)
    }

    /// A component as one body; none if something holds it.
    fn freeze(&self, component: u32) -> Option<Frozen> {
        let mut bodies = self.bodies_of(component).map(|(body, _)| body);
        let is_locked = |body: &JointedBody| body.locks != [DVec3::ZERO; 2];
        if self.borne.is_held[component as usize] || bodies.any(is_locked) {
            return None;
        }
        let (mut mass, mut center) = (0.0, DVec3::ZERO);
        for (body, _) in self.bodies_of(component) {
            mass += body.mass;
            center += body.mass * body.center;
        }
        center /= mass;
        let mut inertia = DMat3::ZERO;
        for (body, _) in self.bodies_of(component) {
            let arm = body.center - center;
            let [x, y, z] = arm.to_array().map(|along| along * arm);
            let squares = DMat3::from_diagonal(DVec3::splat(arm.length_squared()));
            inertia += body.inertia + (squares - DMat3::from_cols(x, y, z)) * body.mass;
        }
        Some(Frozen {
            mass,
            center,
            inertia,
        })
    }
}

/// Connected bodies as one.
struct Frozen {
    /// kg
    mass: f64,
    /// Center of mass, m.
    center: DVec3,
    /// kg m2, world axes.
    inertia: DMat3,
}

impl Frozen {
    /// Its motion with a momentum, N s, and an angular momentum about its center, N m s.
    fn moving(&self, momentum: DVec3, spin: DVec3) -> Option<RigidMotion> {
        let (linear, angular) = (momentum / self.mass, self.inertia.inverse() * spin);
        let motion = RigidMotion {
            center: self.center,
            linear,
            angular,
            twice_energy: momentum.dot(linear) + spin.dot(angular),
        };
        motion.twice_energy.is_finite().then_some(motion)
    }
}
