//! How heavy bodies are, and what follows from it: inertia and energy.

use crate::bodies::body::{RigidBody, Shape};
use crate::bodies::store::Bodies;
use crate::mass::{MassError, MassProperties};
use crate::math::rotate;
use glam::{Mat3, Quat, Vec3};

impl Bodies {
    /// Mass properties in the body's frame; zero mass for half-spaces, and before the first mass phase: each step begins with one, and
    /// `step::mass_properties` is one for whoever must know before.
    #[inline]
    pub fn mass(&self, slot: u32) -> &MassProperties {
        &self.mass[slot as usize]
    }

    /// Density of the body, kg/m3.
    pub fn density(&self, slot: u32) -> f32 {
        self.info(slot).density
    }

    /// Kinetic energy of a dynamic body, J.
    pub fn kinetic_energy(&self, slot: u32) -> f64 {
        self.kinetic_energy_at(slot, self.rotation[slot as usize])
    }

    /// Kinetic energy of a dynamic body if its rotation were `rotation`, J.
    fn kinetic_energy_at(&self, slot: u32, rotation: Quat) -> f64 {
        let (v, omega) = self.velocity(slot);
        let m = self.mass(slot);
        let spin = rotate((rotation * m.principal_frame).inverse(), omega);
        0.5 * (f64::from(m.mass) * f64::from(v.length_squared())
            + f64::from((m.principal * spin).dot(spin)))
    }

    /// Kinetic and potential energy (zero at the origin) of all dynamic bodies under `gravity` (m/s2), J: where they are, or
    /// where the solver has moved them.
    pub(crate) fn energy(&self, gravity: Vec3, after_motion: bool) -> [f64; 2] {
        let dynamic = |&slot: &u32| self.is_active(slot) && self.kind(slot) == RigidBody::Dynamic;
        let mut energy = [0.0; 2];
        for slot in self.iter().filter(dynamic) {
            let i = slot as usize;
            let (center, rotation) = if after_motion {
                (
                    self.center[i] + self.motion[i].shift,
                    self.motion[i].rotation,
                )
            } else {
                (self.center[i], self.rotation[i])
            };
            let weight = f64::from(self.mass(slot).mass) * gravity.as_dvec3();
            energy[0] += self.kinetic_energy_at(slot, rotation);
            energy[1] -= weight.dot(center.as_dvec3());
        }
        energy
    }

    /// Whether the body's mass was given instead of computed.
    pub fn has_mass_override(&self, slot: u32) -> bool {
        self.info(slot).mass_override.is_some()
    }

    /// Recomputes the mass properties of one body, keeping its frame where it is.
    pub(crate) fn refresh_mass(&mut self, slot: u32) -> Result<(), MassError> {
        let i = slot as usize;
        let pose = self.pose(slot);
        let info = self.info(slot);
        let kind = info.kind;
        self.mass[i] = match (&info.shape, info.mass_override) {
            (Shape::HalfSpace(_) | Shape::Level(_), _) => MassProperties::default(),
            (Shape::Convex(_) | Shape::Compound(_), Some(given)) => given,
            (Shape::Compound(compound), None) => {
                MassProperties::of_compound(compound, info.density)?
            }
            (Shape::Convex(mesh), None) => MassProperties::of_shape(mesh, info.density)?,
        };
        let movable = kind == RigidBody::Dynamic;
        self.velocity[i].inverse_mass = if movable {
            1.0 / self.mass[i].mass
        } else {
            0.0
        };
        if kind == RigidBody::Static {
            self.halt(slot);
        }
        self.radius[i] = self.radius_about(slot, self.mass[i].center);
        self.renew_version(slot);
        self.place(slot, pose);
        self.refresh_world(slot);
        self.fresh_mass.push(slot);
        if self.any_compound {
            self.renew_cluster(slot)?;
        }
        Ok(())
    }

    /// Largest distance of the body's hull from its center of mass, m; 0 for half-spaces, and until the mass phase has seen its shape.
    #[inline]
    pub(crate) fn radius(&self, slot: u32) -> f32 {
        self.radius[slot as usize]
    }

    /// Whether the body's surface is curved.
    #[inline]
    pub(crate) fn is_round(&self, slot: u32) -> bool {
        self.any_round && self.info(slot).shape.is_round()
    }

    fn radius_about(&self, slot: u32, center: Vec3) -> f32 {
        match &self.info(slot).shape {
            Shape::Level(mesh) => mesh.radius() + center.length(),
            Shape::Convex(mesh) => mesh.farthest_from(center),
            Shape::Compound(compound) => compound.farthest_from(center),
            Shape::HalfSpace(_) => 0.0,
        }
    }

    /// Recomputes what follows from the pose: inverse inertia.
    pub(crate) fn refresh_world(&mut self, slot: u32) {
        let i = slot as usize;
        if self.velocity[i].inverse_mass > 0.0 {
            let free = inverse_inertia(&self.mass[i], self.rotation[i]);
            self.inverse_inertia[i] = self.drives.locked_inertia(slot, free);
        }
    }
}

/// Inverse inertia tensor about the center of mass, world axes, 1/(kg m2).
pub(crate) fn inverse_inertia(mass: &MassProperties, rotation: Quat) -> Mat3 {
    let r = Mat3::from_quat(rotation * mass.principal_frame);
    let Vec3 { x, y, z } = mass.principal.recip();
    Mat3::from_cols(r.x_axis * x, r.y_axis * y, r.z_axis * z) * r.transpose()
}
