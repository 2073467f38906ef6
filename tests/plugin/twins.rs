//! Random worlds as they stand: who is there, what they say, and the same entities made afresh in another app.
#![allow(dead_code, reason = "each test program uses some of it")]

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
        ConstantTorque, SurfaceVelocity, Anchors, Fatigue, RigidBody, Transform, LinearVelocity, AngularVelocity,
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

/// What a body is, as text.
fn state(world: &World, entity: Entity) -> Option<String> {
    let slot = body_of(world, entity)?;
    let bodies = world.resource::<Bodies>();
    Some(format!(
        "{:?} active {} sensor {} mass {:.2e} drive {:?} fracturable {:?} anchors {:?} fatigue {:?}",
        bodies.kind(slot),
        bodies.is_active(slot),
        bodies.is_sensor(slot),
        bodies.mass(slot).mass,
        bodies.drive(slot),
        bodies.fracturable(slot),
        bodies.anchors(slot),
        bodies.fatigue(slot).map(|it| it.energy),
    ))
}

/// What is wrong with a joint, and whether it holds.
fn joint(world: &World, entity: Entity) -> (Option<String>, bool) {
    let problem = world.get::<JointProblem>(entity);
    let handle = world.get::<JointHandle>(entity);
    (
        problem.map(|problem| problem.0.to_string()),
        handle.is_some_and(|handle| handle.get().is_some()),
    )
}

/// One step; whether nothing broke.
pub(crate) fn is_quiet(scene: &mut RandomWorld) -> bool {
    scene.run(Deed::Frame(1));
    let broken = scene.app.world().resource::<Messages<Fractured>>();
    broken.iter_current_update_messages().next().is_none()
}

/// Whether each entity is and says the same as its copy in another world.
pub(crate) fn compare(
    world: &World,
    fresh_world: &World,
    twins: &EntityHashMap<Entity>,
) -> Result<(), String> {
    for (&entity, &copy) in twins {
        // What is disabled is not looked at.
        if fresh_world.get_entity(copy).is_err() || world.entity(entity).contains::<Disabled>() {
            continue;
        }
        let (own, fresh) = (texts(world, entity), texts(fresh_world, copy));
        let (a, b) = (state(world, entity), state(fresh_world, copy));
        // A body is what it was while its next shape is still to come.
        if b.is_none() && fresh_world.entity(copy).contains::<ShapeAwaited>() {
            continue;
        }
        // Who is refused says what was found first. A body that was there before says all.
        let is_refused = b.is_none() && !fresh.is_empty();
        let said_alike = if is_refused {
            !own.is_empty()
        } else {
            own == fresh
        };
        if !said_alike {
            return Err(format!("{entity} says {own:?}, afresh {fresh:?}"));
        }
        if !is_refused && own.is_empty() && a != b {
            return Err(format!("{entity} is {a:?}, afresh {b:?}"));
        }
        let ends = [
            world.get::<JointA>(entity).map(|a| a.0),
            world.get::<JointB>(entity).map(|b| b.0),
        ];
        // A body that got unusable later, or is disabled, is still held; afresh there is none.
        let is_sound = |end: Entity| {
            let is_there = fresh_world.get_entity(twins[&end]).is_ok();
            is_there && texts(world, end).is_empty() && !world.entity(end).contains::<Disabled>()
        };
        let broke = world.entity(entity).contains::<Joint>()
            != fresh_world.entity(copy).contains::<Joint>();
        let (a, b) = (joint(world, entity), joint(fresh_world, copy));
        if ends.into_iter().flatten().all(is_sound) && !broke && a != b {
            return Err(format!("joint {entity} is {a:?}, afresh {b:?}"));
        }
    }
    Ok(())
}
