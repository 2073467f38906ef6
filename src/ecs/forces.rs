//! What pushes bodies: forces of a step, forces that last, damping, locked axes, explosions.

use crate::bodies::drive::StepForces;
use crate::bodies::explosion::Explosion;
use crate::bodies::store::Bodies;
use crate::ecs::components::*;
use crate::mass::MassProperties;
use crate::math::rotate;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_math::{Quat, Vec3};
use bevy_transform::components::{GlobalTransform, Transform};

/// How much of [`Gravity`](crate::solver::Gravity) acts on a body: 0 lets it float, -1 lets it rise.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct GravityScale(pub f32);

impl Default for GravityScale {
    /// 1.
    fn default() -> Self {
        Self(1.0)
    }
}

/// Slows a body: `v' = -damping v`, 1/s. 0.1 takes a tenth of the velocity in a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct LinearDamping(pub f32);

/// Slows the turning of a body: `omega' = -damping omega`, 1/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct AngularDamping(pub f32);

/// Limits of a body's speeds, at the end of every sub-step.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct MaxSpeed {
    /// m/s.
    pub linear: f32,
    /// rad/s.
    pub angular: f32,
}

impl Default for MaxSpeed {
    /// No limits.
    fn default() -> Self {
        Self {
            linear: f32::INFINITY,
            angular: f32::INFINITY,
        }
    }
}

/// A force at the center of mass in every step, world axes, N.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ConstantForce(pub Vec3);

/// A torque in every step, world axes, N m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ConstantTorque(pub Vec3);

/// Mass of a body, kg, in place of what follows from its [`Density`](crate::contact::Density): its material is as dense as that
/// takes. Pieces have that density, and no `Mass` of their own.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Mass(pub f32);

impl Default for Mass {
    /// 1 kg.
    fn default() -> Self {
        Self(1.0)
    }
}

/// What [`Forces`] gathered for the next step; part of every body, and of one pointer until something pushes that.
#[derive(Clone, Debug, Default, PartialEq, Component)]
#[component(summary_tick, clone_behavior = Ignore)]
pub struct AppliedForces(Option<Box<Gathered>>);

/// What was applied, in parts that are put together once the center of mass is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Gathered {
    forces: StepForces,
    /// Sum of the forces that act at points, N, and their moment about the origin of the body's frame, N m.
    at_points: [Vec3; 2],
    /// The same of impulses, N s and N m s.
    impulses_at_points: [Vec3; 2],
}

impl AppliedForces {
    /// Where more is added to.
    fn sum(&mut self) -> &mut Gathered {
        self.0.get_or_insert_default()
    }

    /// An impulse, N s, at a point so far from the origin of the body's frame, world axes, m.
    pub(super) fn push_at(&mut self, impulse: Vec3, lever: Vec3) {
        let [sum, moment] = &mut self.sum().impulses_at_points;
        *sum += impulse;
        *moment += lever.cross(impulse);
    }

    /// What there is, if anything; nothing is left. Its place in memory is kept: who is pushed once is pushed again.
    fn take(&mut self) -> Option<Gathered> {
        let gathered = std::mem::take(&mut **self.0.as_mut()?);
        (gathered != Gathered::default()).then_some(gathered)
    }
}

impl Gathered {
    /// All of it about the center of mass of a body with this rotation.
    fn total(&self, mass: &MassProperties, rotation: Quat) -> StepForces {
        let to_center = rotate(rotation, mass.center);
        let about_center = |[sum, moment]: [Vec3; 2]| moment - to_center.cross(sum);
        StepForces {
            force: self.forces.force + self.at_points[0],
            torque: self.forces.torque + about_center(self.at_points),
            impulse: self.forces.impulse + self.impulses_at_points[0],
            angular_impulse: self.forces.angular_impulse + about_center(self.impulses_at_points),
            ..self.forces
        }
    }
}

/// Pushes bodies: query data, `Query<Forces>`.
///
/// What is applied acts in the next step and in no other, however many frames or systems come before it: call it in `FixedUpdate`
/// for a force that lasts, or use [`ConstantForce`]. It acts on dynamic bodies, wakes them if it is not zero, and waits for those
/// that have no body yet. World axes.
#[derive(Debug, QueryData)]
#[query_data(mutable, derive(Debug))]
pub struct Forces {
    transform: &'static Transform,
    global: Option<&'static GlobalTransform>,
    parent: Has<ChildOf>,
    linear: &'static LinearVelocity,
    angular: &'static AngularVelocity,
    mass: &'static MassProperties,
    applied: &'static mut AppliedForces,
}

impl ForcesItem<'_, '_> {
    /// A force at the center of mass, N.
    pub fn apply_force(&mut self, force: Vec3) {
        self.applied.sum().forces.force += force;
    }

    /// A force, N, at a point of the world, m.
    pub fn apply_force_at(&mut self, force: Vec3, point: Vec3) {
        let lever = point - self.origin();
        let [sum, moment] = &mut self.applied.sum().at_points;
        *sum += force;
        *moment += lever.cross(force);
    }

    /// A torque, N m.
    pub fn apply_torque(&mut self, torque: Vec3) {
        self.applied.sum().forces.torque += torque;
    }

    /// An impulse at the center of mass, N s.
    pub fn apply_impulse(&mut self, impulse: Vec3) {
        self.applied.sum().forces.impulse += impulse;
    }

    /// An impulse, N s, at a point of the world, m.
    pub fn apply_impulse_at(&mut self, impulse: Vec3, point: Vec3) {
        let lever = point - self.origin();
        let [sum, moment] = &mut self.applied.sum().impulses_at_points;
        *sum += impulse;
        *moment += lever.cross(impulse);
    }

    /// An angular impulse, N m s.
    pub fn apply_angular_impulse(&mut self, impulse: Vec3) {
        self.applied.sum().forces.angular_impulse += impulse;
    }

    /// An acceleration whatever the mass, m/s2.
    pub fn apply_acceleration(&mut self, acceleration: Vec3) {
        self.applied.sum().forces.acceleration += acceleration;
    }

    /// An angular acceleration whatever the inertia, rad/s2.
    pub fn apply_angular_acceleration(&mut self, acceleration: Vec3) {
        self.applied.sum().forces.angular_acceleration += acceleration;
    }

    /// Velocity of the center of mass after the last step, m/s.
    pub fn linear_velocity(&self) -> Vec3 {
        self.linear.0
    }

    /// Angular velocity after the last step, rad/s.
    pub fn angular_velocity(&self) -> Vec3 {
        self.angular.0
    }

    /// Mass, kg; zero before the first step.
    pub fn mass(&self) -> f32 {
        self.mass.mass
    }

    /// Center of mass, world, m.
    pub fn center_of_mass(&self) -> Vec3 {
        self.origin() + rotate(self.rotation(), self.mass.center)
    }

    /// Velocity of the body's material at a point of the world, m/s.
    pub fn velocity_at(&self, point: Vec3) -> Vec3 {
        let lever = point - self.center_of_mass();
        self.linear.0 + self.angular.0.cross(lever)
    }

    /// Where the body's frame is in the world.
    fn origin(&self) -> Vec3 {
        match self.global.filter(|_| self.parent) {
            Some(global) => global.translation(),
            None => self.transform.translation,
        }
    }

    fn rotation(&self) -> Quat {
        match self.global.filter(|_| self.parent) {
            Some(global) => global.rotation(),
            None => self.transform.rotation,
        }
    }
}

/// Pushing on request.
pub trait ForceCommands {
    /// Lets a blast act at the start of the next step. One that has a number that is not finite, or no radius, is logged and does
    /// nothing.
    fn explode(&mut self, explosion: Explosion);
}

impl ForceCommands for Commands<'_, '_> {
    fn explode(&mut self, explosion: Explosion) {
        self.queue(move |world: &mut World| {
            let Some(mut bodies) = world.get_resource_mut::<Bodies>() else {
                return;
            };
            if bodies.explode(explosion).is_err() {
                log::warn!("an explosion with unusable numbers does nothing: {explosion:?}");
            }
        });
    }
}

/// What forces are read from.
pub(crate) type ForceQuery<'w, 's> = Query<
    'w,
    's,
    (Entity, &'static BodyHandle, &'static mut AppliedForces),
    Changed<AppliedForces>,
>;

/// Lets what was gathered act, once masses are known.
pub(crate) fn apply_forces(
    bodies: &mut Bodies,
    warnings: &mut Messages<BodyWarning>,
    forces: &mut ForceQuery,
) {
    for (entity, handle, mut applied) in forces {
        let Some((slot, _)) = handle.0.filter(|&(slot, id)| bodies.is_current(slot, id)) else {
            continue;
        };
        // The plugin's own taking is no change.
        let Some(gathered) = applied.bypass_change_detection().take() else {
            continue;
        };
        let total = gathered.total(bodies.mass(slot), bodies.pose(slot).rotation);
        if let Err(error) = bodies.apply(slot, &total) {
            warn(warnings, entity, error);
        }
    }
}
