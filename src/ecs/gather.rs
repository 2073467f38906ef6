//! Components into flat arrays: new bodies, removed bodies, and what the user changed since the last step.

mod motion;

use crate::bodies::body::{BodyDesc, BodyError, RigidBody, Shape};
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::contact::impulses::ContactCache;
use crate::contact::layers::CollisionLayers;
use crate::contact::material::{Density, Friction, Restitution};
use crate::ecs::bond::make_bonds;
use crate::ecs::components::*;
use crate::ecs::gather::motion::{ReadMotion, gather_motion};
use crate::ecs::state::BodyQueue;
use crate::ecs::state::PluginState;
use crate::fracture::Bonds;
use crate::geometry::{ConvexMesh, HalfSpaceShape};
use crate::mass::MassProperties;
use crate::math::Pose;
use crate::slice::fracturable::Fracturable;
use bevy_ecs::change_detection::ContiguousRef;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::SystemParam;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

/// Everything a body is made from.
#[derive(QueryData)]
pub(crate) struct BodyParts {
    kind: &'static RigidBody,
    convex: Option<&'static ConvexMesh>,
    half_space: Option<&'static HalfSpaceShape>,
    transform: &'static Transform,
    linear: &'static LinearVelocity,
    angular: &'static AngularVelocity,
    density: &'static Density,
    mass: Option<&'static MassOverride>,
    friction: &'static Friction,
    restitution: &'static Restitution,
    layers: &'static CollisionLayers,
    fracturable: Option<&'static Fracturable>,
}

/// Observer: an entity got a `RigidBody`. Pieces of a fracture already have their slot.
pub(crate) fn on_body_inserted(
    insert: On<Insert<RigidBody>>,
    handles: Query<&BodyHandle>,
    mut state: ResMut<PluginState>,
) {
    let entity = insert.entity;
    let is_new = handles.get(entity).is_ok_and(|handle| handle.0.is_none());
    if is_new {
        state.queue.arrived.push(entity);
    }
}

/// Observer: a `RigidBody` is replaced, removed, or despawned with its entity.
pub(crate) fn on_body_discarded(
    discard: On<Discard<(RigidBody, BodyHandle)>>,
    mut handles: Query<&mut BodyHandle>,
    mut state: ResMut<PluginState>,
) {
    if let Ok(mut handle) = handles.get_mut(discard.entity) {
        state.queue.left.extend(handle.0.take());
    }
}

/// Components that a body's description is made from and that may go while the body stays.
type Removable = (
    (ConvexMesh, HalfSpaceShape, MassOverride, Fracturable),
    (Transform, LinearVelocity, AngularVelocity),
    (Density, Friction, Restitution, CollisionLayers),
);

/// Observer: a body loses a component, or is despawned.
pub(crate) fn on_part_removed(
    remove: On<Remove<Removable>>,
    handles: Query<&BodyHandle>,
    mut state: ResMut<PluginState>,
) {
    let entity = remove.entity;
    let is_body = handles.get(entity).is_ok_and(|handle| handle.0.is_some());
    let reduced = &mut state.queue.reduced;
    if is_body && reduced.last() != Some(&entity) {
        reduced.push(entity);
    }
}

/// Observer: an entity was marked as sleeping; by the plugin, if its body sleeps already.
pub(crate) fn on_sleeping_inserted(
    insert: On<Insert<Sleeping>>,
    handles: Query<&BodyHandle>,
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
    handles: Query<&BodyHandle>,
    mut bodies: ResMut<Bodies>,
) {
    let body = handles.get(remove.entity).ok().and_then(|handle| handle.0);
    if let Some((slot, _)) =
        body.filter(|&(slot, id)| bodies.is_current(slot, id) && bodies.is_asleep(slot))
    {
        bodies.wake(slot);
    }
}

/// What the user changed about entities that have bodies, and the entities that commands name.
#[derive(SystemParam)]
pub(crate) struct Readings<'w, 's> {
    ticks: Query<'w, 's, ChangeTicks, With<BodyHandle>>,
    changed: Query<'w, 's, Entity, (Changes, With<BodyHandle>)>,
    described: Query<'w, 's, (&'static BodyHandle, Option<BodyParts>)>,
    motion: Query<'w, 's, ReadMotion>,
    marked: Query<'w, 's, &'static BodyHandle, With<Sleeping>>,
    handles: Query<'w, 's, &'static BodyHandle>,
}

/// Reads what the user changed about bodies, and makes the bonds that were asked for, now that the entities have bodies.
pub(crate) fn read_entities(
    state: &mut PluginState,
    bodies: &mut Bodies,
    bonds: &mut Bonds,
    warnings: &mut Messages<BodyWarning>,
    readings: &Readings,
) {
    let PluginState {
        entities,
        queue,
        bond_requests,
        ..
    } = state;
    gather_changes(queue, bodies, warnings, readings);
    gather_motion(bodies, entities, warnings, &readings.motion);
    settle_marked(queue, bodies, &readings.marked);
    make_bonds(bond_requests, bodies, bonds, warnings, &readings.handles);
}

/// Bodies that were marked as sleeping need not wait for it.
fn settle_marked(
    queue: &mut BodyQueue,
    bodies: &mut Bodies,
    marked: &Query<&BodyHandle, With<Sleeping>>,
) {
    for entity in queue.marked.drain(..) {
        let body = marked.get(entity).ok().and_then(|handle| handle.0);
        if let Some((slot, _)) = body.filter(|&(slot, id)| bodies.is_current(slot, id)) {
            bodies.request_sleep(slot);
        }
    }
}

/// An entity that is to become a body, and whether it is marked as sleeping.
type Arrival = (&'static mut BodyHandle, Option<BodyParts>, Has<Sleeping>);

/// Run condition of [`register_bodies`]: most steps would fetch all that it takes only to find that nothing is queued.
pub(crate) fn any_body_comes_or_goes(state: Res<PluginState>) -> bool {
    let BodyQueue {
        arrived,
        left,
        refused,
        ..
    } = &state.queue;
    !(arrived.is_empty() && left.is_empty() && refused.is_empty())
}

/// System: frees the slots of bodies that left, gives slots to those that arrived.
pub(crate) fn register_bodies(
    mut state: ResMut<PluginState>,
    mut bodies: ResMut<Bodies>,
    mut cache: ResMut<ContactCache>,
    mut warnings: ResMut<Messages<BodyWarning>>,
    mut parts: Query<Arrival, With<RigidBody>>,
) {
    let PluginState {
        entities,
        queue,
        joints,
        ..
    } = &mut *state;
    joints.have_bodies_changed = true;
    remove_bodies(&mut queue.left, &mut bodies, &mut cache);
    let earlier = std::mem::take(&mut queue.refused);
    let arrived = std::mem::take(&mut queue.arrived);
    let arrived = arrived.into_iter().map(|entity| (entity, None));
    let earlier = earlier.into_iter().map(|(entity, why)| (entity, Some(why)));
    for (entity, known_problem) in earlier.chain(arrived) {
        let Ok((mut handle, item, is_marked)) = parts.get_mut(entity) else {
            continue;
        };
        if handle.0.is_some() {
            continue;
        }
        match insert(&mut bodies, item.as_ref()) {
            Ok((slot, seen)) => {
                let id = bodies.id(slot);
                handle.0 = Some((slot, id));
                entities.set(slot, id, entity, seen);
                if is_marked {
                    queue.marked.push(entity);
                }
            }
            Err(_) if queue.refused.iter().any(|(known, _)| *known == entity) => {}
            Err(error) => {
                // As texts, because a NaN in the reason is not equal to itself.
                if known_problem.map(|p| p.to_string()) != Some(error.to_string()) {
                    warn(&mut warnings, entity, error);
                }
                queue.refused.push((entity, error));
            }
        }
    }
}

/// Removes the bodies that `left`, in that order, and then their cache entries in one pass.
fn remove_bodies(left: &mut Vec<(u32, BodyId)>, bodies: &mut Bodies, cache: &mut ContactCache) {
    left.retain(|&(slot, id)| bodies.is_current(slot, id));
    for &(slot, _) in left.iter() {
        bodies.remove(slot);
    }
    if !left.is_empty() {
        left.sort_unstable_by_key(|&(_, id)| id);
        cache.remove_bodies(|id| left.binary_search_by_key(&id, |&(_, id)| id).is_ok());
        left.clear();
    }
}

/// Adds the body that `parts` describe; its slot, and the `Transform` it was made from.
fn insert(
    bodies: &mut Bodies,
    parts: Option<&BodyPartsItem>,
) -> Result<(u32, Transform), BodyError> {
    let parts = parts.ok_or(BodyError::Incomplete)?;
    let pose = pose_of(parts.transform)?;
    let slot = bodies.insert(describe(parts, pose)?)?;
    Ok((slot, *parts.transform))
}

fn describe(parts: &BodyPartsItem, pose: Pose) -> Result<BodyDesc, BodyError> {
    let shape = match (parts.convex, parts.half_space) {
        (Some(mesh), _) => Shape::Convex(mesh.clone()),
        (None, Some(half_space)) => Shape::HalfSpace(*half_space),
        (None, None) => return Err(BodyError::NoShape),
    };
    Ok(BodyDesc {
        kind: *parts.kind,
        shape,
        pose,
        linear_velocity: parts.linear.0,
        angular_velocity: parts.angular.0,
        density: parts.density.0,
        mass: parts.mass.map(|m| m.0),
        friction: *parts.friction,
        restitution: *parts.restitution,
        layers: *parts.layers,
        fracturable: parts.fracturable.cloned(),
    })
}

/// The pose in a `Transform`, which must not be scaled.
fn pose_of(transform: &Transform) -> Result<Pose, BodyError> {
    if transform.scale != Vec3::ONE {
        return Err(BodyError::Scaled(transform.scale));
    }
    Ok(Pose::new(transform.translation, transform.rotation))
}

/// What of a body's description changed.
type Changes = Or<(
    Changed<ConvexMesh>,
    Changed<HalfSpaceShape>,
    Changed<Density>,
    Changed<MassOverride>,
    Changed<Friction>,
    Changed<Restitution>,
    Changed<CollisionLayers>,
    Changed<Fracturable>,
)>;

/// The same components, table by table.
type ChangeTicks = (
    Option<Ref<'static, ConvexMesh>>,
    Option<Ref<'static, HalfSpaceShape>>,
    Option<Ref<'static, Density>>,
    Option<Ref<'static, MassOverride>>,
    Option<Ref<'static, Friction>>,
    Option<Ref<'static, Restitution>>,
    Option<Ref<'static, CollisionLayers>>,
    Option<Ref<'static, Fracturable>>,
);

/// Whether any description may have changed: a look at what tables have noted of all their entities together.
fn has_any_changed(ticks: &Query<ChangeTicks, With<BodyHandle>>) -> bool {
    fn any<T>(column: Option<ContiguousRef<T>>) -> bool {
        column.is_some_and(|column| {
            let (_, ticks) = ContiguousRef::split(column);
            // All of these components ask for such a note.
            ticks.summary_tick_is_changed().unwrap_or(true)
        })
    }
    let Ok(mut tables) = ticks.contiguous_iter() else {
        return true;
    };
    tables.any(|(a, b, c, d, e, f, g, h)| {
        any(a) || any(b) || any(c) || any(d) || any(e) || any(f) || any(g) || any(h)
    })
}

/// Shapes, densities, materials and layers that the user changed. What is not usable is not taken over.
fn gather_changes(
    queue: &mut BodyQueue,
    bodies: &mut Bodies,
    warnings: &mut Messages<BodyWarning>,
    readings: &Readings,
) {
    let has_changed = has_any_changed(&readings.ticks);
    let changed = has_changed.then(|| readings.changed.iter());
    let changed = changed.into_iter().flatten();
    for entity in changed.chain(queue.reduced.drain(..)) {
        let Ok((handle, parts)) = readings.described.get(entity) else {
            continue;
        };
        let Some((slot, _)) = handle.0.filter(|&(slot, id)| bodies.is_current(slot, id)) else {
            continue;
        };
        // Pose and velocity are gather_motion's business: broken ones must not hide a new shape.
        let parts = parts.as_ref().ok_or(BodyError::Incomplete);
        let desc = parts.and_then(|parts| describe(parts, Pose::IDENTITY));
        if let Err(error) = desc.and_then(|desc| bodies.redescribe(slot, desc)) {
            warn(warnings, entity, error);
        }
    }
}

/// Writes computed mass properties to their entities.
pub(crate) fn publish_mass(
    bodies: &Bodies,
    entities: &BodyEntities,
    masses: &mut Query<&mut MassProperties>,
) {
    for &slot in &bodies.fresh_mass {
        let entity = entities.of(slot, bodies.id(slot));
        if let Some(mut mass) = entity.and_then(|e| masses.get_mut(e).ok()) {
            mass.set_if_neq(*bodies.mass(slot));
        }
    }
}
