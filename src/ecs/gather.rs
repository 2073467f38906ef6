//! Components into flat arrays: new bodies, removed bodies, and what the user changed since the last step.

mod description;
mod kinds;
mod lone;
mod motion;
mod observers;

pub(crate) use lone::{HasPart, on_lone_part_added, on_lone_part_removed};
pub(crate) use observers::*;

use crate::bodies::body::{BodyError, RigidBody};
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::contact::impulses::ContactCache;
use crate::ecs::bond::make_bonds;
use crate::ecs::components::*;
use crate::ecs::forces::AppliedForces;
use crate::ecs::gather::description::*;
use crate::ecs::gather::kinds::{RareReadings, read_kinds, set_kind, toggle};
use crate::ecs::gather::motion::{MotionReader, ReadMotion};
use crate::ecs::issues::{Issues, Source};
use crate::ecs::options::{BodyOptions, ChangedOptions, read_options};
use crate::ecs::parents::Parents;
use crate::ecs::scaled_shapes::ScaledShapes;
use crate::ecs::state::{BodyQueue, PluginState};
use crate::fracture::Bonds;
use crate::mass::MassProperties;
use crate::math::Pose;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

/// What the user changed about entities that have bodies, and the entities that commands name.
#[derive(SystemParam)]
pub(crate) struct Readings<'w, 's> {
    ticks: Query<'w, 's, ChangeTicks, With<BodyHandle>>,
    changed: Query<'w, 's, Entity, (Changes, With<BodyHandle>)>,
    described: Query<'w, 's, (&'static BodyHandle, Option<BodyParts>)>,
    motion: Query<'w, 's, ReadMotion>,
    marked: Query<'w, 's, &'static BodyHandle, With<Sleeping>>,
    handles: Query<'w, 's, &'static BodyHandle>,
    /// Of those that are disabled too: their bodies and bonds are kept.
    kept: Query<'w, 's, &'static BodyHandle, Allow<Disabled>>,
    /// Of those that are disabled too.
    forces: Query<'w, 's, (Ref<'static, AppliedForces>, Has<Disabled>), With<BodyHandle>>,
    changed_options: Query<'w, 's, Entity, (ChangedOptions, With<BodyHandle>)>,
    options: Query<'w, 's, BodyOptions>,
    parents: Parents<'w, 's>,
    rare: RareReadings<'w, 's>,
}

impl Readings<'_, '_> {
    /// Whether forces may have been applied: a look at what tables have noted of all their entities together.
    pub(crate) fn has_forces(&self) -> bool {
        let Ok(mut tables) = self.forces.contiguous_iter() else {
            return true;
        };
        tables.any(|(column, _)| any_changed(Some(column)))
    }
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
        settings,
        entities,
        scaled,
        queue,
        bond_requests,
        options,
        issues,
        children,
        kinematic,
        ..
    } = state;
    read_kinds(queue, bodies, issues, warnings, &readings.rare);
    let enabled = toggle(queue, bodies, issues, &readings.rare);
    // Who has lost a parent is where its `Transform` says now.
    let motion_of = |entity| readings.motion.get(entity);
    let is_orphan = |&entity: &Entity| motion_of(entity).is_ok_and(|(.., up)| up.is_none());
    let orphans: Vec<Entity> = children.drain(..).filter(is_orphan).collect();
    options.read_again(&queue.reduced);
    let shapes = (&mut *bodies, &mut *scaled);
    gather_changes(queue, shapes, issues, warnings, readings);
    let mut reader = MotionReader {
        bodies: &mut *bodies,
        entities,
        issues: &mut *issues,
        warnings: &mut *warnings,
        children,
        kinematic,
        rescaled: &mut queue.reduced,
        halted: &queue.halted,
        parents: &readings.parents,
        handles: &readings.handles,
    };
    reader.read_all(&readings.motion);
    reader.read_again(&readings.motion, enabled, orphans);
    options.read_again(&queue.reduced);
    if !queue.reduced.is_empty() {
        let shapes = (&mut *bodies, &mut *scaled);
        redescribe(queue, shapes, issues, warnings, readings, None);
    }
    kinematic.retain_mut(|target| target.begin(bodies, settings.step_dt));
    settle_marked(queue, bodies, &readings.marked);
    read_options(
        options,
        (bodies, entities),
        (issues, warnings),
        &readings.changed_options,
        &readings.options,
    );
    make_bonds(bond_requests, bodies, bonds, warnings, &readings.kept);
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
    (mut parts, parents): (Query<Arrival, With<RigidBody>>, Parents),
) {
    let PluginState {
        entities,
        scaled,
        queue,
        joints,
        options,
        issues,
        ..
    } = &mut *state;
    joints.have_bodies_changed = true;
    queue.left.iter().for_each(|&(slot, _)| scaled.forget(slot));
    remove_bodies(&mut queue.left, &mut bodies, &mut cache);
    let earlier = std::mem::take(&mut queue.refused);
    let arrived = std::mem::take(&mut queue.arrived);
    for entity in earlier.into_iter().chain(arrived) {
        let Ok((mut handle, item, is_marked)) = parts.get_mut(entity) else {
            continue;
        };
        if (handle.0).is_some_and(|(slot, id)| bodies.is_current(slot, id)) {
            continue;
        }
        let inserted = insert((&mut bodies, scaled), item.as_ref(), &parents);
        let inserted = unless_awaited(item.as_ref(), inserted);
        let inserted = issues.note(&mut warnings, entity, Source::Body, inserted);
        match inserted.flatten() {
            Some(arrival) => {
                let (slot, id) = (arrival.slot, bodies.id(arrival.slot));
                handle.0 = Some((slot, id));
                entities.set(slot, id, entity, arrival.seen);
                issues.begin_body(entity);
                if let Some((parent, local)) = arrival.local {
                    entities.set_local(slot, parent, local);
                }
                issues.note(&mut warnings, entity, Source::Breaking, arrival.breaking);
                issues.note(&mut warnings, entity, Source::Velocity, arrival.motion);
                if is_marked {
                    queue.marked.push(entity);
                }
                if options.is_used {
                    options.entities.push(entity);
                }
            }
            None => {
                queue.refused.insert(entity);
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

/// A body that was added.
struct Arrived {
    slot: u32,
    /// The `Transform` that it was made from, in the world.
    seen: Transform,
    /// Its parent and the one beneath that, if it has one.
    local: Option<(Entity, Transform)>,
    /// What does nothing on it.
    breaking: Result<(), BodyError>,
    motion: Result<(), BodyError>,
}

/// Adds the body that `parts` describe.
fn insert(
    (bodies, scaled_shapes): (&mut Bodies, &mut ScaledShapes),
    parts: Option<&BodyPartsItem>,
    parents: &Parents,
) -> Result<Arrived, BodyError> {
    let parts = parts.ok_or(BodyError::Incomplete)?;
    let (pose, scale) =
        parents.place(parts.transform, parts.child_of, *parts.kind, &|_, _| None)?;
    let own = shape_of(parts)?;
    let shape = scaled(&own, scale)?;
    let desc = describe(parts, pose, shape.clone())?;
    let breaking = idle_part(parts, &desc);
    let motion = idle_velocity(desc.kind, desc.linear_velocity, desc.angular_velocity);
    let slot = bodies.insert(desc)?;
    if scale != Vec3::ONE {
        scaled_shapes.keep((slot, bodies.id(slot)), own, scale, shape);
    }
    let parent = parts.child_of.map(ChildOf::parent);
    let world = Transform {
        translation: pose.position,
        rotation: pose.rotation,
        scale,
    };
    Ok(Arrived {
        slot,
        seen: parent.map_or(*parts.transform, |_| world),
        local: parent.map(|parent| (parent, *parts.transform)),
        breaking,
        motion,
    })
}

/// A velocity that does nothing.
fn idle_velocity(kind: RigidBody, linear: Vec3, angular: Vec3) -> Result<(), BodyError> {
    let is_idle = kind == RigidBody::Static && (linear, angular) != (Vec3::ZERO, Vec3::ZERO);
    if is_idle {
        return Err(BodyError::StaticVelocity);
    }
    Ok(())
}

/// Shapes, densities, materials and layers that the user changed. What is not usable is not taken over.
fn gather_changes(
    queue: &mut BodyQueue,
    (bodies, scaled): (&mut Bodies, &mut ScaledShapes),
    issues: &mut Issues,
    warnings: &mut Messages<BodyWarning>,
    readings: &Readings,
) {
    let has_changed = has_any_changed(&readings.ticks);
    if has_changed || !queue.reduced.is_empty() {
        let changed = has_changed.then_some(&readings.changed);
        redescribe(queue, (bodies, scaled), issues, warnings, readings, changed);
    }
}

/// Reads the descriptions of entities that are queued or `changed`.
fn redescribe(
    queue: &mut BodyQueue,
    (bodies, scaled): (&mut Bodies, &mut ScaledShapes),
    issues: &mut Issues,
    warnings: &mut Messages<BodyWarning>,
    readings: &Readings,
    changed: Option<&Query<Entity, (Changes, With<BodyHandle>)>>,
) {
    let changed = changed.into_iter().flat_map(|changed| changed.iter());
    let mut turned = Vec::new();
    for entity in changed.chain(queue.reduced.drain(..)) {
        let Ok((handle, parts)) = readings.described.get(entity) else {
            continue;
        };
        let Some(body) = handle.0.filter(|&(slot, id)| bodies.is_current(slot, id)) else {
            continue;
        };
        let slot = body.0;
        // Pose and velocity are read elsewhere: broken ones must not hide a new shape.
        let parts = parts.as_ref();
        let desc = parts.ok_or(BodyError::Incomplete).and_then(|parts| {
            let parents = &readings.parents;
            let placed = parents.place(parts.transform, parts.child_of, *parts.kind, &|_, _| None);
            let (_, scale) = placed?;
            let shape = scaled_anew(scaled, body, shape_of(parts)?, scale)?;
            let desc = describe(parts, Pose::IDENTITY, shape)?;
            issues.note(warnings, entity, Source::Breaking, idle_part(parts, &desc));
            Ok(desc)
        });
        if matches!(desc, Err(BodyError::NoShape)) {
            // What of a shape breaks is not known while there is none.
            issues.mend(entity, Source::Breaking);
        }
        let taken = desc.and_then(|desc| bodies.redescribe(slot, desc));
        let taken = unless_awaited(parts, taken);
        issues.note(warnings, entity, Source::Description, taken);
        if let Some(parts) = parts {
            // A kind that the shape before did not allow.
            let before = bodies.kind(slot);
            let target = (entity, slot, (parts.linear.0, parts.angular.0));
            let made = set_kind((bodies, issues), &mut queue.halted, target, *parts.kind);
            issues.note(warnings, entity, Source::Kind, made);
            turned.extend((bodies.kind(slot) != before).then_some(entity));
            if bodies.kind(slot) != RigidBody::Static {
                // It may have been let fall since that was told.
                issues.mend(entity, Source::Velocity);
            }
        }
    }
    // What else depends on the kind is to be looked at again.
    queue.reduced = turned;
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
