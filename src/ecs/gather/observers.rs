//! What happens to bodies' entities, put into queues in the order in which it happens.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::contact::layers::CollisionLayers;
use crate::contact::material::{Density, Friction, Restitution};
use crate::contact::surface::SurfaceMaterials;
use crate::ecs::collisions::Sensor;
use crate::ecs::components::*;
use crate::ecs::forces::Mass;
use crate::ecs::state::PluginState;
use crate::geometry::{Compound, ConvexMesh, HalfSpaceShape, StaticMesh};
use crate::slice::fracturable::Fracturable;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_transform::components::Transform;

/// Observer: an entity got a `RigidBody`, perhaps in place of another one. Pieces of a fracture already have their slot.
pub(crate) fn on_body_inserted(
    insert: On<Insert<RigidBody>>,
    parts: Query<(&BodyHandle, &RigidBody), Allow<Disabled>>,
    bodies: Res<Bodies>,
    mut state: ResMut<PluginState>,
) {
    let entity = insert.entity;
    let is_current = |&(slot, id): &(u32, BodyId)| bodies.is_current(slot, id);
    let known = parts.get(entity).ok();
    let known = known.and_then(|(handle, kind)| Some((handle.0.filter(is_current)?.0, *kind)));
    match known {
        Some((slot, kind)) if bodies.kind(slot) == kind => {
            // Another kind may have been refused, or components that it requires may have come back with it.
            if state.issues.is_any_of(entity) {
                state.queue.reduced.push(entity);
            }
        }
        Some(_) => {
            state.queue.changed_kind.push(entity);
            state.joints.have_bodies_changed = true;
        }
        None => state.queue.arrived.push(entity),
    }
}

/// Observer: a `RigidBody` or the handle of its body is removed, or despawned with its entity.
pub(crate) fn on_body_removed(
    remove: On<Remove<(RigidBody, BodyHandle)>>,
    mut handles: Query<&mut BodyHandle, Allow<Disabled>>,
    mut state: ResMut<PluginState>,
) {
    if let Ok(mut handle) = handles.get_mut(remove.entity) {
        let body = handle.0.take();
        if state.is_watching {
            let departed = body.map(|(_, id)| (id, remove.entity));
            state.departed.extend(departed);
        }
        state.queue.left.extend(body);
        // What it leaves behind does nothing any more.
        state.queue.lone_parts.push(remove.entity);
    }
}

/// Observer: an entity is disabled. Its body is kept, and takes no part.
pub(crate) fn on_disabled(
    insert: On<Insert<Disabled>>,
    handles: Query<&BodyHandle, Allow<Disabled>>,
    mut state: ResMut<PluginState>,
) {
    if handles.contains(insert.entity) {
        state.queue.toggled.push(insert.entity);
    }
}

/// Observer: an entity is enabled again. If it never had a body, it gets one now.
pub(crate) fn on_enabled(
    remove: On<Remove<Disabled>>,
    handles: Query<&BodyHandle, (With<RigidBody>, Allow<Disabled>)>,
    mut state: ResMut<PluginState>,
) {
    if let Ok(handle) = handles.get(remove.entity) {
        match handle.0 {
            Some(_) => state.queue.toggled.push(remove.entity),
            None => state.queue.arrived.push(remove.entity),
        }
    }
}

/// Components that a body's description is made from and that may go while the body stays.
type Removable = (
    (
        ConvexMesh,
        Compound,
        HalfSpaceShape,
        StaticMesh,
        ShapeAwaited,
    ),
    (Fracturable, Sensor),
    (MassOverride, Mass),
    (Transform, LinearVelocity, AngularVelocity),
    (Density, Friction, Restitution, SurfaceMaterials),
    CollisionLayers,
);

/// Observer: a body loses a component, or is despawned.
pub(crate) fn on_part_removed(
    remove: On<Remove<Removable>>,
    handles: Query<&BodyHandle, Allow<Disabled>>,
    state: ResMut<PluginState>,
) {
    describe_again(remove.entity, &handles, state);
}

/// Observer: a body that may have lost its shape is to get another one.
pub(crate) fn on_shape_awaited(
    add: On<Add<ShapeAwaited>>,
    handles: Query<&BodyHandle, Allow<Disabled>>,
    state: ResMut<PluginState>,
) {
    describe_again(add.entity, &handles, state);
}

fn describe_again(
    entity: Entity,
    handles: &Query<&BodyHandle, Allow<Disabled>>,
    mut state: ResMut<PluginState>,
) {
    let is_body = handles.get(entity).is_ok_and(|handle| handle.0.is_some());
    let reduced = &mut state.queue.reduced;
    // One bundle may have several.
    if is_body && reduced.last() != Some(&entity) {
        reduced.push(entity);
    }
}

/// Observer: an entity was marked as sleeping; by the plugin, if its body sleeps already.
pub(crate) fn on_sleeping_inserted(
    insert: On<Insert<Sleeping>>,
    handles: Query<&BodyHandle, Allow<Disabled>>,
    bodies: Res<Bodies>,
    mut state: ResMut<PluginState>,
) {
    let body = handles.get(insert.entity).ok().and_then(|handle| handle.0);
    if !body.is_some_and(|(slot, id)| bodies.is_current(slot, id) && bodies.is_asleep(slot)) {
        state.queue.marked.push(insert.entity);
    }
}

/// Observer: a sleeping body lost its mark; if it was not the plugin that saw it wake, this wakes it.
pub(crate) fn on_sleeping_removed(
    remove: On<Remove<Sleeping>>,
    handles: Query<&BodyHandle, Allow<Disabled>>,
    mut bodies: ResMut<Bodies>,
) {
    let body = handles.get(remove.entity).ok().and_then(|handle| handle.0);
    if let Some((slot, _)) =
        body.filter(|&(slot, id)| bodies.is_current(slot, id) && bodies.is_asleep(slot))
    {
        bodies.wake(slot);
    }
}
