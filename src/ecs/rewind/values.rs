//! Values of components, kept and put back.

use crate::bodies::anchors::Anchors;
use crate::bodies::body::RigidBody;
use crate::bodies::drive::LockedAxes;
use crate::bodies::fatigue::Fatigue;
use crate::contact::layers::CollisionLayers;
use crate::contact::material::{Density, Friction, Restitution};
use crate::contact::surface::SurfaceMaterials;
use crate::ecs::collisions::{CollisionEvents, ContactForceEvents, Sensor};
use crate::ecs::components::*;
use crate::ecs::forces::*;
use crate::ecs::issues::BodyIssues;
use crate::ecs::joint::{JointA, JointB, JointHandle, JointProblem};
use crate::ecs::parts::CompoundOfChildren;
use crate::ecs::pieces::PieceOf;
use crate::ecs::set_aside::SetAside;
use crate::ecs::shape_constructor::{CompoundConstructor, LevelConstructor, ShapeConstructor};
use crate::ecs::walker::{Walker, Walking};
use crate::geometry::{Compound, ConvexMesh, HalfSpaceShape, StaticMesh};
use crate::joints::{Joint, JointLoad};
use crate::mass::MassProperties;
use crate::slice::fracturable::Fracturable;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::{Allow, QueryFilter, QueryState};
use bevy_ecs::relationship::Relationship;
use bevy_transform::components::Transform;

/// Entities of bodies and joints.
pub(super) type HasPhysics = Or<(With<BodyHandle>, With<JointHandle>)>;

/// Those of them that are no part of what was set aside, whether they are disabled or not.
pub(super) type InPhysics = There<HasPhysics>;

/// The values that a component has.
pub(super) trait Values: Send + Sync {
    /// Copies them.
    fn keep(&mut self, world: &mut World) -> Box<dyn Kept>;
}

/// Those that it had.
pub(super) trait Kept: Send + Sync {
    /// Puts them back.
    fn restore(&self, world: &mut World);

    /// Takes what they have now from those of `tracked` that had none: after all values are back, with which others come by default.
    fn remove_new(&self, world: &mut World, tracked: &EntityHashSet);
}

/// Those that pass `F`.
type There<F> = (F, Without<SetAside>, Allow<Disabled>);

/// Values of `C` on entities that pass `F`.
pub(super) struct ValuesOf<C: Component, F: QueryFilter>(
    Option<QueryState<(Entity, &'static C), There<F>>>,
);

impl<C: Component + Clone, F: QueryFilter + Send + Sync + 'static> ValuesOf<C, F> {
    pub(super) fn boxed() -> Box<dyn Values> {
        Box::new(Self(None))
    }
}

impl<C: Component + Clone, F: QueryFilter + Send + Sync + 'static> Values for ValuesOf<C, F> {
    fn keep(&mut self, world: &mut World) -> Box<dyn Kept> {
        let query = self.0.get_or_insert_with(|| QueryState::new(world));
        let values = query
            .iter(world)
            .map(|(entity, value)| (entity, value.clone()));
        Box::new(KeptValues(values.collect()))
    }
}

struct KeptValues<C>(Vec<(Entity, C)>);

/// Who `R` relates entities to.
pub(super) struct Relations<R: Component>(Option<QueryState<(Entity, &'static R), InPhysics>>);

struct KeptRelations<R>(Vec<(Entity, R)>);

impl<R: Relationship + Clone + PartialEq> Values for Relations<R> {
    fn keep(&mut self, world: &mut World) -> Box<dyn Kept> {
        let query = self.0.get_or_insert_with(|| QueryState::new(world));
        let relations = query.iter(world).map(|(entity, it)| (entity, it.clone()));
        Box::new(KeptRelations(relations.collect()))
    }
}

impl<R: Relationship + Clone + PartialEq> Kept for KeptRelations<R> {
    fn restore(&self, world: &mut World) {
        for (entity, relation) in &self.0 {
            // One that is no more has taken its relations with it.
            if world.get_entity(relation.get()).is_err() {
                continue;
            }
            if let Ok(mut entity) = world.get_entity_mut(*entity)
                && entity.get::<R>() != Some(relation)
            {
                entity.insert(relation.clone());
            }
        }
    }

    fn remove_new(&self, world: &mut World, tracked: &EntityHashSet) {
        remove_new(&self.0, world, tracked);
    }
}

/// Takes `C` from those of `tracked` that had none.
fn remove_new<C: Component>(had: &[(Entity, C)], world: &mut World, tracked: &EntityHashSet) {
    let had: EntityHashSet = had.iter().map(|&(entity, _)| entity).collect();
    let mut now = world.query_filtered::<Entity, (With<C>, Allow<Disabled>)>();
    let new = |entity: &Entity| tracked.contains(entity) && !had.contains(entity);
    let new: Vec<Entity> = now.iter(world).filter(new).collect();
    for entity in new {
        // An observer of the app may have despawned it.
        if let Ok(mut entity) = world.get_entity_mut(entity) {
            entity.remove::<C>();
        }
    }
}

impl<C: Component + Clone> Kept for KeptValues<C> {
    fn restore(&self, world: &mut World) {
        for (entity, value) in &self.0 {
            if let Ok(mut entity) = world.get_entity_mut(*entity) {
                entity.insert(value.clone());
            }
        }
    }

    fn remove_new(&self, world: &mut World, tracked: &EntityHashSet) {
        remove_new(&self.0, world, tracked);
    }
}

/// All that the plugin reads of the entities of bodies and joints, or writes to them.
pub(super) fn physics_values() -> Vec<Box<dyn Values>> {
    macro_rules! values {
        ($($component:ty),* $(,)?) => {
            [$(ValuesOf::<$component, HasPhysics>::boxed()),*]
        };
    }
    let values = values![
        // First who it is, with which the rest comes by default.
        BodyHandle,
        JointHandle,
        Disabled,
        Transform,
        ShapeAwaited,
        ShapeConstructor,
        CompoundConstructor,
        CompoundOfChildren,
        LevelConstructor,
        ConvexMesh,
        Compound,
        HalfSpaceShape,
        StaticMesh,
        RigidBody,
        LinearVelocity,
        AngularVelocity,
        Density,
        Mass,
        MassOverride,
        MassProperties,
        Friction,
        Restitution,
        SurfaceMaterials,
        CollisionLayers,
        Fracturable,
        Fatigue,
        Anchors,
        Sensor,
        CollisionEvents,
        ContactForceEvents,
        AppliedForces,
        ConstantForce,
        ConstantTorque,
        SurfaceVelocity,
        GravityScale,
        LinearDamping,
        AngularDamping,
        MaxSpeed,
        LockedAxes,
        Walker,
        Walking,
        Fading,
        Joint,
        JointLoad,
        JointProblem,
        BodyIssues,
        Sleeping,
    ];
    relations().into_iter().chain(values).collect()
}

/// Who bodies and joints are related to.
fn relations() -> [Box<dyn Values>; 4] {
    [
        Box::new(Relations::<ChildOf>(None)),
        Box::new(Relations::<PieceOf>(None)),
        Box::new(Relations::<JointA>(None)),
        Box::new(Relations::<JointB>(None)),
    ]
}
