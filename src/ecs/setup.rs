//! Components that every body has, whether its entity was spawned before the plugin was added or after, and what an app lacks.

use crate::bodies::body::RigidBody;
use crate::contact::layers::CollisionLayers;
use crate::contact::material::{Density, Friction, Restitution};
use crate::ecs::components::*;
use crate::ecs::forces::AppliedForces;
use crate::ecs::gather::HasPart;
use crate::ecs::state::PluginState;
use crate::mass::MassProperties;
use bevy_app::App;
use bevy_ecs::component::Component;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_tasks::ComputeTaskPool;
use bevy_time::Time;
use bevy_transform::components::Transform;

/// All that a body requires, with defaults.
type Required = (
    (Transform, LinearVelocity, AngularVelocity),
    (Density, Friction, Restitution, CollisionLayers),
    (MassProperties, AppliedForces, BodyHandle),
);

/// `(RigidBody, ConvexMesh)` is a whole body: the rest has defaults.
///
/// Of entities that are there already Bevy does not take requirements any more. Then these get their components here, and those that
/// come later from an observer.
pub(crate) fn require_components(app: &mut App) {
    let is_registered = [
        require::<Transform>(app),
        require::<LinearVelocity>(app),
        require::<AngularVelocity>(app),
        require::<Density>(app),
        require::<Friction>(app),
        require::<Restitution>(app),
        require::<CollisionLayers>(app),
        require::<MassProperties>(app),
        require::<AppliedForces>(app),
        require::<BodyHandle>(app),
    ];
    if is_registered.contains(&false) {
        app.add_observer(complete_body);
        adopt_bodies(app.world_mut());
    }
}

fn require<T: Component + Default>(app: &mut App) -> bool {
    let done = app.try_register_required_components::<RigidBody, T>();
    done.is_ok()
}

/// Observer: a body that came after others had come before the plugin.
fn complete_body(add: On<Add<RigidBody>>, mut commands: Commands) {
    let mut entity = commands.entity(add.entity);
    entity.insert_if_new(Required::default());
}

/// Entities that are there already become bodies, in the order of their names, and what is without a body is looked at.
fn adopt_bodies(world: &mut World) {
    let mut bodies = world.query_filtered::<Entity, (With<RigidBody>, Allow<Disabled>)>();
    let mut lone = world.query_filtered::<Entity, (HasPart, Without<RigidBody>, Allow<Disabled>)>();
    let mut arrived: Vec<Entity> = bodies.iter(world).collect();
    arrived.sort_unstable();
    let lone: Vec<Entity> = lone.iter(world).collect();
    for &entity in &arrived {
        world.entity_mut(entity).insert_if_new(Required::default());
    }
    let state = &mut *world.resource_mut::<PluginState>();
    state.options.is_used = true;
    state.queue.arrived.extend(arrived);
    state.queue.lone_parts.extend(lone);
}

/// System, once: says what the app lacks to make steps at all, or to make them fast.
pub(crate) fn name_what_is_missing(time: Option<Res<Time>>) {
    if time.is_none() {
        log::warn!(
            "no physics step is made: the app has no Time; add TimePlugin (part of DefaultPlugins and MinimalPlugins)"
        );
    }
    if ComputeTaskPool::try_get().is_none() {
        log::warn!(
            "physics runs on one thread: the app has no compute task pool; add TaskPoolPlugin (part of DefaultPlugins and \
             MinimalPlugins)"
        );
    }
}
