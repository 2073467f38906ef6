//! What moves a body besides gravity and contacts, or keeps it from moving: forces, damping, limits of speed, locked axes.
//!
//! Few bodies have any, so they are a list of their own; the others are asked for none of it.

use crate::bodies::body::BodyError;
use crate::contact::body_id::BodyId;
use bevy_ecs::component::Component;
use glam::{Mat3, Vec3};
use std::ops::BitOr;

/// Marks a slot without a drive.
const NONE: u32 = u32::MAX;

/// Axes of the world along which a body does not move, and about which it does not turn: a game in a plane, a figure that stays
/// upright.
///
/// Turns are locked exactly: the body has no end of inertia about these axes, and contacts know. Of a way that is locked the
/// velocity is taken out after contacts have acted in each sub-step, so what hits the body along it finds it softer than a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct LockedAxes(u8);

impl LockedAxes {
    /// None.
    pub const NONE: Self = Self(0);
    /// No way along x.
    pub const TRANSLATION_X: Self = Self(1);
    /// No way along y.
    pub const TRANSLATION_Y: Self = Self(2);
    /// No way along z.
    pub const TRANSLATION_Z: Self = Self(4);
    /// No way at all.
    pub const TRANSLATION: Self = Self(7);
    /// No turn about x.
    pub const ROTATION_X: Self = Self(8);
    /// No turn about y.
    pub const ROTATION_Y: Self = Self(16);
    /// No turn about z.
    pub const ROTATION_Z: Self = Self(32);
    /// No turn at all.
    pub const ROTATION: Self = Self(56);
    /// Moves in the xy plane only, and turns about z.
    pub const PLANE_XY: Self = Self(4 | 8 | 16);

    /// These and those.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all of `axes` are locked.
    pub const fn contains(self, axes: Self) -> bool {
        self.0 & axes.0 == axes.0
    }

    /// One for each axis along which the body may move, zero for the others.
    pub(super) fn free_ways(self) -> Vec3 {
        self.free(0)
    }

    /// The same of turns.
    pub(super) fn free_turns(self) -> Vec3 {
        self.free(3)
    }

    fn free(self, first: u8) -> Vec3 {
        let is_free = |axis: u8| f32::from(self.0 & (1 << (first + axis)) == 0);
        Vec3::new(is_free(0), is_free(1), is_free(2))
    }
}

impl BitOr for LockedAxes {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        self.and(other)
    }
}

/// What moves a dynamic body besides gravity and contacts, and how the surface of any body runs, until it is changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyDrive {
    /// How much of gravity acts on it; of what stands, on the parts that bonds hold.
    pub gravity_scale: f32,
    /// Share of its velocity that it loses in a second, for small shares, 1/s.
    pub linear_damping: f32,
    /// The same of its angular velocity, 1/s.
    pub angular_damping: f32,
    /// Largest speed, m/s.
    pub max_speed: f32,
    /// Largest angular speed, rad/s.
    pub max_angular_speed: f32,
    /// Axes that it does not move along or turn about.
    pub locked: LockedAxes,
    /// Force at the center of mass, world axes, N.
    pub force: Vec3,
    /// Torque, world axes, N m.
    pub torque: Vec3,
    /// How fast its surface runs along itself, in the axes of its shape, m/s: friction takes what touches it to this velocity, less what of it
    /// is along the normal. Not where the two are bonded.
    pub surface_velocity: Vec3,
}

impl Default for BodyDrive {
    /// None of it.
    fn default() -> Self {
        Self {
            gravity_scale: 1.0,
            linear_damping: 0.0,
            angular_damping: 0.0,
            max_speed: f32::INFINITY,
            max_angular_speed: f32::INFINITY,
            locked: LockedAxes::NONE,
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
            surface_velocity: Vec3::ZERO,
        }
    }
}

impl BodyDrive {
    /// What pieces of the body have of it: a force on a body ends with it, or each of its pieces would get all of it, and what is broken
    /// does not run.
    pub(crate) fn of_pieces(self) -> Self {
        Self {
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
            surface_velocity: Vec3::ZERO,
            ..self
        }
    }

    /// Whether all numbers mean something.
    ///
    /// # Errors
    /// [`BodyError::Drive`] with the name of what does not.
    pub fn validate(&self) -> Result<(), BodyError> {
        let at_least_zero = |value: f32| value.is_finite() && value >= 0.0;
        let checks = [
            ("GravityScale", self.gravity_scale.is_finite()),
            ("LinearDamping", at_least_zero(self.linear_damping)),
            ("AngularDamping", at_least_zero(self.angular_damping)),
            (
                "MaxSpeed",
                self.max_speed >= 0.0 && self.max_angular_speed >= 0.0,
            ),
            ("ConstantForce", self.force.is_finite()),
            ("ConstantTorque", self.torque.is_finite()),
            ("SurfaceVelocity", self.surface_velocity.is_finite()),
        ];
        match checks.iter().find(|(_, is_usable)| !is_usable) {
            Some((name, _)) => Err(BodyError::Drive(name)),
            None => Ok(()),
        }
    }
}

/// Forces of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepForces {
    /// N, at the center of mass, world axes.
    pub force: Vec3,
    /// N m.
    pub torque: Vec3,
    /// N s, at the center of mass, at the start of the step.
    pub impulse: Vec3,
    /// N m s.
    pub angular_impulse: Vec3,
    /// m/s2.
    pub acceleration: Vec3,
    /// rad/s2.
    pub angular_acceleration: Vec3,
}

impl StepForces {
    pub(super) fn is_finite(&self) -> bool {
        let parts = [
            self.force,
            self.torque,
            self.impulse,
            self.angular_impulse,
            self.acceleration,
            self.angular_acceleration,
        ];
        parts.iter().all(|part| part.is_finite())
    }
}

/// A body that is driven.
#[derive(Clone, Copy, Debug)]
pub(super) struct Driven {
    slot: u32,
    pub(super) id: BodyId,
    pub(super) drive: BodyDrive,
    /// Of this step only.
    pub(super) acceleration: Vec3,
    pub(super) angular_acceleration: Vec3,
}

/// The bodies that are driven.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drives {
    list: Vec<Driven>,
    /// By slot: index in the list.
    index: Vec<u32>,
    /// Whether there ever was a surface that runs.
    pub(super) has_surfaces: bool,
}

impl Drives {
    /// Whether nothing is.
    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    pub(super) fn get(&self, slot: u32) -> Option<&Driven> {
        let index = self.index.get(slot as usize).filter(|_| !self.is_empty())?;
        self.list.get(*index as usize)
    }

    /// The body in `slot`, driven by nothing yet if it was not among them.
    pub(super) fn of(&mut self, slot: u32, id: BodyId) -> &mut Driven {
        let i = slot as usize;
        if self.index.len() <= i {
            self.index.resize(i + 1, NONE);
        }
        if self.index[i] == NONE {
            self.index[i] = self.list.len() as u32;
            self.list.push(Driven {
                slot,
                id,
                drive: BodyDrive::default(),
                acceleration: Vec3::ZERO,
                angular_acceleration: Vec3::ZERO,
            });
        }
        &mut self.list[self.index[i] as usize]
    }

    /// Forgets the body in `slot`.
    pub(super) fn remove(&mut self, slot: u32) {
        if let Some(&index) = self.index.get(slot as usize)
            && index != NONE
        {
            self.list.swap_remove(index as usize);
            self.index[slot as usize] = NONE;
            if let Some(moved) = self.list.get(index as usize) {
                self.index[moved.slot as usize] = index;
            }
        }
    }

    /// Ends the forces of the step, and forgets who was driven by nothing else; the others' slots.
    pub(super) fn end_step(&mut self) -> impl Iterator<Item = u32> + use<'_> {
        let mut at = 0;
        while let Some(driven) = self.list.get_mut(at) {
            (driven.acceleration, driven.angular_acceleration) = (Vec3::ZERO, Vec3::ZERO);
            if driven.drive == BodyDrive::default() {
                let slot = driven.slot;
                self.remove(slot);
            } else {
                at += 1;
            }
        }
        self.list.iter().map(|driven| driven.slot)
    }

    /// Whether the body in `slot` does not turn freely.
    pub(crate) fn has_locked_turns(&self, slot: u32) -> bool {
        let locked = self
            .get(slot)
            .map_or(LockedAxes::NONE, |driven| driven.drive.locked);
        locked.free_turns() != Vec3::ONE
    }

    /// Inverse inertia about the axes that a body may turn about: the inverse of that part of its inertia.
    pub(crate) fn locked_inertia(&self, slot: u32, inverse: Mat3) -> Mat3 {
        if self.is_empty() || !self.has_locked_turns(slot) {
            return inverse;
        }
        let free = self
            .get(slot)
            .map_or(Vec3::ONE, |driven| driven.drive.locked.free_turns());
        let locks = Mat3::from_diagonal(Vec3::ONE - free);
        let keeps = Mat3::from_diagonal(free);
        // The inertia with ones in place of what is locked has that part's inverse where it is free.
        let inertia = keeps * inverse.inverse() * keeps + locks;
        keeps * inertia.inverse() * keeps
    }
}

/// How one body is driven within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drive {
    /// Besides gravity, m/s2 and rad/s2.
    pub(crate) acceleration: Vec3,
    pub(crate) angular_acceleration: Vec3,
    pub(super) damping: [f32; 2],
    pub(super) most: [f32; 2],
    pub(super) free: [Vec3; 2],
}

impl Drive {
    /// Nothing.
    pub(crate) const NONE: Self = Self {
        acceleration: Vec3::ZERO,
        angular_acceleration: Vec3::ZERO,
        damping: [0.0; 2],
        most: [f32::INFINITY; 2],
        free: [Vec3::ONE; 2],
    };

    /// The same forces, weight among them, on a body with so many times the inverse mass and inertia.
    pub(crate) fn scale_inverse_mass(&mut self, scale: f32, gravity: Vec3) {
        self.acceleration = scale * (gravity + self.acceleration) - gravity;
        self.angular_acceleration *= scale;
    }

    /// The velocities (m/s, rad/s) after `h` seconds; gravity is not among it.
    pub(crate) fn advance(&self, linear: &mut Vec3, angular: &mut Vec3, h: f32) {
        *linear = (*linear + h * self.acceleration) / (1.0 + h * self.damping[0]);
        *angular = (*angular + h * self.angular_acceleration) / (1.0 + h * self.damping[1]);
    }

    /// Keeps velocities within what is free and the limits.
    pub(crate) fn restrain(&self, linear: &mut Vec3, angular: &mut Vec3) {
        for (v, (free, most)) in [linear, angular]
            .into_iter()
            .zip(self.free.iter().zip(self.most))
        {
            *v *= *free;
            if v.length_squared() > most * most {
                *v *= most / v.length();
            }
        }
    }
}
