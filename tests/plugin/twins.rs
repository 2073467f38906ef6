//! Random worlds as they stand: who is there, what they say, and the same entities made afresh in another app.

use crate::app::app;
use crate::random_world::{Deed, RandomWorld, story};
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;
use std::collections::BTreeSet;
use std::ops::Range;

/// What must hold of every story.
pub(crate) type Law = fn(&[Deed]) -> Result<(), String>;

/// Holds random stories of so many deeds against a law.
pub(crate) fn check(law: Law, deeds: usize, seeds: Range<u64>) {
    for seed in seeds {
        if let Err(error) = law(&story(seed, deeds)) {
            panic!("seed {seed}: {error}");
        }
    }
}

/// What is wrong with an entity, without numbers: rounding is another matter.
pub(crate) fn texts(world: &World, entity: Entity) -> BTreeSet<String> {
    let issues = world.get::<BodyIssues>(entity);
    issues
        .into_iter()
        .flat_map(|issues| issues.iter().map(ToString::to_string))
        .map(|text| text.split('[').next().unwrap_or_default().to_string())
        .collect()
}

/// Those of all that ever were that are there.
pub(crate) fn alive(scene: &RandomWorld) -> Vec<Entity> {
    let mut alive = scene.everyone.clone();
    alive.sort_unstable();
    alive.dedup();
    alive.retain(|&entity| scene.app.world().get_entity(entity).is_ok());
    alive
}

/// The body of an entity.
pub(crate) fn body_of(world: &World, entity: Entity) -> Option<u32> {
    Some(world.get::<BodyHandle>(entity)?.get()?.0)
}

/// Where the body of an entity is.
pub(crate) fn place_of(world: &World, entity: Entity) -> Option<Vec3> {
    let slot = body_of(world, entity)?;
    Some(world.resource::<Bodies>().pose(slot).position)
}

/// Gives an entity what it has of these components.
macro_rules! copy {
    ($from:ident to $to:ident: $($type:ty),* $(,)?) => {$(
        if let Some(value) = $from.get::<$type>() {
            $to.insert(value.clone());
        }
    )*};
}

/// Another app with entities of the same components, and which is which.
pub(crate) fn twin(scene: &RandomWorld) -> (App, EntityHashMap<Entity>) {
    let mut app = app();
    let from = scene.app.world();
    app.insert_resource(*from.resource::<Gravity>());
    app.insert_resource(*from.resource::<SolverConfig>());
    let alive = alive(scene);
    let twins = alive
        .iter()
        .map(|&entity| (entity, app.world_mut().spawn_empty().id()));
    let twins: EntityHashMap<Entity> = twins.collect();
    for &entity in &alive {
        let it = from.entity(entity);
        let mut to = app.world_mut().entity_mut(twins[&entity]);
        copy_body(it, &mut to);
        if let Some(of) = it.get::<ChildOf>() {
            to.insert(ChildOf(twins[&of.parent()]));
        }
        if let Some(a) = it.get::<JointA>() {
            to.insert(JointA(twins[&a.0]));
        }
        if let Some(b) = it.get::<JointB>() {
            to.insert(JointB(twins[&b.0]));
        }
        copy!(it to to: Joint, Disabled);
    }
    (app, twins)
}

fn copy_body(it: EntityRef, to: &mut EntityWorldMut) {
    copy!(it to to: CompoundOfChildren, ShapeConstructor);
    // The constructor may be of no use any more.
    to.remove::<ConvexMesh>();
    copy!(
        it to to: ShapeAwaited, ConvexMesh, Compound, HalfSpaceShape, StaticMesh, Density,
        MassOverride, Mass, Friction, Restitution, Fracturable, Sensor, ContactForceEvents,
        LockedAxes, MaxSpeed, GravityScale, LinearDamping, AngularDamping, ConstantForce,
        ConstantTorque, Anchors, Fatigue, RigidBody, Transform, LinearVelocity, AngularVelocity,
        CollisionLayers, CollisionEvents,
    );
    // What the others required.
    if !it.contains::<Transform>() {
        to.remove::<Transform>();
    }
    if !it.contains::<LinearVelocity>() {
        to.remove::<LinearVelocity>();
    }
    if !it.contains::<Density>() {
        to.remove::<Density>();
    }
    if !it.contains::<CollisionLayers>() {
        to.remove::<CollisionLayers>();
    }
    if !it.contains::<CollisionEvents>() {
        to.remove::<CollisionEvents>();
    }
}
