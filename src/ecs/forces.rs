//! What pushes bodies: forces of a step, forces that last, damping, locked axes, explosions.
//!
//! All of it is for dynamic bodies. On others, what would push all the time is an issue of the entity; what bounds a motion
//! ([`GravityScale`], damping, [`MaxSpeed`], locked axes) is kept to by what does not move, and waits until the body is dynamic.

use crate::bodies::body::BodyError;
use crate::bodies::drive::StepForces;
use crate::bodies::explosion::Explosion;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::components::*;
use crate::mass::MassProperties;
use crate::math::rotate;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::{Allow, QueryData};
use bevy_math::{Quat, Vec3};
use bevy_transform::components::{GlobalTransform, Transform};

/// How much of [`Gravity`](crate::solver::Gravity) acts on a dynamic body: 0 lets it float, -1 lets it rise. And on what stands and is
/// built of bonded parts: so much their bonds bear.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct GravityScale(pub f32);

impl Default for GravityScale {
    /// 1.
    fn default() -> Self {
        Self(1.0)
    }
}

/// Slows a dynamic body: `v' = -damping v`, 1/s. 0.1 takes a tenth of the velocity in a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct LinearDamping(pub f32);

/// Slows the turning of a dynamic body: `omega' = -damping omega`, 1/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct AngularDamping(pub f32);

/// Limits of a dynamic body's speeds, at the end of every sub-step.
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

/// How fast the surface of a body runs along itself, in its own axes, m/s: a conveyor belt, a moving walkway, tracks. Friction takes what
/// touches it to what of that velocity is along the face there, and a [`Walker`](crate::ecs::Walker) who stands on it goes along; the body
/// itself stays where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct SurfaceVelocity(pub Vec3);

/// A force at the center of mass in every step, world axes, N. On a body that is not dynamic it is an issue
/// ([`BodyError::IdleForce`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ConstantForce(pub Vec3);

/// A torque in every step, world axes, N m. On a body that is not dynamic it is an issue ([`BodyError::IdleForce`]).
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
#[derive(Clone, Debug, Default, PartialEq)]
struct Gathered {
    forces: StepForces,
    at_points: Vec<PointForce>,
}

/// What acts at a point of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PointForce {
    /// World, m: where the body is, the step knows, and not who draws it between two of them.
    point: Vec3,
    /// N.
    force: Vec3,
    /// N s.
    impulse: Vec3,
}

impl AppliedForces {
    /// Where more is added to.
    fn sum(&mut self) -> &mut Gathered {
        self.0.get_or_insert_default()
    }

    /// A force, N, and an impulse, N s, at a point of the world, m.
    pub(super) fn act_at(&mut self, point: Vec3, [force, impulse]: [Vec3; 2]) {
        self.sum().at_points.push(PointForce {
            point,
            force,
            impulse,
        });
    }

    /// What there is, if anything.
    fn get(&self) -> Option<&Gathered> {
        let gathered = self.0.as_deref();
        gathered.filter(|it| !it.at_points.is_empty() || it.forces != StepForces::default())
    }

    /// Forgets all but impulses: nobody was there for the step through which the rest acts. Whether there are any.
    fn keep_impulses(&mut self) -> bool {
        if let Some(gathered) = self.0.as_deref_mut() {
            gathered.forces = StepForces {
                impulse: gathered.forces.impulse,
                angular_impulse: gathered.forces.angular_impulse,
                ..StepForces::default()
            };
            (gathered.at_points.iter_mut()).for_each(|point| point.force = Vec3::ZERO);
            (gathered.at_points).retain(|point| point.impulse != Vec3::ZERO);
        }
        self.get().is_some()
    }

    /// Forgets it. Its place in memory is kept: who is pushed once is pushed again.
    fn clear(&mut self) {
        if let Some(gathered) = self.0.as_deref_mut() {
            gathered.forces = StepForces::default();
            gathered.at_points.clear();
        }
    }
}

impl Gathered {
    /// All of it about the center of mass (world, m).
    fn total(&self, center: Vec3) -> StepForces {
        // Sum, and moment about the center.
        let sum = |part: fn(&PointForce) -> Vec3| {
            let (mut sum, mut moment) = (Vec3::ZERO, Vec3::ZERO);
            for at in &self.at_points {
                sum += part(at);
                moment += (at.point - center).cross(part(at));
            }
            (sum, moment)
        };
        let (force, torque) = sum(|point| point.force);
        let (impulse, angular_impulse) = sum(|point| point.impulse);
        StepForces {
            force: self.forces.force + force,
            torque: self.forces.torque + torque,
            impulse: self.forces.impulse + impulse,
            angular_impulse: self.forces.angular_impulse + angular_impulse,
            ..self.forces
        }
    }
}

/// Pushes bodies: query data, `Query<Forces>`.
///
/// What is applied acts in the next step and in no other, however many frames or systems come before it: call it in `FixedUpdate`
/// for a force that lasts, or use [`ConstantForce`]. It acts on dynamic bodies and wakes them if it is not zero. An impulse waits for
/// those that have no body yet, or are disabled; a force is over with the step. World axes. Points are where [`SpatialQuery`] sees them:
/// on the body as the last step left it, however it is drawn.
///
/// [`SpatialQuery`]: crate::ecs::SpatialQuery
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

    /// A force, N, at a point of the world, m. Of a body whose parts bonds hold it loads the part that is there, see [`Bodies::apply_at`].
    pub fn apply_force_at(&mut self, force: Vec3, point: Vec3) {
        self.applied.act_at(point, [force, Vec3::ZERO]);
    }

    /// A torque, N m.
    pub fn apply_torque(&mut self, torque: Vec3) {
        self.applied.sum().forces.torque += torque;
    }

    /// An impulse at the center of mass, N s.
    pub fn apply_impulse(&mut self, impulse: Vec3) {
        self.applied.sum().forces.impulse += impulse;
    }

    /// An impulse, N s, at a point of the world, m. Of a body whose parts bonds hold it hits the part that is there, see [`Bodies::apply_at`].
    pub fn apply_impulse_at(&mut self, impulse: Vec3, point: Vec3) {
        self.applied.act_at(point, [Vec3::ZERO, impulse]);
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
pub(crate) type ForceQuery<'w, 's> = Query<'w, 's, Pushed, Allow<Disabled>>;

type Pushed = (Entity, &'static BodyHandle, &'static mut AppliedForces);

/// Lets what was gathered act on a body: of a cluster on its parts.
fn apply(bodies: &mut Bodies, slot: u32, gathered: &Gathered) -> Result<(), BodyError> {
    if gathered.at_points.is_empty() || bodies.cluster(slot).is_none() {
        let total = gathered.total(bodies.center_of_mass(slot));
        return bodies.apply(slot, &total);
    }
    for at in &gathered.at_points {
        bodies.apply_at(slot, at.point, [at.force, at.impulse])?;
    }
    bodies.apply(slot, &gathered.forces)
}

/// Lets what was gathered act, once masses are known: of entities that were pushed since the last step, and of those that
/// `wait`, which are then those that still do.
pub(crate) fn apply_forces(
    bodies: &mut Bodies,
    warnings: &mut Messages<BodyWarning>,
    forces: &mut ForceQuery,
    wait: &mut Vec<Entity>,
) {
    let before = std::mem::take(wait);
    let mut take = |entity: Entity, handle: &BodyHandle, applied: &mut AppliedForces| {
        let is_there =
            |&(slot, id): &(u32, BodyId)| bodies.is_current(slot, id) && bodies.is_active(slot);
        let Some((slot, _)) = handle.0.filter(is_there) else {
            if applied.keep_impulses() {
                wait.push(entity);
            }
            return;
        };
        let Some(gathered) = applied.get() else {
            return;
        };
        if let Err(error) = apply(bodies, slot, gathered) {
            warn(warnings, entity, error);
        }
        applied.clear();
    };
    // The plugin's own taking is no change.
    for (entity, handle, mut applied) in forces.iter_mut() {
        if applied.is_changed() {
            take(entity, handle, applied.bypass_change_detection());
        }
    }
    for entity in before {
        if let Ok((_, handle, mut applied)) = forces.get_mut(entity)
            && !applied.is_changed()
        {
            take(entity, handle, applied.bypass_change_detection());
        }
    }
}
